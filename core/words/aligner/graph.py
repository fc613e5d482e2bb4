"""Builds the search graph: all ways to speak the words one after the other, as a graph of triphones.

Between two words there may be silence, noise or nothing; without a gap, the phones at the border take each other as context.
A word may have several pronunciations."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .acoustic import BEGINS, ENDS, INSIDE, WHOLE, AcousticModel

Pronunciation = tuple[int, ...]
"""A pronunciation as numbers of phones."""
GAP = -1
"""Word number of silence and noise between words."""
_SILENCE, _NOISE = -34.0, -120.0
"""Log probabilities of a pause between two words, and of a noise in it."""
_NOISES = ("+NSN+",)


class Graph(NamedTuple):
    """A search graph whose nodes are phones.

    Per node: ``senones`` ``(nodes, 3)``, ``phone`` (number in the model), ``word`` (number, or :data:`GAP`), whether a path
    ``begins`` or ``ends`` there, and whether it ``closes`` a word before a gap. Per arc, sorted by the target node ``to``:
    ``source`` (a node, or -1 for the end of any word, where jumps are allowed) and ``cost`` (a log probability)."""

    senones: np.ndarray
    phone: np.ndarray
    word: np.ndarray
    source: np.ndarray
    to: np.ndarray
    cost: np.ndarray
    begins: np.ndarray
    ends: np.ndarray
    closes: np.ndarray


class _Builder:
    """Collects nodes and arcs of a graph."""

    def __init__(self, model: AcousticModel):
        self.model = model
        self.senones: list[Sequence[int]] = []
        self.phone: list[int] = []
        self.word: list[int] = []
        self.arcs: list[tuple[int, int, float]] = []

    def add(self, phone: int, senones: Sequence[int], word: int) -> int:
        """Add a node; return its number."""
        self.phone.append(phone)
        self.senones.append(senones)
        self.word.append(word)
        return len(self.phone) - 1

    def join(self, sources: Sequence[int], targets: Sequence[int], cost: float = 0.0) -> None:
        """Add arcs from all sources to all targets."""
        self.arcs += [(source, target, cost) for target in targets for source in sources]

    def gap(self, sources: Sequence[int]) -> list[int]:
        """Add silence and noise, in any order, after some nodes; return their nodes."""
        model = self.model
        kinds = [model.silence, *(model.phones[name] for name in _NOISES if name in model.phones)]
        nodes = [self.add(kind, model.alone[kind].tolist(), GAP) for kind in kinds]
        for node, cost in zip(nodes, (_SILENCE, *[_NOISE] * len(nodes)), strict=False):
            self.join([*sources, *(other for other in nodes if other != node)], [node], cost)
        return nodes

    def word_between(
        self, number: int, ways: Sequence[Pronunciation], lefts: set[int], rights: set[int]
    ) -> tuple[dict[tuple[int, int], list[int]], dict[tuple[int, int], list[int]]]:
        """Add a word with its pronunciations between possible neighbours ``lefts`` and ``rights`` (phones).

        Returns its first nodes by ``(phone, left)`` and its last nodes by ``(phone, right)``."""
        first: dict[tuple[int, int], list[int]] = {}
        last: dict[tuple[int, int], list[int]] = {}
        senones = self.model.triphone
        for way in ways:
            if len(way) == 1:
                for left in lefts:
                    for right in rights:
                        node = self.add(way[0], senones(way[0], left, right, WHOLE), number)
                        first.setdefault((way[0], left), []).append(node)
                        last.setdefault((way[0], right), []).append(node)
                continue
            heads = [(left, self.add(way[0], senones(way[0], left, way[1], BEGINS), number)) for left in lefts]
            before = [node for _, node in heads]
            for place in range(1, len(way) - 1):
                node = self.add(way[place], senones(way[place], way[place - 1], way[place + 1], INSIDE), number)
                self.join(before, [node])
                before = [node]
            tails = [(right, self.add(way[-1], senones(way[-1], way[-2], right, ENDS), number)) for right in rights]
            self.join(before, [node for _, node in tails])
            for left, node in heads:
                first.setdefault((way[0], left), []).append(node)
            for right, node in tails:
                last.setdefault((way[-1], right), []).append(node)
        return first, last


def build_graph(
    model: AcousticModel, words: Sequence[Sequence[Pronunciation]], open_end: bool = False, jump: float | None = None
) -> Graph:
    """Build the graph of words in this order, each with its pronunciations.

    With ``open_end`` any word may be the last. With ``jump`` (a log probability) any word may also follow any other one, and be
    the first or the last."""
    builder, silence = _Builder(model), model.silence
    gap = builder.gap([])
    begins, ends, closes, before = [*gap], [], [], {}
    for number, ways in enumerate(words):
        following = {way[0] for way in words[number + 1]} if number + 1 < len(words) else set()
        first, last = builder.word_between(number, ways, {silence, *(phone for phone, _ in before)}, {silence, *following})
        for (phone, left), nodes in first.items():
            if left == silence:
                builder.join(gap, nodes)
                begins += nodes if not number or jump is not None else []
                builder.join([-1] if jump is not None else [], nodes, jump or 0.0)
            builder.join(before.get((left, phone), []), nodes)
        closing = [node for (_, right), nodes in last.items() if right == silence for node in nodes]
        gap = builder.gap(closing)
        closes += closing + gap
        if open_end or jump is not None or number == len(words) - 1:
            ends += closing + gap
        before = {pair: nodes for pair, nodes in last.items() if pair[1] != silence}
    return _graph(builder, begins, ends, closes)


def _graph(builder: _Builder, begins: list[int], ends: list[int], closes: list[int]) -> Graph:
    """Convert to arrays."""
    arcs = sorted(builder.arcs, key=lambda arc: arc[1])
    source, to, cost = (np.array(column) for column in zip(*arcs, strict=True))
    marks = np.zeros((3, len(builder.phone)), bool)
    for mark, nodes in zip(marks, (begins, ends, closes), strict=True):
        mark[nodes] = True
    parts = np.array(builder.senones), np.array(builder.phone), np.array(builder.word)
    return Graph(*parts, source, to, cost.astype(np.float32), *marks)
