"""The corpus's speech: talks in many voices with the time of every word."""

import json
from dataclasses import asdict, dataclass
from os import PathLike

import numpy as np

from ...files import atomic_file
from ...sound.audio import SAMPLE_RATE
from . import acting, human_speech, kathleen, recording_simulation, texts, vocal_delivery, voices
from .phonemes import SpokenWord
from .talk_list import ROUND, Talk, count, talks

__all__ = ["Speech", "Talk", "Word", "count", "make", "speak", "talks"]

@dataclass(frozen=True)
class Word:
    """A word in a talk. Times in seconds; ``vowel``: span of its most stressed vowel; ``stress`` 0 none, 1 secondary, 2 main.

    ``sentence`` counts from 0; ``closing`` is the punctuation mark after it, or "".
    """

    text: str
    start: float
    end: float
    vowel: tuple[float, float]
    stress: int
    sentence: int
    closing: str


@dataclass(frozen=True)
class Speech:
    """A spoken talk: ``clean`` and ``recorded`` (degraded) audio ``(n,)`` float32 at 16 kHz, words, affect of each sentence
    ``(s, 3)``.

    ``voice`` holds its ``kind``, as in ``piper``, ``flite:slt``, ``espeak:en-gb``, ``human:kathleen`` or ``human:prompts``.
    ``affect``: what was acted, as ranks 0..1. A recording without known text has no words and one row of neutral affect.
    """

    index: int
    split: int
    clean: np.ndarray
    recorded: np.ndarray
    words: tuple[Word, ...]
    affect: np.ndarray
    voice: dict

    @property
    def duration(self) -> float:
        """Length in seconds."""
        return len(self.clean) / SAMPLE_RATE

    def save(self, path: str | PathLike) -> None:
        """Write as ``.npz`` with 16-bit audio, atomically."""
        words = [asdict(word) for word in self.words]
        text = json.dumps({"index": self.index, "split": self.split, "words": words, "voice": self.voice})
        pcm = {name: np.round(getattr(self, name) * 32767).astype(np.int16) for name in ("clean", "recorded")}
        with atomic_file(path) as temporary, open(temporary, "wb") as file:
            np.savez(file, **pcm, affect=self.affect, text=np.array(text))

    @classmethod
    def load(cls, path: str | PathLike) -> "Speech":
        """Read what :meth:`save` wrote."""
        with np.load(path) as data:
            text = json.loads(str(data["text"]))
            clean, recorded = (data[name].astype(np.float32) / 32767 for name in ("clean", "recorded"))
            affect = data["affect"]
        words = tuple(Word(**{**word, "vowel": tuple(word["vowel"])}) for word in text["words"])
        return cls(text["index"], text["split"], clean, recorded, words, affect, text["voice"])


def make(material: str, index: int, seed: int) -> Speech | None:
    """Synthesize talk ``index`` of :func:`talks`, or join it from recordings; None if no sentence or recording is usable.

    All randomness follows from ``seed`` and the index, except the noise inside Piper's generator: two runs differ in detail
    there, and the cache keeps the first. Raises :class:`S2agError` where a voice's program is missing.
    """
    talk = talks(material, seed)[index]
    random = np.random.default_rng([seed, index])
    if talk.script is None:
        return _person_talk(material, talk, seed, random)
    hers = talk.kind == kathleen.KIND
    voice = kathleen.Reader(material, talk.script) if hers else voices.voice(talk.kind)
    # all readings of a script by one voice are one talker's
    person = vocal_delivery.draw_voice(talk.kind, np.random.default_rng([seed, 41, talk.script.index, talk.number // ROUND]))
    if talk.acting == "natural":
        return _speak(talk.script, voice, person, None, random, index)
    acted = acting.act(np.array([sentence.affect for sentence in talk.script.sentences]), talk.acting, random, talk.mood)
    return _speak(talk.script, voice, person, acted, random, index)


def speak(script: texts.Script, kind: str, random: np.random.Generator, index: int = 0) -> Speech | None:
    """Speak a script in a voice of this kind, acting what its text expresses; None if no sentence's words were aligned."""
    person = vocal_delivery.draw_voice(kind, random)
    acted = np.array([0.6 * np.array(sentence.affect) + 0.4 * script.affect for sentence in script.sentences])
    return _speak(script, voices.voice(kind), person, acted, random, index)


def _speak(
    script: texts.Script,
    voice: voices.Voice,
    person: vocal_delivery.Voice,
    acted: np.ndarray | None,
    random: np.random.Generator,
    index: int,
) -> Speech | None:
    """Speak a script, each sentence in its mood of ``acted`` ``(s, 3)``; None: as the voice says it."""
    pieces, words, affects = [_silence(random.uniform(0.3, 1.5))], [], []
    moods = np.full((len(script.sentences), 3), acting.NEUTRAL) if acted is None else acted
    for sentence, affect in zip(script.sentences, moods, strict=True):
        arousal = float(affect[1])
        delivery = vocal_delivery.draw_delivery(person, affect, random)
        utterance = voice.say(sentence, delivery.manner)
        if utterance is None:
            continue
        audio, spoken = utterance
        if acted is not None:
            # a recording is as fast as it was read; the vocoder gives it the tempo
            tempo = delivery.manner.tempo if person.kind == kathleen.KIND else 1.0
            audio = vocal_delivery.apply_delivery(audio, spoken, delivery, random, tempo)
            spoken = vocal_delivery.hasten(spoken, tempo)
            pauses = [vocal_delivery.comma_pause(arousal, random) for _ in spoken[:-1]] + [0.0]
            audio, spoken = vocal_delivery.insert_pauses(audio, spoken, pauses)
        numbers = [len(affects)] * len(spoken)
        words += _words(spoken, sum(map(len, pieces)), numbers, texts.closing_marks(sentence.text))
        pieces += [audio, _silence(vocal_delivery.sentence_pause(arousal, random))]
        affects.append(affect)
    if not affects:
        return None
    return _finish(index, script.split, np.concatenate(pieces), words, np.array(affects), asdict(person), random)


def _person_talk(material: str, talk: Talk, seed: int, random: np.random.Generator) -> Speech | None:
    words, voice = [], {"kind": talk.kind}
    if talk.kind == "human:sonnet":
        audio, spoken, closings, numbers = human_speech.sonnet(material)
        words = _words(spoken, 0, numbers, closings)
    else:
        groups = human_speech.prompt_talks(seed)
        if talk.number > len(groups):
            return None
        audio = human_speech.join_prompts(groups[talk.number - 1], random)
    rows = 1 + (words[-1].sentence if words else 0)
    return _finish(talk.index, 0, audio, words, np.full((rows, 3), 0.5), voice, random)


def _finish(
    index: int,
    split: int,
    audio: np.ndarray,
    words: list[Word],
    affect: np.ndarray,
    voice: dict,
    random: np.random.Generator,
) -> Speech:
    """Normalise the peak, simulate a recording, and return the talk."""
    clean = (audio / max(np.abs(audio).max(), 1e-9) * 0.9).astype(np.float32)
    recorded = recording_simulation.simulate_recording(clean, random).astype(np.float32)
    return Speech(index, split, clean, recorded, tuple(words), affect, voice)


def _words(spoken: list[SpokenWord], offset: int, sentences: list[int], closings: list[str]) -> list[Word]:
    """Convert words in samples, ``offset`` samples into the talk, to words in seconds."""
    result = []
    for word, sentence, closing in zip(spoken, sentences, closings, strict=True):
        start, end, first, last = ((x + offset) / SAMPLE_RATE for x in (word.start, word.end, *word.vowel))
        result.append(Word(word.text, start, end, (first, last), word.stress, sentence, closing))
    return result


def _silence(seconds: float) -> np.ndarray:
    return np.zeros(round(seconds * SAMPLE_RATE))
