"""The best path of a sound through a graph of phones, and how well every word on it sounds."""

from typing import NamedTuple

import numpy as np

from .acoustic import STATES, AcousticModel, Heard
from .graph import GAP, Graph

_NEVER = np.float32(-1e30)


class Said(NamedTuple):
    """A word on the path: its number, first frame, frame after its last, summed log likelihood over the background's, and its
    ``phones``, each with its first frame."""

    word: int
    begin: int
    end: int
    total: float
    phones: tuple[tuple[int, int], ...] = ()


def path(model: AcousticModel, graph: Graph, heard: Heard, background: np.ndarray) -> list[Said]:
    """Words of the best path, which is exact: no beam forgets anything. Empty where the sound is too short for any.

    ``background`` ``(frames,)`` is what a score is compared with.
    """
    senones = model.together(np.unique(graph.senones))
    place = np.empty(senones.max() + 1, int)
    place[senones] = np.arange(len(senones))
    column = place[graph.senones.T]
    scores = model.scores(heard, senones) - background[:, None].astype(np.float32)
    marks = _walk(model, graph, scores, column)
    return _read(graph, scores, column, *marks) if marks else []


def _walk(model: AcousticModel, graph: Graph, scores: np.ndarray, column: np.ndarray):
    """Frame by frame: ``moved`` (packed bits: whether a state was entered), ``came`` (the source a phone was entered from),
    and the last phone; None without a path."""
    count, frames = len(graph.phone), len(scores)
    targets, starts = np.unique(graph.to, return_index=True)
    widest = int(np.diff(np.append(starts, len(graph.to))).max())
    sources, costs = _table(graph, targets, starts, widest)
    stay, leave = (part[graph.phone].T.copy() for part in (model.stay, model.leave))
    state = np.full((STATES, count), _NEVER)
    state[0, graph.begins] = 0
    state += scores[0][column]
    moved = np.empty((frames, (STATES * count + 7) // 8), np.uint8)
    came = np.zeros((frames, len(targets)), np.uint8)
    hub = np.zeros(frames, np.int32)
    closing = np.flatnonzero(graph.closes) if (graph.source < 0).any() else ()
    enter = np.full((STATES, count), _NEVER)
    out = np.full(count + 2, _NEVER)  # all ends of phones, the end of any word, and none
    every = np.arange(len(targets))
    for frame in range(1, frames):
        np.add(state[:-1], leave[:-1], out=enter[1:])
        np.add(state[-1], leave[-1], out=out[:count])
        if len(closing):
            hub[frame] = closing[out[closing].argmax()]
            out[count] = out[hub[frame]]
        ways = out[sources] + costs
        choice = ways.argmax(axis=0)
        enter[0, targets] = ways[choice, every]
        came[frame] = choice
        state += stay
        new = enter > state
        np.maximum(state, enter, out=state)
        state += scores[frame][column]
        moved[frame] = np.packbits(new)
    final = np.where(graph.ends, state[-1], _NEVER)
    last = int(final.argmax())
    return None if final[last] < _NEVER / 2 else (moved, came, sources, hub, last)


def _table(graph: Graph, targets: np.ndarray, starts: np.ndarray, widest: int) -> tuple[np.ndarray, np.ndarray]:
    """Sources and costs ``(widest, targets)`` of the arcs into every target; where there are fewer, no source."""
    count = len(graph.phone)
    sources = np.full((widest, len(targets)), count + 1)
    costs = np.zeros((widest, len(targets)), np.float32)
    row = np.searchsorted(targets, graph.to)
    rank = np.arange(len(graph.to)) - starts[row]
    sources[rank, row] = np.where(graph.source < 0, count, graph.source)
    costs[rank, row] = graph.cost
    return sources, costs


def _read(graph: Graph, scores: np.ndarray, column: np.ndarray, moved, came, sources, hub, last: int) -> list[Said]:
    """Words from the marks of the walk, backwards."""
    count, targets = len(graph.phone), np.unique(graph.to)
    said: list[Said] = []
    phone, state, end, total, phones = last, STATES - 1, len(scores), 0.0, []
    for frame in range(len(scores) - 1, -1, -1):
        total += float(scores[frame, column[state, phone]])
        bit = state * count + phone
        if not frame or not moved[frame, bit >> 3] >> (7 - (bit & 7)) & 1:
            continue
        if state:
            state -= 1
            continue
        source = int(sources[came[frame, np.searchsorted(targets, phone)], np.searchsorted(targets, phone)])
        jumped = source == count
        phones.append((int(graph.phone[phone]), frame))
        source = int(hub[frame]) if jumped else source
        if jumped or graph.word[source] != graph.word[phone]:
            if graph.word[phone] != GAP:
                said.append(Said(int(graph.word[phone]), frame, end, total, tuple(phones[::-1])))
            end, total, phones = frame, 0.0, []
        phone, state = source, STATES - 1
    if graph.word[phone] != GAP:
        phones.append((int(graph.phone[phone]), 0))
        said.append(Said(int(graph.word[phone]), 0, end, total, tuple(phones[::-1])))
    return said[::-1]
