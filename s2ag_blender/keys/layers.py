"""Gestures and the animation that is there: replaced in a copy, covered by a strip, or added to as a layer.

No action that is there is ever changed. What this package makes is known by its provenance, so that a second try on the
same frames takes the first one's place and leaves what was below it as it was.
"""

import contextlib
from dataclasses import dataclass

import bpy
import numpy as np

from ...core.motion import quaternion
from .. import compat, provenance
from ..datablocks import ArmatureObject, Slot
from . import faces, keyframes, mixing

TRACK = "Gestures"
"""What names of tracks made here start with."""
DRAFT = "draft"
"""In the provenance of a draft of the live preview."""
_SLOT, _BASE, BEFORE = "s2ag_slot", "s2ag_base", "s2ag_before"  # properties of actions of ours; pointers survive renaming


@dataclass(frozen=True)
class Place:
    """Where an action of ours belongs: how it meets the animation below, and the frames it is for."""

    result: str
    first: int
    last: int
    influence: float = 1.0
    blend_in: int = 0
    blend_out: int = 0
    piece: bool = False  # of a recording: what is around it stays

    @classmethod
    def of(cls, action: bpy.types.Action | None) -> "Place | None":
        """The place that an action was made for, or None if it is not ours."""
        told = provenance.of(action) if action is not None else None
        place = told.get("place") if told else None
        known = place and {"result", "first", "last"} <= place.keys() <= cls.__dataclass_fields__.keys()
        return cls(**place) if known else None

    def same(self, other: "Place | None") -> bool:
        """Whether two actions are takes of one another."""
        return other is not None and (self.result, self.first, self.last) == (other.result, other.first, other.last)

    def within(self, other: "Place | None") -> bool:
        """Whether this is another place of the same kind or a piece of it, as a draft around the playhead is."""
        return other is not None and self.result == other.result and other.first <= self.first <= self.last <= other.last

    def overlaps(self, first: int, last: int) -> bool:
        """Whether any of these frames is this place's, too."""
        return self.first <= last and first <= self.last

    def beyond(self, first: int, last: int) -> bool:
        """Whether these frames are only a part of this place."""
        return self.first <= first and last <= self.last and (first, last) != (self.first, self.last)


def base_action(armature: ArmatureObject, first: int, last: int, piece: bool = False) -> bpy.types.Action | None:
    """The active action that gestures on these frames meet; one of ours on them gives way to what it was made from.

    Not where a ``piece`` of it is made anew: what is around that stays.
    """
    data = armature.animation_data
    action = data.action if data else None
    while is_draft(action) or (
        (place := Place.of(action)) is not None and place.overlaps(first, last) and not (piece and place.beyond(first, last))
    ):
        action = action.get(BEFORE if is_draft(action) else _BASE)
    return action


def is_draft(action: bpy.types.Action | None) -> bool:
    """Whether an action is a draft of the live preview."""
    told = provenance.of(action) if action is not None else None
    return bool(told and told.get(DRAFT))


def draft_of(armature: ArmatureObject) -> bpy.types.Action | None:
    """The draft that the character plays, if any."""
    action = armature.animation_data.action if armature.animation_data else None
    return action if is_draft(action) else None


def remember(action: bpy.types.Action, slot: Slot | None, base: bpy.types.Action | None) -> None:
    """Note on an action of ours its slot and the action that it was made from."""
    action[_SLOT] = compat.slot_name(slot)
    if base is not None:
        action[_BASE] = base


def slot_of(armature: ArmatureObject, action: bpy.types.Action):
    """The slot of an action that is for this character, or None where there are no slots."""
    data = armature.animation_data
    if data is not None and data.action == action and compat.active_slot(armature) is not None:
        return compat.active_slot(armature)
    return compat.find_slot(action, action.get(_SLOT, "")) or compat.first_slot(action, armature.name)


def own_curves(action: bpy.types.Action) -> list:
    """The curves of an action that are its character's: a copy of an imported one has other objects' of the same paths, too."""
    return compat.curves(action, compat.find_slot(action, action.get(_SLOT, "")))


def is_animated(armature: ArmatureObject, base: bpy.types.Action | None) -> bool:
    """Whether the character has animation that gestures could blend with: an FBX may bring an action of its place alone."""
    curves = compat.curves(base, slot_of(armature, base)) if base is not None else ()
    return any(curve.data_path.startswith("pose.") for curve in curves) or any(_foreign_strips(armature))


def deltas(
    armature: ArmatureObject,
    rotations: dict[str, np.ndarray],
    neutral: dict[str, np.ndarray],
    share: np.ndarray | None = None,
) -> list:
    """Channels of an additive layer: by how much ``rotations`` (keys, 4) depart from ``neutral`` (4,).

    With ``share`` (keys,) only so much of it.
    Blender combines quaternions as rotations, but adds Euler angles and axis angles number by number; so those are
    differences of numbers, which are exact over a base in the neutral pose and near it elsewhere.
    """
    found = []
    for name, values in rotations.items():
        bone = armature.pose.bones[name]
        if bone.rotation_mode == "QUATERNION":
            apart = _apart(neutral[name], values)
            apart = apart if share is None else quaternion.power(apart, share)
            found.append(keyframes.channels(bone, quaternion.continuous(apart)))
            continue
        both = keyframes.channels(bone, quaternion.continuous(np.concatenate([neutral[name][None], values])))
        parts = {i: (column[1:] - column[0]) * (1 if share is None else share) for i, column in both.values.items()}
        found.append(keyframes.Channels(both.bone, both.path, parts))
    return found


def share(place: Place, frames: np.ndarray) -> np.ndarray:
    """How much of a layer is seen on its frames (keys,), as its strip's keyed influence has it."""
    return place.influence * mixing.ramp(frames, place.blend_in) * mixing.ramp(frames, place.blend_out, at_end=True)


def added_numbers(armature: ArmatureObject, bones) -> list[str]:
    """Bones for which an additive layer is only near: those without quaternions."""
    return [name for name in bones if armature.pose.bones[name].rotation_mode != "QUATERNION"]


def show(armature: ArmatureObject, action: bpy.types.Action) -> None:
    """Let the character play an action of ours in the place it was made for, instead of another take of it."""
    faces.show(armature, action)
    place = Place.of(action)
    if place is None or place.result == "ACTION":
        _activate(armature, action)
        return
    strip = next((strip for strip in strips(armature) if place.same(Place.of(strip.action))), None)
    if strip is None:
        _clear_way(armature, place)
        strip = _new_strip(armature, action, place)
    _play(strip, action, armature, place)


@contextlib.contextmanager
def below(armature: ArmatureObject, base: bpy.types.Action | None, span):
    """While it lasts, the character shows only what gestures on these frames meet, not what they take the place of."""
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


def playing(armature: ArmatureObject) -> list[bpy.types.Action]:
    """Actions of ours that the character plays, the active one last."""
    data = armature.animation_data
    found = [strip.action for strip in strips(armature)] + [data.action if data else None]
    return [action for action in found if action is not None and Place.of(action) is not None]


def formers(armature: ArmatureObject) -> dict:
    """What stood in the place of all that actions of ours key now, by data path."""
    found = {}
    for action in playing(armature):
        found |= keyframes.former(action)
    return found


def hide(armature: ArmatureObject, action: bpy.types.Action) -> None:
    """Stop playing an action of ours: what it was made from is active again, its strip and an emptied track go."""
    data = armature.animation_data
    if data is None:
        return
    if data.action == action:
        _activate(armature, action.get(_BASE))
    for track in list(data.nla_tracks):
        for strip in [strip for strip in track.strips if strip.action == action]:
            track.strips.remove(strip)
            if not track.strips and track.name.startswith(TRACK):
                data.nla_tracks.remove(track)
                break
    keyframes.give_back(armature, action)
    faces.hide(armature, action)


def _apart(neutral: np.ndarray, values: np.ndarray) -> np.ndarray:
    return quaternion.multiply(quaternion.conjugate(neutral), values)


def _activate(armature: ArmatureObject, action: bpy.types.Action) -> None:
    former = armature.animation_data.action if armature.animation_data else None
    if former != action:
        _protect(former)
        _let_go(armature, former, action)
    assign(armature, action)


def _let_go(armature: ArmatureObject, former, action: bpy.types.Action) -> None:
    """Give back what an action of ours has keyed and the one that plays from now on has not: it would stay as it is now."""
    if former is not None and Place.of(former) is not None:
        keyed = {curve.data_path for curve in compat.curves(action)} if action is not None else set()
        keyframes.give_back(armature, former, keyed)


def assign(armature: ArmatureObject, action: bpy.types.Action | None) -> None:
    """Make an action the active one, through its slot for this character."""
    compat.assign_action(armature, action, slot_of(armature, action) if action is not None else None)


def _protect(former) -> None:
    """Let an action that is no longer played stay in the file; takes of ours stay by being in the list."""
    if former is not None and former.library is None and Place.of(former) is None:
        former.use_fake_user = True


def _clear_way(armature: ArmatureObject, place: Place) -> None:
    """Push the active action down, as Blender's own button does, so that strips above it are seen."""
    data = armature.animation_data_create()
    former, slot = data.action, compat.active_slot(armature)
    if former is None:
        return
    base = base_action(armature, place.first, place.last, place.piece)
    if base != former:
        slot = slot_of(armature, base) if base is not None else None
    if base is not None:
        push_down(armature, base, slot).name = base.name
    _protect(former)
    data.action = None


def push_down(armature: ArmatureObject, action: bpy.types.Action, slot: Slot | None) -> bpy.types.NlaTrack:
    """A new track above all others with an action on it, as the active one plays; it stays active, too."""
    data = armature.animation_data
    track = data.nla_tracks.new()
    start = float(action.frame_range[0])
    strip = track.strips.new(action.name, int(start), action)
    strip.frame_start = start
    strip.extrapolation = data.action_extrapolation
    strip.blend_type = data.action_blend_type
    compat.strip_slot(strip, slot)
    return track


def _new_strip(armature: ArmatureObject, action: bpy.types.Action, place: Place) -> bpy.types.NlaStrip:
    """A strip on the first track of ours that has room, else on a new one above all others."""
    data = armature.animation_data_create()
    for track in data.nla_tracks:
        free = all(strip.frame_end <= place.first or strip.frame_start >= place.last for strip in track.strips)
        if track.name.startswith(TRACK) and free and not track.lock:
            return track.strips.new(action.name, place.first, action)
    track = data.nla_tracks.new()
    track.name = TRACK
    return track.strips.new(action.name, place.first, action)


def _play(strip: bpy.types.NlaStrip, action: bpy.types.Action, armature: ArmatureObject, place: Place) -> None:
    if strip.action != action:
        _let_go(armature, strip.action, action)
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
    """Influence over the strip's frames; Blender heeds only a keyed one (and then no blend in and out)."""
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


def strips(armature: ArmatureObject) -> list:
    """The NLA strips of a character on tracks that play."""
    data = armature.animation_data
    return [strip for track in (data.nla_tracks if data else ()) for strip in track.strips if not track.mute]


def _foreign_strips(armature: ArmatureObject) -> list:
    return [strip for strip in strips(armature) if strip.action is not None and Place.of(strip.action) is None]
