"""Rigs with twist bones in the chain, scapulas and end bones, and the meshes that tell which bone carries what.

Each kind is a list of an arm's bones below the chest: name, where it starts and which stretch of skin hangs on it, both
along the arm: 0 collar, 1 shoulder, 2 elbow, 3 wrist, 4 finger tips.
"""

import numpy as np
import skeletons
from bodies import Body

FACING_X = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
KINDS = {
    "trailing": [
        ("scapula", 0, (0, 1)),
        ("arm", 1, (1, 1.8)),
        ("arm_twist", 1, (1.8, 2)),
        ("forearm", 2, (2, 2.5)),
        ("wrist_twist", 2.6, (2.5, 3)),
        ("wrist", 3, (3, 4)),
    ],
    "leading": [
        ("scapula", 0, (0, 1)),
        ("arm_twist", 1, (1, 1.3)),
        ("arm", 1, (1.3, 2)),
        ("forearm_twist", 2, (2, 2.4)),
        ("forearm", 2, (2.4, 3)),
        ("wrist", 3, (3, 4)),
    ],
    "middle": [
        ("scapula", 0, (0, 1)),
        ("arm", 1, (1, 1.5)),
        ("arm_twist", 1.5, (1.5, 2)),
        ("forearm", 2, (2, 2.5)),
        ("wrist_twist", 2.5, (2.5, 3)),
        ("wrist", 3, (3, 4)),
    ],
    "ahead": [  # the twist bone starts a little further along than the bone that carries the arm
        ("scapula", 0, (0, 1)),
        ("arm", 0.97, (0.97, 1.9)),
        ("arm_twist", 1.05, (1.9, 2)),
        ("forearm", 2, (2, 2.9)),
        ("wrist_twist", 3, (2.9, 3)),
        ("wrist", 3, (3, 4)),
    ],
    "late": [  # twist bones stand at the end of what they carry
        ("scapula", 0, (0, 1)),
        ("arm", 1, (1, 1.5)),
        ("arm_twist", 2, (1.5, 2)),
        ("forearm", 2, (2, 2.5)),
        ("wrist_twist", 3, (2.5, 3)),
        ("wrist", 3, (3, 4)),
    ],
}
CHAINS = {
    "trailing": (("arm", "arm_twist"), ("forearm", "wrist_twist")),
    "leading": (("arm_twist", "arm"), ("forearm_twist", "forearm")),
    "middle": (("arm", "arm_twist"), ("forearm", "wrist_twist")),
    "ahead": (("arm", "arm_twist"), ("forearm", "wrist_twist")),
    "late": (("arm", "arm_twist"), ("forearm", "wrist_twist")),
}
"""Which bones are the upper arm and the forearm of each kind."""


def along(side: str, pose: str, place: float) -> np.ndarray:
    """Where on an arm (3,) a place from 0 to 4 is."""
    joints = list(skeletons.arm_joints(side, pose).values())
    joints[4] = joints[3] + 2 * (joints[4] - joints[3])
    step = min(int(place), 3)
    return joints[step] + (place - step) * (joints[step + 1] - joints[step])


def person(kind: str, pose: str = "T", fingers: bool = True, name: str = "b_{side}_{bone}") -> Body:
    """A person whose arms are of one kind, in metres, facing -y; without fingers, end bones stand there."""
    joints = {"b_root": (np.zeros(3), None), "b_hip": (np.array((0, 0.01, 0.98)), "b_root")}
    above = "b_hip"
    for link in range(3):
        joints[f"b_spine{link + 1}"] = (np.array((0, 0, 1.05 + 0.12 * link)), above)
        above = f"b_spine{link + 1}"
    joints |= {"b_neck": (np.array((0, 0.01, 1.46)), above), "b_head": (np.array((0, -0.01, 1.58)), "b_neck")}
    joints["b_head_End"] = (np.array((0, -0.01, 1.8)), "b_head")
    for side, letter in (("left", "l"), ("right", "r")):
        last = above
        for bone, place, _ in KINDS[kind]:
            joints[spelt(name, letter, bone)] = (along(side, pose, place), last)
            last = spelt(name, letter, bone)
        if fingers:
            points = skeletons.arm_joints(side, pose)
            skeletons.add_fingers(joints, last, points["hand"], points["tip"], f"b_{letter}_finger_")
        else:
            joints[f"{last}_End"] = (along(side, pose, 4), last)
    skeletons.add_legs(joints, "b_hip", "b_leg")
    upper, fore = CHAINS[kind]
    chains = {"torso": ("b_spine1", "b_spine2", "b_spine3"), "neck": ("b_neck",), "head": ("b_head",)}
    for side, letter in (("left", "l"), ("right", "r")):
        parts = {"clavicle": ("scapula",), "upper_arm": upper, "forearm": fore, "hand": ("wrist",)}
        chains |= {f"{side}_{part}": tuple(spelt(name, letter, one) for one in bones) for part, bones in parts.items()}
    return Body(joints, chains, "b_hip")


def spelt(name: str, letter: str, bone: str) -> str:
    """A bone's name by the pattern of its rig."""
    return name.format(side=letter, bone=bone)


def tubes(kind: str, pose: str = "T", name: str = "b_{side}_{bone}", rings: int = 12) -> list[tuple]:
    """Tubes ``(bone, start (3,), end (3,), radius, rings)`` that make the body's skin, one for each stretch of a bone's."""
    found = [("b_hip", (0, 0, 0.9), (0, 0, 1.05), 0.14, 4), ("b_head", (0, 0, 1.6), (0, 0, 1.8), 0.09, 6)]
    found += [(f"b_spine{n + 1}", (0, 0, 1.05 + 0.12 * n), (0, 0, 1.17 + 0.12 * n), 0.13, 4) for n in range(3)]
    found += [("b_neck", (0, 0, 1.41), (0, 0, 1.6), 0.05, 4), ("b_head", (0, -0.13, 1.66), (0, -0.05, 1.66), 0.02, 3)]
    for side, letter in (("left", "l"), ("right", "r")):
        for bone, _, (start, end) in KINDS[kind]:
            radius = 0.05 - 0.008 * start
            count = max(2, round(rings * (end - start)))
            found.append((spelt(name, letter, bone), along(side, pose, start), along(side, pose, end), radius, count))
        for link, (high, low) in enumerate(((0.93, 0.5), (0.5, 0.09))):
            sign = skeletons.SIGN[side]
            found.append((f"b_leg_{side}_{link}", (0.1 * sign, 0, high), (0.1 * sign, 0, low), 0.06, 4))
        found.append((f"b_leg_{side}_2", (0.1 * sign, 0.05, 0.04), (0.1 * sign, -0.15, 0.03), 0.035, 3))
    return [(bone, np.asarray(start, float), np.asarray(end, float), *rest) for bone, start, end, *rest in found]


def skinned(kind, pose="T", *, facing=None, scale=0.01, name="b_{side}_{bone}", fingers=True):
    """The armature object and its mesh: centimetres in an object scaled by ``scale``, turned by ``facing`` (3, 3)."""
    import bpy
    import rigging

    facing, size = np.eye(3) if facing is None else facing, 1 / scale
    body = person(kind, pose, fingers, name)
    joints = {joint: (size * (facing @ np.asarray(at, float)), above) for joint, (at, above) in body.joints.items()}
    item = rigging.make_armature(Body(joints, body.chains, body.hips), kind)
    vertices, faces, hung = [], [], []
    for bone, start, end, radius, rings in tubes(kind, pose, name):
        axis = (end - start) / np.linalg.norm(end - start)
        out = np.cross(axis, (0.3, 0.5, 0.8))
        out = out / np.linalg.norm(out)
        ring = [np.cos(a) * out + np.sin(a) * np.cross(axis, out) for a in np.arange(8) * np.pi / 4]
        first = len(vertices)
        for step in range(rings + 1):
            vertices += [size * (facing @ (start + (end - start) * step / rings + radius * spoke)) for spoke in ring]
        hung += [bone] * (8 * (rings + 1))
        quads = [(step * 8 + k, step * 8 + (k + 1) % 8) for step in range(rings) for k in range(8)]
        faces += [(first + a, first + b, first + b + 8, first + a + 8) for a, b in quads]
    data = bpy.data.meshes.new(kind)
    data.from_pydata([tuple(vertex) for vertex in vertices], [], faces)
    mesh = bpy.data.objects.new(f"{kind} mesh", data)
    for bone in dict.fromkeys(hung):
        mesh.vertex_groups.new(name=bone).add([index for index, one in enumerate(hung) if one == bone], 1.0, "REPLACE")
    bpy.context.collection.objects.link(mesh)
    mesh.parent = item
    modifier = mesh.modifiers.new("Armature", "ARMATURE")
    modifier.object = item
    item.scale = (scale,) * 3
    bpy.context.view_layer.update()
    return item, mesh, body
