"""Bones of a face: which of an armature they are, found by name and by place, and how a face's channels move them.

``bones.json`` has names in the order in which they are preferred, ``{side}`` for however a side is spelt. What has no name
that is known is looked for by place: a jaw that points ahead below the head, eyes that lie as each other's mirror image and
point ahead, lids that start where an eye does.
"""

import functools
import json
from collections.abc import Mapping as Named
from importlib import resources

import numpy as np

from ...core.motion import quaternion
from ...core.motion.face import CHANNELS, GAZE
from ..names import plain_name
from ..plain import Bones, Mapping, character_frame

SIDES = ("left", "right")
PARTS = (
    "jaw",
    "gaze",
    *(f"{side}_{part}" for side in SIDES for part in ("eye", "upper_lid", "lower_lid", "lip_corner", "brow")),
)
"""Parts of a face that bones can be; ``gaze`` is a control that eyes look at."""
JAW, FARTHEST = 22.0, 35.0
"""Degrees that a jaw is opened, and an upper lid closed where no lower one tells how far."""
_SPELT = {"left": ("l", "left"), "right": ("r", "right")}
_KANJI = {"left": "左", "right": "右"}
_AHEAD, _LEVEL, _LOWER, _MIRRORED = 0.75, 0.2, 0.15, 0.1
_AT_EYE = 0.35
"""Of a lid's way from the eye's centre, how far from there one starts that turns about it."""
_LID = 0.35
"""Of an eye's length, how far an upper lid goes down straight where no lower one tells."""
_CORNER_IN, _CORNER_AHEAD, _CORNER_OUT, _RAISED = 0.13, 0.05, 0.06, 0.13
"""Ways of lips' corners and brows, of the distance between the eyes."""


def find(bones: Bones, mapping: Mapping) -> dict[str, str]:
    """Bones by part of the face, of an armature whose body is known; those that constraints or drivers rule are none."""
    found = _by_name(bones, _beside_body(bones, mapping))
    taken = {bones.row(name) for name in found.values()}
    free = [row for row in _below_head(bones, mapping) if row not in taken and not bones.driven[row]]
    return {**_by_place(bones, free, character_frame(bones, mapping), found), **found}


def shown(parts: Named[str, str]) -> set[str]:
    """Channels that these parts show."""
    channels = {"jaw": ("JAW", "PP"), "gaze": ("LOOK_LEFT", "LOOK_UP"), "left_eye": ("LOOK_LEFT", "LOOK_UP")}
    channels |= {"left_upper_lid": ("BLINK_LEFT",), "left_lower_lid": ("BLINK_LEFT",), "right_upper_lid": ("BLINK_RIGHT",)}
    channels |= {"left_brow": ("BROW_INNER", "BROW_OUTER"), "left_lip_corner": ("SMILE", "OU")}
    return {channel for part in parts for channel in channels.get(part, ())}


def needed(parts: Named[str, str], shapes) -> dict[str, str]:
    """Those of ``parts`` that show what shape keys (:class:`.shapes.Shapes`, or None) do not."""
    there = set() if shapes is None else shapes.shown | set(shapes.rest)
    if shapes is not None:
        there |= {"SMILE", "OU"}
    return {part: name for part, name in parts.items() if not shown([part.replace("right", "left")]) & there}


def moved(bones: Bones, mapping: Mapping, parts: Named[str, str], weights: np.ndarray) -> tuple[dict, dict]:
    """``rotations`` ``{bone: (frames, 4)}`` and ``places`` ``{bone: (frames, 3)}``, each in the bone's own rest frame, by which
    ``parts`` show ``weights`` ``(frames, channels)``."""
    left, back, up = character_frame(bones, mapping)
    there = {part: bones.row(name) for part, name in parts.items() if name in bones.names}
    turns, ways = {}, {}
    if "jaw" in there:
        turns["jaw"] = quaternion.about(left, np.radians(JAW) * _of(weights, "JAW"))
    yaw, pitch = (np.radians(GAZE) * _of(weights, name) for name in ("LOOK_LEFT", "LOOK_UP"))
    eyes = [there[f"{side}_eye"] for side in SIDES if f"{side}_eye" in there]
    if "gaze" in there and eyes:
        far = max(float((bones.heads[eyes].mean(0) - bones.heads[there["gaze"]]) @ back), 0.0)
        ways["gaze"] = far * (np.tan(yaw)[:, None] * left + np.tan(pitch)[:, None] * up)
    else:
        looks = quaternion.multiply(quaternion.about(up, yaw), quaternion.about(left, -pitch))
        turns |= {f"{side}_eye": looks for side in SIDES if f"{side}_eye" in there}
    wide = _apart(bones, there)
    for side, out in zip(SIDES, (left, -left), strict=True):
        _lids(bones, there, side, (left, up), _of(weights, f"BLINK_{side.upper()}"), turns, ways)
        _mouth_and_brow(side, out, up, back, weights, wide, there, ways)
    rotations = {}
    for part, world in turns.items():
        rest = bones.rest[there[part]]
        rotations[parts[part]] = quaternion.multiply(quaternion.multiply(quaternion.conjugate(rest), world), rest)
    return rotations, {parts[part]: way @ bones.matrices[there[part], :3, :3] for part, way in ways.items()}


def _lids(bones: Bones, there, side: str, axes, shut: np.ndarray, turns: dict, ways: dict) -> None:
    """An upper lid down to the lower one: about the eye where it starts in it, else straight."""
    left, up = axes
    upper, lower, eye = (there.get(f"{side}_{part}") for part in ("upper_lid", "lower_lid", "eye"))
    if upper is None:
        return
    centre = bones.heads[upper if eye is None else eye]
    if _at(bones, upper, centre):
        height = [_height(bones.tails[row] - centre, left, up) for row in (upper, lower) if row is not None]
        angle = height[0] - height[1] if len(height) == 2 else np.radians(FARTHEST)
        turns[f"{side}_upper_lid"] = quaternion.about(left, float(np.clip(angle, 0, np.radians(80))) * shut)
        return
    gap = bones.heads[upper] - bones.heads[lower] if lower is not None else _LID * bones.lengths[eye] * up
    ways[f"{side}_upper_lid"] = -shut[:, None] * (gap @ up) * up


def _mouth_and_brow(side: str, out, up, back, weights, wide: float, there, ways: dict) -> None:
    """Corners of the lips in for round sounds, out for broad ones and up for a smile, and brows up."""
    if f"{side}_lip_corner" in there:
        round_lips = np.clip(sum(_of(weights, name) for name in ("OU", "OH", "CH")), 0, 1)[:, None]
        broad = np.clip(_of(weights, "IH") + _of(weights, "SS") + _of(weights, "EH"), 0, 1)[:, None]
        mood = (_of(weights, "SMILE") - _of(weights, "FROWN"))[:, None]
        way = round_lips * (-_CORNER_IN * out - _CORNER_AHEAD * back) + broad * _CORNER_OUT * out
        ways[f"{side}_lip_corner"] = wide * (way + mood * (_CORNER_OUT * out + _CORNER_OUT * up))
    if f"{side}_brow" in there:
        raised = 0.5 * (_of(weights, "BROW_INNER") + _of(weights, "BROW_OUTER")) - _of(weights, "BROW_LOWER")
        ways[f"{side}_brow"] = wide * _RAISED * raised[:, None] * up


def _by_name(bones: Bones, rows: list[int]) -> dict[str, str]:
    plain = {row: plain_name(bones.names[row]) for row in rows if not bones.driven[row]}
    found = {}
    for part, names in _known().items():
        for side in SIDES if "{side}" in "".join(names) else ("",):
            spelt = [one for name in names for one in _spelt(name, side)]
            fits = ((place, len(text), row) for place, one in enumerate(spelt) for row, text in plain.items() if text == one)
            ends = ((len(spelt) + place, len(text), row) for place, one in enumerate(spelt) if len(one) > 3 or part == "jaw"
                    for row, text in plain.items() if text.endswith(one))  # fmt: skip
            best = min(fits, default=None) or min(ends, default=None)
            if best is not None:
                found[f"{side}_{part}" if side else part] = bones.names[best[2]]
    return found


def _by_place(bones: Bones, free: list[int], frame: np.ndarray, found: dict[str, str]) -> dict[str, str]:
    """A jaw, eyes and lids that names do not tell."""
    left, back, up = frame
    along = bones.matrices[:, :3, 1]
    ahead = [row for row in free if along[row] @ -back > _AHEAD]
    tall = float(np.ptp(bones.heads @ up)) or 1.0
    middle = float(np.median(bones.heads @ left))
    result = {}
    pairs = [
        (float((bones.heads[one] - bones.heads[other]) @ left), one, other)
        for one in ahead
        for other in ahead
        if (out := bones.heads[one] @ left - middle) > 0.005 * tall
        and np.linalg.norm(bones.heads[one] - bones.heads[other] - 2 * out * left) < _MIRRORED * out
        and abs(bones.lengths[one] - bones.lengths[other]) < 0.1 * bones.lengths[one]
    ]
    if not {"left_eye", "right_eye"} & found.keys() and pairs:
        level = [pair for pair in pairs if max(abs(along[row] @ up) for row in pair[1:]) < _LEVEL]
        if level:
            _, one, other = max(level)
            result |= {"left_eye": bones.names[one], "right_eye": bones.names[other]}
    eyes = {side: (result | found).get(f"{side}_eye") for side in SIDES}
    for side, name in eyes.items():
        if name is not None and f"{side}_upper_lid" not in found:
            result |= _lids_at(bones, bones.row(name), [row for row in free if bones.names[row] != name], side, up)
    low = [row for row in free if abs(bones.heads[row] @ left - middle) < 0.01 * tall and along[row] @ -back > 0.4
           and along[row] @ up < -_LOWER]  # fmt: skip
    if "jaw" not in found and low:
        result["jaw"] = bones.names[max(low, key=lambda row: bones.lengths[row])]
    return result


def _lids_at(bones: Bones, eye: int, free: list[int], side: str, up: np.ndarray) -> dict[str, str]:
    near = [row for row in free if _at(bones, row, bones.heads[eye])]
    tilt = {row: float((bones.matrices[row, :3, 1] - bones.matrices[eye, :3, 1]) @ up) for row in near}
    upper, lower = max(near, key=tilt.get, default=None), min(near, key=tilt.get, default=None)
    found = {}
    if upper is not None and tilt[upper] > 0.1:
        found[f"{side}_upper_lid"] = bones.names[upper]
    if lower is not None and tilt[lower] < -0.1:
        found[f"{side}_lower_lid"] = bones.names[lower]
    return found


def _beside_body(bones: Bones, mapping: Mapping) -> list[int]:
    """Rows that are neither of the body nor hang on the arms: controls of a face may hang on anything else."""
    arms = {bones.row(name) for part, chain in mapping.chains.items() if "arm" in part or "hand" in part for name in chain}
    body = {bones.row(name) for chain in mapping.chains.values() for name in chain}
    return [row for row in range(len(bones.names)) if row not in body and not arms & set(bones.ancestors(row))]


def _below_head(bones: Bones, mapping: Mapping) -> list[int]:
    """Rows that hang on the head; none where it is not known."""
    head = mapping.chains.get("head", ())
    return [row for row in range(len(bones.names)) if head and bones.row(head[-1]) in bones.ancestors(row)]


def _spelt(name: str, side: str) -> list[str]:
    if "{kanji}" in name:
        return [plain_name(name.replace("{kanji}", _KANJI[side]))]
    return [plain_name(name.replace("{side}", one)) for one in _SPELT.get(side, ("",))]


@functools.lru_cache(maxsize=1)
def _known() -> dict[str, list[str]]:
    return json.loads((resources.files(__package__) / "bones.json").read_text("utf-8"))


def _apart(bones: Bones, there: Named[str, int]) -> float:
    both = [bones.heads[there[name]] for name in ("left_eye", "right_eye") if name in there]
    return float(np.linalg.norm(both[0] - both[1])) if len(both) == 2 else 0.0


def _height(way: np.ndarray, left: np.ndarray, up: np.ndarray) -> float:
    """Angle of a direction above the level, seen from the side."""
    flat = way - (way @ left) * left
    return float(np.arctan2(flat @ up, np.linalg.norm(flat - (flat @ up) * up)))


def _at(bones: Bones, row: int, centre: np.ndarray) -> bool:
    """Whether a bone turns about a point rather than lies far from it."""
    return bool(np.linalg.norm(bones.heads[row] - centre) <= _AT_EYE * np.linalg.norm(bones.tails[row] - centre))


def _of(weights: np.ndarray, channel: str) -> np.ndarray:
    return np.asarray(weights[:, CHANNELS.index(channel)], float)
