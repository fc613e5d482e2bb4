"""Curves led through given values on some frames, so that what is before and behind flows into them and out of them."""

from collections.abc import Collection, Sequence

import bpy
import numpy as np

from . import keyframes, layers

EASE = 0.3
"""Seconds in which a curve comes to what it is led through, and goes from it."""
Targets = dict[tuple[str, int], tuple[np.ndarray, np.ndarray]]
"""Data path and index of a curve -> frames (n,) in order and its values (n,) there."""


def values(action: bpy.types.Action, frames: Sequence[float], bones: Collection[str] | None = None) -> Targets:
    """What the curves of an action have on these frames: those of some bones, or of all."""
    paths = None if bones is None else tuple(f'pose.bones["{bpy.utils.escape_identifier(bone)}"].' for bone in bones)
    at = np.array(sorted(set(frames)), float)
    return {
        (curve.data_path, curve.array_index): (at, np.array([curve.evaluate(frame) for frame in at]))
        for curve in layers.own_curves(action)
        if curve.data_path.startswith(paths or "pose.bones[")
    }


def lead(action: bpy.types.Action, targets: Targets, fps: float) -> None:
    """Lead curves of an action through ``targets``; there they have keys and exactly these values."""
    there = {(curve.data_path, curve.array_index): curve for curve in layers.own_curves(action)}
    for path in dict.fromkeys(path for path, _ in targets):
        curves = {index: there[path, index] for one, index in targets if one == path and (path, index) in there}
        if not curves:
            continue
        at = targets[path, min(curves)][0]
        wanted = {index: targets[path, index][1] for index in curves}
        now = {index: np.array([curve.evaluate(frame) for frame in at]) for index, curve in curves.items()}
        if path.endswith("rotation_quaternion"):  # both signs are the same rotation
            turned = np.where(sum(wanted[index] * now[index] for index in curves) < 0, -1.0, 1.0)
            wanted = {index: turned * column for index, column in wanted.items()}
        for index, curve in curves.items():
            _lead(curve, at, wanted[index], wanted[index] - now[index], EASE * fps)


def _lead(curve: bpy.types.FCurve, at: np.ndarray, wanted: np.ndarray, apart: np.ndarray, room: float) -> None:
    present = np.empty(len(curve.keyframe_points) * 2)
    curve.keyframe_points.foreach_get("co", present)
    for frame in at[~np.isclose(at[:, None], present[None, ::2], atol=1e-3).any(1)]:
        curve.keyframe_points.insert(frame, curve.evaluate(frame))
    keys = keyframes.columns(curve.keyframe_points)
    for name in ("co", "handle_left", "handle_right"):
        keys[name][:, 1] += _offset(keys[name][:, 0], at, apart, room)
    rows = np.abs(keys["co"][:, None, 0] - at).argmin(0)
    keys["co"][rows, 1] = wanted
    keyframes.replace(curve, keys)


def _offset(frames: np.ndarray, at: np.ndarray, apart: np.ndarray, room: float) -> np.ndarray:
    """By how much to move a curve on ``frames`` for it to be moved by ``apart`` at ``at``, evenly, and by nothing far away."""
    knots, moved = [at[0] - room], [0.0]
    for number, frame in enumerate(at):
        knots.append(frame)
        moved.append(apart[number])
        after = at[number + 1] if number + 1 < len(at) else np.inf
        if after - frame > 2 * room:
            knots += [frame + room, after - room] if np.isfinite(after) else [frame + room]
            moved += [0.0, 0.0] if np.isfinite(after) else [0.0]
    knots, moved = np.array(knots), np.array(moved)
    place = np.clip(np.searchsorted(knots, frames, side="right") - 1, 0, len(knots) - 2)
    share = np.clip((frames - knots[place]) / np.maximum(knots[place + 1] - knots[place], 1e-6), 0, 1)
    share = share**3 * (10 - 15 * share + 6 * share**2)  # without a jerk at either end
    return moved[place] + share * (moved[place + 1] - moved[place])
