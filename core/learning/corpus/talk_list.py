"""The list of all talks: who speaks which script, acted how. Every beginning of it holds all kinds."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from . import acting, kathleen, texts, voices

_SLOTS = "KPFPKFPKFPFKPFPKFOPKFP"
"""Whose talk it is, in rotation: Kathleen's, Piper's, one of Flite's, another's (a formant voice and telephone prompts)."""
_FLITE = ("flite:slt", "flite:rms", "flite:awb", "flite:kal16")
_MAX_PROMPTS = 28
"""Talks of telephone prompts, and before them one sonnet; their indices stay reserved where the material is missing."""
_STUDIED = 3
"""Every third script is spoken three times by one voice: near neutral, and in two moods."""
ROUND = 3
"""Readings of a script by one talker; those numbered from here on are another's."""


@dataclass(frozen=True)
class Talk:
    """A talk to be synthesized: its permanent index, the ``kind`` of its voice, the script (None: a person's recording without
    one), its ``number`` (which reading of the script, from 0; which one of the recordings of people), how it is acted
    (:data:`acting.KINDS`; "natural": as a person read it) and the mood ("": drawn)."""

    index: int
    kind: str
    script: texts.Script | None
    number: int
    acting: str = "natural"
    mood: str = ""

    @property
    def split(self) -> int:
        """0 train, 1 validation, 2 test; recordings of people without a script are for training."""
        return self.script.split if self.script else 0


@dataclass(frozen=True)
class _Reading:
    script: texts.Script
    number: int
    acting: str
    mood: str = ""


@lru_cache(maxsize=1)
def talks(material: str, seed: int) -> list[Talk]:
    """List all possible talks, until the scripts are used up; the readings of a studied script stand a few places apart.

    Every prefix of the list has all splits and nearly the same share of every voice.
    """
    queue = _readings(texts.group_scripts(texts.load_sentences(material), seed), seed)
    hers, others = _kathleen(kathleen.scripts(material, seed), seed), _others()
    waiting: dict[str, list[tuple[str, _Reading]]] = {"P": [], "F": [], "O": []}
    scripts_of_flite = 0
    result: list[Talk] = []
    position = -1
    while True:
        position += 1
        slot = _SLOTS[position % len(_SLOTS)]
        kind, number = next(others) if slot == "O" else ("piper", 0)
        if slot == "K":
            reading = next(hers, None)
            if reading is None:
                continue
            kind = kathleen.KIND
        elif kind.startswith("human"):
            result.append(Talk(len(result), kind, None, number))
            continue
        else:
            if not waiting[slot]:
                readings = next(queue, None)
                if readings is None:
                    return result
                if slot == "F":
                    kind = _FLITE[scripts_of_flite % len(_FLITE)]
                    scripts_of_flite += 1
                waiting[slot] = [(kind, reading) for reading in readings]
            kind, reading = waiting[slot].pop(0)
        result.append(Talk(len(result), kind, reading.script, reading.number, reading.acting, reading.mood))


def count(material: str, seed: int) -> int:
    """Return the number of talks of :func:`talks`."""
    return len(talks(material, seed))


def _readings(scripts: list[texts.Script], seed: int) -> Iterator[tuple[_Reading, ...]]:
    """Yield what one voice speaks of a script: once, or three times where it is studied; then all scripts once more."""
    for turn in (0, 1):
        half = turn * len(scripts) // 2
        for script in scripts[half:] + scripts[:half]:
            random = np.random.default_rng([seed, 31, script.index, turn])
            if script.index % _STUDIED == turn:
                first, second = map(str, random.permutation(list(acting.MOODS))[:2])
                ways = [("plain", ""), ("talk", first), ("talk", second)]
                yield tuple(_Reading(script, ROUND * turn + k, *way) for k, way in enumerate(ways))
            else:
                yield (_Reading(script, ROUND * turn, acting.draw_kind(random)),)


def _kathleen(scripts: tuple[texts.Script, ...], seed: int) -> Iterator[_Reading]:
    """Yield her talks as she read them, every other three acted after it, too; then the rest acted."""
    for late in (False, True):
        for number, script in enumerate(scripts):
            random = np.random.default_rng([seed, 37, number])
            if not late:
                yield _Reading(script, 0, "natural")
            if (number // 3 % 2 == 1) == late:
                yield _Reading(script, 1, str(random.choice(acting.KINDS[1:])))


def _others() -> Iterator[tuple[str, int]]:
    """Yield kind and number: a sonnet, then formant voices and telephone prompts by turns, at last formant voices alone."""
    yield "human:sonnet", 0
    for number in range(100000):
        yield f"espeak:{voices.ESPEAK[number % len(voices.ESPEAK)]}", 0
        if number < _MAX_PROMPTS:
            yield "human:prompts", number + 1
