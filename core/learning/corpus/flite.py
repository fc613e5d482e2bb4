"""Flite's voices through its C library, which reports every phone's word, syllable and end time."""

import ctypes
from ctypes import POINTER, c_char_p, c_float, c_int, c_short, c_void_p
from typing import Protocol

import numpy as np

from ...errors import S2agError
from ...sound.audio import SAMPLE_RATE
from .lexicon import FUNCTION_WORDS
from .phonemes import SpokenWord
from .texts import Sentence

NAMES = ("slt", "rms", "awb", "kal16")
_WORD = b"R:SylStructure.parent.parent.R:Token.parent"
"""Path from a phone to its token of the text between spaces ("John's" is two of Flite's words but one token)."""


class _Wave(ctypes.Structure):
    _fields_ = [("type", c_char_p), ("rate", c_int), ("count", c_int), ("channels", c_int), ("samples", POINTER(c_short))]


class _Voice(ctypes.Structure):
    _fields_ = [("name", c_char_p), ("features", c_void_p)]


_SIGNATURES = {
    "flite_synth_text": (c_void_p, c_char_p, c_void_p),
    "utt_wave": (POINTER(_Wave), c_void_p),
    "utt_relation": (c_void_p, c_void_p, c_char_p),
    "relation_head": (c_void_p, c_void_p),
    "item_next": (c_void_p, c_void_p),
    "path_to_item": (c_void_p, c_void_p, c_char_p),
    "ffeature_string": (c_char_p, c_void_p, c_char_p),
    "ffeature_float": (c_float, c_void_p, c_char_p),
    "feat_set_float": (None, c_void_p, c_char_p, c_float),
    "delete_utterance": (None, c_void_p),
}


class _Manner(Protocol):
    """The part of :class:`voices.Manner` that Flite follows."""

    @property
    def tempo(self) -> float: ...


class Flite:
    """The Flite voice of one of :data:`NAMES`. Raises :class:`S2agError` where the library is missing."""

    def __init__(self, name: str) -> None:
        try:
            # the voices resolve their language and dictionary from the symbols already loaded
            self._library = ctypes.CDLL("libflite.so.1", mode=ctypes.RTLD_GLOBAL)
            for part in ("usenglish", "cmulex"):
                ctypes.CDLL(f"libflite_{part}.so.1", mode=ctypes.RTLD_GLOBAL)
            register = getattr(ctypes.CDLL(f"libflite_cmu_us_{name}.so.1"), f"register_cmu_us_{name}")
        except (OSError, AttributeError) as error:
            raise S2agError(f"The Flite voice {name} cannot be loaded.", "Install it with: apt-get install flite") from error
        self._library.flite_init()
        for function, (result, *arguments) in _SIGNATURES.items():
            getattr(self._library, function).restype = result
            getattr(self._library, function).argtypes = arguments
        register.restype, register.argtypes = c_void_p, [c_char_p]
        self._voice = register(None)
        self._features = ctypes.cast(self._voice, POINTER(_Voice)).contents.features

    def say(self, sentence: Sentence, manner: _Manner) -> tuple[np.ndarray, list[SpokenWord]] | None:
        """Return audio at 16 kHz and the words' times; None where Flite reads the text as other words."""
        flite = self._library
        # Flite's noise comes from the C library's generator, which is seeded for each sentence to be reproducible
        ctypes.CDLL(None).srand(1)
        flite.feat_set_float(self._features, b"duration_stretch", 1 / manner.tempo)
        utterance = flite.flite_synth_text(sentence.text.encode(), self._voice)
        if not utterance:
            return None
        try:
            wave = flite.utt_wave(utterance).contents
            if wave.rate != SAMPLE_RATE:
                raise S2agError(f"This Flite speaks at {wave.rate} Hz.", f"Use a voice at {SAMPLE_RATE} Hz.")
            audio = np.ctypeslib.as_array(wave.samples, (wave.count,)) / 32768
            phones = self._phones(utterance)
        finally:
            flite.delete_utterance(utterance)
        spoken = place_words(sentence.words, phones)
        return (audio, spoken) if spoken else None

    def _phones(self, utterance: int) -> list[tuple[int | None, float, bool, bool]]:
        """Return each phone's token (None in a pause), end (s), whether its syllable is stressed, whether it is a vowel."""
        flite, result = self._library, []
        phone = flite.relation_head(flite.utt_relation(utterance, b"Segment"))
        while phone:
            stressed = flite.ffeature_string(phone, b"R:SylStructure.parent.stress") == b"1"
            vowel = flite.ffeature_string(phone, b"ph_vc") == b"+"
            result.append((flite.path_to_item(phone, _WORD), flite.ffeature_float(phone, b"end"), stressed, vowel))
            phone = flite.item_next(phone)
        return result


def place_words(texts: tuple[str, ...], phones: list[tuple[int | None, float, bool, bool]]) -> list[SpokenWord] | None:
    """Return words from phones ``(token or None, end in seconds, stressed, vowel)``; None if their number differs."""
    groups, begin = [], 0.0
    for identity, end, stressed, vowel in phones:
        if not groups or identity != groups[-1][0]:
            groups.append((identity, []))
        groups[-1][1].append((round(begin * SAMPLE_RATE), round(end * SAMPLE_RATE), stressed, vowel))
        begin = end
    spoken = [k for k, group in enumerate(groups) if group[0]]
    if len(spoken) != len(texts):
        return None
    result = []
    for text, k in zip(texts, spoken, strict=True):
        part = groups[k][1]
        vowels = [phone for phone in part if phone[3]] or part
        main = next((phone for phone in vowels if phone[2]), vowels[0])
        pause = -1
        if k + 1 < len(groups) and not groups[k + 1][0]:
            pause = (groups[k + 1][1][0][0] + groups[k + 1][1][-1][1]) // 2
        result.append(SpokenWord(text, part[0][0], part[-1][1], main[:2], 0 if text in FUNCTION_WORDS else 2, pause))
    return result
