"""Sounds by ear alone, where nobody wrote the words down: the aligner's model of speech asked for single sounds.

Which sound it is, the model tells poorly without words; which kind of mouth makes it, well enough for lips.
"""

from functools import lru_cache

import numpy as np

from ..sound import voice
from ..words.align import Phone, pcm
from ..words.aligner import cepstra, packed
from ..words.aligner.acoustic import AcousticModel

_CHANGE, _GRAMMAR = 2.0, 2.0
"""Nats that going on with another sound costs, and how much it counts which sound follows which in English words."""
_LIPS = 8.0
"""Nats by which a sound of closed lips is favoured: one too many is seen less than one that is missed.

Of those heard about half are too many."""
_LATER = 0.006
_BEST = 1
_RARE = 20.0
"""Times that every pair of sounds is taken to have been met, so that none is impossible."""
_CLOSED = "PBM"


def sounds(audio: np.ndarray) -> tuple[Phone, ...]:
    """``(phone, start, end)`` of a recording ``(n,)`` at 16 kHz, in order of time; none where nobody speaks."""
    found: list[Phone] = []
    spans = voice.stretches(voice.probability(audio), 0.1, 0.3)
    sound = np.concatenate([np.zeros(0, "<i2"), *(np.frombuffer(piece, "<i2") for piece in pcm(audio))])
    for start, end in spans:
        found += _stretch(sound[int(start * 16000) : int(end * 16000)], start)
    return tuple(found)


def _stretch(sound: np.ndarray, start: float) -> list[Phone]:
    features = cepstra.features(np.array(sound))
    if len(features) < 4:
        return []
    model = _model()
    alone = model.together(np.unique(model.alone))
    column = np.searchsorted(np.sort(alone), model.alone)
    scores = model.scores(model.hear(features, _BEST), alone)
    order = np.argsort(alone)
    path = _path(scores[:, order][:, column], model)
    names = list(model.phones)
    edges = np.flatnonzero(np.diff(path, prepend=-1, append=-1))
    found = [(names[path[begin]], int(begin), int(stop)) for begin, stop in zip(edges[:-1], edges[1:], strict=True)]
    at = start + _LATER
    return [(name, at + begin / 100, at + stop / 100) for name, begin, stop in found if name.isalpha() and name != "SIL"]


def _path(scores: np.ndarray, model: AcousticModel) -> np.ndarray:
    """The best sound of every frame ``(frames,)``: each has three states in a row, any may follow any."""
    frames, count, states = scores.shape
    stay, leave, follows = model.stay, model.leave, _follows(model)
    state = np.full((count, states), -1e30, np.float32)
    state[:, 0] = scores[0, :, 0]
    moved, came = np.zeros((frames, count, states), bool), np.zeros((frames, count), np.int32)
    enter, every = np.empty_like(state), np.arange(count)
    for frame in range(1, frames):
        out = state[:, -1] + leave[:, -1]
        ways = out + follows
        came[frame] = ways.argmax(axis=1)
        enter[:, 0] = ways[every, came[frame]]
        enter[:, 1:] = state[:, :-1] + leave[:, :-1]
        state += stay
        np.greater(enter, state, out=moved[frame])
        np.maximum(state, enter, out=state)
        state += scores[frame]
    phone, at = int(state[:, -1].argmax()), states - 1
    path = np.empty(frames, np.int64)
    for frame in range(frames - 1, -1, -1):
        path[frame] = phone
        if moved[frame, phone, at]:
            if at:
                at -= 1
            else:
                phone, at = int(came[frame, phone]), states - 1
    return path


def _follows(model: AcousticModel) -> np.ndarray:
    """Nats ``(phones, phones)`` that it costs to go on with the first after the second; noises follow and precede silence."""
    names, count = packed.neighbours()
    rows = np.array([*(model.phones[name] for name in names), model.silence])
    pairs = np.full((len(model.phones), len(model.phones)), _RARE)
    # words end in other words more often than in silence: of their borders one half goes on
    across = np.outer(count[:-1, -1], count[-1, :-1]) / count[-1].sum()
    pairs[np.ix_(rows, rows)] += count
    pairs[np.ix_(rows[:-1], rows[:-1])] += across
    logs = np.log(pairs / pairs.sum(0))
    favour = np.array([_LIPS * (name in _CLOSED) for name in model.phones])
    return (_GRAMMAR * logs - _CHANGE + favour[:, None]).astype(np.float32)


@lru_cache(maxsize=1)
def _model() -> AcousticModel:
    return AcousticModel(packed.read())
