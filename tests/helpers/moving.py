"""Small files in the layouts of data sets: a person in BVH and SMPL-X who raises the left arm forwards, sound, words."""

import json
import wave

import numpy as np
from s2ag.core.motion import skeleton

DOWN, FORWARD = [0, 1, 0], [0, 0, 1]
LEFT_FOREARM, RIGHT_FOREARM = 5, 8
_CHAIN = """
Hips - 0 90 0, Spine Hips 0 13.2 -1.6, Spine1 Spine 0 8.6 0, Spine2 Spine1 0 8.6 0, Spine3 Spine2 0 8.6 0,
Neck Spine3 0 11.1 1.1, Neck1 Neck 0 7.1 0, Head Neck1 0 7.1 0, RightShoulder Spine3 0 7.9 5.2,
RightArm RightShoulder -18.4 0 0,
RightForeArm RightArm -29.1 0 0, RightHand RightForeArm -24.7 0 0, LeftShoulder Spine3 0 7.9 5.2, LeftArm LeftShoulder 18.4 0 0,
LeftForeArm LeftArm 29.1 0 0, LeftHand LeftForeArm 24.7 0 0, RightUpLeg Hips -9 0 0, LeftUpLeg Hips 9 0 0
"""
"""Trinity's chain and offsets in centimetres (reference D.3), fingers and feet left out."""
_PARTS = [part.split() for part in _CHAIN.replace("\n", " ").split(",")]
JOINTS = [(name, None if parent == "-" else parent, tuple(map(float, place))) for name, parent, *place in _PARTS]
TALKING = {
    "Hips": "b_root", "Spine": "b_spine0", "Spine1": "b_spine1", "Spine2": "b_spine2", "Spine3": "b_spine3",
    "Neck": "b_neck0", "Neck1": "b_neck0", "Head": "b_head",
    **{f"{side}{part}": f"b_{side[0].lower()}_{name}" for side in ("Left", "Right") for part, name in (
        ("Shoulder", "shoulder"), ("Arm", "arm"), ("ForeArm", "forearm"), ("Hand", "wrist"), ("UpLeg", "upleg"))},
}  # fmt: skip
"""Trinity's names in those of Talking With Hands (GENEA 2022 and 2023), whose neck is one joint."""


def talking(path, frames=150):
    """The same person as GENEA 2022 and 2023 have it: thirty frames a second, a root above the hips, six channels a joint.

    Between arm and forearm, and before the wrist, lies a joint for the twist, as there.
    """
    children = {"b_spine3": ["b_neck0", "b_r_shoulder", "b_l_shoulder"], "b_root": ["b_spine0", "b_r_upleg", "b_l_upleg"]}
    for one, after in (("b_spine0", "b_spine1"), ("b_spine1", "b_spine2"), ("b_spine2", "b_spine3"), ("b_neck0", "b_head")):
        children[one] = [after]
    places = {TALKING[name]: place for name, _, place in JOINTS if name != "Neck1"} | {"b_root": (0.0, 92.0, 0.0)}
    for side, sign in (("l", 1), ("r", -1)):
        limbs = ("shoulder", "arm", "arm_twist", "forearm", "wrist_twist", "wrist")
        chain = [f"b_{side}_{part}" for part in limbs]
        children |= {one: [after] for one, after in zip(chain, chain[1:], strict=False)}
        for one, length in (("arm_twist", 14.0), ("forearm", 15.1), ("wrist_twist", 12.0), ("wrist", 12.7)):
            places[f"b_{side}_{one}"] = (sign * length, 0.0, 0.0)
    children["body_world"], places["body_world"] = ["b_root"], (0.0, 0.0, 0.0)
    lines, names = ["HIERARCHY"], []

    def write(name):
        x, y, z = places[name]
        names.append(name)
        lines.append(f"{'JOINT' if lines[1:] else 'ROOT'} {name}\n{{\nOFFSET {x} {y} {z}")
        lines.append("CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation")
        for child in children.get(name, ()):
            write(child)
        lines.extend([] if name in children else ["End Site\n{\nOFFSET 0 5 0\n}"])
        lines.append("}")

    write("body_world")
    rows = []
    for frame in range(frames):
        turns = {"b_l_arm": (-90, 0, 0), "b_r_arm": (90, 0, 0), "b_l_forearm": (0, 0, -90 * frame / (frames - 1))}
        rows.append(" ".join(f"{v:.5f}" for name in names for v in (*places[name], *turns.get(name, (0, 0, 0)))))
    path.write_text("\n".join(lines) + f"\nMOTION\nFrames: {frames}\nFrame Time: 0.0333333\n" + "\n".join(rows) + "\n")


def bvh(path, frames=300, fps=60.0, hips_yaw=0.0, arm=None, z_up=False):
    """Arms hang, the left forearm points forwards as far as ``arm`` ``(frames,)`` in 0..1 says."""
    arm = np.linspace(0, 1, frames) if arm is None else np.asarray(arm)
    lines = ["HIERARCHY"]

    def offset(value):
        x, y, z = value
        return f"{x} {-z} {y}" if z_up else f"{x} {y} {z}"

    def write(name, depth):
        parent, place = next((p, o) for n, p, o in JOINTS if n == name)
        tab = "\t" * depth
        lines.append(f"{tab}{'JOINT' if parent else 'ROOT'} {name}\n{tab}{{\n{tab}\tOFFSET {offset(place)}")
        positions = "Xposition Yposition Zposition " if not parent else ""
        lines.append(f"{tab}\tCHANNELS {6 if not parent else 3} {positions}Zrotation Xrotation Yrotation")
        children = [n for n, p, _ in JOINTS if p == name]
        for child in children:
            write(child, depth + 1)
        if not children:
            lines.append(f"{tab}\tEnd Site\n{tab}\t{{\n{tab}\t\tOFFSET {offset((0, 5, 0))}\n{tab}\t}}")
        lines.append(f"{tab}}}")
        order.append(name)

    order: list[str] = []
    write("Hips", 0)
    names = [line.split()[1] for line in "\n".join(lines).splitlines() if line.split()[0] in ("ROOT", "JOINT")]
    rows = []
    for frame in range(frames):
        row = []
        for name in names:
            z, x, y = 0.0, 0.0, 0.0
            if name == "Hips":
                row += [float(v) for v in offset((3, 90, 7)).split()]
                y = hips_yaw
            if name == "LeftArm":
                z = -90.0
            if name == "RightArm":
                z = 90.0
            if name == "LeftForeArm":
                y = -90.0 * arm[frame]
            row += [z, x, y] if not z_up else [y, x, z]
        rows.append(" ".join(f"{value:.5f}" for value in row))
    path.write_text("\n".join(lines) + f"\nMOTION\nFrames: {frames}\nFrame Time: {1 / fps:.7f}\n" + "\n".join(rows) + "\n")


def smplx(path, frames=150, fps=30):
    """Arms hang, the left forearm comes forwards."""
    poses = np.zeros((frames, 165))
    poses[:, 16 * 3 + 2], poses[:, 17 * 3 + 2] = -np.pi / 2, np.pi / 2
    poses[:, 18 * 3 + 1] = -np.pi / 2 * np.linspace(0, 1, frames)
    np.savez(path, poses=poses, trans=np.zeros((frames, 3)), betas=np.zeros(300), mocap_frame_rate=np.array(fps))


def sound(path, seconds=5.0, rate=16000):
    """Noise in bursts."""
    rng = np.random.default_rng(0)
    time = np.arange(int(seconds * rate)) / rate
    samples = rng.normal(0, 3000, len(time)) * (np.sin(2 * np.pi * 1.5 * time) > 0)
    with wave.open(str(path), "wb") as file:
        file.setparams((1, 2, rate, 0, "NONE", ""))
        file.writeframes(samples.astype("<i2").tobytes())


def google(path):
    """A transcript as GENEA 2020 has it."""
    words = [
        {"start_time": "0.400s", "end_time": "0.800s", "word": "deep"},
        {"start_time": "1s", "end_time": "1.500s", "word": "water"},
    ]
    path.write_text(json.dumps([{"alternatives": [{"words": words}]}, {"alternatives": []}]))


def textgrid(path):
    """A transcript as BEAT2 has it."""

    def tier(number, name, intervals):
        head = f'    item [{number}]:\n        class = "IntervalTier"\n        name = "{name}"\n'
        head += "        xmin = 0\n        xmax = 5\n"
        lines = [f"        intervals: size = {len(intervals)}\n"]
        for row, (start, end, text) in enumerate(intervals, 1):
            indent = "            "
            lines.append(f'        intervals [{row}]:\n{indent}xmin = {start}\n{indent}xmax = {end}\n{indent}text = "{text}"\n')
        return head + "".join(lines)

    start = 'File type = "ooTextFile"\nObject class = "TextGrid"\n\nxmin = 0\nxmax = 5\ntiers? <exists>\nsize = 2\nitem []:\n'
    words = [(0, 1.2, ""), (1.2, 1.7, 'say ""hi""'), (2.0, 2.5, "friend")]
    path.write_text(start + tier(1, "phones", [(0, 5, "AH0")]) + tier(2, "words", words))


def check(directions):
    """Assert that canonical ``directions`` show this person: arms hang, the left forearm rises, the head is upright."""
    np.testing.assert_allclose(directions[:, [4, 7, RIGHT_FOREARM]], np.broadcast_to(DOWN, (len(directions), 3, 3)), atol=0.08)
    np.testing.assert_allclose(directions[0, LEFT_FOREARM], DOWN, atol=0.08)
    np.testing.assert_allclose(directions[-1, LEFT_FOREARM], FORWARD, atol=0.08)
    assert (directions[:, 3, 0] < -0.5).all() and (directions[:, 6, 0] > 0.5).all()  # the left lies at -x
    upright = skeleton.MEAN_UNIT[[0, 1, 2]]
    assert (np.degrees(np.arccos(np.clip((directions[0, :3] * upright).sum(-1), -1, 1))) < 12).all()
