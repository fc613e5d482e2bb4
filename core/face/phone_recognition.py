"""Recognises phones without a transcript, with the aligner's acoustic model.

Without words the model often confuses phones, but mostly with others of a similar mouth shape, which is enough for lips. Noise
is not removed and only every second frame is scored: closures are found as well, in a fifth of the time."""

from functools import lru_cache

import numpy as np

from ..sound.audio import SAMPLE_RATE, speech_gain
from ..words.align import Phone
from ..words.aligner import cepstra, packed_model
from ..words.aligner.acoustic import AcousticModel

_CHANGE, _GRAMMAR = 2.0, 2.0
"""Cost in nats of a change of phone, and weight of the log probabilities of phone pairs in English words."""
_CLOSURE_BONUS = 8.0
"""Nats in favour of phones with closed lips: a missed closure is more visible than an extra one."""
_STRIDE = 2
"""Hundredths of a second between scored frames."""
_MARGIN_SECONDS, _FRAME_OFFSET = 0.05, 0.006
"""Added before and after a phrase, and to the times of frames."""
_GROUP_SECONDS = 60.0
"""Phrases that are recognised together, with a common cepstral mean."""
_MIN_FRAMES = 4
_GAUSSIANS = 1
"""Gaussians scored per codebook."""
_PAIR_PRIOR = 20.0
"""Added to the counts of phone pairs, so that none is impossible."""
_CLOSED = "PBM"


def recognise_phones(audio: np.ndarray, phrases: np.ndarray) -> tuple[Phone, ...]:
    """Recognise the phones ``(name, start, end)`` in seconds of a recording ``(n,)`` at 16 kHz, in order of time.

    ``phrases`` ``(p, 2)`` are its phrases in seconds."""
    phones: list[Phone] = []
    parts = np.ceil((phrases[:, 1] - phrases[:, 0]).sum() / _GROUP_SECONDS) if len(phrases) else 0
    factor = 32767 * 2 * speech_gain(audio)  # the aligner's level
    for group in np.array_split(phrases, max(int(parts), 1)):
        phones += _recognise(audio, group, factor)
    return tuple(sorted(phones, key=lambda phone: phone[1]))


def _recognise(audio: np.ndarray, phrases: np.ndarray, factor: float) -> list[Phone]:
    """Recognise the phones of some phrases, after scaling the sound by ``factor``."""
    starts, coefficients = [], []
    for begin, end in phrases.tolist():
        start = max(begin - _MARGIN_SECONDS, 0.0)
        piece = audio[int(start * SAMPLE_RATE) : int((end + _MARGIN_SECONDS) * SAMPLE_RATE)] * factor
        power = cepstra.mel_power(np.clip(piece, -32768, 32767).astype(np.int16))
        if len(power) >= _MIN_FRAMES:
            starts.append(start)
            coefficients.append(cepstra.cepstra_of_power(power))
    if not coefficients:
        return []
    model, mean = _model(), cepstra.cepstral_mean(np.concatenate(coefficients))
    features = [cepstra.with_slopes(rows - mean)[::_STRIDE] for rows in coefficients]
    names, phones = list(model.phones), []
    for start, path in zip(starts, _paths(_scores(features, model), [len(rows) for rows in features], model), strict=True):
        edges = np.flatnonzero(np.diff(path, prepend=-1, append=-1))
        for begin, stop in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
            name = names[path[begin]]
            if name.isalpha() and name != "SIL":
                at = start + _FRAME_OFFSET
                phones.append((name, float(at + begin * _STRIDE / 100), float(at + stop * _STRIDE / 100)))
    return phones


def _scores(features: list[np.ndarray], model: AcousticModel) -> np.ndarray:
    """Return log likelihoods ``(frames, phrases, phones, 3)`` of the states of context-independent phones, 0 after a phrase's
    end; ``features`` are one array per phrase."""
    alone = model.together(np.unique(model.alone))
    order = np.argsort(alone)
    column = order[np.searchsorted(alone[order], model.alone)]
    every = model.scores(model.hear(np.concatenate(features), _GAUSSIANS), alone)[:, column] * np.float32(_STRIDE)
    lengths = np.array([len(rows) for rows in features])
    scores = np.zeros((lengths.max(), len(lengths), *column.shape), np.float32)
    for number, rows in enumerate(np.split(every, np.cumsum(lengths)[:-1])):
        scores[: len(rows), number] = rows
    return scores


def _paths(scores: np.ndarray, lengths: list[int], model: AcousticModel) -> list[np.ndarray]:
    """Return the best phone of every frame of every phrase (Viterbi): phones have three states, any may follow any.

    All phrases are processed together, as numpy takes as long for one as for twenty."""
    frames, phrases, count, states = scores.shape
    stay, leave, follows = model.stay, model.leave, _transitions()
    state = np.full((phrases, count, states), -1e30, np.float32)
    state[..., 0] = scores[0, ..., 0]
    moved, came = np.zeros((frames, phrases, count, states), bool), np.zeros((frames, phrases, count), np.uint8)
    enter, finals = np.empty_like(state), np.zeros((frames, phrases), np.uint8)
    for frame in range(1, frames):
        entries = (state[..., -1] + leave[:, -1])[:, None] + follows
        came[frame] = best = entries.argmax(axis=2)
        enter[..., 0] = np.take_along_axis(entries, best[..., None], 2)[..., 0]
        enter[..., 1:] = state[..., :-1] + leave[:, :-1]
        state += stay
        np.greater(enter, state, out=moved[frame])
        np.maximum(state, enter, out=state)
        state += scores[frame]
        finals[frame] = state[..., -1].argmax(axis=1)
    return [
        _backtrace(moved[:length, number], came[:length, number], finals[length - 1, number])
        for number, length in enumerate(lengths)
    ]


def _backtrace(moved: np.ndarray, came: np.ndarray, phone: int) -> np.ndarray:
    """Return the phones ``(frames,)`` of the path that ends with ``phone``."""
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
def _transitions() -> np.ndarray:
    """Return log weights ``(phones, phones)`` of the first phone after the second, from phone pairs in English words."""
    model, (names, count) = _model(), packed_model.phone_pairs()
    rows = np.array([*(model.phones[name] for name in names), model.silence])
    pairs = np.full((len(model.phones), len(model.phones)), _PAIR_PRIOR)
    # a word is followed by another word more often than by silence: add pairs across word borders
    across = np.outer(count[:-1, -1], count[-1, :-1]) / count[-1].sum()
    pairs[np.ix_(rows, rows)] += count
    pairs[np.ix_(rows[:-1], rows[:-1])] += across
    logs = np.log(pairs / pairs.sum(0))
    bonus = np.array([_CLOSURE_BONUS * (name in _CLOSED) for name in model.phones])
    return (_GRAMMAR * logs - _CHANGE + bonus[:, None]).astype(np.float32)


@lru_cache(maxsize=1)
def _model() -> AcousticModel:
    return AcousticModel(packed_model.read())
