"""A plain head for looking at faces: a plate with lips, lids and brows, moved by shape keys with a family's names."""

import bpy
import numpy as np

_COLOURS = {"plate": (0.7, 0.5, 0.4), "upper": (0.5, 0.1, 0.1), "lower": (0.5, 0.1, 0.1), "lid": (0.45, 0.25, 0.2),
            "brow": (0.05, 0.03, 0.02), "hole": (0.03, 0.0, 0.0), "eye": (0.9, 0.9, 0.9), "iris": (0.05, 0.1, 0.3)}  # fmt: skip
VRM = {
    "A": {"jawOpen": 0.45},
    "I": {"mouthStretchLeft": 0.8, "mouthStretchRight": 0.8, "mouthLowerDownLeft": 0.4, "mouthLowerDownRight": 0.4},
    "U": {"mouthPucker": 0.9, "jawOpen": 0.1},
    "E": {"jawOpen": 0.2, "mouthStretchLeft": 0.4, "mouthStretchRight": 0.4},
    "O": {"mouthFunnel": 0.8, "jawOpen": 0.2},
    "Blink": {"eyeBlinkLeft": 1, "eyeBlinkRight": 1},
    "Joy": {"mouthSmileLeft": 1, "mouthSmileRight": 1},
    "Sorrow": {"mouthFrownLeft": 1, "mouthFrownRight": 1},
    "LookUp": {"eyeLookUpLeft": 1, "eyeLookUpRight": 1},
    "LookDown": {"eyeLookDownLeft": 1, "eyeLookDownRight": 1},
    "LookLeft": {"eyeLookOutLeft": 1, "eyeLookInRight": 1},
    "LookRight": {"eyeLookInLeft": 1, "eyeLookOutRight": 1},
}
"""The names of VRM 0, each mixed of ARKit's, as makers of such characters do."""
_N = 13


def build(armature, mixed: dict | None = None, size: float = 0.1):
    """A head on ``armature`` with ARKit's names, or with the names of ``mixed``, each a mixture ``{ARKit's name: weight}``."""
    points, faces, parts = _mesh()
    mesh = bpy.data.meshes.new("Plain head")
    mesh.from_pydata((points * size).tolist(), [], faces)
    for colour in _COLOURS.values():
        material = bpy.data.materials.new("Plain")
        material.diffuse_color = (*colour, 1)
        mesh.materials.append(material)
    names = list(_COLOURS)
    mesh.polygons.foreach_set("material_index", [names.index(parts[face[0]]) for face in faces])
    item = bpy.data.objects.new("Plain head", mesh)
    bpy.context.scene.collection.objects.link(item)
    item.parent = armature
    item.shape_key_add(name="Basis", from_mix=False)
    units = _units(points, np.array(parts))
    keys = {name: {name: 1.0} for name in units} if mixed is None else mixed
    for name, mixture in keys.items():
        moved = points + sum(weight * units[unit] for unit, weight in mixture.items())
        block = item.shape_key_add(name=name, from_mix=False)
        block.data.foreach_set("co", (moved * size).astype(np.float32).ravel())
        block.value = 0
    return item


def named_keys(armature, names):
    """Shape keys of these names, which move nothing, on a triangle of the character; returns them all, the basis first."""
    mesh = bpy.data.meshes.new("Box")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    item = bpy.data.objects.new("Box", mesh)
    bpy.context.scene.collection.objects.link(item)
    item.parent = armature
    for name in ("Basis", *names):
        item.shape_key_add(name=name, from_mix=False).value = 0.0
    return mesh.shape_keys


def gap(item) -> float:
    """How far the lips of a head are apart in the middle, in units of its size."""
    evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    flat = np.empty(3 * len(evaluated.data.vertices), np.float32)
    evaluated.data.vertices.foreach_get("co", flat)
    parts, heights = np.array(_mesh()[2]), flat.reshape(-1, 3)[:, 2]
    upper, lower = (heights[parts == name].reshape(2, _N)[:, _N // 2] for name in ("upper", "lower"))
    return float(upper.min() - lower.max()) / 0.1


def _mesh():
    points, faces, parts = [], [], []

    def strip(part, low, high, depth):
        base = len(points)
        for edge in (low, high):
            points.extend((x, depth, z) for x, z in edge)
        parts.extend([part] * (len(low) + len(high)))
        count = len(low)
        faces.extend([base + k, base + k + 1, base + count + k + 1, base + count + k] for k in range(count - 1))

    def line(left, right, height, bow=0.0):
        x = np.linspace(left, right, _N)
        return [(a, height + bow * (1 - ((a - (left + right) / 2) * 2 / (right - left)) ** 2)) for a in x]

    strip("plate", line(-1, 1, -1.2, -0.3), line(-1, 1, 1.1, 0.3), 0.2)
    strip("hole", line(-0.42, 0.42, -0.6), line(-0.42, 0.42, -0.6), 0.1)
    strip("lower", line(-0.45, 0.45, -0.6, -0.16), line(-0.45, 0.45, -0.6), 0.0)
    strip("upper", line(-0.45, 0.45, -0.6), line(-0.45, 0.45, -0.6, 0.14), 0.0)
    for side in (0.45, -0.45):
        strip("eye", line(side - 0.2, side + 0.2, 0.25, -0.12), line(side - 0.2, side + 0.2, 0.25, 0.12), 0.05)
        strip("iris", line(side - 0.07, side + 0.07, 0.25, -0.07), line(side - 0.07, side + 0.07, 0.25, 0.07), 0.04)
        strip("lid", line(side - 0.22, side + 0.22, 0.36, 0.03), line(side - 0.22, side + 0.22, 0.42, 0.03), 0.0)
        strip("brow", line(side - 0.25, side + 0.25, 0.55, 0.05), line(side - 0.25, side + 0.25, 0.62, 0.05), 0.0)
    return np.array(points), faces, parts


def _units(points, parts) -> dict[str, np.ndarray]:
    x, z = points[:, 0], points[:, 2]
    left = {"Left": x > 0.02, "Right": x < -0.02}
    middle = np.clip(1 - (x / 0.45) ** 2, 0, 1)
    lower, upper, hole = parts == "lower", parts == "upper", parts == "hole"
    lips = lower | upper | hole
    hollow = hole & (np.cumsum(hole) <= _N)  # its lower edge

    def move(rows, dx=0.0, dz=0.0):
        result = np.zeros_like(points)
        result[:, 0], result[:, 2] = rows * dx, rows * dz
        return result

    brow, lid = parts == "brow", (parts == "lid") & (z < 0.4)
    units = {
        "jawOpen": move(lower | hollow, dz=-0.9 * middle) + move(parts == "plate", dz=-0.25 * (z < -1)),
        "mouthPucker": move(lips, dx=-0.5 * x),
        "mouthFunnel": move(lips, -0.3 * x) + move(upper, dz=0.12 * middle) + move(lower | hollow, dz=-0.2 * middle),
        "mouthRollLower": move(lower, dz=0.1 * (z + 0.6) + 0.05 * middle),
        "browInnerUp": move(brow, dz=0.12),
    }
    for side in ("Left", "Right"):
        here = left[side]
        units |= {
            f"mouthStretch{side}": move(lips & here, dx=0.35 * x),
            f"mouthSmile{side}": move(lips & here, 0.2 * x, 0.5 * x**2),
            f"mouthFrown{side}": move(lips & here, dz=-0.8 * x**2),
            f"mouthLowerDown{side}": move((lower | hollow) & here, dz=-0.2 * middle),
            f"mouthUpperUp{side}": move((upper | hole & ~hollow) & here, dz=0.12 * middle),
            f"eyeBlink{side}": move(lid & here, dz=-0.24),
            f"browOuterUp{side}": move(brow & here, dz=0.1),
            f"browDown{side}": move(brow & here, dz=-0.1),
        }
        iris = (parts == "iris") & here
        out = 1 if side == "Left" else -1
        for name, dx, dz in (("Up", 0, 0.08), ("Down", 0, -0.08), ("Out", 0.1 * out, 0), ("In", -0.1 * out, 0)):
            units[f"eyeLook{name}{side}"] = move(iris, dx, dz)
    return units
