"""Recordings of people for training: a sonnet, and telephone prompts joined to talks.

Held out for evaluation and not read here: the sonnet p002 and the LibriVox clips of Debian's pocketsphinx-testdata.
"""

import re
from functools import lru_cache
from os import PathLike
from pathlib import Path

import numpy as np

from ...sound.audio import SAMPLE_RATE, load, speech_gain
from ...words.transcript import tokenise
from .phonemes import PUNCTUATION, SpokenWord
from .voices import align_words, words_from_times

PROMPTS = Path("/usr/share/asterisk/sounds/en_US_f_Allison")
"""Folder of Debian's asterisk-core-sounds-en-wav (Allison Smith, CC BY-SA 3.0); the package holds no texts."""

MISSING = "Telephone prompts are left out: they come with apt-get install asterisk-core-sounds-en-wav"

_NOT_SPEECH = {"beep", "beeperr", "ascending-2tone", "descending-2tone", "tt-monkeys", "confbridge-lock-in", "pause"}
_FOLDERS = {"silence", "letters", "phonetic"}


def prompts() -> list[Path]:
    """Return the files with speech in a fixed order; empty where the package is missing."""
    files = sorted(PROMPTS.rglob("*.wav"))
    return [f for f in files if f.stem not in _NOT_SPEECH and f.parent.name not in _FOLDERS]


@lru_cache(maxsize=1)
def prompt_talks(seed: int) -> list[list[Path]]:
    """Group the prompts into talks of 40 to 70 s with their pauses."""
    files, random = prompts(), np.random.default_rng([seed, 571])
    talks, group, seconds, aim = [], [], 0.0, random.uniform(40, 65)
    for index in random.permutation(len(files)):
        group.append(files[index])
        # 16-bit samples at 8 kHz, and the mean pause
        seconds += files[index].stat().st_size / 16000 + 0.5
        if seconds >= aim:
            talks.append(group)
            group, seconds, aim = [], 0.0, random.uniform(40, 65)
    return talks


def join_prompts(files: list[Path], random: np.random.Generator) -> np.ndarray:
    """Join prompts to one talk ``(n,)`` at 16 kHz, with shorter pauses after short prompts."""
    pieces = [np.zeros(round(random.uniform(0.3, 1) * SAMPLE_RATE))]
    for file in files:
        audio = _trim(levelled(load(file)))
        long = len(audio) > 1.2 * SAMPLE_RATE
        pause = random.uniform(0.3, 1.4) if long else random.uniform(0.06, 0.35)
        pieces += [audio, np.zeros(round(pause * SAMPLE_RATE))]
    return np.concatenate(pieces)


def levelled(audio: np.ndarray) -> np.ndarray:
    """Scale sound so that its active speech level is :data:`audio.SPEECH_RMS`, which cancels the microphone gain."""
    return audio * np.float32(speech_gain(audio))


def _trim(audio: np.ndarray) -> np.ndarray:
    """Cut the silence before and after."""
    loud = np.flatnonzero(np.abs(audio) > 0.02 * np.abs(audio).max())
    margin = SAMPLE_RATE // 50
    return audio[max(loud[0] - margin, 0) : loud[-1] + margin] if len(loud) else audio


def sonnet(material: str | PathLike) -> tuple[np.ndarray, list[SpokenWord], list[str], list[int]]:
    """Load the reading p001: audio ``(n,)`` at 16 kHz, words, closing punctuation and line number of each word.

    Raises ``FileNotFoundError`` where ``material``/speech is missing.
    """
    folder = Path(material) / "speech"
    page = (folder / "p001.xhtml").read_text(encoding="utf-8")
    lines = re.findall(r'<span id="f\d+">(.*?)</span>', page)
    audio = load(folder / "p001.mp3")
    tokens, closings, numbers = [], [], []
    for number, line in enumerate(lines):
        # the title is a numeral
        for token in ["one"] if number == 0 else line.split():
            for word, spoken_forms in tokenise(token):
                tokens.append((word.lower().replace("’", "'"), spoken_forms))
                closings.append(token[-1] if token[-1] in PUNCTUATION else "")
                numbers.append(number)
    spans, _ = align_words(audio, [spoken_forms for _, spoken_forms in tokens])
    return audio, words_from_times(audio, tuple(word for word, _ in tokens), spans), closings, numbers
