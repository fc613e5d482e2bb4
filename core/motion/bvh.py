"""A motion as BVH: the plain ten-joint skeleton, readable by any animation program.

Frame: y up, z forward, left at +x. Unit: metres unless ``unit`` says otherwise. One joint for each of the nine edges,
named as Mixamo does so that rigs and programs recognise them, below still hips. Where the motion has hands, they turn and have
fingers; where it has a pelvis, hips move, and there are legs that keep their feet in place. The rest pose
stretches the arms out to the sides in a T, while torso, neck, head and clavicles lie along the data's mean, so that no
rotation means an average posture.
"""

import os

import numpy as np

from ...rigs import quaternion
from ...rigs.goals import NEUTRAL, Goals, Options
from ...rigs.legs import Leg, Legs
from ...rigs.plain import Bones, Mapping
from ...rigs.retarget import rotations
from ..files import whole_file
from . import skeleton
from .motion import Motion

HIPS_HEIGHT = 0.9
SPINE_OFFSET = 0.1
HAND = 0.1
"""Metres: the hips above the floor, the spine joint above the hips, the length of a hand."""

JOINT_OF_EDGE = {
    "torso": "Spine",
    "neck": "Neck",
    "head": "Head",
    "left_clavicle": "LeftShoulder",
    "left_upper_arm": "LeftArm",
    "left_forearm": "LeftForeArm",
    "right_clavicle": "RightShoulder",
    "right_upper_arm": "RightArm",
    "right_forearm": "RightForeArm",
}
"""The BVH joint that stands at an edge's start and turns it."""

_JOINTS = (  # name, parent, the edge that leads to it
    ("Hips", None, None),
    ("Spine", "Hips", None),
    ("Neck", "Spine", "torso"),
    ("Head", "Neck", "neck"),
    ("LeftShoulder", "Spine", "torso"),
    ("LeftArm", "LeftShoulder", "left_clavicle"),
    ("LeftForeArm", "LeftArm", "left_upper_arm"),
    ("LeftHand", "LeftForeArm", "left_forearm"),
    ("RightShoulder", "Spine", "torso"),
    ("RightArm", "RightShoulder", "right_clavicle"),
    ("RightForeArm", "RightArm", "right_upper_arm"),
    ("RightHand", "RightForeArm", "right_forearm"),
)
_LEG = (("UpLeg", "Hips", (0.09, -0.03, 0.0)), ("Leg", "UpLeg", (0.01, -0.4, 0.015)), ("Foot", "Leg", (0.01, -0.4, -0.025)))
"""A left leg: joints below "Left", what they hang on, and offsets in metres; straight but for what tells where a knee bends."""
_FINGERS = {  # of a left hand with its palm down: from the wrist to the first joint, then from joint to joint, metres
    "Thumb": ((0.025, -0.012, 0.03), (0.028, -0.008, 0.022), (0.024, -0.004, 0.014), (0.02, -0.003, 0.01)),
    "Index": ((0.095, 0.0, 0.026), (0.042, 0.0, 0.003), (0.026, 0.0, 0.001), (0.02, 0.0, 0.0)),
    "Middle": ((0.1, 0.0, 0.004), (0.046, 0.0, 0.0), (0.03, 0.0, 0.0), (0.022, 0.0, 0.0)),
    "Ring": ((0.094, 0.0, -0.016), (0.043, 0.0, -0.002), (0.028, 0.0, -0.001), (0.021, 0.0, 0.0)),
    "Pinky": ((0.084, 0.0, -0.034), (0.034, 0.0, -0.004), (0.022, 0.0, -0.002), (0.018, 0.0, 0.0)),
}
_TOES = np.array([0.01, -0.06, 0.13])
_ENDS = {"Head": "head", "LeftHand": "left_forearm", "RightHand": "right_forearm"}
_CROWN = "crown"  # a bone that only the solver sees: where the head ends
_ORDER = "YXZ"  # as Blender names it: y turns first; BVH lists the same from the outside in, Z X Y


def save(motion: Motion, path: str | os.PathLike, unit: float = 1.0) -> None:
    """Write ``motion`` at its own frame rate to ``path``, whole or not at all; ``unit`` is a metre's length in the file.

    Raises :class:`OutputUnwritable`.
    """
    text = hierarchy(unit, motion.pelvis is not None, motion.hands is not None) + frames(motion, unit)
    with whole_file(path) as temporary:
        temporary.write_text(text, "ascii")


def hierarchy(unit: float = 1.0, legs: bool = False, fingers: bool = False) -> str:
    """The HIERARCHY section: joints, offsets and channels."""
    lines = ["HIERARCHY"]
    _joint(lines, "Hips", "", unit, _joints(legs, fingers))
    return "\n".join(lines) + "\n"


def frames(motion: Motion, unit: float = 1.0) -> str:
    """The MOTION section: degrees with five decimals."""
    hips, angles = _solved(motion)
    angles = np.degrees(angles)[..., [2, 0, 1]]
    rows = np.concatenate([unit * hips, angles.reshape(len(angles), -1)], -1)
    body = "\n".join(" ".join(f"{value:.5f}" for value in row) for row in rows)
    return f"MOTION\nFrames: {len(rows)}\nFrame Time: {1.0 / motion.fps:.9f}\n{body}\n"


def _joints(legs: bool, fingers: bool) -> tuple[tuple[str, str | None, np.ndarray], ...]:
    """Name, parent and offset (3,) of every joint, in the file's order: what hangs on a joint follows it."""
    found = [(name, parent, _offset(name)) for name, parent, _ in _JOINTS]
    for side, sign in (("Left", 1.0), ("Right", -1.0)) if legs else ():
        for name, parent, offset in _LEG:
            found.append((side + name, parent if parent == "Hips" else side + parent, np.array(offset) * [sign, 1, 1]))
    for hand, sign in (("LeftHand", 1.0), ("RightHand", -1.0)) if fingers else ():
        for finger, offsets in _FINGERS.items():
            names = [f"{hand}{finger}{number}" for number in range(1, len(offsets))]
            found += [
                (*pair, np.array(offset) * [sign, 1, 1]) for *pair, offset in zip(names, [hand, *names], offsets, strict=False)
            ]

    def below(above: str | None) -> list:
        return [one for joint in found if joint[1] == above for one in (joint, *below(joint[0]))]

    return tuple(below(None))


def _joint(lines: list[str], name: str, indent: str, unit: float, joints) -> None:
    is_root = name == "Hips"
    channels = "6 Xposition Yposition Zposition" if is_root else "3"
    lines += [
        f"{indent}{'ROOT' if is_root else 'JOINT'} {name}",
        f"{indent}{{",
        f"{indent}\tOFFSET {_offset_text(next(offset for joint, _, offset in joints if joint == name), unit)}",
        f"{indent}\tCHANNELS {channels} Zrotation Xrotation Yrotation",
    ]
    children = [child for child, parent, _ in joints if parent == name]
    for child in children:
        _joint(lines, child, indent + "\t", unit, joints)
    if not children:
        end = f"{indent}\t\tOFFSET {_offset_text(_end(name), unit)}"
        lines += [f"{indent}\tEnd Site", f"{indent}\t{{", end, f"{indent}\t}}"]
    lines.append(f"{indent}}}")


def _offset_text(offset: np.ndarray, unit: float) -> str:
    return " ".join(f"{value * unit + 0.0:.6f}" for value in offset)


def _rest() -> np.ndarray:
    """Rest directions (9, 3), y up: the data's mean with arms stretched out to the sides."""
    rest = skeleton.canonical_to_y_up(NEUTRAL).astype(float)
    rest[[4, 5]], rest[[7, 8]] = [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]
    return rest


def _offset(name: str) -> np.ndarray:
    edge = next(edge for joint, _, edge in _JOINTS if joint == name)
    if edge is None:
        return np.array([0.0, SPINE_OFFSET if name == "Spine" else 0.0, 0.0])
    row = skeleton.EDGE_NAMES.index(edge)
    return _rest()[row] * skeleton.LENGTHS[row]


def _end(name: str) -> np.ndarray:
    side = [1 if name.startswith("Left") else -1, 1, 1]
    if name.endswith("Foot"):
        return _TOES * side
    finger = name[:-1].partition("Hand")[2]
    if finger:
        return np.array(_FINGERS[finger][-1]) * side
    row = skeleton.EDGE_NAMES.index(_ENDS[name])
    return _rest()[row] * (skeleton.LENGTHS[row] if name == "Head" else HAND)


def _bones(legs: bool, fingers: bool) -> Bones:
    """The skeleton at rest, joints as bones whose axes are the file's own; bones after those mark where others end."""
    joints = _joints(legs, fingers)
    ends = {_CROWN: "Head"} | ({f"{side} toes": f"{side}Foot" for side in ("Left", "Right")} if legs else {})
    ends |= {f"{name} tip": name for name, _, _ in joints if name[:-1].partition("Hand")[2] and name.endswith("3")}
    names = (*(name for name, _, _ in joints), *ends)
    parents = [-1 if above is None else names.index(above) for _, above, _ in joints]
    parents = np.array(parents + [names.index(above) for above in ends.values()])
    offsets = [offset for _, _, offset in joints] + [_end(above) for above in ends.values()]
    matrices = np.tile(np.eye(4), (len(names), 1, 1))
    for row, offset in enumerate(offsets):
        above = matrices[parents[row], :3, 3] if row else np.array([0.0, HIPS_HEIGHT, 0.0])
        matrices[row, :3, 3] = above + offset
    return Bones(names, parents, matrices, np.full(len(names), HAND))


def _solved(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Places of the hips (frames, 3) in metres, and Euler angles (frames, joints, 3) as x, y, z in radians."""
    moves = motion.pelvis is not None
    bones = _bones(moves, motion.hands is not None)
    chains = {edge: (joint,) for edge, joint in JOINT_OF_EDGE.items()}
    chains |= {"left_hand": ("LeftHand",), "right_hand": ("RightHand",), "crown": (_CROWN,)}
    options = Options(clavicle=1.0, aimed=frozenset(skeleton.EDGE_NAMES), palms=0.0, clear_body=0.0, limits=False)
    pair = tuple(Leg(*(bones.row(side + name) for name, _, _ in _LEG)) for side in ("Left", "Right") if moves)
    about = {"hands": motion.hands, "pelvis": motion.pelvis, "legs": Legs(bones.row("Hips"), pair) if moves else None}
    goals = Goals(bones, Mapping(chains, hips="Hips"), motion.directions, motion.fps, options, **about)
    found, still = goals.extras() | rotations(goals), np.zeros((len(motion.directions), 3))
    names = [name for name, _, _ in _joints(moves, motion.hands is not None)]
    angles = [quaternion.to_euler(found[name], _ORDER) if name in found else still for name in names]
    places = goals.stood.places["Hips"] if goals.stood is not None else still
    return places + [0.0, HIPS_HEIGHT, 0.0], np.stack(angles, 1)
