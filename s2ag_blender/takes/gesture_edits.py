"""Shows the gestures of a take as pose markers of its action, and turns an animator's changes into edits."""

import functools
import json
import re
from typing import Any, NamedTuple, cast

import bpy

from ...core import json_text
from ...core.editing import gestures
from ...core.editing.edits import performing_order
from ...core.errors import UsageError
from ...core.motion.motion import Motion
from .. import json_properties, provenance
from ..datablocks import ArmatureObject
from ..keys import key_restoring
from ..keys.apply import scene_fps
from . import markers, take_list, timing, versions

GESTURES = "s2ag_gestures"
"""Name of an action's custom property: JSON of the take's gestures."""
WORDS = "s2ag_words"
"""Name of an action's custom property: JSON of the take's words, each with the seconds of its start and end."""
SHORTEST = 0.8
"""Least seconds of a range to regenerate."""
_WORD_MARGIN = 0.2
"""Seconds before and after chosen words that are regenerated with them."""
_EDIT_MARGIN = 2.0 / 15
"""Seconds around an edited range in which keys change, too, because they lie between frames of the motion."""
_BESIDE = 0.8
"""Seconds beside an edit in which another one that is done after it may come out otherwise."""
_MARKER_NAME = re.compile(r"#\d+ ")
_NUMBER = int | float
_KINDS = (_NUMBER, str, str, _NUMBER, str, _NUMBER, _NUMBER)


class ShownGesture(NamedTuple):
    """A gesture: seconds of its stroke, hand, kind, size in metres, word, seconds of its begin and end, and its marker."""

    at: float
    hand: str
    kind: str
    size: float
    word: str
    begin: float
    end: float
    frame: int
    name: str


def store_gestures(action: bpy.types.Action, motion: Motion, scene: bpy.types.Scene) -> None:
    """Store the gestures and words of ``motion`` on its action, and mark the gestures."""
    rows = [
        [round(one.at, 4), one.hand, one.kind, round(one.size, 3), one.word, round(one.begin, 3), round(one.end, 3)]
        for one in gestures.find_gestures(motion)
    ]
    action[GESTURES] = json.dumps(rows)
    action[WORDS] = json.dumps([[word, round(start, 3), round(end, 3)] for word, start, end in motion.words])
    for marker in gesture_markers(action):
        action.pose_markers.remove(marker)
    for one in shown_gestures(action, scene):
        mark = action.pose_markers.new(one.name)
        mark.frame, mark.select = one.frame, False  # selections are the animator's


def gesture_markers(action: bpy.types.Action) -> list[bpy.types.TimelineMarker]:
    """Return the pose markers of an action that mark gestures."""
    return [marker for marker in action.pose_markers if _MARKER_NAME.match(marker.name)]


def shown_gestures(action: bpy.types.Action, scene: bpy.types.Scene) -> list[ShownGesture]:
    """Return the gestures of a take within its frames; older takes have none stored."""
    meta, rows = (action.get(name) for name in (provenance.PROPERTY, GESTURES))
    if not isinstance(meta, str) or not isinstance(rows, str):
        return []
    place = _place(meta, scene_fps(scene))
    return list(_shown(rows, *place)) if place else []


@functools.lru_cache(maxsize=8)
def _place(text: str, fps: float) -> tuple[timing.Clock, int, int] | None:
    """Return clock, first and last frame of a take from its provenance as text; cached because lists draw it per row."""
    meta = provenance.read(cast(bpy.types.Action, {provenance.PROPERTY: text})) or {}
    place = meta.get("place", {})
    if "start" not in meta or not {"first", "last"} <= place.keys():
        return None
    return timing.clock_of(meta, fps), place["first"], place["last"]


@functools.lru_cache(maxsize=8)
def _shown(text: str, clock: timing.Clock, first: int, last: int) -> tuple[ShownGesture, ...]:
    try:
        rows: Any = json_text.parse(text, json_properties.LARGEST)
    except json_text.NotJson:
        return ()
    gestures_shown = []
    for number, row in enumerate(rows if isinstance(rows, list) else (), 1):
        if not isinstance(row, list) or len(row) not in (5, 7) or not all(map(isinstance, row, _KINDS)):
            continue
        values = list(cast(list[Any], row))
        if len(values) == 5:  # of older takes
            values += [values[0] - 0.5 * SHORTEST, values[0] + 0.5 * SHORTEST]
        frame = round(float(clock.frame(values[0])))
        if first <= frame <= last:
            name = f"#{number} {values[4] or values[2]} ({values[1]})"[:60]
            gestures_shown.append(ShownGesture._make([*values, frame, name]))
    return tuple(gestures_shown)


def nearest_gesture(action: bpy.types.Action, scene: bpy.types.Scene, at: float = -1.0) -> ShownGesture | None:
    """Return the gesture nearest to ``at`` seconds, or the one whose marker is nearest to the playhead, or None."""
    if at >= 0:
        return min(shown_gestures(action, scene), key=lambda one: abs(one.at - at), default=None)
    frames = {marker.name: marker.frame for marker in gesture_markers(action)}
    candidates = shown_gestures(action, scene)
    marked = [one for one in candidates if one.name in frames] or candidates
    return min(marked, key=lambda one: abs(frames.get(one.name, one.frame) - scene.frame_current), default=None)


def marker_row(armature: ArmatureObject | None, scene: bpy.types.Scene) -> int:
    """Return the index of the marker of :func:`nearest_gesture` among the selected take's pose markers; -1 for none."""
    take = take_list.active(armature) if armature is not None else None
    gesture = nearest_gesture(take.action, scene) if take is not None else None
    if take is None or gesture is None:
        return -1
    names = [marker.name for marker in take.action.pose_markers]
    return names.index(gesture.name) if gesture.name in names else -1


def go_to(armature: ArmatureObject | None, scene: bpy.types.Scene, number: int) -> None:
    """Move the playhead to pose marker ``number`` of the selected take."""
    take = take_list.active(armature) if armature is not None else None
    if take is not None and 0 <= number < len(take.action.pose_markers):
        scene.frame_set(take.action.pose_markers[number].frame)


def stored_words(action: bpy.types.Action) -> list[tuple[str, float, float]]:
    """Return the words of a take with the seconds of their starts and ends."""
    rows = json_properties.read(action, WORDS, list)
    kinds = str, _NUMBER, _NUMBER
    valid = (one for one in rows if isinstance(one, list) and len(one) == 3 and all(map(isinstance, one, kinds)))
    return [(word, start, end) for word, start, end in valid]


def word_occurrence(action: bpy.types.Action, number: int) -> tuple[str, int]:
    """Return word ``number`` of a take in the form that edits use, and its occurrence, counted from 1."""
    said = [gestures.normalize_word(word) for word, *_ in stored_words(action)]
    return said[number], said[: number + 1].count(said[number])


def seconds_at(action: bpy.types.Action, scene: bpy.types.Scene, frame: float) -> float:
    """Return the seconds of the recording at a scene frame."""
    clock = timing.clock_of(provenance.require(action), scene_fps(scene))
    return round(max(float(clock.seconds(frame)), 0.0), 4)


def frame_at(action: bpy.types.Action, scene: bpy.types.Scene, seconds: float) -> int:
    """Return the scene frame at seconds of the recording."""
    return round(float(timing.clock_of(provenance.require(action), scene_fps(scene)).frame(seconds)))


def edits_from_markers(action: bpy.types.Action, scene: bpy.types.Scene) -> list[dict]:
    """Return the edits by markers: those that are gone delete their gestures, all in one, moved ones move theirs."""
    frames = {marker.name: marker.frame for marker in action.pose_markers}
    shown = shown_gestures(action, scene)
    moved = [one for one in shown if frames.get(one.name, one.frame) != one.frame]
    edits = deletion([one for one in shown if one.name not in frames])
    return [*edits, *({"do": "move", "at": one.at, "to": seconds_at(action, scene, frames[one.name])} for one in moved)]


def deletion(gone: list[ShownGesture]) -> list[dict]:
    """Return the edit that deletes these gestures together; none for none."""
    times = [one.at for one in gone]
    return [{"do": "delete", "at": times[0] if len(times) == 1 else times}] if times else []


def chosen_gestures(action: bpy.types.Action, scene: bpy.types.Scene) -> list[ShownGesture]:
    """Return the gestures with a selected marker; raises :class:`UsageError` where there are none."""
    names = {marker.name for marker in action.pose_markers if marker.select}
    chosen = [one for one in shown_gestures(action, scene) if one.name in names]
    if not chosen:
        raise UsageError("No marker of a gesture is selected.", "Select pose markers in the Action Editor.")
    return chosen


def preview_range(action: bpy.types.Action, scene: bpy.types.Scene, settings: Any) -> tuple[float, float]:
    """Return the seconds of the preview range; raises :class:`UsageError` without one."""
    if not scene.use_preview_range:
        raise UsageError("No preview range is set.", "Press P over the timeline and drag.")
    first, last = (seconds_at(action, scene, at) for at in (scene.frame_preview_start, scene.frame_preview_end))
    return first, last


def selected_gestures(action: bpy.types.Action, scene: bpy.types.Scene, settings: Any) -> tuple[float, float]:
    """Return the seconds from the first to the last gesture with a selected marker; raises :class:`UsageError`."""
    chosen = chosen_gestures(action, scene)
    return _widen(min(one.begin for one in chosen), max(one.end for one in chosen))


def selected_words(action: bpy.types.Action, scene: bpy.types.Scene, settings: Any) -> tuple[float, float]:
    """Return the seconds from the first to the last word with a selected marker; raises :class:`UsageError`."""
    clock = timing.clock_of(provenance.require(action), scene_fps(scene))
    frames = {mark.frame for mark in markers.ours(scene, settings.marker_prefix) if mark.select}
    chosen = [(begin, end) for _, begin, end in stored_words(action) if round(float(clock.frame(begin))) in frames]
    if not chosen:
        raise UsageError("No word of the take is selected.", "Select word markers in the timeline.")
    return _widen(chosen[0][0] - _WORD_MARGIN, chosen[-1][1] + _WORD_MARGIN)


def between_markers(action: bpy.types.Action, scene: bpy.types.Scene, settings: Any) -> tuple[float, float]:
    """Return the seconds from the first to the last selected marker of the timeline; raises :class:`UsageError`."""
    frames = sorted(mark.frame for mark in scene.timeline_markers if mark.select)
    if len(frames) < 2 or frames[0] == frames[-1]:
        raise UsageError("Fewer than two markers are selected.", "Select two markers of the timeline, or more.")
    return _widen(*(seconds_at(action, scene, frame) for frame in (frames[0], frames[-1])))


def _widen(first: float, last: float) -> tuple[float, float]:
    """Extend a range to at least :data:`SHORTEST` seconds."""
    more = max(SHORTEST - (last - first), 0.0) / 2
    first = max(first - more, 0.0)
    return round(first, 4), round(max(last + more, first + SHORTEST), 4)


RANGES = {"PREVIEW": preview_range, "GESTURES": selected_gestures, "WORDS": selected_words, "MARKERS": between_markers}
"""``{choice: function of action, scene and settings that returns the seconds to regenerate}``."""


def reroll_edits(take: Any, span: tuple[float, float]) -> tuple[list[dict], list[dict]]:
    """Return the edits of a take to keep, and one that regenerates a span of seconds, with a seed that no version has."""
    edits, reroll = edits_of(take.action), {"do": "reroll", "from": span[0], "to": span[1]}
    if edits and _without_seed(edits[-1]) == reroll:
        edits = edits[:-1]
    made = map(edits_of, versions.version_actions(take))
    others = [one[-1] for one in made if one and one[:-1] == edits and _without_seed(one[-1]) == reroll]
    return edits, [{**reroll, "seed": 1 + max((one.get("seed", 0) for one in others), default=0)}]


def _without_seed(edit: dict) -> dict:
    return {name: value for name, value in edit.items() if name != "seed"}


def edits_of(action: bpy.types.Action) -> list[dict]:
    """Return the edits of a take."""
    return list((provenance.read(action) or {}).get("edits", []))


def plan_arguments(action: bpy.types.Action, edits: list[dict]) -> dict[str, Any]:
    """Return arguments for ``generate.plan`` that make a take again with these edits.

    Raises :class:`UsageError` if the take was made by other weights."""
    if take_list.has_other_weights(provenance.require(action)):
        remedy = "Generate a new take, and direct that."
        raise UsageError("The take was made by other weights, so phrases would not fit in.", remedy)
    return take_list.remake_arguments(action, edits=edits, former=action)


def restore_untouched_keys(former: bpy.types.Action, action: bpy.types.Action, scene: bpy.types.Scene) -> None:
    """Restore the keys of the ``former`` take wherever the edits by which the two differ touched nothing.

    Solving a rig depends on the whole motion, so the last digits would differ; and keys edited by hand stay."""
    meta, before = provenance.read(action), provenance.read(former)
    if not meta or not before or any(meta.get(name) != before.get(name) for name in ("start", "place", timing.WAY)):
        return
    spans = _performed_anew(*(_performed(one) for one in (before, meta)))
    clock = timing.clock_of(meta, scene_fps(scene))
    near = [(clock.frame(low - _EDIT_MARGIN), clock.frame(high + _EDIT_MARGIN)) for low, high in spans]
    key_restoring.restore_outside(former, action, near)


def _performed_anew(old: list[tuple[dict, list]], new: list[tuple[dict, list]]) -> list[list[float]]:
    """Return the spans of seconds in which two takes differ: those of edits that one of them lacks, or that were done elsewhere
    in it, and those of edits that were done after these, and so again, in or beside their spans."""
    pairs = enumerate(zip(old, new, strict=False))
    same = next((at for at, (one, other) in pairs if one[0] != other[0]), min(len(old), len(new)))
    alone, both = old[same:], []
    for one in new[same:]:
        if one in alone:
            alone.remove(one)
            both.append(one)
        else:
            alone.append(one)
    spans: list[list[float]] = []
    while alone:
        spans += [span for _, touched in alone for span in touched]
        near = [(low - _BESIDE, high + _BESIDE) for low, high in spans]
        alone = [one for one in both if any(low <= own[1] and own[0] <= high for own in one[1] for low, high in near)]
        both = [one for one in both if one not in alone]
    return spans


def _performed(meta: dict[str, Any]) -> list[tuple[dict, list]]:
    """Return the edits of a take in the order in which they were done, each with the seconds that it touched."""
    edits, touched = meta.get("edits", []), meta.get("touched", [])
    return [(edits[at], touched[at] if at < len(touched) else []) for at in performing_order(edits)]
