"""Reads a character's keyed sliders over time, and style changes at timeline markers."""

from typing import Any

import bpy
import numpy as np

from ...core import styles
from ...core.control_curves import HEARD_STEP
from ...core.errors import UnknownStyle
from ...core.motion import skeleton
from ...core.motion.interpolation import simplify_polyline
from ...core.settings import AFFECTS, CURVES
from ...core.synthesis import curves
from .. import compat, provenance
from ..datablocks import ArmatureObject, Bag
from ..keys import layers
from ..keys.apply import scene_fps
from ..translations import translate
from . import menu_items, timing

_PATHS = {f"s2ag.{name}": name for name in CURVES}
_STYLE_PREFIX = "as "
"""Prefix of the names of markers at which a style begins."""
_TOLERANCE, _HEARD_TOLERANCE = 2e-3, 0.05
"""Most deviation of a slider from the straight line between two of its points, and of what is heard from that of its keys."""


def keyed_curves(armature: ArmatureObject) -> dict[str, bpy.types.FCurve]:
    """Return the F-curves of keyed sliders, by name: of the active action, and of the one that a draft hides."""
    sliders, action = {}, armature.animation_data.action if armature.animation_data else None
    while action is not None:
        for curve in compat.curves(action, layers.slot_of(armature, action)):
            if curve.data_path in _PATHS and not curve.mute:
                sliders.setdefault(_PATHS[curve.data_path], curve)
        action = layers.below_draft(action)
    return sliders


def sample_curves(armature: ArmatureObject, scene: bpy.types.Scene, span: Any) -> dict[str, list[list[float]]]:
    """Return the keyed sliders for the engine, ``{name: [[seconds, value], ...]}``; ``span`` is a :class:`sources.Span`."""
    rate, keyed = scene_fps(scene), {}
    for name, curve in keyed_curves(armature).items():
        until = span.start + span.length if span.length is not None else max(curve.range()[1], scene.frame_end)
        seconds = np.arange(0, max(until - span.start, 1) / rate + 1 / skeleton.FPS, 1 / skeleton.FPS)
        prop: Any = armature.s2ag.bl_rna.properties[name]
        values = np.array([curve.evaluate(span.start + at * rate) for at in seconds.tolist()])
        points = np.stack([seconds, np.clip(values, prop.hard_min, prop.hard_max)], 1)
        keyed[name] = points[simplify_polyline(points[:, 1], _TOLERANCE)].round(4).tolist()
    return keyed


def style_changes(armature: ArmatureObject, scene: bpy.types.Scene, span: Any) -> tuple[list[list], tuple[str, ...]]:
    """Return ``[[seconds, style], ...]`` of the timeline markers ``as STYLE``, and warnings about unknown styles."""
    names, changes, strange = menu_items.style_names(armature.s2ag), [], []
    for marker in sorted(scene.timeline_markers, key=lambda one: one.frame):
        if not marker.name.startswith(_STYLE_PREFIX):
            continue
        style = marker.name[len(_STYLE_PREFIX) :].strip()
        try:
            if len(styles.split_sequence(style)) > 1:
                raise UnknownStyle("A walk.")
            styles.parse(style, names)
        except UnknownStyle:
            strange.append(translate('The marker "{name}" names no style, and none begins there.', name=marker.name))
            continue
        changes.append([round(max((marker.frame - span.start) / scene_fps(scene), 0.0), 4), style])
    return [] if menu_items.walks(armature.s2ag) else changes, tuple(strange)


def copy_curves(armature: ArmatureObject, action: bpy.types.Action, bag: Bag) -> None:
    """Copy the keyed sliders of the active action to a new action, so that they stay keyed."""
    for name, curve in keyed_curves(armature).items():
        path = f"s2ag.{name}"
        if curve.id_data == action:
            continue
        old = bag.fcurves.find(path)
        if old is not None:
            bag.fcurves.remove(old)
        copied = bag.fcurves.new(path)
        copied.extrapolation = curve.extrapolation
        copied.keyframe_points.add(len(curve.keyframe_points))
        for point, key in zip(copied.keyframe_points, curve.keyframe_points, strict=True):
            point.co, point.interpolation, point.easing = key.co, key.interpolation, key.easing
            point.handle_left_type, point.handle_right_type = key.handle_left_type, key.handle_right_type
            point.handle_left, point.handle_right = key.handle_left, key.handle_right
        copied.update()


def heard_affect(action: bpy.types.Action | None, scene: bpy.types.Scene) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return the affects that a take followed, slider and voice together, by name, each at scene frames ``(n,)``; none for a
    take that listens or heard nothing."""
    meta = provenance.read(action) or {}
    try:
        heard = np.array([meta["heard"][name] for name in AFFECTS if not meta.get("listen")], float).T
        frames = timing.clock_of(meta, scene_fps(scene)).frame(HEARD_STEP * np.arange(len(heard)))
        follows = zip(AFFECTS, curves.shown(heard, float(meta.get("follow", 1.0))).T, strict=True)
        together = {name: np.clip(float(meta["affect"].get(name, 0.0)) + track, -1, 1) for name, track in follows}
    except (KeyError, TypeError, ValueError, AttributeError):
        return np.zeros(0), {}
    return (frames, together) if frames.size and np.isfinite(list(together.values())).all() else (np.zeros(0), {})


def heard_now(action: bpy.types.Action | None, scene: bpy.types.Scene) -> dict[str, str]:
    """Return what :func:`heard_affect` has at the playhead, as text by name."""
    frames, tracks = heard_affect(action, scene)
    return {name: f"{round(float(np.interp(scene.frame_current, frames, line)), 1) + 0.0:.1f}" for name, line in tracks.items()}


def key_heard(armature: ArmatureObject, action: bpy.types.Action, scene: bpy.types.Scene) -> int:
    """Key the sliders of the affects with what a take followed, instead of their keys; return the number of new keys."""
    frames, tracks = heard_affect(action, scene)
    count = 0
    for name, track in tracks.items():
        if old := keyed_curves(armature).get(name):
            own: Any = old.id_data
            bag = compat.bag(own, layers.slot_of(armature, own))
            bag.fcurves.remove(old)
        kept = sorted(simplify_polyline(track, _HEARD_TOLERANCE))
        setattr(armature.s2ag, name, track[0])
        armature.keyframe_insert(f"s2ag.{name}", frame=frames[0])
        curve = keyed_curves(armature)[name]
        for at in kept:
            curve.keyframe_points.insert(frames[at], track[at], options={"FAST"})
        curve.update()
        count += len(kept)
    return count
