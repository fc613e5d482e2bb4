"""Finds the best path of a sound through a graph of phones (Viterbi), with the score of every word on it."""

from typing import NamedTuple

import numpy as np

from .acoustic import STATES, AcousticModel, BestGaussians
from .graph import GAP, Graph

_NEVER = np.float32(-1e30)


class PathWord(NamedTuple):
    """A word on the path: its number, first frame, frame after its last, summed log likelihood relative to the background, and
    its ``phones``, each with its first frame."""

    word: int
    begin: int
    end: int
    total: float
    phones: tuple[tuple[int, int], ...] = ()


def best_path(model: AcousticModel, graph: Graph, heard: BestGaussians, background: np.ndarray) -> list[PathWord]:
    """Return the words of the best path; the search is exact, without beams. Empty if the sound is too short for any path.

    ``background`` ``(frames,)`` is subtracted from all scores."""
    senones = model.together(np.unique(graph.senones))
    place = np.empty(senones.max() + 1, int)
    place[senones] = np.arange(len(senones))
    scores = model.scores(heard, senones) - background[:, None].astype(np.float32)
    walk = _Walk(model, graph, scores, place)
    return _backtrace(graph, walk, walk.last) if walk.last is not None else []


class _Walk:
    """The forward pass through all frames; phones are sorted so that those with most incoming arcs come first.

    ``order`` ``(phones,)`` are the graph's numbers of the sorted phones. The best of the arcs into a phone is found in rounds:
    its second arc against its first, its third against the better of both. ``last`` is the phone where the best path ends,
    None without a path."""

    def __init__(self, model: AcousticModel, graph: Graph, scores: np.ndarray, place: np.ndarray):
        self.frames, self.scores, self._phones = len(scores), scores, len(graph.phone)
        degree = np.bincount(graph.to, minlength=self._phones)
        self.order = np.argsort(-degree, kind="stable")
        self.position = np.argsort(self.order)
        self.column = place[graph.senones.T[:, self.order]]
        self._order_arcs(graph, degree)
        self._bits = np.zeros(STATES * self._phones + len(self._sources) - self._widths[0], bool)
        self._marks = np.empty((self.frames, (len(self._bits) + 7) // 8), np.uint8)
        self._hub = np.zeros(self.frames, np.int32)
        self.last = self._walk(model, graph)

    def entered(self, frame: int, state: int, phone: int) -> bool:
        """Return whether the best path into a state at a frame comes from another state."""
        return self._is_set(frame, state * self._phones + phone)

    def source(self, frame: int, phone: int) -> tuple[int, bool]:
        """Return the phone from which another one was entered at a frame, and whether that was a jump."""
        bit, arc = STATES * self._phones + phone, phone
        best = arc
        for before, width in zip(self._widths, self._widths[1:], strict=False):
            if phone >= width:
                break
            arc += before
            best = arc if self._is_set(frame, bit) else best
            bit += width
        source = int(self._sources[best])
        return (int(self._hub[frame]), True) if source == self._phones else (source, False)

    def _is_set(self, frame: int, bit: int) -> bool:
        return bool(self._marks[frame, bit >> 3] >> (7 - (bit & 7)) & 1)

    def _order_arcs(self, graph: Graph, degree: np.ndarray) -> None:
        """Sort sources and costs of arcs: the first arc into every phone, then the second one of those that have two, ..."""
        starts = np.searchsorted(graph.to, self.order)
        self._widths = [int((degree > rank).sum()) for rank in range(int(degree.max()))]
        arcs = np.concatenate([starts[:width] + rank for rank, width in enumerate(self._widths)])
        source = graph.source[arcs]
        self._sources = np.where(source < 0, self._phones, self.position[source])
        self._costs = graph.cost[arcs]

    def _walk(self, model: AcousticModel, graph: Graph) -> int | None:
        """Run the forward pass, storing for every frame which states were entered; return :attr:`last`."""
        count, jumps = self._phones, bool((graph.source < 0).any())
        closing = self.position[np.flatnonzero(graph.closes)]
        stay, leave = (part[graph.phone[self.order]].T.copy() for part in (model.stay, model.leave))
        state = np.full((STATES, count), _NEVER)
        state[0, self.position[np.flatnonzero(graph.begins)]] = 0
        state += self.scores[0][self.column]
        enter, emitted = np.full((STATES, count), _NEVER), np.empty((STATES, count), np.float32)
        out = np.full(count + 1, _NEVER)  # all ends of phones, and the best end of any word
        arcs, first = np.empty(len(self._sources), np.float32), enter[0, : self._widths[0]]
        rounds, new = self._rounds(arcs, first), self._bits[: STATES * count].reshape(STATES, count)
        for frame in range(1, self.frames):
            np.add(state[:-1], leave[:-1], out=enter[1:])
            np.add(state[-1], leave[-1], out=out[:count])
            if jumps:
                self._hub[frame] = hub = closing[out[closing].argmax()]
                out[count] = out[hub]
            out.take(self._sources, out=arcs, mode="clip")
            arcs += self._costs
            first[:] = arcs[: len(first)]
            for best, other, better in rounds:
                np.greater(other, best, out=better)
                np.maximum(best, other, out=best)
            state += stay
            np.greater(enter, state, out=new)
            np.maximum(state, enter, out=state)
            state += self.scores[frame].take(self.column, out=emitted, mode="clip")
            self._marks[frame] = np.packbits(self._bits)
        final = np.where(graph.ends, state[-1, self.position], _NEVER)
        last = int(final.argmax())
        return None if final[last] < _NEVER / 2 else int(self.position[last])

    def _rounds(self, arcs: np.ndarray, first: np.ndarray) -> list[tuple[np.ndarray, ...]]:
        """Return the comparisons of every frame as views: best arcs so far, next arcs, and bits for which is better."""
        rounds, arc, bit = [], len(first), STATES * self._phones
        for width in self._widths[1:]:
            rounds.append((first[:width], arcs[arc : arc + width], self._bits[bit : bit + width]))
            arc, bit = arc + width, bit + width
        return rounds


def _backtrace(graph: Graph, walk: _Walk, last: int) -> list[PathWord]:
    """Follow the best path backwards from its ``last`` phone; return its words in order of time."""
    words, names = graph.word[walk.order], graph.phone[walk.order]
    path: list[PathWord] = []
    phone, state, end, total, phones = last, STATES - 1, walk.frames, 0.0, []
    for frame in range(walk.frames - 1, -1, -1):
        total += float(walk.scores[frame, walk.column[state, phone]])
        if not frame or not walk.entered(frame, state, phone):
            continue
        if state:
            state -= 1
            continue
        source, jumped = walk.source(frame, phone)
        phones.append((int(names[phone]), frame))
        if jumped or words[source] != words[phone]:
            if words[phone] != GAP:
                path.append(PathWord(int(words[phone]), frame, end, total, tuple(phones[::-1])))
            end, total, phones = frame, 0.0, []
        phone, state = source, STATES - 1
    if words[phone] != GAP:
        phones.append((int(names[phone]), 0))
        path.append(PathWord(int(words[phone]), 0, end, total, tuple(phones[::-1])))
    return path[::-1]
