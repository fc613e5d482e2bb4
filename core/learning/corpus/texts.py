"""EmoBank's sentences, cleaned for speech synthesis and joined into talks of similar affect.

EmoBank gives each sentence valence, arousal and dominance (1 to 5, as judged by readers) and a split. A talk holds sentences
of one split only, so that the splits of the corpus share neither audio nor sentences.
"""

import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

SPLITS = {"train": 0, "dev": 1, "test": 2}
_REPLACE = str.maketrans({"’": "'", "‘": "'", "“": "", "”": "", '"': "", "–": ", ", "—": ", ", "…": ".", "-": " "})
WORD = re.compile(r"[a-z']*[a-z][a-z']*")
_WORDS_A_SECOND = 2.55
"""Words a second over a whole talk, pauses included; used only to choose the number of sentences of a talk."""


@dataclass(frozen=True)
class Sentence:
    """Text for the synthetic voice, its words in lower case, affect as ranks 0..1 (valence, arousal, dominance), split."""

    text: str
    words: tuple[str, ...]
    affect: tuple[float, float, float]
    split: int


@dataclass(frozen=True)
class Script:
    """The sentences of a talk; ``index`` identifies it permanently."""

    index: int
    sentences: tuple[Sentence, ...]

    @property
    def split(self) -> int:
        """0 train, 1 validation, 2 test."""
        return self.sentences[0].split

    @property
    def affect(self) -> np.ndarray:
        """Mean valence, arousal, dominance ranks ``(3,)``."""
        return np.mean([sentence.affect for sentence in self.sentences], axis=0)


def clean_text(text: str) -> str | None:
    """Return text that a voice reads word for word, or None if it holds digits, symbols, acronyms or several sentences."""
    text = re.sub(r"\s*\.(\s*\.)+\s*", ". ", text.translate(_REPLACE))
    text = re.sub(r"\s+([,.?!;:])", r"\1", re.sub(r"\s+", " ", text)).strip(" ,.;:'")
    text = re.sub(r"[,;:]*([,;:.?!])[,.;:?!]*", r"\1", text)
    if re.search(r"[^A-Za-z' ,.?!;:]|\b[A-Z]{2,}\b|\b[A-Z]\.|\b(Mr|Mrs|Dr|St|vs|etc)\b|[.?!] ", text):
        return None
    return text if text[-1:] in "?!" else text + "."


def load_sentences(material: str | PathLike) -> list[Sentence]:
    """Return the usable sentences of ``material``/emobank/emobank.csv (3 to 32 words), in the file's order."""
    rows = []
    with open(Path(material) / "emobank" / "emobank.csv", newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            text = clean_text(row["text"])
            words = tuple(WORD.findall(text.lower())) if text else ()
            if 3 <= len(words) <= 32:
                judged = [float(row[key]) for key in "VAD"]
                rows.append((text, tuple(word.strip("'") for word in words), judged, SPLITS[row["split"]]))
    affect = np.array([row[2] for row in rows])
    # ranks, because most judgements are near 3; ties keep the file's order
    ranks = np.argsort(np.argsort(affect, axis=0, kind="stable"), axis=0) / max(len(rows) - 1, 1)
    return [
        Sentence(text, words, (float(valence), float(arousal), float(dominance)), split)
        for (text, words, _, split), (valence, arousal, dominance) in zip(rows, ranks, strict=True)
    ]


def closing_marks(text: str) -> list[str]:
    """Return the punctuation mark after each word of a cleaned sentence, or ""."""
    return [mark if mark.strip() else "" for mark in (text[m.end() : m.end() + 1] for m in WORD.finditer(text.lower()))]


def group_scripts(sentences: list[Sentence], seed: int) -> list[Script]:
    """Group the sentences into talks of 40 to 70 s, shuffled so that every prefix of the list has all splits.

    The list does not depend on how many talks are used, so that a corpus can grow without making its talks again.
    """
    random = np.random.default_rng(seed)
    by_split = []
    for split in sorted(set(SPLITS.values())):
        talks = list(_group([s for s in sentences if s.split == split], random))
        random.shuffle(talks)  # pyright: ignore[reportArgumentType]  (the stubs know arrays only)
        by_split.append(talks)
    # interleave by relative position within each split
    placed = sorted(((i + 0.5) / len(talks), k, talk) for k, talks in enumerate(by_split) for i, talk in enumerate(talks))
    return [Script(index, talk) for index, (_, _, talk) in enumerate(placed)]


def _group(sentences: list[Sentence], random: np.random.Generator) -> Iterator[tuple[Sentence, ...]]:
    """Yield groups of sentences of similar arousal and valence, of random length between 40 and 70 s."""
    cells: dict[tuple[int, int], list[Sentence]] = {}
    for sentence in sentences:
        cells.setdefault((int(sentence.affect[1] * 4.999), int(sentence.affect[0] * 2.999)), []).append(sentence)
    for key in sorted(cells):
        group, words, aim = [], 0, 0.0
        for index in random.permutation(len(cells[key])):
            aim = aim or random.uniform(40, 70) * _WORDS_A_SECOND
            group.append(cells[key][index])
            words += len(group[-1].words)
            if words >= aim:
                yield tuple(group)
                group, words, aim = [], 0, 0.0
