"""Golden keys: what a stored take (:data:`golden.TAKE`) becomes on three characters in Blender."""

import bpy
import golden
import numpy as np
from s2ag.core.motion.motion import Motion
from s2ag.s2ag_blender import compat
from s2ag.s2ag_blender.characters import loading
from s2ag.s2ag_blender.keys.apply import apply_motion

STEP = 15
"""Of how many keys of a curve one is stored."""


def keys(character: str) -> dict[str, np.ndarray]:
    """Sampled values of all F-curves on a character and its meshes, by data path, with their components in columns."""
    _, (actor,), _ = loading.build_scene([(character, "female", None, None)])
    bpy.context.scene.render.fps = 24
    action = apply_motion(actor.armature, Motion.load(golden.TAKE), 1)
    shapes = [mesh.data.shape_keys for mesh in actor.meshes if mesh.data.shape_keys is not None]
    played = [item.animation_data.action for item in shapes if item.animation_data and item.animation_data.action]
    curves: dict[str, list] = {}
    for curve in sorted((one for each in {action, *played} for one in compat.curves(each)), key=lambda one: one.array_index):
        values = np.empty(2 * len(curve.keyframe_points), np.float32)
        curve.keyframe_points.foreach_get("co", values)
        curves.setdefault(curve.data_path, []).append(values[1::2][::STEP].astype(float))
    return {path: np.stack(columns, -1) for path, columns in sorted(curves.items())}


def pack_all() -> dict[str, np.ndarray]:
    """Keys of all characters as they are stored."""
    packed = {}
    for character in golden.RIGS:
        packed |= golden.pack({f"{character}|{path}": values for path, values in keys(character).items()})
    return packed
