"""All ways in which words can be said one after the other, as a graph of phones between their neighbours.

Between words there may be silence or noise or nothing: then the last phone of one and the first of the next sound as their
neighbour across the border makes them. Of a word with several pronunciations any may be said.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .acoustic import BEGINS, ENDS, INSIDE, WHOLE, AcousticModel

Way = tuple[int, ...]
"""A pronunciation as numbers of phones."""
GAP = -1
_SILENCE, _NOISE = -34.0, -120.0
"""Log probabilities of a pause, and of a noise in it, between two words."""
_NOISES = ("+NSN+",)


class Graph(NamedTuple):
    """``senones`` ``(phones, 3)``; ``phone`` of the model and ``word`` of each, :data:`GAP` for none; arcs sorted by their
    target ``to``: ``source`` (a phone, or -1 for any word's end, where the text may be jumped) and ``cost`` (log); ``begins``
    and ``ends`` ``(phones,)``, whether a path may; ``closes``: whether a phone ends a word before a gap."""

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
    def __init__(self, model: AcousticModel):
        self.model = model
        self.senones: list = []
        self.phone: list[int] = []
        self.word: list[int] = []
        self.arcs: list[tuple[int, int, float]] = []

    def add(self, phone: int, senones, word: int) -> int:
        self.phone.append(phone)
        self.senones.append(senones)
        self.word.append(word)
        return len(self.phone) - 1

    def join(self, sources, targets, cost: float = 0.0) -> None:
        self.arcs += [(source, target, cost) for target in targets for source in sources]

    def gap(self, sources) -> list[int]:
        """Silence or noise, in any order, after some phones."""
        model = self.model
        kinds = [model.silence, *(model.phones[name] for name in _NOISES if name in model.phones)]
        nodes = [self.add(kind, model.alone[kind].tolist(), GAP) for kind in kinds]
        for node, cost in zip(nodes, (_SILENCE, *[_NOISE] * len(nodes)), strict=False):
            self.join([*sources, *(other for other in nodes if other != node)], [node], cost)
        return nodes

    def word_between(self, number: int, ways: Sequence[Way], lefts: set[int], rights: set[int]):
        """Phones of a word: its first ones by ``(phone, left)`` and its last ones by ``(phone, right)``."""
        first: dict[tuple[int, int], list[int]] = {}
        last: dict[tuple[int, int], list[int]] = {}
        spell = self.model.triphone
        for way in ways:
            if len(way) == 1:
                for left in lefts:
                    for right in rights:
                        node = self.add(way[0], spell(way[0], left, right, WHOLE), number)
                        first.setdefault((way[0], left), []).append(node)
                        last.setdefault((way[0], right), []).append(node)
                continue
            heads = [(left, self.add(way[0], spell(way[0], left, way[1], BEGINS), number)) for left in lefts]
            before = [node for _, node in heads]
            for place in range(1, len(way) - 1):
                node = self.add(way[place], spell(way[place], way[place - 1], way[place + 1], INSIDE), number)
                self.join(before, [node])
                before = [node]
            tails = [(right, self.add(way[-1], spell(way[-1], way[-2], right, ENDS), number)) for right in rights]
            self.join(before, [node for _, node in tails])
            for left, node in heads:
                first.setdefault((way[0], left), []).append(node)
            for right, node in tails:
                last.setdefault((way[-1], right), []).append(node)
        return first, last


def build(model: AcousticModel, words: Sequence[Sequence[Way]], open_end: bool = False, jump: float | None = None) -> Graph:
    """The graph of words in this order, each with its pronunciations.

    With ``open_end`` any word may be the last. With ``jump`` (a log probability) any word may also follow any other, and be
    the first or the last.
    """
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
    arcs = sorted(builder.arcs, key=lambda arc: arc[1])
    source, to, cost = (np.array(column) for column in zip(*arcs, strict=True))
    marks = np.zeros((3, len(builder.phone)), bool)
    for mark, nodes in zip(marks, (begins, ends, closes), strict=True):
        mark[nodes] = True
    parts = np.array(builder.senones), np.array(builder.phone), np.array(builder.word)
    return Graph(*parts, source, to, cost.astype(np.float32), *marks)
