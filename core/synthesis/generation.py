"""The stage *draw*: what every kind of network makes of the speech it hears, all frames of all takes."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..motion import hand_channels, rest, skeleton, stroke_requests
from ..smoothing import gaussian
from . import accent_selection, curves, flow_sampling, refine, stroke_conditions, time_warp
from .features import SpeechFeatures
from .style_sequence import SIZE, StyleSequence

_CALM, _CALM_EASE = 0.3, 0.2
"""Noise is reduced by this share in silence; seconds over which that sets in."""
_CALMER, _LIVELIER = 0.36, 0.1
"""... and by this share at an arousal of -1, mostly near it, and what it gains at 1: chance has most of the arms' movement, and
calm bodies are to have little."""
_OTHER_HAND, _LEADING_HAND = 1.2, 0.4
"""... and for the arm that never leads, and what the leading one gains: equal chance makes arms move more alike than people."""
_CHANCE = np.array([1.0, 0.7, 0.7, 1.05, 1.03, 1.03, 1.05, 1.03, 1.03, 1.0])
"""... and of each direction and of hands: with equal chance heads turn twice as often as people's, and not with the arms."""
_BANDS, _LED = np.array([1.5, 2.6]), np.array([1.0, 0.5])
"""... and of an arm in bands (:func:`noise.in_bands`): people stay and beat more. How much of each the leading hand decides."""


class GeneratedTakes(NamedTuple):
    """What a network made of each take, without tremble: ``directions`` ``(takes, frames, 9, 3)`` float32, and hands on them as
    ``numbers`` ``(frames, SIZE)`` (:mod:`hand_channels`; None where it draws none)."""

    directions: np.ndarray
    numbers: Sequence[np.ndarray | None]

    def split(self, counts: Sequence[int]) -> list["GeneratedTakes"]:
        """Split into the first ``counts[0]`` takes, the next ``counts[1]``, and so on."""
        ends = np.cumsum(counts).tolist()
        spans = [slice(end - count, end) for end, count in zip(ends, counts, strict=True)]
        return [GeneratedTakes(self.directions[here], self.numbers[here]) for here in spans]


def generate(
    checkpoint: Any, heard: SpeechFeatures, cast: Sequence[StyleSequence],
    progress: Callable[[float], None] = lambda value: None, cancelled: Callable[[], bool] = lambda: False
) -> GeneratedTakes:  # fmt: skip
    """Generate all takes of all performers, those of a request after those of the one before it.

    ``checkpoint`` is a :class:`loaded_checkpoint.LoadedCheckpoint` network."""
    if not checkpoint.draws:
        from ..model import windows

        poses = [(one.first, one.rest(heard.frames)) for one in cast for _ in one.latents]
        inputs = heard.features.slice, heard.frames, _latents(heard, cast), poses
        return GeneratedTakes(windows.perform(checkpoint, *inputs, progress, cancelled), (None,) * len(poses))
    about = accent_selection.CONTROLS, heard.affect, heard.frames, skeleton.FPS
    wishes = [curves.asked_and_heard(one.request, *about) for one in cast]
    tastes = [one.taste(heard.frames) for one in cast]
    asked = [_asked_strokes(checkpoint, heard, *each) for each in zip(cast, tastes, wishes, strict=True)]
    lively = [_noise_scale(heard.activity, *each) for each in zip(tastes, wishes, strict=True)]
    settings = {"lively": lively, "tempo": time_warp.warp_for(heard.rhythm, heard.activity)}
    inputs = heard.features.slice, cast, asked, heard.frames, progress, cancelled
    drawn, extras = flow_sampling.sample(checkpoint.network, *inputs, **settings)
    poses = [pose for one in cast for pose in [one.rest(heard.frames)] * len(one.latents)]
    kept = [frames for one in cast for frames in [one.given(heard.frames).frames] * len(one.latents)]
    calm = [rest.hold_still(rest.remove_jitter(*each), each[1]) for each in zip(drawn, kept, strict=True)]
    large = [rest.raise_head(rest.scale_amplitude(one, SIZE, pose)) for one, pose in zip(calm, poses, strict=True)]
    given = [at[1:].tolist() for at in kept]  # without the start, which is always given
    arms = [refine.refine(one, rules=refine.DRAWN, given=at) for one, at in zip(large, given, strict=True)]
    if extras.shape[-1] != hand_channels.SIZE:
        return GeneratedTakes(np.stack(arms), [None] * len(drawn))
    return GeneratedTakes(np.stack(arms), [rest.remove_jitter_of_numbers(*each) for each in zip(extras, kept, strict=True)])


def _asked_strokes(
    checkpoint: Any, heard: SpeechFeatures, performers: StyleSequence, tastes: np.ndarray | None, controls: Mapping
) -> np.ndarray | None:
    """Return the strokes that each take is asked for ``(takes, frames, 7)``: those of marks in the words, then accents that
    its ``tastes`` (:meth:`StyleSequence.taste`) answer."""
    frames, request = heard.frames, performers.request
    if not checkpoint.meanings:
        return None
    written = stroke_conditions.stroke_channels(heard.wishes, heard.words, checkpoint.meanings, frames, controls["hand"])
    rhythm = heard.rhythm
    if tastes is None or rhythm is None or not rhythm.accents:
        return None if written is None else np.repeat(written[None], len(performers.latents), axis=0)
    marked = np.zeros((frames, len(stroke_requests.CHANNELS)), np.float32) if written is None else written
    taken = marked[:, 0] > 0
    turns = () if performers.begins is None else performers.begins / skeleton.FPS
    keys = [(request.keyed_seed, identity, performers.who) for identity in request.identities]
    accents = [accent_selection.accent_channels(rhythm, tastes, controls, key, taken, turns) for key in keys]
    return np.stack([marked if one is None else np.where(taken[:, None], marked, one) for one in accents])


def _noise_scale(activity: np.ndarray, tastes: np.ndarray | None, wishes: Mapping) -> np.ndarray:
    """Return the scale of the noise of each direction and of hands ``(frames, 10, 2)`` in bands: smaller in silence, as waiting
    hands are less various, where arousal is low, and for the arm that leads less."""
    quiet = 1 - _CALM * (1 - gaussian(activity, _CALM_EASE * skeleton.FPS))
    aroused = wishes[accent_selection.AROUSAL]
    usual = quiet * (1 - _CALMER * np.maximum(-aroused, 0) ** 1.5 + _LIVELIER * np.maximum(aroused, 0))
    scale = np.repeat((usual[:, None] * _CHANCE)[..., None], 2, axis=2)
    right = np.zeros(len(activity)) if tastes is None else accent_selection.right_leads(tastes, wishes)
    for arm, other in zip(skeleton.ARMS, (right, -right), strict=True):
        less = np.minimum(np.where(other > 0, _OTHER_HAND, _LEADING_HAND) * other, 1)
        scale[:, arm] *= ((1 - less[:, None] * _LED) * _BANDS)[:, None]
    return scale


def cache_key(checkpoint: Any, heard: SpeechFeatures, cast: Sequence[StyleSequence]) -> tuple:
    """Return all that a performance depends on beside recording, words and network: a key of the session's cache."""
    latents = _latents(heard, cast)
    if not checkpoint.draws:
        return latents.shape, latents.tobytes(), np.stack([one.first for one in cast]).tobytes()
    kept = tuple((own.frames.tobytes(), own.directions.tobytes()) for own in (one.given(heard.frames) for one in cast))
    drawn = tuple((one.keyed_seed, *one.identities, one.hand, str(one.curves)) for one in (each.request for each in cast))
    return latents.shape, latents.tobytes(), kept, drawn


def _latents(heard: SpeechFeatures, cast: Sequence[StyleSequence]) -> np.ndarray:
    frames = heard.frames if any(one.varies for one in cast) else 1
    return np.concatenate([one.on_the_way(frames) for one in cast])
