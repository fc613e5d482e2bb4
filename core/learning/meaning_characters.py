"""Measures gestures of meaning on a character as Blender keys it, by the figures of :mod:`meaning_figures`."""

import re
from collections.abc import Sequence

import numpy as np

from .. import characters
from ..motion import skeleton
from ..motion.readers.ten_joints import Posed
from . import meaning_figures
from .evaluate import talk_characters
from .meaning_figures import Body, Shown

_BEFORE, _AFTER = 0.7, 1.4
"""Seconds before and after a stroke that are keyed; in the first an arm is led on from the piece before."""
_FINGERS = ("index", "mid", "ring", "pink|little")
_STRAIGHT, _THUMB = 42.0, 35.0
"""Degrees below which fingers and the thumb are straight."""
_ARM = float(skeleton.LENGTHS[list(skeleton.ARMS[0])].sum())


def figures(character: str, shown: Sequence[Shown], run: talk_characters.Run) -> list[dict[str, float]]:
    """Key every gesture, and each style's plain take, on a character; return what is seen of each.

    Lengths are those of an arm as long as the canonical figure's. Raises :class:`S2agError` where Blender or the character is
    missing."""
    plain = {one.style: one.plain for one in shown}
    spans = [meaning_figures.span(one) for one in shown]
    starts = [max(first - round(_BEFORE * skeleton.FPS), 0) for first, _ in spans]
    pieces = [
        talk_characters.cut(one.motion, slice(start, last + round(_AFTER * skeleton.FPS)))
        for one, start, (_, last) in zip(shown, starts, spans, strict=True)
    ]
    keyed = [*plain.values(), *pieces]
    body = _body(talk_characters.keyed(characters.resolve(character), keyed, run), character)
    edges = np.cumsum([0, *(len(motion.directions) for motion in keyed)]).tolist()
    parts = [Body(*(each[low:high] for each in body)) for low, high in zip(edges, edges[1:], strict=False)]
    beside = dict(zip(plain, parts, strict=False))
    seen = []
    for one, (first, last), start, part in zip(shown, spans, starts, parts[len(plain) :], strict=True):
        cut = Body(*(each[start : start + len(part.head)] for each in beside[one.style]))
        seen.append(meaning_figures.measure(one.schema, first - start, last - start, part, cut))
    return seen


def _body(posed: Posed, character: str) -> Body:
    """Return what is measured of a character."""
    joints = talk_characters.joint_places(posed, character)
    arm = np.linalg.norm(np.diff(joints[0, 4:7], axis=0), axis=-1).sum()
    wrists = (joints[:, [6, 9]] - joints[:, [4, 7]].mean(1, keepdims=True)) * (_ARM / arm)
    clavicles = skeleton.normalize(joints[:, [4, 7]] - joints[:, [1]])
    return Body(wrists, skeleton.normalize(joints[:, 3] - joints[:, 2]), clavicles, straight_fingers(posed))


def straight_fingers(posed: Posed) -> np.ndarray:
    """Return how many fingers of each hand are straight ``(frames, 2)``; the thumb counts where all others are."""
    counted = []
    for side in ("left", "right"):
        wrist = posed.positions[:, posed.row(f"{side}_wrist")]
        chains = [_chain(posed, side, finger) for finger in _FINGERS]
        bends = [_bend(np.concatenate([wrist[:, None], chain], 1)) for chain in chains]
        straight = np.stack(bends) < _STRAIGHT
        thumb = _bend(np.concatenate([wrist[:, None], _chain(posed, side, "thumb")], 1)) < _THUMB
        counted.append(straight.sum(0) + thumb * straight.all(0))
    return np.stack(counted, -1)


def _chain(posed: Posed, side: str, finger: str) -> np.ndarray:
    """Return the joints of a finger ``(frames, joints, 3)`` from the knuckle on; bones in the palm are left out."""
    letter = side[0]
    of_side = re.compile(rf"{side}|[._ ]{letter}([._ ]|$)|(^|[._ ]){letter}[._ ]", re.IGNORECASE)
    rows = [
        row
        for row, name in enumerate(posed.names)
        if re.search(finger, name, re.IGNORECASE) and of_side.search(name) and not re.search("meta|palm", name, re.IGNORECASE)
    ]
    if len(rows) < 2:
        raise ValueError(f"no joints of the {side} hand are called {finger}")
    return posed.positions[:, rows]


def _bend(chain: np.ndarray) -> np.ndarray:
    """Return the largest angle in degrees ``(frames,)`` between a bone and the one before it."""
    bones = skeleton.normalize(np.diff(chain, axis=1))
    return np.degrees(np.arccos(np.clip((bones[:, 1:] * bones[:, :-1]).sum(-1), -1, 1))).max(1)
