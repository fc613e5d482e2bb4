"""What every kind of network is asked in one way: to perform what was heard, all frames of all takes."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..motion import hand_numbers, requested, skeleton
from ..smoothing import gaussian
from . import answering, asking, course, drawing, tempo
from .casting import Performers
from .hearing import Heard

_CALM, _BRIEF = 0.3, 0.2
"""By how much chance is less in silence, and the seconds over which that comes and goes."""
_NEAR, _OF_STROKE = 0.25, requested.CHANNELS.index("stroke")
"""Seconds beside a stroke in which arms begin to wait, and the channel that says where strokes are."""


class Made(NamedTuple):
    """What a network made of each take: ``directions`` ``(takes, frames, 9, 3)`` float32 as it drew them, hands on them as
    ``numbers`` ``(frames, SIZE)`` (:mod:`hand_numbers`; None where it draws none), and how far each frame is from the strokes
    that were asked for, ``idle`` ``(frames,)`` in 0..1.
    """

    directions: np.ndarray
    numbers: Sequence[np.ndarray | None]
    idle: Sequence[np.ndarray | float]

    def split(self, counts: Sequence[int]) -> list["Made"]:
        """The first so many takes, the next so many, and so on."""
        ends = np.cumsum(counts)
        return [Made(*(part[end - n : end] for part in self)) for n, end in zip(counts, ends, strict=True)]


def perform(
    checkpoint,
    heard: Heard,
    cast: Sequence[Performers],
    progress: Callable[[float], None] = lambda value: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> Made:
    """All takes of all performers, those of a request after those before it."""
    told = progress, cancelled
    if not checkpoint.draws:
        from ..model import windows

        generator = checkpoint.network.generator
        latents, seeds = _latents(heard, cast), np.concatenate([one.seeds for one in cast])
        made = windows.generate(generator, heard.features.slice, latents, seeds, heard.frames, checkpoint.window[0], *told)
        return Made(made, (None,) * len(made), (0.0,) * len(made))
    asked = [_asked(checkpoint, heard, one) for one in cast]
    manner = {"lively": _lively(heard.activity), "tempo": tempo.follow(heard.rhythm, heard.activity)}
    drawn, extras = drawing.draw(checkpoint.network, heard.features.slice, cast, asked, heard.frames, *told, **manner)
    idle = [part for one, wishes in zip(cast, asked, strict=True) for part in _idle(heard, one, wishes)]
    hands = extras.shape[-1] == hand_numbers.SIZE
    return Made(drawn, extras if hands else (None,) * len(drawn), idle)


def _asked(checkpoint, heard: Heard, performers: Performers) -> np.ndarray | None:
    """Strokes that each take is asked for ``(takes, frames, 7)``: what the words wish, and accents that its taste answers."""
    frames, request = heard.frames, performers.request
    if not checkpoint.meanings:
        return None
    wishes = {name: course.over(request, name, frames) for name in ("rate", "hand", "arousal")}
    written = asking.channels(heard.wishes, heard.words, checkpoint.meanings, frames, wishes["hand"])
    tastes = _tastes(heard, performers)
    if tastes is None:
        return None if written is None else np.repeat(written[None], len(performers.latents), axis=0)
    told = np.zeros((frames, len(requested.CHANNELS)), np.float32) if written is None else written
    taken = told[:, 0] > 0
    keys = [(request.seed, identity, performers.who) for identity in request.identities]
    turns = () if performers.begins is None else performers.begins / skeleton.FPS
    chosen = [answering.channels(heard.rhythm, tastes, wishes, key, taken, turns) for key in keys]
    return np.stack([np.where(taken[:, None], told, one) for one in chosen])


def _tastes(heard: Heard, performers: Performers) -> np.ndarray | None:
    """Tastes ``(frames or 1, 8)`` by which takes choose their accents, None where they do not."""
    return performers.taste(heard.frames) if heard.rhythm is not None and heard.rhythm.accents else None


def _idle(heard: Heard, performers: Performers, asked: np.ndarray | None) -> list[np.ndarray | float]:
    """How far each frame ``(frames,)`` of each take is from the strokes that it chose, in 0..1; 0 where it chose none."""
    if asked is None or _tastes(heard, performers) is None:
        return [0.0] * len(performers.latents)
    busy = asked[..., _OF_STROKE] > 0
    busy[:, performers.given(heard.frames).frames] = True
    return [1 - np.clip(gaussian(take.astype(float), _NEAR * skeleton.FPS), 0, 1) for take in busy]


def _lively(activity: np.ndarray) -> np.ndarray:
    """How much chance has its way ``(frames,)``: less where nobody speaks, as people's waiting hands are less various."""
    return 1 - _CALM * (1 - gaussian(activity, _BRIEF * skeleton.FPS))


def known_by(checkpoint, heard: Heard, cast: Sequence[Performers]) -> tuple:
    """All that a performance depends on beside recording, words and network: equal for requests that give the same."""
    latents = _latents(heard, cast)
    if not checkpoint.draws:
        return latents.shape, latents.tobytes(), np.concatenate([one.seeds for one in cast]).tobytes()
    given = [one.given(heard.frames) for one in cast]
    kept = tuple((one.frames.tobytes(), one.directions.tobytes()) for one in given)
    drawn = tuple((one.request.seed, tuple(one.request.identities), one.request.hand, str(one.request.curves)) for one in cast)
    return latents.shape, latents.tobytes(), kept, drawn


def joins(checkpoint, frames: int) -> list[int]:
    """Frames at which windows of a performance of so many ``frames`` meet; none where all frames are drawn as one."""
    if checkpoint.draws:
        return []
    from ..model import windows

    return windows.starts(frames, *checkpoint.window)[1:]


def _latents(heard: Heard, cast: Sequence[Performers]) -> np.ndarray:
    walking = any(one.varies for one in cast)
    return np.concatenate([one.on_the_way(heard.frames if walking else 1) for one in cast])
