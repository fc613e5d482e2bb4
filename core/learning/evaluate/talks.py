"""The speech of the evaluation: held-out talks of a directed corpus, and recordings of people."""

from dataclasses import dataclass, replace
from functools import cached_property
from os import PathLike
from pathlib import Path

import numpy as np

from ... import styles
from ...errors import CorpusUnreadable
from ...motion import skeleton
from ...sound import prosody, voice_activity
from ...sound.audio import SAMPLE_RATE

TEST = 2
_NEEDED = ("affect", "accents", "accent_starts", "strokes", "stroke_starts")


@dataclass(frozen=True)
class Talk:
    """A recording with its annotations. ``recording`` is the same for performances of the same speech.

    ``audio`` ``(n,)`` float32 at 16 kHz; ``words`` (text, start, end); ``accents`` ``(a, 3)`` time, strength, main;
    ``style`` the speaker's name; ``controls`` by name; ``affect`` ``(3,)`` as acted (ranks, 0..1), None for people. Of a
    directed performance also ``directed`` ``(frames, 9, 3)`` with its ``strokes`` ``(s,)`` and ``rest`` ``(9, 3)``.
    """

    name: str
    recording: str
    audio: np.ndarray
    words: tuple[tuple[str, float, float], ...]
    accents: np.ndarray
    style: str = ""
    controls: dict[str, float] | None = None
    affect: np.ndarray | None = None
    directed: np.ndarray | None = None
    strokes: np.ndarray | None = None
    rest: np.ndarray | None = None

    @property
    def main(self) -> np.ndarray:
        """Times of the phrases' main accents."""
        return self.accents[self.accents[:, 2] > 0.5, 0]

    @cached_property
    def spoken(self) -> tuple[tuple[str, float, float], ...]:
        """The words with times, or voiced segments where the words are unknown."""
        return self.words or tuple(("", start, end) for start, end in voice_activity.segments(self.audio))

    @cached_property
    def loudness(self) -> np.ndarray:
        """Root mean square ``(frames,)`` of the sound at 15 fps."""
        frames, hop = int(len(self.audio) / SAMPLE_RATE * skeleton.FPS), SAMPLE_RATE / skeleton.FPS
        edges = np.round(np.arange(frames + 1) * hop).astype(int)
        total = np.concatenate([[0.0], np.cumsum(np.square(self.audio, dtype=float))])
        return np.sqrt(np.diff(total[edges]) / np.diff(edges))

    def cut(self, seconds: float) -> "Talk":
        """Return the first ``seconds`` of the talk."""
        frames = int(seconds * skeleton.FPS)
        return replace(
            self,
            name=f"{self.name} ({seconds:g} s)",
            audio=self.audio[: int(seconds * SAMPLE_RATE)],
            words=tuple(word for word in self.words if word[2] <= seconds),
            accents=self.accents[self.accents[:, 0] < seconds],
            directed=None if self.directed is None else self.directed[:frames],
            strokes=None if self.strokes is None else self.strokes[self.strokes < seconds],
        )


class Corpus:
    """A directed corpus (a folder, see ``core/learning/train/storage.py``) with the arrays for evaluation, and its speech."""

    def __init__(self, folder: str | PathLike, speech: str | PathLike) -> None:
        """Open both folders. Raises :class:`CorpusUnreadable` where one is missing or the corpus has no test split."""
        from ..train.storage import load_arrays

        self.arrays, self.meta = load_arrays(folder)
        missing = [name for name in _NEEDED if name not in self.arrays]
        remedy = "Build it again with: python -m s2ag.core.learning.corpus"
        if missing:
            raise CorpusUnreadable(f"{folder} holds no {missing[0]}.npy, which evaluation needs.", remedy)
        if not (self.arrays["split"] == TEST).any():
            raise CorpusUnreadable(f"{folder} holds no performance of the test split.", remedy)
        self.speech = Path(speech)
        if not self.speech.is_dir():
            raise CorpusUnreadable(f"There is no folder of speech {speech}.", "Name the one that the corpus was built with.")

    @cached_property
    def speakers(self) -> list[dict]:
        """Name, description and resting pose of every speaker."""
        return self.meta["speakers"]

    def rest(self, speaker: int) -> np.ndarray:
        """Return a speaker's pose between gestures, ``(9, 3)``."""
        return np.array(self.speakers[speaker]["rest"], np.float32)

    def performance(self, number: int) -> np.ndarray:
        """Return the directions ``(frames, 9, 3)`` float32 of a performance."""
        starts = self.arrays["starts"]
        return skeleton.normalize(self.arrays["directions"][starts[number] : starts[number + 1]].astype(np.float32))

    def acted(self) -> np.ndarray:
        """Return which recordings ``(R,)`` were synthesized with an annotated affect; recordings of people were not."""
        return np.array([not str(entry.get("kind", "")).startswith("human") for entry in self.meta["recordings"]])

    def chosen(self, count: int) -> list[int]:
        """Return ``count`` test performances of as many recordings as possible, with speakers in rotation; deterministic."""
        arrays = self.arrays
        rounds: list[tuple[int, int, int]] = []
        recordings = np.unique(arrays["recording"][arrays["split"] == TEST])
        for row, recording in enumerate(recordings):
            takes = np.flatnonzero((arrays["recording"] == recording) & (arrays["split"] == TEST))
            rounds += [(turn, row, int(take)) for turn, take in enumerate(np.roll(takes, -row))]
        return [number for *_, number in sorted(rounds)[:count]]

    def talk(self, number: int) -> Talk:
        """Load a performance with its recording. Raises :class:`CorpusUnreadable` where its speech is missing or differs."""
        from ..corpus.speech import Speech

        arrays = self.arrays
        recording, speaker = int(arrays["recording"][number]), int(arrays["speaker"][number])
        entry = self.meta["recordings"][recording]
        path = self.speech / entry["speech"]
        try:
            speech = Speech.load(path)
        except (OSError, ValueError, KeyError) as error:
            message = f"The speech {path} is missing or damaged."
            raise CorpusUnreadable(message, "Name the folder that the corpus was built with.") from error
        directed = self.performance(number)
        if abs(len(directed) - speech.duration * skeleton.FPS) > 2:
            message = f"The speech {path} is not what the corpus was directed to: it has another length."
            raise CorpusUnreadable(message, "Name the folder that the corpus was built with.")
        return Talk(
            f"{path.stem} {self.speakers[speaker]['name']}",
            path.stem,
            speech.recorded,
            tuple((str(word), float(start), float(end)) for word, start, end in entry["words"]),
            self._part("accents", "accent_starts", recording),
            self.speakers[speaker]["name"],
            dict(zip(styles.CONTROLS, arrays["controls"][number].tolist(), strict=True)),
            np.array(arrays["affect"][recording]) if self.acted()[recording] else None,
            directed,
            self._emphases(number),
            self.rest(speaker),
        )

    def _emphases(self, number: int) -> np.ndarray:
        """Return the emphasis times of a performance; corpora of the first half of 2026 hold nothing else of strokes."""
        strokes = self._part("strokes", "stroke_starts", number)
        return strokes[:, 2] if strokes.ndim == 2 else strokes

    def _part(self, name: str, starts: str, row: int) -> np.ndarray:
        begin, end = self.arrays[starts][row : row + 2]
        return np.array(self.arrays[name][begin:end], float)


def load_human_recording(path: str | PathLike, text: str | None = None) -> Talk:
    """Load a person's recording, aligned with its ``text``, by default the text file of the same name, if there is one.

    Raises :class:`S2agError` for unreadable files.
    """
    from ...sound import audio
    from ...words import transcript

    path = Path(path)
    sound = audio.load(path)
    file = path.with_suffix(".txt")
    words = transcript.timed_transcript(sound, file if text is None and file.is_file() else None, text).words
    accents = [(accent.time, accent.strength, accent.main) for accent in prosody.analyse(sound, words).accents]
    return Talk(path.stem, path.stem, sound, words, np.array(accents, float).reshape(-1, 3))
