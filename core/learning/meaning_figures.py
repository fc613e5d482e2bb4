"""Measures whether every schema's gestures differ from the plain performance as they are meant.

Each form of each schema is performed at the word in three styles, by a document (docs/meaning.md), and measured at its stroke:
how far wrists go up, out and forward, how far apart hands are, how round a path is and how often it turns back, how near to the
chest a hand is, which fingers are straight, how far the head turns and shoulders rise.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from os import PathLike
from typing import NamedTuple

import numpy as np

from ..motion import handshape, skeleton
from ..motion.motion import Motion
from ..synthesis.request import Request
from ..synthesis.session import Session

STYLES = ("calm lecturer", "stern", "excited teenager")
_STRAIGHT, _SIDE = 35.0, ("left", "right")
"""A finger that is bent less, in degrees, is straight."""
_AFTER = 1.2
"""Seconds after a stroke in which head and shoulders are seen."""
NUMBERS = ("one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
_WIDER, _CLOSER = ("wide", "grow", "big", "split", "open"), ("merge",)
_OUT, _IN = ("forward", "future", "push", "give", "throw", "out", "far", "refusal"), ("back", "past", "pull", "take", "come")
_DOWN = ("fall", "low", "force", "certain", "now", "here", "step")
_UP = ("rise", "high", "think", "listen", "phone", "eat")
_ACROSS = ("across", "wave", "away", "we", "around", "there", "whole", "many", "contrast")
_SMALL = ("small", "narrow", "near", "shrink", "container", "hold", "close", "few", "part")
_ROUND = {"circle": 60.0, "mix": 300.0, "repeat": 300.0}
"""Least degrees, less where a path is not round; of two hands that draw a circle each draws half."""
_TIMES = {"shake": 3, "balance": 2}
_CHEST, _SWING = np.array([0.0, 0.15, 0.12]), 0.03
"""Where the chest is below the shoulders and before them; metres of a swing that counts."""
_EITHER = ("long", "surface", "line", "cut", "in", "fast", "greet")
"""Schemas whose forms go different ways, but far."""


class Shown(NamedTuple):
    """A gesture as it was performed in a style: ``forms`` count from 1."""

    schema: str
    form: int
    style: str
    motion: Motion
    plain: Motion
    lands: float
    seconds: float


def perform(
    session: Session,
    schemas: Sequence[str],
    styles: Sequence[str],
    word: str,
    recording: str | PathLike,
    transcript: str | PathLike,
) -> Iterator[Shown]:
    """Yield every form of the schemas, performed at the word of a recording with a transcript, both files, in each style."""
    known = session.vocabulary
    for style in styles:
        request = Request(recording, transcript=transcript, style=style, seed=1, hands=1.0)
        plain = session.synthesize(replace(request, meanings={"format": 1, "gestures": []})).motions[0]
        for schema in schemas:
            for form, gesture in enumerate(known.forms[schema], 1):
                asked = {"words": word, "schema": schema, "form": form, "size": 1.0}
                wanted = replace(request, meanings={"format": 1, "gestures": [asked]})
                motion = session.synthesize(wanted).motions[0]
                yield Shown(schema, form, style, motion, plain, motion.meta["shows"][0][1], gesture.seconds)


class Body(NamedTuple):
    """What is measured of a figure: wrists ``(frames, 2, 3)`` in metres from the middle between its shoulders, left first, y
    down and z forward; unit directions of the head ``(frames, 3)`` and of the clavicles ``(frames, 2, 3)``; fingers that are
    straight ``(frames, 2)``."""

    wrists: np.ndarray
    head: np.ndarray
    clavicles: np.ndarray
    straight: np.ndarray


def canonical(motion: Motion) -> Body:
    """Return the canonical figure that performs a motion."""
    joints = skeleton.to_positions(motion.directions)
    shoulders = joints[:, [skeleton.EDGES[upper][0] for upper, _ in skeleton.ARMS]].mean(1, keepdims=True)
    wrists = joints[:, [skeleton.EDGES[fore][1] for _, fore in skeleton.ARMS]] - shoulders
    assert motion.hands is not None
    fingers = motion.hands.shape
    bent = np.stack([handshape.columns(fingers, part) for part in ("base", "rest")]).max(0) > _STRAIGHT
    thumbs = handshape.column(fingers, "thumb_out") > 40
    straight = (~bent).sum(-1) + thumbs * (~bent).all(-1)
    return Body(wrists, motion.directions[:, 2], motion.directions[:, [3, 6]], straight)


def span(shown: Shown) -> tuple[int, int]:
    """Return the first and the last frame of a gesture's stroke."""
    return round(max(shown.lands - shown.seconds, 0) * skeleton.FPS), round(shown.lands * skeleton.FPS)


def figures(shown: Shown) -> dict[str, float]:
    """Return what is seen of a gesture on the canonical figure (:func:`measure`)."""
    return measure(shown.schema, *span(shown), canonical(shown.motion), canonical(shown.plain))


def measure(schema: str, first: int, last: int, body: Body, plain: Body) -> dict[str, float]:
    """Return what is seen of a stroke, in metres, degrees and fingers; arms are those that differ most from the plain take."""
    places = body.wrists
    arm = int(np.linalg.norm(np.diff(places[first : last + 1], axis=0), axis=-1).sum(0).argmax())
    way = places[first : last + 1, arm] * (-1 if arm == 0 else 1, -1, 1)  # outward, up, forward
    gap = np.linalg.norm(places[:, 0] - places[:, 1], axis=-1)
    straight = body.straight[last + 1]
    near = slice(first, last + round(_AFTER * skeleton.FPS))
    head = np.degrees(np.arcsin(np.clip(body.head[near, 0] - plain.head[near, 0], -1, 1)))
    lift = [-one.clavicles[near, arm, 1].min() for one in (body, plain)]
    return {
        "away": float(np.linalg.norm(places - plain.wrists, axis=-1)[last].max()),
        "way": float(np.linalg.norm(np.diff(way, axis=0), axis=-1).sum()),
        "up": float(way[-1, 1] - way[0, 1]),
        "height": float(way[-1, 1]),
        "out": float(way[:, 0].max() - way[:, 0].min()),
        "side": float(places[last, arm, 0]),
        "forward": float(way[-1, 2] - way[0, 2]),
        "gap": float(gap[last]),
        "widened": float(gap[last] - gap[first]),
        "round": _round(way),
        "swings": float(max(_swings(along) for along in way.T)),
        "chest": float(np.linalg.norm(places[last] - _CHEST, axis=-1).min()),
        "held": 0.0 if straight[arm] <= 1 else float(gap[last]),
        "fingers": float(straight.sum() if schema in NUMBERS[5:] else straight[arm]),
        "shake": float(np.ptp(head)),
        "shoulders": float(np.degrees(lift[0] - lift[1])),
    }


def _round(way: np.ndarray) -> float:
    """Return the degrees by which a path turns about its middle, in the plane in which it is largest, times how round it is."""
    flat = way - way.mean(0)
    _, sizes, axes = np.linalg.svd(flat, full_matrices=False)
    turned = np.diff(np.unwrap(np.arctan2(*(flat @ axes[:2].T).T)))
    return float(np.degrees(np.abs(turned.sum())) * sizes[1] / max(sizes[0], 1e-9))


def _swings(along: np.ndarray) -> int:
    """Return how often a hand turns back along an axis, by more than :data:`_SWING`."""
    turns, way, farthest = 0, 0, along[0]
    for place in along:
        if way * (place - farthest) >= 0:
            farthest, way = place, way or int(np.sign(place - along[0]))
        elif abs(place - farthest) > _SWING:
            turns, way, farthest = turns + 1, -way, place
    return turns


def meant(schema: str, seen: dict[str, float]) -> tuple[str, bool]:
    """Return the figure that a schema is about, and whether it is as meant."""
    if schema in NUMBERS:
        return "fingers", seen["fingers"] == NUMBERS.index(schema) + 1
    for figure, schemas, least in (
        ("widened", _WIDER, 0.1), ("up", _UP, 0.08), ("forward", _OUT, 0.1), ("out", _ACROSS, 0.15),
    ):  # fmt: skip
        if schema in schemas:
            return figure, seen[figure] >= least
    for figure, schemas, most in (("widened", _CLOSER, -0.05), ("up", _DOWN, -0.06), ("forward", _IN, -0.08)):
        if schema in schemas:
            return figure, seen[figure] <= most
    if schema in _EITHER:
        return "way", seen["way"] >= 0.2
    if schema in _SIDE:
        return "side", seen["side"] * (-1 if schema == "left" else 1) > 0.2
    if schema in _ROUND:
        return "round", seen["round"] >= _ROUND[schema]
    if schema in _TIMES:
        return "swings", seen["swings"] >= _TIMES[schema]
    if schema in _SMALL:
        return "held", seen["held"] <= 0.32 and seen["away"] >= 0.1
    if schema in ("me", "heart"):
        return "chest", seen["chest"] <= 0.25
    if schema == "shrug":
        return "shoulders", seen["shoulders"] >= 7
    if schema == "negation":
        return "shake", seen["shake"] > 2
    return "away", seen["away"] >= 0.1
