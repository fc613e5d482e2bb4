"""Finds the bones of a face by name and position, and moves them by a face's channels.

``bones.json`` lists names by preference, with ``{side}`` for any spelling of a side. Parts without a known name are found
by position: a jaw below the head that points forwards, mirrored eyes that point forwards, lids that start at an eye."""

import functools
import json
from collections.abc import Container, Iterable
from collections.abc import Mapping as Named
from importlib import resources
from typing import Protocol

import numpy as np

from ...core.motion import quaternion
from ...core.motion.face import CHANNELS, GAZE_DEGREES
from ..names import plain_name
from ..skeleton import Bones, Mapping, character_frame

SIDES = ("left", "right")
PARTS = (
    "jaw",
    "gaze",
    *(f"{side}_{part}" for side in SIDES for part in ("eye", "upper_lid", "lower_lid", "lip_corner", "brow")),
)
"""Parts of a face that can be bones; ``gaze`` is a target control for the eyes."""
JAW, FARTHEST = 22.0, 35.0
"""Degrees by which a fully open jaw rotates, and a closed upper lid if there is no lower one."""
_SIDE_WORDS = {"left": ("l", "left"), "right": ("r", "right")}
_KANJI = {"left": "左", "right": "右"}
_MIN_AHEAD, _MAX_TILT, _MIN_DROP, _MIRROR_TOLERANCE = 0.75, 0.2, 0.15, 0.1
"""Bounds for bones found by position: forward part of a direction, upward part of an eye's, downward part of a jaw's, and
the distance of an eye from its mirror image, relative to its distance from the middle."""
_EYE_CENTRE_SHARE = 0.35
"""Largest distance of a lid's head from the eye's centre, relative to its tail's, for a lid that rotates about the eye."""
_LID_TRAVEL = 0.35
"""Travel of a sliding upper lid without a lower one, in lengths of the eye bone."""
_CORNER_IN, _CORNER_AHEAD, _CORNER_OUT, _BROW_RAISE = 0.13, 0.05, 0.06, 0.13
"""Displacements of lip corners and brows, in distances between the eyes."""


class ShapeKeys(Protocol):
    """What this module needs of :class:`.shapes.Shapes`, which imports it."""

    @property
    def shown(self) -> set[str]:
        """Channels that the keys express."""
        ...

    @property
    def rest(self) -> tuple[str, ...]:
        """Channels that need no key."""
        ...


def find(bones: Bones, mapping: Mapping) -> dict[str, str]:
    """Find the face bones of an armature with a known body, by part; bones with constraints or drivers are ignored."""
    named = _by_name(bones, _beside_body(bones, mapping))
    taken = {bones.row(name) for name in named.values()}
    head = mapping.chains.get("head", ())
    below = [row for row in range(len(bones.names)) if head and bones.row(head[-1]) in bones.ancestors(row)]
    free = [row for row in below if row not in taken and not bones.driven[row]]
    return {**_by_position(bones, free, character_frame(bones, mapping), named), **named}


def shown_channels(parts: Iterable[str]) -> set[str]:
    """Return the channels that these parts can express."""
    channels = {"jaw": ("JAW", "PP"), "gaze": ("LOOK_LEFT", "LOOK_UP"), "left_eye": ("LOOK_LEFT", "LOOK_UP")}
    channels |= {"left_upper_lid": ("BLINK_LEFT",), "left_lower_lid": ("BLINK_LEFT",), "right_upper_lid": ("BLINK_RIGHT",)}
    channels |= {"left_brow": ("BROW_INNER", "BROW_OUTER"), "left_lip_corner": ("SMILE", "OU")}
    return {channel for part in parts for channel in channels.get(part, ())}


def needed_parts(parts: Named[str, str], shapes: ShapeKeys | None) -> dict[str, str]:
    """Return those of ``parts`` whose channels the shape keys do not express."""
    covered = set() if shapes is None else shapes.shown | set(shapes.rest)
    if shapes is not None:
        covered |= {"SMILE", "OU"}
    return {part: name for part, name in parts.items() if not shown_channels([part.replace("right", "left")]) & covered}


def bone_motion(
    bones: Bones, mapping: Mapping, parts: Named[str, str], weights: np.ndarray
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return rotations ``{bone: (frames, 4)}`` and translations ``{bone: (frames, 3)}`` of ``parts`` for the channels'
    ``weights`` ``(frames, channels)``, each in the bone's rest space."""
    left, back, up = character_frame(bones, mapping)
    there = {part: bones.row(name) for part, name in parts.items() if name in bones.names}
    turns: dict[str, np.ndarray] = {}
    ways: dict[str, np.ndarray] = {}
    if "jaw" in there:
        turns["jaw"] = quaternion.about(left, np.radians(JAW) * _of(weights, "JAW"))
    yaw, pitch = (np.radians(GAZE_DEGREES) * _of(weights, name) for name in ("LOOK_LEFT", "LOOK_UP"))
    eyes = [there[f"{side}_eye"] for side in SIDES if f"{side}_eye" in there]
    if "gaze" in there and eyes:
        far = max(float((bones.heads[eyes].mean(0) - bones.heads[there["gaze"]]) @ back), 0.0)
        ways["gaze"] = far * (np.tan(yaw)[:, None] * left + np.tan(pitch)[:, None] * up)
    else:
        looks = quaternion.multiply(quaternion.about(up, yaw), quaternion.about(left, -pitch))
        turns |= {f"{side}_eye": looks for side in SIDES if f"{side}_eye" in there}
    wide = _eye_distance(bones, there)
    for side, out in zip(SIDES, (left, -left), strict=True):
        _lids(bones, there, side, (left, up), _of(weights, f"BLINK_{side.upper()}"), turns, ways)
        _mouth_and_brow(side, out, up, back, weights, wide, there, ways)
    rotations = {}
    for part, world in turns.items():
        rest = bones.rest[there[part]]
        rotations[parts[part]] = quaternion.multiply(quaternion.multiply(quaternion.conjugate(rest), world), rest)
    return rotations, {parts[part]: way @ bones.matrices[there[part], :3, :3] for part, way in ways.items()}


def _lids(
    bones: Bones, there: Named[str, int], side: str, axes: tuple[np.ndarray, np.ndarray], shut: np.ndarray,
    turns: dict[str, np.ndarray], ways: dict[str, np.ndarray]
) -> None:  # fmt: skip
    """Close an upper lid to the lower one by ``shut`` (frames,): rotate it if it starts in the eye, else slide it."""
    left, up = axes
    upper, lower, eye = (there.get(f"{side}_{part}") for part in ("upper_lid", "lower_lid", "eye"))
    if upper is None:
        return
    centre = bones.heads[upper if eye is None else eye]
    if _starts_at(bones, upper, centre):
        height = [_height(bones.tails[row] - centre, left, up) for row in (upper, lower) if row is not None]
        angle = height[0] - height[1] if len(height) == 2 else np.radians(FARTHEST)
        turns[f"{side}_upper_lid"] = quaternion.about(left, float(np.clip(angle, 0, np.radians(80))) * shut)
        return
    gap = bones.heads[upper] - bones.heads[lower] if lower is not None else _LID_TRAVEL * bones.lengths[eye] * up
    ways[f"{side}_upper_lid"] = -shut[:, None] * (gap @ up) * up


def _mouth_and_brow(
    side: str, out: np.ndarray, up: np.ndarray, back: np.ndarray, weights: np.ndarray, wide: float, there: Container[str],
    ways: dict[str, np.ndarray]
) -> None:  # fmt: skip
    """Move lip corners in for rounded, out for spread vowels and up for a smile; raise brows. ``wide`` scales all."""
    if f"{side}_lip_corner" in there:
        round_lips = np.clip(sum(_of(weights, name) for name in ("OU", "OH", "CH")), 0, 1)[:, None]
        broad = np.clip(_of(weights, "IH") + _of(weights, "SS") + _of(weights, "EH"), 0, 1)[:, None]
        mood = (_of(weights, "SMILE") - _of(weights, "FROWN"))[:, None]
        way = round_lips * (-_CORNER_IN * out - _CORNER_AHEAD * back) + broad * _CORNER_OUT * out
        ways[f"{side}_lip_corner"] = wide * (way + mood * (_CORNER_OUT * out + _CORNER_OUT * up))
    if f"{side}_brow" in there:
        raised = 0.5 * (_of(weights, "BROW_INNER") + _of(weights, "BROW_OUTER")) - _of(weights, "BROW_LOWER")
        ways[f"{side}_brow"] = wide * _BROW_RAISE * raised[:, None] * up


def _by_name(bones: Bones, rows: list[int]) -> dict[str, str]:
    """Find parts by their names; exact names first, then names that end with a known one."""
    plain = {row: plain_name(bones.names[row]) for row in rows if not bones.driven[row]}
    result = {}
    for part, names in _part_names().items():
        for side in SIDES if "{side}" in "".join(names) else ("",):
            spellings = [spelling for name in names for spelling in _spellings(name, side)]
            exact = (
                (rank, len(text), row) for rank, name in enumerate(spellings) for row, text in plain.items() if text == name
            )
            endings = (
                (rank, len(text), row)
                for rank, name in enumerate(spellings)
                if len(name) > 3 or part == "jaw"
                for row, text in plain.items()
                if text.endswith(name)
            )
            best = min(exact, default=None) or min(endings, default=None)
            if best is not None:
                result[f"{side}_{part}" if side else part] = bones.names[best[2]]
    return result


def _by_position(bones: Bones, free: list[int], frame: np.ndarray, named: dict[str, str]) -> dict[str, str]:
    """Find jaw, eyes and lids that are not among the ``named`` parts, by the positions of ``free`` bones."""
    left, back, up = frame
    along = bones.matrices[:, :3, 1]
    ahead = [row for row in free if along[row] @ -back > _MIN_AHEAD]
    tall = float(np.ptp(bones.heads @ up)) or 1.0
    middle = float(np.median(bones.heads @ left))
    result = {}
    pairs = [
        (float((bones.heads[first] - bones.heads[second]) @ left), first, second)
        for first in ahead
        for second in ahead
        if (out := bones.heads[first] @ left - middle) > 0.005 * tall
        and np.linalg.norm(bones.heads[first] - bones.heads[second] - 2 * out * left) < _MIRROR_TOLERANCE * out
        and abs(bones.lengths[first] - bones.lengths[second]) < 0.1 * bones.lengths[first]
    ]
    if not {"left_eye", "right_eye"} & named.keys() and pairs:
        level = [pair for pair in pairs if max(abs(along[row] @ up) for row in pair[1:]) < _MAX_TILT]
        if level:
            _, first, second = max(level)
            result |= {"left_eye": bones.names[first], "right_eye": bones.names[second]}
    eyes = {side: (result | named).get(f"{side}_eye") for side in SIDES}
    for side, name in eyes.items():
        if name is not None and f"{side}_upper_lid" not in named:
            result |= _lids_at(bones, bones.row(name), [row for row in free if bones.names[row] != name], side, up)
    low = [row for row in free if abs(bones.heads[row] @ left - middle) < 0.01 * tall and along[row] @ -back > 0.4
           and along[row] @ up < -_MIN_DROP]  # fmt: skip
    if "jaw" not in named and low:
        result["jaw"] = bones.names[max(low, key=lambda row: bones.lengths[row])]
    return result


def _lids_at(bones: Bones, eye: int, free: list[int], side: str, up: np.ndarray) -> dict[str, str]:
    """Find the lids among bones that start at an eye: the ones tilted most up and down against it."""
    near = [row for row in free if _starts_at(bones, row, bones.heads[eye])]
    tilt = {row: float((bones.matrices[row, :3, 1] - bones.matrices[eye, :3, 1]) @ up) for row in near}
    upper, lower = (choose(near, key=lambda row: tilt[row], default=None) for choose in (max, min))
    lids = {}
    if upper is not None and tilt[upper] > 0.1:
        lids[f"{side}_upper_lid"] = bones.names[upper]
    if lower is not None and tilt[lower] < -0.1:
        lids[f"{side}_lower_lid"] = bones.names[lower]
    return lids


def _beside_body(bones: Bones, mapping: Mapping) -> list[int]:
    """Return the rows that are neither mapped nor below the arms: face controls may have any other parent."""
    arms = {bones.row(name) for part, chain in mapping.chains.items() if "arm" in part or "hand" in part for name in chain}
    body = {bones.row(name) for chain in mapping.chains.values() for name in chain}
    return [row for row in range(len(bones.names)) if row not in body and not arms & set(bones.ancestors(row))]


def _spellings(name: str, side: str) -> list[str]:
    """Return a name of ``bones.json`` in all spellings of ``side`` ("" for none), as plain names."""
    if "{kanji}" in name:
        return [plain_name(name.replace("{kanji}", _KANJI[side]))]
    return [plain_name(name.replace("{side}", word)) for word in _SIDE_WORDS.get(side, ("",))]


@functools.lru_cache(maxsize=1)
def _part_names() -> dict[str, list[str]]:
    return json.loads((resources.files(str(__package__)) / "bones.json").read_text("utf-8"))


def _eye_distance(bones: Bones, there: Named[str, int]) -> float:
    """Return the distance between the eyes, 0 unless both are found."""
    both = [bones.heads[there[name]] for name in ("left_eye", "right_eye") if name in there]
    return float(np.linalg.norm(both[0] - both[1])) if len(both) == 2 else 0.0


def _height(way: np.ndarray, left: np.ndarray, up: np.ndarray) -> float:
    """Return the angle in radians of a direction above the horizontal, seen from the side."""
    flat = way - (way @ left) * left
    return float(np.arctan2(flat @ up, np.linalg.norm(flat - (flat @ up) * up)))


def _starts_at(bones: Bones, row: int, centre: np.ndarray) -> bool:
    """Return whether a bone starts near a point, compared with its end, and so rotates about it."""
    return bool(np.linalg.norm(bones.heads[row] - centre) <= _EYE_CENTRE_SHARE * np.linalg.norm(bones.tails[row] - centre))


def _of(weights: np.ndarray, channel: str) -> np.ndarray:
    """Return a channel (frames,) of ``weights`` (frames, channels)."""
    return np.asarray(weights[:, CHANNELS.index(channel)], float)
