"""Sounds by ear alone, where nobody wrote the words down: the aligner's model of speech asked for single sounds.

Which sound it is, the model tells poorly without words; which kind of mouth makes it, well enough for lips. Noise is left in,
and only every other hundredth of a second is looked at: closures are found as well, in a fifth of the time.
"""

from functools import lru_cache

import numpy as np

from ..sound.audio import SAMPLE_RATE, gain
from ..words.align import Phone
from ..words.aligner import cepstra, packed
from ..words.aligner.acoustic import AcousticModel

_CHANGE, _GRAMMAR = 2.0, 2.0
"""Nats that going on with another sound costs, and how much it counts which sound follows which in English words."""
_LIPS = 8.0
"""Nats by which a sound of closed lips is favoured: one too many is seen less than one that is missed."""
_STRIDE = 2
"""Hundredths of a second from one frame that is looked at to the next."""
_AROUND, _LATER = 0.05, 0.006
"""Seconds before and after a phrase that belong to it, and by which sounds are later than their frames."""
_TOGETHER = 60.0
"""Seconds of phrases that are heard at once, and over which the usual sound of voice and room is taken."""
_LEAST = 4
_BEST = 1
_RARE = 20.0
"""Times that every pair of sounds is taken to have been met, so that none is impossible."""
_CLOSED = "PBM"


def sounds(audio: np.ndarray, phrases: np.ndarray) -> tuple[Phone, ...]:
    """``(phone, start, end)`` of a recording ``(n,)`` at 16 kHz with ``phrases`` ``(p, 2)`` in seconds, in order of time."""
    found: list[Phone] = []
    parts = np.ceil((phrases[:, 1] - phrases[:, 0]).sum() / _TOGETHER) if len(phrases) else 0
    factor = 32767 * 2 * gain(audio)  # as loud as for the aligner
    for group in np.array_split(phrases, max(int(parts), 1)):
        found += _group(audio, group, factor)
    return tuple(sorted(found, key=lambda sound: sound[1]))


def _group(audio: np.ndarray, phrases: np.ndarray, factor: float) -> list[Phone]:
    starts, heard = [], []
    for begin, end in phrases.tolist():
        start = max(begin - _AROUND, 0.0)
        piece = audio[int(start * SAMPLE_RATE) : int((end + _AROUND) * SAMPLE_RATE)] * factor
        power = cepstra.mel_power(np.clip(piece, -32768, 32767).astype(np.int16))
        if len(power) >= _LEAST:
            starts.append(start)
            heard.append(cepstra.coefficients(power))
    if not heard:
        return []
    model, usual = _model(), cepstra.usual(np.concatenate(heard))
    features = [cepstra.with_slopes(one - usual)[::_STRIDE] for one in heard]
    names, found = list(model.phones), []
    for start, path in zip(starts, _paths(_scores(features, model), [len(one) for one in features], model), strict=True):
        edges = np.flatnonzero(np.diff(path, prepend=-1, append=-1))
        for begin, stop in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
            name = names[path[begin]]
            if name.isalpha() and name != "SIL":
                at = start + _LATER
                found.append((name, float(at + begin * _STRIDE / 100), float(at + stop * _STRIDE / 100)))
    return found


def _scores(features: list[np.ndarray], model: AcousticModel) -> np.ndarray:
    """Log likelihoods ``(frames, phrases, phones, 3)`` of the states of sounds without neighbours, 0 after a phrase's end."""
    alone = model.together(np.unique(model.alone))
    order = np.argsort(alone)
    column = order[np.searchsorted(alone[order], model.alone)]
    every = model.scores(model.hear(np.concatenate(features), _BEST), alone)[:, column] * np.float32(_STRIDE)
    lengths = np.array([len(one) for one in features])
    scores = np.zeros((lengths.max(), len(lengths), *column.shape), np.float32)
    for number, one in enumerate(np.split(every, np.cumsum(lengths)[:-1])):
        scores[: len(one), number] = one
    return scores


def _paths(scores: np.ndarray, lengths: list[int], model: AcousticModel) -> list[np.ndarray]:
    """The best sound of every frame of every phrase: each has three states in a row, any may follow any.

    All phrases are gone through at once, for numpy takes as long for one as for twenty.
    """
    frames, phrases, count, states = scores.shape
    stay, leave, follows = model.stay, model.leave, _follows()
    state = np.full((phrases, count, states), -1e30, np.float32)
    state[..., 0] = scores[0, ..., 0]
    moved, came = np.zeros((frames, phrases, count, states), bool), np.zeros((frames, phrases, count), np.uint8)
    enter, finals = np.empty_like(state), np.zeros((frames, phrases), np.uint8)
    for frame in range(1, frames):
        ways = (state[..., -1] + leave[:, -1])[:, None] + follows
        came[frame] = best = ways.argmax(axis=2)
        enter[..., 0] = np.take_along_axis(ways, best[..., None], 2)[..., 0]
        enter[..., 1:] = state[..., :-1] + leave[:, :-1]
        state += stay
        np.greater(enter, state, out=moved[frame])
        np.maximum(state, enter, out=state)
        state += scores[frame]
        finals[frame] = state[..., -1].argmax(axis=1)
    return [
        _back(moved[:length, number], came[:length, number], finals[length - 1, number])
        for number, length in enumerate(lengths)
    ]


def _back(moved: np.ndarray, came: np.ndarray, phone: int) -> np.ndarray:
    """The sounds ``(frames,)`` on the way that ends with ``phone``."""
    at = last = moved.shape[2] - 1
    path = np.empty(len(moved), np.int64)
    for frame in range(len(moved) - 1, -1, -1):
        path[frame] = phone
        if moved[frame, phone, at]:
            if at:
                at -= 1
            else:
                phone, at = came[frame, phone], last
    return path


@lru_cache(maxsize=1)
def _follows() -> np.ndarray:
    """Nats ``(phones, phones)`` that it costs to go on with the first after the second; noises follow and precede silence."""
    model, (names, count) = _model(), packed.neighbours()
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
