"""Who listens: a body that waits as captured listeners do, nods as the other's phrases end, and seldom denies.

Listeners nod most often as a phrase of the other ends (Dittmann and Llewellyn 1968); they look at who speaks (Kendon 1967)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..motion import skeleton
from ..smoothing import gaussian
from . import idling

_CHANCE = {"accept": 0.55, "deny": 0.06}
"""Probability of a captured nod or denial as a phrase of the other ends."""
_PERSONAL, _WARMER = ("i", "me", "my", "mine", "myself", "we", "us", "our", "you", "your"), 1.5
"""Words of a phrase that is about the speaker or the listener, and how much more often and more that is answered."""
_SIZE = (0.4, 0.7)
"""Its share of the captured one, who answered a question and not a talk."""
_MIN_GAP = 1.2
"""Seconds between two responses."""
_DELAY = (-0.35, 0.15)
"""Seconds from the end of a phrase to the start of the response, which shows a little later."""
_MAX_TURN, _SPEAKING_SHARE, _TURN_EASE = 55.0, 0.35, 0.35
"""Degrees that a head turns towards the other speaker, the share of them while it speaks itself, and the easing in seconds."""


class Response(NamedTuple):
    """A response of a ``kind`` (accept or deny) from ``at`` seconds on: ``numbers`` ``(frames, 27 + SIZE)`` to be added."""

    kind: str
    at: float
    numbers: np.ndarray


def draw_responses(
    phrases: np.ndarray, hears: np.ndarray, seed: int = 0, words: Sequence[tuple] = (), fps: float = skeleton.FPS
) -> list[Response]:  # fmt: skip
    """Draw a listener's responses to the ends of another's ``phrases`` ``(p, 2)`` in seconds, of ``words`` (word, start, end).

    ``hears`` ``(frames,)`` in 0..1 says how far it listens in each frame."""
    personal = np.array([time for word, time, _ in words if word.casefold().partition("'")[0] in _PERSONAL])
    rng, responses, free = np.random.default_rng((seed, 0x115)), [], 0.0
    for start, end in np.asarray(phrases).reshape(-1, 2):
        warm = _WARMER if ((personal >= start) & (personal < end)).any() else 1.0
        at = max(float(end + rng.uniform(*_DELAY)), 0.0)
        chances = warm * np.array([*_CHANCE.values()])
        kind, size = rng.choice([*_CHANCE, ""], p=[*chances, 1 - chances.sum()]), warm * rng.uniform(*_SIZE)
        clip = idling.answer(str(kind), rng) if kind else None
        if clip is not None and at >= free and hears[min(int(at * fps), len(hears) - 1)] > 0.5:
            responses.append(Response(str(kind), at, size * (clip - clip[0])))
            free = at + len(clip) / skeleton.FPS + _MIN_GAP
    return responses


def listen(frames: int, responses: list[Response], style: str = "", seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Return how far the directions ``(frames, 9, 3)`` of a listener are from where they rest, and hands ``(frames, SIZE)``."""
    body = idling.listening(frames, style, seed)
    for one in responses:
        first = round(one.at * skeleton.FPS)
        body[first : first + len(one.numbers)] += one.numbers[: max(frames - first, 0)]
    return body[:, :27].reshape(-1, 9, 3), body[:, 27:]


def turn_head_toward(directions: np.ndarray, toward: float, hears: np.ndarray | None, fps: float = skeleton.FPS) -> np.ndarray:
    """Turn the head of directions ``(frames, 9, 3)`` by ``toward`` degrees to the left: wholly where it ``hears``
    ``(frames,)``, 0..1, else a little."""
    if not toward:
        return directions
    share = np.zeros(len(directions)) if hears is None else gaussian(hears, _TURN_EASE * fps)
    turn = -np.clip(toward, -_MAX_TURN, _MAX_TURN) * (_SPEAKING_SHARE + (1 - _SPEAKING_SHARE) * share)
    result = directions.copy()  # all else stays to the bit
    for edge in skeleton.HEAD:
        result[:, edge] = skeleton.normalize(skeleton.rotate_about_axis(directions[:, edge].astype(float), 1, turn))
    return result
