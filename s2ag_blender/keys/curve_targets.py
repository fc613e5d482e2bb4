"""Bends F-curves so that they pass through given values on some frames, with smooth transitions before and after."""

from collections.abc import Collection, Sequence

import bpy
import numpy as np

from . import keyframes, layers

EASE = 0.3
"""Seconds of the transition before and after a target."""
Targets = dict[tuple[str, int], tuple[np.ndarray, np.ndarray]]
"""``{(data path, index): (ascending frames (n,), values (n,))}``."""


def curve_values(action: bpy.types.Action, frames: Sequence[float], bones: Collection[str] | None = None) -> Targets:
    """Return the values of an action's curves at these frames, of some bones or of all."""
    paths = None if bones is None else tuple(f'pose.bones["{bpy.utils.escape_identifier(bone)}"].' for bone in bones)
    at = np.array(sorted(set(frames)), float)
    return {
        (curve.data_path, curve.array_index): (at, np.array([curve.evaluate(frame) for frame in at]))
        for curve in layers.own_curves(action)
        if curve.data_path.startswith(paths or "pose.bones[")
    }


def lead_through(action: bpy.types.Action, targets: Targets, fps: float) -> None:
    """Bend the curves of an action through ``targets``; those that do not pass there get keys with exactly these values."""
    present = {(curve.data_path, curve.array_index): curve for curve in layers.own_curves(action)}
    for path in dict.fromkeys(path for path, _ in targets):
        curves = {index: present[path, index] for one, index in targets if one == path and (path, index) in present}
        if not curves:
            continue
        at = targets[path, min(curves)][0]
        target = {index: targets[path, index][1] for index in curves}
        now = {index: np.array([curve.evaluate(frame) for frame in at]) for index, curve in curves.items()}
        if path.endswith("rotation_quaternion"):  # both signs are the same rotation
            sign = np.where(sum(target[index] * now[index] for index in curves) < 0, -1.0, 1.0)
            target = {index: sign * column for index, column in target.items()}
        if all(np.allclose(target[index], now[index], rtol=0, atol=1e-6) for index in curves):
            continue
        for index, curve in curves.items():
            _lead(curve, at, target[index], target[index] - now[index], EASE * fps)


def _lead(curve: bpy.types.FCurve, at: np.ndarray, target: np.ndarray, apart: np.ndarray, room: float) -> None:
    """Bend one curve through ``target`` at frames ``at``, ``apart`` from its values there, within ``room`` frames."""
    present = np.empty(len(curve.keyframe_points) * 2)
    curve.keyframe_points.foreach_get("co", present)
    for frame in at[~np.isclose(at[:, None], present[None, ::2], atol=1e-3).any(1)]:
        curve.keyframe_points.insert(frame, curve.evaluate(frame))
    keys = keyframes.columns(curve.keyframe_points)
    for name in ("co", "handle_left", "handle_right"):
        keys[name][:, 1] += _offset(keys[name][:, 0], at, apart, room)
    rows = np.abs(keys["co"][:, None, 0] - at).argmin(0)
    keys["co"][rows, 1] = target
    keyframes.replace_keys(curve, keys)


def _offset(frames: np.ndarray, at: np.ndarray, apart: np.ndarray, room: float) -> np.ndarray:
    """Return the offsets of a curve on ``frames``: ``apart`` at ``at``, smooth between, 0 from ``room`` frames away."""
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
    share = share**3 * (10 - 15 * share + 6 * share**2)  # zero velocity and acceleration at both ends
    return moved[place] + share * (moved[place + 1] - moved[place])
