"""The gestures of a take on the timeline, as pose markers of its action, and the edits that an animator makes of them."""

import functools
import json
import re
from typing import Any, NamedTuple

import bpy

from ...core import json_text
from ...core.direction import gestures
from ...core.errors import UsageError
from ...core.motion.motion import Motion
from .. import provenance, stored
from ..datablocks import ArmatureObject
from ..keys import restoring
from ..keys.apply import scene_fps
from . import choices, markers, takes, timing, versions

GESTURES = "s2ag_gestures"
"""Name of an action's custom property that holds the gestures of the take, as JSON text."""
WORDS = "s2ag_words"
"""Name of the one that holds its words: what is said, and the seconds of its start and end."""
SHORTEST = 0.8
"""Seconds of a range that is made anew around chosen gestures or words, at least."""
_ASIDE = 0.2
"""Seconds before and behind chosen words that are made anew with them."""
_REACH = 2.0 / 15
"""Seconds around what an edit touched in which keys between frames of the motion change, too."""
_OURS = re.compile(r"#\d+ ")
_NUMBER = int | float
_KINDS = (_NUMBER, str, str, _NUMBER, str, _NUMBER, _NUMBER)


class Shown(NamedTuple):
    """A gesture: seconds of its stroke, hand, kind, metres, word, seconds of begin and end; frame and name of its marker."""

    at: float
    hand: str
    kind: str
    size: float
    word: str
    begin: float
    end: float
    frame: int
    name: str


def note(action: bpy.types.Action, motion: Motion, scene: bpy.types.Scene) -> None:
    """Remember the gestures and words of ``motion`` on its action, and mark the gestures."""
    rows = [
        [round(one.at, 4), one.hand, one.kind, round(one.size, 3), one.word, round(one.begin, 3), round(one.end, 3)]
        for one in gestures.find(motion)
    ]
    action[GESTURES] = json.dumps(rows)
    action[WORDS] = json.dumps([[word, round(start, 3), round(end, 3)] for word, start, end in motion.words])
    for marker in ours(action):
        action.pose_markers.remove(marker)
    for one in shown(action, scene):
        mark = action.pose_markers.new(one.name)
        mark.frame, mark.select = one.frame, False  # what is selected, the animator has chosen


def ours(action: bpy.types.Action) -> list[bpy.types.TimelineMarker]:
    """The pose markers of an action that stand for gestures."""
    return [marker for marker in action.pose_markers if _OURS.match(marker.name)]


def shown(action: bpy.types.Action, scene: bpy.types.Scene) -> list[Shown]:
    """The gestures of a take within its frames; none of a take from before they were remembered."""
    told, rows = (action.get(name) for name in (provenance.PROPERTY, GESTURES))
    if not isinstance(told, str) or not isinstance(rows, str):
        return []
    place = _place(told, scene_fps(scene))
    return list(_shown(rows, *place)) if place else []


@functools.lru_cache(maxsize=8)
def _place(told: str, fps: float) -> tuple | None:
    """Clock, first and last frame of a take, of the text of its provenance; a panel asks for it with every row."""
    found = provenance.of({provenance.PROPERTY: told}) or {}
    place = found.get("place", {})
    known = "start" in found and {"first", "last"} <= place.keys()
    return (timing.clock(found, fps), place["first"], place["last"]) if known else None


@functools.lru_cache(maxsize=8)
def _shown(text: str, clock: timing.Clock, first: int, last: int) -> tuple[Shown, ...]:
    try:
        rows = json_text.parse(text, stored.LARGEST)
    except json_text.NotJson:
        return ()
    found = []
    for number, row in enumerate(rows if isinstance(rows, list) else (), 1):
        if not isinstance(row, list) or len(row) not in (5, 7) or not all(map(isinstance, row, _KINDS)):
            continue
        row = row if len(row) == 7 else [*row, row[0] - 0.5 * SHORTEST, row[0] + 0.5 * SHORTEST]  # of takes of before
        frame = round(float(clock.frame(row[0])))
        if first <= frame <= last:
            found.append(Shown(*row, frame, f"#{number} {row[4] or row[2]} ({row[1]})"[:60]))
    return tuple(found)


def nearest(action: bpy.types.Action, scene: bpy.types.Scene) -> Shown | None:
    """The gesture whose marker is at the playhead, or nearest to it."""
    there = {marker.name: marker.frame for marker in ours(action)}
    found = shown(action, scene)
    marked = [one for one in found if one.name in there] or found
    return min(marked, key=lambda one: abs(there.get(one.name, one.frame) - scene.frame_current), default=None)


def row(armature: ArmatureObject | None, scene: bpy.types.Scene) -> int:
    """The number of the pose marker of :func:`nearest` among all of the selected take; -1 for none."""
    take = takes.active(armature) if armature is not None else None
    one = nearest(take.action, scene) if take is not None else None
    names = [marker.name for marker in take.action.pose_markers] if one is not None else []
    return names.index(one.name) if one is not None and one.name in names else -1


def go_to(armature: ArmatureObject | None, scene: bpy.types.Scene, number: int) -> None:
    """Set the playhead to that pose marker of the selected take."""
    take = takes.active(armature) if armature is not None else None
    if take is not None and 0 <= number < len(take.action.pose_markers):
        scene.frame_set(take.action.pose_markers[number].frame)


def words(action: bpy.types.Action) -> list[tuple[str, float, float]]:
    """The words of a take and the seconds between which each is said."""
    rows = stored.read(action, WORDS, list)
    kinds = str, _NUMBER, _NUMBER
    return [tuple(one) for one in rows if isinstance(one, list) and len(one) == 3 and all(map(isinstance, one, kinds))]


def nth(action: bpy.types.Action, number: int) -> tuple[str, int]:
    """A word of a take as edits name it, and its how many-th it is."""
    said = [gestures.spoken(word) for word, *_ in words(action)]
    return said[number], said[: number + 1].count(said[number])


def seconds(action: bpy.types.Action, scene: bpy.types.Scene, frame: float) -> float:
    """Seconds of the recording at a frame of the scene."""
    clock = timing.clock(provenance.of(action), scene_fps(scene))
    return round(max(float(clock.seconds(frame)), 0.0), 4)


def by_markers(action: bpy.types.Action, scene: bpy.types.Scene) -> list[dict]:
    """The edits that markers ask for: those elsewhere move their gestures, those that are gone delete them."""
    there = {marker.name: marker.frame for marker in action.pose_markers}
    edits = []
    for one in shown(action, scene):
        if one.name not in there:
            edits.append({"do": "delete", "at": one.at})
        elif there[one.name] != one.frame:
            edits.append({"do": "move", "at": one.at, "to": seconds(action, scene, there[one.name])})
    return edits


def preview_range(action: bpy.types.Action, scene: bpy.types.Scene, settings: Any) -> tuple[float, float]:
    """Seconds of the preview range; raises :class:`UsageError` without one."""
    if not scene.use_preview_range:
        raise UsageError("No preview range is set.", "Set one in the timeline: it is made anew.")
    first, last = (seconds(action, scene, at) for at in (scene.frame_preview_start, scene.frame_preview_end))
    return first, last


def selected_gestures(action: bpy.types.Action, scene: bpy.types.Scene, settings: Any) -> tuple[float, float]:
    """Seconds of the gestures whose markers are selected, from the first to the last; raises :class:`UsageError`."""
    names = {marker.name for marker in action.pose_markers if marker.select}
    chosen = [one for one in shown(action, scene) if one.name in names]
    if not chosen:
        raise UsageError("No marker of a gesture is selected.", "Select pose markers in the Action Editor.")
    return _wide(min(one.begin for one in chosen), max(one.end for one in chosen))


def selected_words(action: bpy.types.Action, scene: bpy.types.Scene, settings: Any) -> tuple[float, float]:
    """Seconds of the words whose markers are selected, from the first to the last; raises :class:`UsageError`."""
    clock = timing.clock(provenance.of(action), scene_fps(scene))
    frames = {mark.frame for mark in markers.ours(scene, settings.marker_prefix) if mark.select}
    chosen = [(begin, end) for _, begin, end in words(action) if round(float(clock.frame(begin))) in frames]
    if not chosen:
        raise UsageError("No word of the take is selected.", "Select word markers in the timeline.")
    return _wide(chosen[0][0] - _ASIDE, chosen[-1][1] + _ASIDE)


def _wide(first: float, last: float) -> tuple[float, float]:
    """A range that is long enough to be made anew."""
    more = max(SHORTEST - (last - first), 0.0) / 2
    first = max(first - more, 0.0)
    return round(first, 4), round(max(last + more, first + SHORTEST), 4)


RANGES = {"PREVIEW": preview_range, "GESTURES": selected_gestures, "WORDS": selected_words}
"""What may be made anew -> a function of action, scene and settings that tells between which seconds it is."""


def anew(take: Any, span: tuple[float, float]) -> tuple[list[dict], list[dict]]:
    """The edits of a take that stay, and the one that makes a span of seconds anew, with a seed that no version of it has."""
    edits, wanted = made(take.action), {"do": "reroll", "from": span[0], "to": span[1]}
    if edits and _of(edits[-1]) == wanted:
        edits = edits[:-1]
    others = [one[-1] for one in versions.edits(take) if one and one[:-1] == edits and _of(one[-1]) == wanted]
    return edits, [{**wanted, "seed": 1 + max((one.get("seed", 0) for one in others), default=0)}]


def _of(edit: dict) -> dict:
    return {name: value for name, value in edit.items() if name != "seed"}


def made(action: bpy.types.Action) -> list[dict]:
    """The edits that a take came of."""
    return list((provenance.of(action) or {}).get("edits", []))


def directed(action: bpy.types.Action, edits: list[dict]) -> dict:
    """Arguments for ``generate.plan`` that make a take of ours once more, after these edits.

    Raises :class:`UsageError` where other weights would make it.
    """
    told = provenance.of(action)
    hash_ = choices.known(told["settings"].get("checkpoint", "")).get("hash")
    if hash_ and told.get("checkpoint") not in (None, hash_):
        remedy = "Generate a new take, and direct that."
        raise UsageError("The take was made by other weights, so phrases would not fit in.", remedy)
    return takes.again(action, edits=edits, former=action)


def settle(former: bpy.types.Action, action: bpy.types.Action, scene: bpy.types.Scene) -> None:
    """Give a take the keys of the ``former`` one wherever the edits that it has more, or less, have touched nothing.

    Solving a rig looks at the whole motion, so that the last digits would differ; and what was keyed by hand stays.
    """
    told, before = provenance.of(action), provenance.of(former)
    if not told or not before or any(told.get(name) != before.get(name) for name in ("start", "place", timing.WAY)):
        return
    pairs = list(zip(made(former), made(action), strict=False))
    same = next((number for number, (one, other) in enumerate(pairs) if one != other), len(pairs))
    spans = [span for one in (before, told) for part in one.get("touched", [])[same:] for span in part]
    clock = timing.clock(told, scene_fps(scene))
    near = [(clock.frame(low - _REACH), clock.frame(high + _REACH)) for low, high in spans]
    restoring.outside(former, action, near)
