"""Restores the keys of a former action outside the frames that an edit was meant to change."""

from collections.abc import Sequence

import bpy
import numpy as np

from . import keyframes, layers


def restore_outside(former: bpy.types.Action, action: bpy.types.Action, spans: Sequence[tuple[float, float]]) -> None:
    """Give the curves of ``action`` the keys of ``former`` outside of ``spans`` of frames, and those that it lacks, which
    were keyed by hand."""
    former_curves = {(curve.data_path, curve.array_index): curve for curve in layers.own_curves(former)}
    for curve in layers.own_curves(action):
        old = former_curves.pop((curve.data_path, curve.array_index), None)
        if old is None:
            continue
        kept, new = keyframes.columns(old.keyframe_points), keyframes.columns(curve.keyframe_points)
        rows = [~_within(kept["co"][:, 0], spans), _within(new["co"][:, 0], spans)]
        if not rows[0].any():
            continue
        merged = {key: np.concatenate([kept[key][rows[0]], new[key][rows[1]]]) for key in kept}
        order = np.argsort(merged["co"][:, 0], kind="stable")
        keyframes.replace_keys(curve, {key: values[order] for key, values in merged.items()})
    bag = layers.own_bag(action)
    for (path, index), old in former_curves.items():
        curve = bag.fcurves.new(path, index=index)
        keyframes.replace_keys(curve, keyframes.columns(old.keyframe_points))
        if old.group is not None:
            curve.group = bag.groups.get(old.group.name) or bag.groups.new(old.group.name)


def _within(frames: np.ndarray, spans: Sequence[tuple[float, float]]) -> np.ndarray:
    inside = np.zeros(len(frames), bool)
    for low, high in spans:
        inside |= (frames >= low) & (frames <= high)
    return inside
