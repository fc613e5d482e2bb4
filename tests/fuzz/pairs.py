"""Pairs that nobody plans: a recording of any content and length, beside words that are not said in it, and settings.

``python tests/fuzz/pairs.py FIRST COUNT`` tries as many and prints what fell; each ends in motions that a body can do, or in
two sentences.
"""

import contextlib
import random
import re
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from door import ROOT
from s2ag.core.errors import S2agError
from s2ag.core.synthesis.session import Request, Session

sys.path.append(str(ROOT / "tests" / "helpers"))  # where no pytest has named it
from sounds import RATE, write_wav  # noqa: E402

SECONDS = 20.0
"""CPU time in which any pair must end; ten seconds of speech take one."""


@cache
def _speech() -> np.ndarray:
    from s2ag.core.sound import audio

    return audio.load(ROOT / "examples" / "hello.flac")


def _noise(count: int, loudness: float) -> np.ndarray:
    return np.random.default_rng(count).normal(0, loudness, count)


SOUNDS: dict[str, Callable[[int], np.ndarray]] = {
    "silence": np.zeros,
    "noise": lambda count: _noise(count, 0.1),
    "hiss": lambda count: _noise(count, 1e-4),
    "hum": lambda count: 0.3 * np.sin(2 * np.pi * 50 * np.arange(count) / RATE),
    "clipped": lambda count: np.sign(_noise(count, 1.0)),
    "constant": lambda count: np.full(count, 0.9),
    "click": lambda count: np.eye(1, count, count // 2)[0],
    "speech": lambda count: np.resize(_speech(), count),
    "speech, late": lambda count: np.pad(_speech()[: count // 2], (count - len(_speech()[: count // 2]), 0)),
}
LENGTHS = (1, 2, 79, 80, 160, 400, 799, 800, 1600, 3200, 8000, 16000, 48000, 80000)
"""Samples: around a frame of analysis, of motion, a syllable, a bark and a sentence."""
TEXTS = {
    "none": None,
    "empty": "",
    "one": "yes",
    "sentence": "I do not know, but it is really great.",
    "marks": "{big} *no* [pause] {none} {as calm} yes",
    "only marks": "[pause] {big}",
    "only signs": "… – !",
    "foreign": "你好 мир 123 ½",
    "many": "word after word and never an end " * 300,
    "one long": "a" * 20_000,
    "names": "ANNA: Hello.\nBERT: Oh, no!",
}
SETTINGS: tuple[dict[str, Any], ...] = (
    {}, {"takes": 2}, {"face": 1.0, "hands": 1.0, "stance": 1.0}, {"intensity": 3.0, "rate": 1.0}, {"intensity": 0.0},
    {"affect": {"arousal": 1.0, "valence": -1.0}}, {"listen": True}, {"turn": "ANNA"}, {"mirror": True, "hand": -1.0},
    {"style": "random", "seed": 2**31}, {"curves": {"intensity": [[0, 0], [1e5, 3]]}}, {"face": 2.0, "rate": -1.0},
)  # fmt: skip


def drawn(number: int) -> tuple[str, int, str, int]:
    """Names of the sound, its samples, the name of the text and the number of the settings of pair ``number``."""
    chance = random.Random(number)
    return chance.choice(list(SOUNDS)), chance.choice(LENGTHS), chance.choice(list(TEXTS)), chance.randrange(len(SETTINGS))


def attempt(session: Session, folder: Path, pair: tuple[str, int, str, int]) -> str:
    """What is wrong with the performance of a pair; nothing where it ends in motions or in an error for users."""
    sound, count, text, settings = pair
    path, began = folder / "sound.wav", time.process_time()
    write_wav(path, SOUNDS[sound](count))
    try:
        for motion in session.synthesize(Request(path, **{"text": TEXTS[text]} | SETTINGS[settings])).motions:
            lengths = np.linalg.norm(motion.directions, axis=-1)
            assert len(motion.directions) == max(int(count / RATE * motion.fps), 2) and np.abs(lengths - 1).max() < 1e-4
            for part in filter(None, (motion.hands, motion.face, motion.pelvis)):
                numbers = [value for value in vars(part).values() if isinstance(value, np.ndarray)]
                assert numbers and all(np.isfinite(value).all() for value in numbers), type(part)
    except S2agError as error:
        if not (error.message and error.remedy):
            return f"its sentences are {error.message!r} and {error.remedy!r}"
    except Exception:  # whatever else comes out is what is looked for
        return traceback.format_exc(limit=-6)
    spent = time.process_time() - began
    return f"it took {spent:.1f} s" if spent > SECONDS else ""


def perform_long(seconds: float, words: str, folder: Path) -> None:
    """Perform speech beside a megabyte of ``words``, repeated, and print the most kilobytes that the process has held."""
    path, text = folder / "sound.wav", words * (1_000_000 // len(words))
    write_wav(path, SOUNDS["speech"](int(seconds * RATE)))
    with contextlib.suppress(S2agError):
        Session(cache="off").synthesize(Request(path, text=text, face=1.0, hands=1.0))
    # Not getrusage, which also counts what the process that started this one held.
    print(re.search(r"VmHWM:\s*(\d+)", Path("/proc/self/status").read_text())[1])


def main() -> None:
    """Try pairs ``FIRST`` to ``FIRST + COUNT``."""
    first, count = map(int, sys.argv[1:])
    session, fallen = Session(cache="off"), 0
    with tempfile.TemporaryDirectory() as folder:
        for number in range(first, first + count):
            wrong = attempt(session, Path(folder), drawn(number))
            fallen += bool(wrong)
            if wrong:
                print(number, drawn(number), wrong, flush=True)
    print(f"{count} pairs, {fallen} fell")


if __name__ == "__main__":
    main()
