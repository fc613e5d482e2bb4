"""Makes a take follow its sound strip when that is moved, trimmed, stretched, or plays another recording of the same words.

Keys, markers and provenance of all versions are moved with the sound. Only parts that had been cut off are generated anew."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import bpy
import numpy as np

from ...core.editing import time_alignment
from ...core.editing.time_alignment import TimeMap
from ...core.errors import UsageError
from ...core.motion.motion import Motion
from .. import compat, json_properties, provenance
from ..datablocks import ArmatureObject, SoundStrip
from ..keys import faces, keyframes, layers
from ..keys.apply import scene_fps
from ..translations import translate
from . import (
    constraints,
    gesture_edits,
    markers,
    recordings,
    sound_strips,
    sources,
    stored_settings,
    strip_speed,
    take_list,
    timing,
    versions,
)

SOUND = "s2ag_sound"
"""Name of an action's custom property: JSON of the state of the strip that its keys follow."""
FOLLOWS = "follows"
"""Key in the provenance of a take that followed its sound: ``path`` and ``file`` (:func:`recordings.content_mark`) of the
recording for which it was generated."""
_MIN_SHIFT = 0.5
"""Smaller changes of a strip, in frames, are ignored."""
FILE = "file"
"""Key in a strip's state: the hash of its file (:func:`recordings.content_mark`); older takes have none."""
_KINDS = {"left": (int, float), "right": (int, float), "keys": list, "path": str}


class Change(NamedTuple):
    """Changes of a strip: frames by which it moved, and whether it was trimmed, extended, stretched or got another file."""

    by: float
    trimmed: bool
    grown: bool
    stretched: bool
    replaced: bool


def strip_of_take(action: bpy.types.Action, scene: bpy.types.Scene) -> SoundStrip | None:
    """Return the sound strip for which a take was generated, or that was added for it, or None."""
    tag = json_properties.text(action, sound_strips.TAG)
    if tag:
        return next((strip for strip in compat.sound_strips(scene) if strip.get(sound_strips.TAG) == tag), None)
    origin = provenance.read(action)
    if not origin or "settings" not in origin or origin["settings"].get("audio_source") == "MIXDOWN":
        return None
    known = json_properties.read(action, SOUND)
    named = [strip for strip in compat.sound_strips(scene) if strip.name == known.get("name")]
    return named[0] if named else sources.chosen_strip(stored_settings.settings_view(origin["settings"]), scene)


def store_strip(action: bpy.types.Action, scene: bpy.types.Scene) -> None:
    """Store the state of a take's strip, which its keys follow from now on."""
    strip = strip_of_take(action, scene)
    if strip is not None and strip.sound is not None:
        action[SOUND] = json.dumps({**_state(strip), "name": strip.name})


def copy_follow_state(former: bpy.types.Action, action: bpy.types.Action) -> None:
    """Copy the stored state of the strip from the former version of a take."""
    if SOUND in former:
        action[SOUND] = former[SOUND]


def _state(strip: SoundStrip) -> dict[str, Any]:
    """Return the state of a strip with a sound: frames relative to its start, path, and hash of its file."""
    assert strip.sound is not None
    start = compat.strip_start(strip)
    sides = {"left": compat.visible_start(strip) - start, "right": compat.strip_end(strip) - start}
    path = sources.strip_path(strip)
    held = "" if strip.sound.packed_file else recordings.content_mark(path)
    return {**sides, "keys": [at - start for at in compat.retiming_frames(strip)], "path": path, FILE: held}


def change(action: bpy.types.Action, scene: bpy.types.Scene) -> Change | None:
    """Return the changes of a take's strip since the take was generated or followed it last; None without changes or strip."""
    origin, strip = provenance.read(action), strip_of_take(action, scene)
    if not origin or "start" not in origin or "place" not in origin or strip is None or strip.sound is None:
        return None
    now, before = _state(strip), json_properties.read(action, SOUND)
    by = compat.strip_start(strip) - origin["start"]
    if not before.keys() >= _KINDS.keys() or not json_properties.has_types(before, _KINDS):
        before = {**now, "keys": []}  # of older takes only the start is known
    apart = {side: now[side] - before[side] for side in ("left", "right")}
    stretched = len(now["keys"]) != len(before["keys"]) or any(
        abs(one - other) >= _MIN_SHIFT for one, other in zip(now["keys"], before["keys"], strict=True)
    )
    written = now[FILE] and before.get(FILE) and now[FILE] != before[FILE]
    replaced = bool(written) or not sources.is_same_file(now["path"], before["path"])
    trimmed = not stretched and max(map(abs, apart.values())) >= _MIN_SHIFT
    longer = apart["left"] <= -_MIN_SHIFT or apart["right"] >= _MIN_SHIFT
    first, last = (origin["place"][end] - origin["start"] for end in ("first", "last"))  # where there are keys
    grown = trimmed and not replaced and longer and (first > now["left"] + 1 or last < now["right"] - 2)
    changes = Change(by if abs(by) >= _MIN_SHIFT else 0.0, trimmed, grown, stretched, replaced)
    return changes if any(changes) else None


def follow(armature: ArmatureObject, scene: bpy.types.Scene, heard: Motion | None = None) -> Change:
    """Make all versions of the selected take follow their sound; ``heard`` is a motion of the new recording, if it has one.

    Raises :class:`UsageError` if nothing has changed, or if the take was blended into other animation, which must stay."""
    take = take_list.active(armature)
    what, place = change(take.action, scene), layers.Place.of(take.action)
    if what is None or place is None:
        raise UsageError("The sound strip lies where it lay.", "Move, trim or stretch it in the sequencer first.")
    if place.result == "ACTION" and layers.base_action(armature, place.first, place.last, place.piece) is not None:
        raise UsageError("The take lies within other animation, which would move, too.", "Generate it anew, or use a layer.")
    strip, fps = strip_of_take(take.action, scene), scene_fps(scene)
    assert strip is not None and strip.sound is not None  # else there is no change
    if heard is not None:
        sound_strips.reload(strip.sound)
    if heard is not None and not (what.trimmed or strip_speed.is_stretched(strip)):
        strip = sound_strips.renew_strip(scene, strip)
    way = _new_warp(take.action, scene, strip, what, heard)
    seen = (round(compat.visible_start(strip)), round(compat.strip_end(strip)) - 1)
    span = seen if what.trimmed or what.stretched else None
    own = timing.clock_of(provenance.require(take.action), fps)
    where = _frame_map(own, compat.strip_start(strip), fps, way)
    _move_markers(armature, scene, place, where, span)
    for action in versions.version_actions(take):
        old = timing.clock_of(provenance.require(action), fps)
        _retime(action, scene, _frame_map(old, compat.strip_start(strip), fps, way), way, strip, span)
        if heard is not None and heard.face is not None:
            _replace_face(armature, action, timing.retimed_motion(heard, strip_speed.strip_time_map(scene, strip)), fps)
        store_strip(action, scene)
    if heard is not None:
        take.recording = Path(sources.strip_path(strip)).name
    take_list.note_frames(take)
    take_list.show(armature)
    return what


def _new_warp(
    action: bpy.types.Action, scene: bpy.types.Scene, strip: SoundStrip, what: Change, heard: Motion | None
) -> TimeMap | None:
    """Return the new time warp of a take's own recording: by the words of both recordings, then by the strip's retiming."""
    stretched = strip_speed.strip_time_map(scene, strip) if what.stretched or what.replaced else None
    if heard is None:
        return stretched if what.stretched else timing.stored_time_map(provenance.require(action))
    there = time_alignment.align_words(gesture_edits.stored_words(action), heard.words)
    return there if stretched is None else TimeMap(stretched.there(there.new), there.old)


def _frame_map(old: timing.Clock, start: float, fps: float, way: TimeMap | None) -> Callable[[Any], Any]:
    """Return the function that maps scene frames of the old clock to those of a new start and time warp."""
    if old.way is None and way is None:
        return lambda frames: frames + (start - old.start)
    new = timing.Clock(start, fps, way)
    return lambda frames: new.frame(old.seconds(frames))


def _move_markers(
    armature: ArmatureObject, scene: bpy.types.Scene, place: layers.Place, where: Callable[[Any], Any],
    span: tuple[int, int] | None
) -> None:  # fmt: skip
    """Move the word markers within ``place`` by ``where``, and remove those outside of ``span``."""
    for marker in markers.ours(scene, armature.s2ag.marker_prefix):
        if place.first <= marker.frame <= place.last:
            marker.frame = round(float(where(marker.frame)))
            if span is not None and not span[0] <= marker.frame <= span[1]:
                scene.timeline_markers.remove(marker)


def _retime(
    action: bpy.types.Action, scene: bpy.types.Scene, where: Callable[[Any], Any], way: TimeMap | None, strip: SoundStrip,
    span: tuple[int, int] | None
) -> None:  # fmt: skip
    """Move keys, provenance and pose markers of an action by ``where``, and cut it to ``span``."""
    origin = provenance.require(action)
    place = {name: round(float(where(origin["place"][name]))) for name in ("first", "last")}
    cut = span is not None and (place["first"] < span[0] or place["last"] > span[1])
    if span is not None:
        place = {"first": max(place["first"], span[0]), "last": min(place["last"], span[1])}
    if place["first"] >= place["last"]:
        raise UsageError("Nothing of the take is heard any more.", "Let the strip show some of it.")
    for one in dict.fromkeys([action, *faces.separate_actions(action)]):
        for curve in compat.curves(one):
            keyframes.move_keys(curve, where)
            if cut:
                keyframes.trim_curve(curve, place["first"], place["last"])
        if one.use_frame_range:
            start, end = (float(where(at)) for at in (one.frame_start, one.frame_end))
            one.frame_start, one.frame_end = (place["first"], place["last"]) if cut else (start, end)
    origin["start"] = compat.strip_start(strip)
    origin["place"] |= place
    known = json_properties.read(action, SOUND)
    if cut or way is not None or FOLLOWS in origin:
        path = known.get("path", sources.strip_path(strip))
        origin.setdefault(FOLLOWS, {"path": path, FILE: known.get(FILE, "")})
    origin[timing.WAY] = timing.time_map_as_meta(way)
    settings = origin["settings"]
    if settings.get("audio_source") == "FILE" and settings.get("range") != "STRIP":
        settings |= {"range": "OWN", "start_frame": round(origin["start"])}
    marked = {marker.name: marker.frame for marker in action.pose_markers}
    still = {one.name for one in gesture_edits.shown_gestures(action, scene) if one.frame == marked.get(one.name)}
    action[provenance.PROPERTY] = json.dumps(origin, sort_keys=True)
    frames = {one.name: one.frame for one in gesture_edits.shown_gestures(action, scene) if one.name in still}
    for marker in list(action.pose_markers):
        marker.frame = frames.get(marker.name, round(float(where(marker.frame))))
        if cut and not place["first"] <= marker.frame <= place["last"]:
            action.pose_markers.remove(marker)


def _replace_face(armature: ArmatureObject, action: bpy.types.Action, heard: Motion, fps: float) -> None:
    """Replace a take's face by that of another recording, ``heard``."""
    origin, place = provenance.require(action), layers.Place.of(action)
    assert place is not None and heard.face is not None
    every = np.arange(place.first, place.last + 1)
    seen = None if place.piece else layers.influence_over_frames(place, every) * faces.end_fade(every, fps)
    _, mapping, _ = constraints.resolved_figure(armature, action)
    spoken = faces.bone_channels(armature, heard.face, origin["start"], every, fps, mapping, seen)
    keyframes.write_channels(compat.bag(action, layers.slot_of(armature, action)), spoken, every, "LINEAR")
    if faces.FACES in action:
        faces.key_face(armature, action, heard.face, origin["start"], every, fps, lambda warning: None, seen)


def voice(action: bpy.types.Action, scene: bpy.types.Scene, span: tuple[int, int] | None = None) -> sources.Voice | None:
    """Return the recording from which to regenerate a take that followed its sound, on its frames or on ``span``; else None.

    Raises :class:`UsageError` if that recording is gone or was overwritten."""
    origin, place = provenance.read(action) or {}, layers.Place.of(action)
    follows = origin.get(FOLLOWS)
    if not isinstance(follows, dict) or not isinstance(follows.get("path"), str) or place is None:
        return None
    path = bpy.path.abspath(follows["path"])
    if not Path(path).is_file():
        raise UsageError(f"{path} is gone, for which the take was performed.", "Put it back, or generate a new take.")
    _check(path, follows)
    first, last = span or (place.first, place.last)
    name, tag = Path(path).name, json_properties.text(action, sound_strips.TAG)
    return sources.Voice(
        path, sources.Span(origin["start"], first, last), True, name, tag, timing.stored_time_map(origin), True
    )


def check_recording(action: bpy.types.Action) -> None:
    """Raise :class:`UsageError` if the recording for which a take was generated was overwritten by another one."""
    known = (provenance.read(action) or {}).get(FOLLOWS) or json_properties.read(action, SOUND)
    if isinstance(known, dict) and isinstance(known.get("path"), str):
        _check(bpy.path.abspath(known["path"]), known)


def _check(path: str, known: dict[str, Any]) -> None:
    if recordings.differs(path, known.get(FILE)):
        raise UsageError(f"{path} was overwritten since the take was performed for it.", "Put it back, or generate a new take.")


def change_sentence(what: Change) -> str:
    """Return a sentence for the user about what was done."""
    if what.replaced:
        return translate("The take follows the other recording")
    if what.stretched or what.trimmed:
        return translate("The take follows its sound")
    return translate("The take was moved by {count:g} frames", count=what.by)
