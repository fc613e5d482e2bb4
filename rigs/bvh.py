"""Writes a motion as a BVH file with a skeleton of its own, which any animation program reads.

Frame: y up, z forward, left at +x. Unit: metres unless ``unit`` says otherwise. Each of the nine edges of a motion becomes
one joint with its Mixamo name, so that rigs and programs recognise it; the hips stay still. A motion with hands gets
turning hands and fingers; one with a pelvis gets moving hips and legs whose feet stay in place. The rest pose is a T: arms
out to the sides; torso, neck, head and clavicles along the mean of the data, so that zero rotations give an average posture.
"""

import os
from collections.abc import Sequence

import numpy as np

from ..core.files import atomic_file
from ..core.motion import quaternion, skeleton
from ..core.motion.motion import Motion
from .goals import Goals, Options
from .legs import Leg, Legs
from .relative_turns import NEUTRAL
from .retarget import rotations
from .skeleton import Bones, Mapping

_Joint = tuple[str, str | None, np.ndarray]
"""Name, parent and offset (3,) from it in metres."""

HIPS_HEIGHT = 0.9
SPINE_OFFSET = 0.1
HAND = 0.1
"""Metres: height of the hips above the floor, of the spine joint above the hips, length of a hand."""

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
"""The BVH joint at the start of an edge, whose rotation turns the edge."""

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
"""A left leg: joint (without "Left"), parent, offset in metres. The small offsets tell which way the knee bends."""
_FINGERS = {  # a left hand, palm down, metres: offset of the first joint from the wrist, then from joint to joint
    "Thumb": ((0.025, -0.012, 0.03), (0.028, -0.008, 0.022), (0.024, -0.004, 0.014), (0.02, -0.003, 0.01)),
    "Index": ((0.095, 0.0, 0.026), (0.042, 0.0, 0.003), (0.026, 0.0, 0.001), (0.02, 0.0, 0.0)),
    "Middle": ((0.1, 0.0, 0.004), (0.046, 0.0, 0.0), (0.03, 0.0, 0.0), (0.022, 0.0, 0.0)),
    "Ring": ((0.094, 0.0, -0.016), (0.043, 0.0, -0.002), (0.028, 0.0, -0.001), (0.021, 0.0, 0.0)),
    "Pinky": ((0.084, 0.0, -0.034), (0.034, 0.0, -0.004), (0.022, 0.0, -0.002), (0.018, 0.0, 0.0)),
}
_TOES = np.array([0.01, -0.06, 0.13])
_ENDS = {"Head": "head", "LeftHand": "left_forearm", "RightHand": "right_forearm"}
_CROWN = "crown"  # a helper bone for the solver at the end of the head; not written
_EULER_ORDER = "YXZ"  # in Blender's notation, y first; BVH lists channels from the outside in: Z X Y


def save(motion: Motion, path: str | os.PathLike, unit: float = 1.0) -> None:
    """Write ``motion`` at its own frame rate to ``path``, whole or not at all; ``unit`` is the length of a metre in the file.

    Raises :class:`OutputUnwritable`.
    """
    text = hierarchy(unit, motion.pelvis is not None, motion.hands is not None) + frames(motion, unit)
    with atomic_file(path) as temporary:
        temporary.write_text(text, "ascii")


def hierarchy(unit: float = 1.0, legs: bool = False, fingers: bool = False) -> str:
    """Return the HIERARCHY section: joints, offsets and channels."""
    lines = ["HIERARCHY"]
    _joint(lines, "Hips", "", unit, _joints(legs, fingers))
    return "\n".join(lines) + "\n"


def frames(motion: Motion, unit: float = 1.0) -> str:
    """Return the MOTION section: degrees with five decimals."""
    hips, angles = _solve(motion)
    angles = np.degrees(angles)[..., [2, 0, 1]]
    rows = np.concatenate([unit * hips, angles.reshape(len(angles), -1)], -1)
    body = "\n".join(" ".join(f"{value:.5f}" for value in row) for row in rows)
    return f"MOTION\nFrames: {len(rows)}\nFrame Time: {1.0 / motion.fps:.9f}\n{body}\n"


def _joints(legs: bool, fingers: bool) -> tuple[_Joint, ...]:
    """Return every joint, depth first as in the file."""
    joints: list[_Joint] = [(name, parent, _offset(name)) for name, parent, _ in _JOINTS]
    for side, sign in (("Left", 1.0), ("Right", -1.0)) if legs else ():
        for name, parent, offset in _LEG:
            joints.append((side + name, parent if parent == "Hips" else side + parent, np.array(offset) * [sign, 1, 1]))
    for hand, sign in (("LeftHand", 1.0), ("RightHand", -1.0)) if fingers else ():
        for finger, offsets in _FINGERS.items():
            names = [f"{hand}{finger}{number}" for number in range(1, len(offsets))]
            joints += [
                (name, parent, np.array(offset) * [sign, 1, 1])
                for name, parent, offset in zip(names, [hand, *names], offsets, strict=False)
            ]

    def below(above: str | None) -> list[_Joint]:
        return [item for joint in joints if joint[1] == above for item in (joint, *below(joint[0]))]

    return tuple(below(None))


def _joint(lines: list[str], name: str, indent: str, unit: float, joints: Sequence[_Joint]) -> None:
    """Append the lines of joint ``name`` and of all joints below it."""
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
    """Return rest directions (9, 3), y up: the mean of the data, with arms out to the sides."""
    rest = skeleton.canonical_to_y_up(NEUTRAL).astype(float)
    rest[[4, 5]], rest[[7, 8]] = [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]
    return rest


def _offset(name: str) -> np.ndarray:
    """Return the offset (3,) of a joint of the body from its parent, metres."""
    edge = next(edge for joint, _, edge in _JOINTS if joint == name)
    if edge is None:
        return np.array([0.0, SPINE_OFFSET if name == "Spine" else 0.0, 0.0])
    row = skeleton.EDGE_NAMES.index(edge)
    return _rest()[row] * skeleton.LENGTHS[row]


def _end(name: str) -> np.ndarray:
    """Return the offset (3,) from a joint without children to the end of its bone, metres."""
    side = [1 if name.startswith("Left") else -1, 1, 1]
    if name.endswith("Foot"):
        return _TOES * side
    finger = name[:-1].partition("Hand")[2]
    if finger:
        return np.array(_FINGERS[finger][-1]) * side
    row = skeleton.EDGE_NAMES.index(_ENDS[name])
    return _rest()[row] * (skeleton.LENGTHS[row] if name == "Head" else HAND)


def _bones(legs: bool, fingers: bool) -> Bones:
    """Return the skeleton at rest as bones with the axes of the file; helper bones after the joints mark the ends of chains."""
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


def _leg(bones: Bones, side: str) -> Leg:
    return Leg(*(bones.row(side + name) for name, _, _ in _LEG))


def _solve(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Return positions of the hips (frames, 3) in metres and Euler angles (frames, joints, 3), x, y, z, in radians."""
    has_pelvis = motion.pelvis is not None
    bones = _bones(has_pelvis, motion.hands is not None)
    chains = {edge: (joint,) for edge, joint in JOINT_OF_EDGE.items()}
    chains |= {"left_hand": ("LeftHand",), "right_hand": ("RightHand",), "crown": (_CROWN,)}
    options = Options(clavicle=1.0, aimed=frozenset(skeleton.EDGE_NAMES), palms=0.0, clear_body=False, limits=False)
    legs = Legs(bones.row("Hips"), (_leg(bones, "Left"), _leg(bones, "Right"))) if has_pelvis else None
    mapping = Mapping(chains, hips="Hips")
    goals = Goals(bones, mapping, motion.directions, motion.fps, options, hands=motion.hands, pelvis=motion.pelvis, legs=legs)
    rotation_of, still = goals.extras() | rotations(goals), np.zeros((len(motion.directions), 3))
    names = [name for name, _, _ in _joints(has_pelvis, motion.hands is not None)]
    angles = [quaternion.to_euler(rotation_of[name], _EULER_ORDER) if name in rotation_of else still for name in names]
    hips = goals.stood.places["Hips"] if goals.stood is not None else still
    return hips + [0.0, HIPS_HEIGHT, 0.0], np.stack(angles, 1)
