"""Acted speech of our own making, to choose settings on: synthetic voices say the same sentences in every mood.

    python -m s2ag.core.learning.evaluate.listens.acted_speech FOLDER

People who act remain the yardstick: these voices act by the table of ``core/learning/corpus/acting.py``, as the corpus does.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...corpus import acting, vocal_delivery, voices
from ...corpus.texts import Sentence
from ..generation import write_wave

KINDS = ("flite:slt", "flite:rms", "flite:awb", "espeak:en-gb+f2")
"""Voices, women and men; each is two talkers."""
SENTENCES = (
    "The letters are on the table in the kitchen.",
    "They carried it upstairs on Wednesday and brought it down again.",
    "In seven hours it will be over.",
    "I will just put this away and then go for a walk with Karl.",
)
"""Sentences that fit every mood, as those that actors are asked to say."""
_TALKERS = 2
_NEUTRAL = (acting.NEUTRAL,) * 3


def speak(
    kinds: Sequence[str] = KINDS, sentences: Sequence[str] = SENTENCES, seed: int = 0
) -> Iterator[tuple[str, np.ndarray]]:
    """Yield names, which tell the mood, and sounds ``(n,)`` at 16 kHz of every talker's sentences in every mood.

    Raises :class:`S2agError` where a voice's program is missing.
    """
    for row, kind in enumerate(kinds):
        for talker in range(_TALKERS):
            person = vocal_delivery.draw_voice(kind, np.random.default_rng([seed, row, talker]))
            for mood, affect in {**acting.MOODS, "neutral": _NEUTRAL}.items():
                for number, text in enumerate(sentences):
                    random = np.random.default_rng([seed, row, talker, number])  # the same accidents in every mood
                    sound = _say(text, person, np.array(affect), random)
                    if sound is not None:
                        yield f"{kind.partition(':')[2]}-{talker}-{mood}-{number}", sound


def _say(text: str, person: vocal_delivery.Voice, affect: np.ndarray, random: np.random.Generator) -> np.ndarray | None:
    """Return a sentence as it is acted, as loud as every other; None where its words are not found."""
    words = tuple(text.lower().rstrip(".").split())
    delivery = vocal_delivery.draw_delivery(person, affect, random)
    said = voices.voice(person.kind).say(Sentence(text, words, tuple(affect.tolist()), 0), delivery.manner)
    if said is None:
        return None
    sound = vocal_delivery.apply_delivery(*said, replace(delivery, loudness=0.0), random)
    return (0.5 * sound / max(np.abs(sound).max(), 1e-9)).astype(np.float32)


def main(arguments: list[str] | None = None) -> int:
    """Write the sounds as WAV files."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("folder", type=Path, help="folder of the recordings")
    folder = parser.parse_args(arguments).folder
    folder.mkdir(parents=True, exist_ok=True)
    count = 0
    for name, sound in speak():
        write_wave(sound, folder / f"{name}.wav")
        count += 1
    print(f"{count} recordings are in {folder}.")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
