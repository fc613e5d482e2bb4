"""The gestures of a take on the timeline, as pose markers of its action, and the edits that an animator makes of them."""

import json
import re
from typing import NamedTuple

import bpy

from ...core.direction import gestures
from ...core.errors import UsageError
from ...core.motion.motion import Motion
from .. import provenance, stored
from ..keys import restoring
from ..keys.apply import scene_fps
from . import choices, takes

GESTURES = "s2ag_gestures"
"""Name of an action's custom property that holds the gestures of the take, as JSON text."""
_REACH = 2.0 / 15
"""Seconds around what an edit touched in which keys between frames of the motion change, too."""
_OURS = re.compile(r"#\d+ ")
_KINDS = (int | float, str, str, int | float, str)


class Shown(NamedTuple):
    """A gesture of a take: seconds of its stroke, hand, kind, metres, word; and the frame and name of its marker."""

    at: float
    hand: str
    kind: str
    size: float
    word: str
    frame: int
    name: str


def note(action: bpy.types.Action, motion: Motion, scene: bpy.types.Scene) -> None:
    """Remember the gestures of ``motion`` on its action, and mark them."""
    rows = [[round(one.at, 4), one.hand, one.kind, round(one.size, 3), one.word] for one in gestures.find(motion)]
    action[GESTURES] = json.dumps(rows)
    for marker in [marker for marker in action.pose_markers if _OURS.match(marker.name)]:
        action.pose_markers.remove(marker)
    for one in shown(action, scene):
        action.pose_markers.new(one.name).frame = one.frame


def shown(action: bpy.types.Action, scene: bpy.types.Scene) -> list[Shown]:
    """The gestures of a take within its frames; none of a take from before they were remembered."""
    told, found = provenance.of(action), []
    if not told or "start" not in told:
        return found
    for number, row in enumerate(stored.read(action, GESTURES, list), 1):
        if not isinstance(row, list) or len(row) != len(_KINDS) or not all(map(isinstance, row, _KINDS)):
            continue
        frame = round(told["start"] + row[0] * scene_fps(scene))
        if told["place"]["first"] <= frame <= told["place"]["last"]:
            found.append(Shown(*row, frame, f"#{number} {row[4] or row[2]} ({row[1]})"[:60]))
    return found


def nearest(action: bpy.types.Action, scene: bpy.types.Scene) -> Shown | None:
    """The gesture at the playhead, or nearest to it."""
    return min(shown(action, scene), key=lambda one: abs(one.frame - scene.frame_current), default=None)


def seconds(action: bpy.types.Action, scene: bpy.types.Scene, frame: float) -> float:
    """Seconds of the recording at a frame of the scene."""
    told = provenance.of(action)
    return round(max((frame - told["start"]) / scene_fps(scene), 0.0), 4)


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


def anew(action: bpy.types.Action, scene: bpy.types.Scene) -> tuple[list[dict], list[dict]]:
    """The edits of a take that stay, and the one that makes the preview range anew: with the next seed, if it is so already.

    Raises :class:`UsageError` without a preview range.
    """
    if not scene.use_preview_range:
        raise UsageError("No preview range is set.", "Set one in the timeline: it is made anew.")
    first, last = (seconds(action, scene, at) for at in (scene.frame_preview_start, scene.frame_preview_end))
    edits = made(action)
    wanted = {"do": "reroll", "from": first, "to": last, "seed": 1}
    before = edits[-1] if edits else {}
    if {**before, "seed": 1} == wanted:
        return edits[:-1], [{**wanted, "seed": before["seed"] + 1}]
    return edits, [wanted]


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
    return takes.again(action, edits=edits)


def settle(former: bpy.types.Action, action: bpy.types.Action, scene: bpy.types.Scene) -> None:
    """Give a take the keys of the ``former`` one wherever the edits that it has more, or less, have touched nothing.

    Solving a rig looks at the whole motion, so that the last digits would differ; and what was keyed by hand stays.
    """
    told, before = provenance.of(action), provenance.of(former)
    if not told or not before or told["start"] != before["start"] or told["place"] != before["place"]:
        return
    pairs = list(zip(made(former), made(action), strict=False))
    same = next((number for number, (one, other) in enumerate(pairs) if one != other), len(pairs))
    spans = [span for one in (before, told) for part in one.get("touched", [])[same:] for span in part]
    rate = scene_fps(scene)
    near = [(told["start"] + (low - _REACH) * rate, told["start"] + (high + _REACH) * rate) for low, high in spans]
    restoring.outside(former, action, near)
