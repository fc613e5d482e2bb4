"""Combines gestures with existing animation: merged into a copy of its action, on an NLA strip above it, or added as a layer.

Existing actions are never changed. Actions of this package ("of ours") are recognised by their provenance, so that a second
try on the same frames replaces the first one and leaves what is below unchanged."""

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ...core.motion import quaternion
from .. import compat, json_properties, provenance
from ..datablocks import ArmatureObject, Slot
from . import blending, faces, keyframes

TRACK = "Gestures"
"""Prefix of the names of NLA tracks made here."""
DRAFT = "draft"
"""Key in the provenance of a draft of the live preview."""
_SLOT, _BASE, BEFORE = "s2ag_slot", "s2ag_base", "s2ag_before"  # properties of actions of ours; pointers survive renaming


@dataclass(frozen=True)
class Place:
    """Where an action of ours belongs: how it combines with the animation below, and its frames."""

    result: str
    first: int
    last: int
    influence: float = 1.0
    blend_in: int = 0
    blend_out: int = 0
    piece: bool = False  # of a recording: animation around it stays

    @classmethod
    def of(cls, action: bpy.types.Action | None) -> "Place | None":
        """Return the place for which an action was made, or None if it is not ours."""
        meta = provenance.read(action)
        place: dict[str, Any] | None = meta.get("place") if meta else None
        if not place or not {"result", "first", "last"} <= place.keys() <= cls.__dataclass_fields__.keys():
            return None
        return cls(**place)

    def same(self, other: "Place | None") -> bool:
        """Return whether two places are those of takes of the same run."""
        return other is not None and (self.result, self.first, self.last) == (other.result, other.first, other.last)

    def within(self, other: "Place | None") -> bool:
        """Return whether this place is equal to ``other`` or a part of it, as a draft around the playhead is."""
        return other is not None and self.result == other.result and other.first <= self.first <= self.last <= other.last

    def overlaps(self, first: int, last: int) -> bool:
        """Return whether any of these frames belongs to this place."""
        return self.first <= last and first <= self.last

    def beyond(self, first: int, last: int) -> bool:
        """Return whether this place has frames before or after these."""
        return self.first < first or last < self.last


def base_action(armature: ArmatureObject, first: int, last: int, piece: bool = False) -> bpy.types.Action | None:
    """Return the action with which gestures on these frames combine: the active one, or what it was made from if it is ours.

    An action of ours that goes beyond a ``piece`` is itself the base, since the rest of it stays."""
    data = armature.animation_data
    action = data.action if data else None

    def is_replaced(action: bpy.types.Action) -> bool:
        place = Place.of(action)
        return place is not None and place.overlaps(first, last) and not (piece and place.beyond(first, last))

    seen = set()
    while action is not None and (is_draft(action) or is_replaced(action)):
        seen.add(action)
        action = provenance.linked(action, BEFORE if is_draft(action) else _BASE)
        action = None if action in seen else action  # a file may hold a circle, which leads nowhere
    return action


def below_draft(action: bpy.types.Action) -> bpy.types.Action | None:
    """Return the action that a draft hides; None if the action is no draft or hides another one, which no draft does."""
    below = provenance.linked(action, BEFORE) if is_draft(action) else None
    return None if is_draft(below) else below


def is_draft(action: bpy.types.Action | None) -> bool:
    """Return whether an action is a draft of the live preview."""
    meta = provenance.read(action)
    return bool(meta and meta.get(DRAFT))


def draft_of(armature: ArmatureObject) -> bpy.types.Action | None:
    """Return the draft that the character plays, or None."""
    action = armature.animation_data.action if armature.animation_data else None
    return action if is_draft(action) else None


def store_base(action: bpy.types.Action, slot: Slot | None, base: bpy.types.Action | None) -> None:
    """Store on an action of ours its slot and the action that it was made from."""
    action[_SLOT] = compat.slot_name(slot)
    if base is not None:
        action[_BASE] = base


def slot_of(armature: ArmatureObject, action: bpy.types.Action) -> Slot | None:
    """Return the slot of an action for this character, or None where there are no slots."""
    data = armature.animation_data
    if data is not None and data.action == action and compat.active_slot(armature) is not None:
        return compat.active_slot(armature)
    return compat.find_slot(action, json_properties.text(action, _SLOT)) or compat.first_slot(action, armature.name)


def own_curves(action: bpy.types.Action) -> list[bpy.types.FCurve]:
    """Return the curves in the character's own slot; copies of imported actions have slots of other objects as well."""
    return compat.curves(action, compat.find_slot(action, json_properties.text(action, _SLOT)))


def own_bag(action: bpy.types.Action) -> compat.Bag:
    """Return where the curves in the character's own slot are."""
    return compat.bag(action, compat.find_slot(action, json_properties.text(action, _SLOT)))


def is_animated(armature: ArmatureObject, base: bpy.types.Action | None) -> bool:
    """Return whether the character has pose animation to blend with; imported FBX actions may move only the object."""
    curves = compat.curves(base, slot_of(armature, base)) if base is not None else ()
    others = (one.action for one in strips(armature) if one.action is not None and Place.of(one.action) is None)
    return any(curve.data_path.startswith("pose.") for curve in curves) or any(others)


def layer_channels(
    armature: ArmatureObject, rotations: dict[str, np.ndarray], neutral: dict[str, np.ndarray], share: np.ndarray | None = None
) -> list[keyframes.Channels]:
    """Return the channels of an additive layer: the difference of ``rotations`` (keys, 4) from ``neutral`` (4,).

    ``share`` (keys,) scales it. Blender combines quaternions as rotations, but adds Euler angles and axis angles number by
    number; so those are differences of numbers, exact over a base in the neutral pose and approximate elsewhere."""
    result = []
    for name, values in rotations.items():
        bone = armature.pose.bones[name]
        if bone.rotation_mode == "QUATERNION":
            apart = quaternion.multiply(quaternion.conjugate(neutral[name]), values)
            apart = apart if share is None else quaternion.power(apart, share)
            result.append(keyframes.channels(bone, quaternion.continuous(apart)))
            continue
        both = keyframes.channels(bone, quaternion.continuous(np.concatenate([neutral[name][None], values])))
        parts = {i: (column[1:] - column[0]) * (1 if share is None else share) for i, column in both.values.items()}
        result.append(keyframes.Channels(both.bone, both.path, parts))
    return result


def influence_over_frames(place: Place, frames: np.ndarray) -> np.ndarray:
    """Return the influence of a layer on its frames (keys,), equal to the keyed influence of its strip."""
    return place.influence * blending.ramp(frames, place.blend_in) * blending.ramp(frames, place.blend_out, at_end=True)


def show(armature: ArmatureObject, action: bpy.types.Action) -> None:
    """Play an action of ours in the place it was made for, instead of another take there."""
    faces.show(armature, action)
    place = Place.of(action)
    if place is None or place.result == "ACTION":
        _activate(armature, action)
        return
    strip = next((strip for strip in strips(armature) if place.same(Place.of(strip.action))), None)
    if strip is None:
        _clear_active(armature, place)
        strip = _new_strip(armature, action, place)
    _play(strip, action, armature, place)


@contextlib.contextmanager
def animation_below(armature: ArmatureObject, base: bpy.types.Action | None, span: Any) -> Iterator[None]:
    """Show only the animation below the gestures within a ``with`` block: ``base``, without our strips on these frames.

    ``span`` is a ``takes.sources.Span``."""
    data = armature.animation_data_create()
    active, slot = data.action, compat.active_slot(armature)
    last = span.first if span.last is None else span.last
    ours = [strip for strip in strips(armature) if (place := Place.of(strip.action)) and place.overlaps(span.first, last)]
    assign(armature, base)
    for strip in ours:
        strip.mute = True
    try:
        yield
    finally:
        for strip in ours:
            strip.mute = False
        compat.assign_action(armature, active, slot)


def playing_actions(armature: ArmatureObject) -> list[bpy.types.Action]:
    """Return the actions of ours that the character plays, the active one last."""
    data = armature.animation_data
    actions = [strip.action for strip in strips(armature)] + [data.action if data else None]
    return [action for action in actions if action is not None and Place.of(action) is not None]


def former_values_of_playing(armature: ArmatureObject) -> dict[str, Any]:
    """Return the former values, by data path, of everything that the playing actions of ours key."""
    values = {}
    for action in playing_actions(armature):
        values |= keyframes.former_values(action)
    return values


def hide(armature: ArmatureObject, action: bpy.types.Action) -> None:
    """Stop playing an action of ours: its base becomes active again, its strip and an emptied track are removed."""
    data = armature.animation_data
    if data is None:
        return
    if data.action == action:
        _activate(armature, provenance.linked(action, _BASE))
    for track in list(data.nla_tracks):
        for strip in [strip for strip in track.strips if strip.action == action]:
            track.strips.remove(strip)
            if not track.strips and track.name.startswith(TRACK):
                data.nla_tracks.remove(track)
                break
    keyframes.restore_former_values(armature, action)
    faces.hide(armature, action)


def _activate(armature: ArmatureObject, action: bpy.types.Action | None) -> None:
    former = armature.animation_data.action if armature.animation_data else None
    if former != action:
        _keep_in_file(former)
        _restore_unkeyed(armature, former, action)
    assign(armature, action)


def _restore_unkeyed(armature: ArmatureObject, former: bpy.types.Action | None, action: bpy.types.Action | None) -> None:
    """Restore the values that an action of ours keyed and the next one does not, which would keep their last value."""
    if former is not None and Place.of(former) is not None:
        keyed = {curve.data_path for curve in compat.curves(action)} if action is not None else set()
        keyframes.restore_former_values(armature, former, keyed)


def assign(armature: ArmatureObject, action: bpy.types.Action | None) -> None:
    """Make an action the active one, with its slot for this character."""
    compat.assign_action(armature, action, slot_of(armature, action) if action is not None else None)


def _keep_in_file(former: bpy.types.Action | None) -> None:
    """Give an action that is no longer played a fake user; takes of ours are kept by the list of takes."""
    if former is not None and former.library is None and Place.of(former) is None:
        former.use_fake_user = True


def _clear_active(armature: ArmatureObject, place: Place) -> None:
    """Push the active action down to an NLA track, as Blender's own button does, so that strips above it take effect."""
    data = armature.animation_data_create()
    former, slot = data.action, compat.active_slot(armature)
    if former is None:
        return
    base = base_action(armature, place.first, place.last, place.piece)
    if base != former:
        slot = slot_of(armature, base) if base is not None else None
    if base is not None:
        push_down(armature, base, slot).name = base.name
    _keep_in_file(former)
    data.action = None


def push_down(armature: ArmatureObject, action: bpy.types.Action, slot: Slot | None) -> bpy.types.NlaTrack:
    """Add a track above all others with an action on it, with the blending of the active one; the active one stays."""
    data = armature.animation_data_create()
    track = data.nla_tracks.new()
    start = float(action.frame_range[0])
    strip = track.strips.new(action.name, int(start), action)
    strip.frame_start = start
    strip.extrapolation = data.action_extrapolation
    strip.blend_type = data.action_blend_type
    compat.strip_slot(strip, slot)
    return track


def _new_strip(armature: ArmatureObject, action: bpy.types.Action, place: Place) -> bpy.types.NlaStrip:
    """Add a strip on the first track of ours that has room, else on a new track above all others."""
    data = armature.animation_data_create()
    for track in data.nla_tracks:
        free = all(strip.frame_end <= place.first or strip.frame_start >= place.last for strip in track.strips)
        if track.name.startswith(TRACK) and free and not track.lock:
            return track.strips.new(action.name, place.first, action)
    track = data.nla_tracks.new()
    track.name = TRACK
    return track.strips.new(action.name, place.first, action)


def _play(strip: bpy.types.NlaStrip, action: bpy.types.Action, armature: ArmatureObject, place: Place) -> None:
    """Make a strip play an action of ours, with the range, blending and influence of its place."""
    if strip.action != action:
        _restore_unkeyed(armature, strip.action, action)
        strip.action = action
    compat.strip_slot(strip, slot_of(armature, action))
    strip.name = action.name
    start, end = action.frame_range
    strip.action_frame_start, strip.action_frame_end = start, end
    strip.frame_start, strip.frame_end = start, end
    strip.use_auto_blend = False
    strip.blend_in = strip.blend_out = 0
    alone = not any(other for other in strips(armature) if other != strip)
    if place.result == "LAYER":
        strip.blend_type, strip.extrapolation = "COMBINE", "NOTHING"
        _key_influence(strip, place)
    else:
        strip.blend_type, strip.extrapolation = "REPLACE", "HOLD" if alone else "NOTHING"
        if place.influence < 1:
            _key_influence(strip, place)
        elif not alone:
            strip.blend_in, strip.blend_out = place.blend_in, place.blend_out


def _key_influence(strip: bpy.types.NlaStrip, place: Place) -> None:
    """Key the influence over the strip's frames; Blender uses only a keyed one, and then no blend in and out."""
    strip.use_animated_influence = True
    curve = compat.strip_curve(strip, "influence")
    if curve is not None:
        curve.keyframe_points.clear()
    keys = {place.first: place.influence, place.last: place.influence}
    if place.blend_in:
        keys = {place.first: 0.0, place.first + place.blend_in: place.influence, **{place.last: place.influence}}
    if place.blend_out:
        keys = {**keys, place.last - place.blend_out: place.influence, place.last: 0.0}
    for frame, value in sorted(keys.items()):
        strip.influence = value
        strip.keyframe_insert("influence", frame=frame)


def strips(armature: ArmatureObject) -> list[bpy.types.NlaStrip]:
    """Return the NLA strips of a character on tracks that are not muted."""
    data = armature.animation_data
    return [strip for track in (data.nla_tracks if data else ()) for strip in track.strips if not track.mute]
