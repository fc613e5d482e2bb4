"""A woman's own reading of 1,131 unrelated sentences (rhasspy's dataset kathleen, CC0), grouped into talks by split.

A sentence belongs to one split for ever, so that training, validation and test share neither its sound nor its words.
"""

import csv
from functools import lru_cache
from os import PathLike
from pathlib import Path

import numpy as np

from ...sound.audio import SAMPLE_RATE, load
from ...words.align import Stretch, align_stretches
from .human_speech import levelled
from .phonemes import SpokenWord
from .texts import WORD, Script, Sentence, clean_text
from .voices import Manner, Said, words_from_times

KIND = "human:kathleen"
_PAUSE = 0.9
"""Mean seconds between sentences, by which a talk's length is planned."""
_SEPARATION = 0.3
"""Seconds of silence between the sentences while their words are looked for."""

_SHORTEST = 0.015
"""Seconds: a sentence with a shorter word was not read as it is written."""


def load_sentences(material: str | PathLike) -> dict[Sentence, tuple[Path, float]]:
    """Return the usable sentences of ``material``/kathleen with file and seconds, a tenth each for validation and test; empty
    where the folder is missing."""
    table = Path(material) / "kathleen" / "sentences.csv"
    if not table.exists():
        return {}
    result = {}
    with open(table, newline="", encoding="utf-8") as file:
        for number, row in enumerate(csv.DictReader(file)):
            text = clean_text(row["text"])
            if text:
                words = tuple(word.strip("'") for word in WORD.findall(text.lower()))
                split = {4: 1, 9: 2}.get(number % 10, 0)
                result[Sentence(text, words, (0.5, 0.5, 0.5), split)] = (table.parent / row["file"], float(row["seconds"]))
    return result


@lru_cache(maxsize=2)
def scripts(material: str, seed: int) -> tuple[Script, ...]:
    """Group the sentences into talks of 40 to 70 s with their pauses; every prefix has all splits."""
    seconds = {sentence: place[1] for sentence, place in load_sentences(material).items()}
    random, placed = np.random.default_rng([seed, 577]), []
    for split in (0, 1, 2):
        own = [sentence for sentence in seconds if sentence.split == split]
        groups, group, total, aim = [], [], 0.0, random.uniform(40, 66)
        for index in random.permutation(len(own)):
            group.append(own[index])
            total += seconds[own[index]] + _PAUSE
            if total >= aim:
                groups.append(tuple(group))
                group, total, aim = [], 0.0, random.uniform(40, 66)
        placed += [((number + 0.5) / len(groups), split, part) for number, part in enumerate(groups)]
    return tuple(Script(index, part) for index, (_, _, part) in enumerate(sorted(placed, key=lambda item: item[:2])))


class Reader:
    """Her voice for the sentences of a script: :class:`voices.Voice` that plays what she read, at her own tempo."""

    def __init__(self, material: str, script: Script) -> None:
        files, cut = load_sentences(material), round(_SEPARATION * SAMPLE_RATE)
        sounds = [_trim(levelled(load(files[sentence][0]))) for sentence in script.sentences]
        # one pass for the talk: the aligner's start costs more than a sentence
        ends = np.cumsum([len(sound) + cut for sound in sounds])
        joined = np.concatenate([np.pad(sound, (0, cut)) for sound in sounds])
        starts = [0, *map(int, ends[:-1])]
        stretches = [
            Stretch([[word] for word in sentence.words], start / SAMPLE_RATE, end / SAMPLE_RATE)
            for sentence, start, end in zip(script.sentences, starts, ends, strict=True)
        ]
        alignment = align_stretches(joined.astype(np.float32), stretches)
        self._said: dict[Sentence, Said] = {}
        first = 0
        for sentence, sound, start in zip(script.sentences, sounds, starts, strict=True):
            last = first + len(sentence.words)
            begin, length = start / SAMPLE_RATE, len(sound) / SAMPLE_RATE
            spans = [(max(a - begin, 0), min(b - begin, length)) for a, b in alignment.spans[first:last]]
            if min(alignment.confidence[first:last]) > 0 and min(b - a for a, b in spans) > _SHORTEST:
                self._said[sentence] = (sound.astype(float), words_from_times(sound, sentence.words, spans))
            first = last

    def say(self, sentence: Sentence, manner: Manner) -> tuple[np.ndarray, list[SpokenWord]] | None:
        """Return what she read; None where a word was not found in it."""
        return self._said.get(sentence)


def _trim(audio: np.ndarray) -> np.ndarray:
    """Cut the silence before and after, but for 50 ms."""
    loud = np.flatnonzero(np.abs(audio) > 0.02 * np.abs(audio).max())
    margin = SAMPLE_RATE // 20
    return audio[max(loud[0] - margin, 0) : loud[-1] + margin] if len(loud) else audio
