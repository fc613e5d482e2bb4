"""Flite's voices through its C library, which knows every phone's word, syllable and end."""

import ctypes
from ctypes import POINTER, c_char_p, c_float, c_int, c_short, c_void_p

import numpy as np

from ...errors import S2agError
from ...sound.audio import SAMPLE_RATE
from .lexicon import FUNCTION
from .phonemes import Spoken
from .texts import Sentence

NAMES = ("slt", "rms", "awb", "kal16")
_WORD = b"R:SylStructure.parent.parent.R:Token.parent"
"""From a phone to what stood between spaces in the text ("John's" is two of Flite's words, one of ours)."""


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


class Flite:
    """One of :data:`NAMES`. Raises :class:`S2agError` where the library is missing."""

    def __init__(self, name: str):
        try:
            # the voices look for their language and dictionary among the symbols already loaded
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

    def say(self, sentence: Sentence, manner) -> tuple[np.ndarray, list[Spoken]] | None:
        """Audio at 16 kHz and placed words; None where Flite reads the text as other words."""
        flite = self._library
        # its noise comes from the C library's generator: every sentence starts anew, so a talk can be made again
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
        placed = words(sentence.words, phones)
        return (audio, placed) if placed else None

    def _phones(self, utterance) -> list[tuple[int | None, float, bool, bool]]:
        """Word identity (None in a pause), end (s), in a stressed syllable, vowel."""
        flite, result = self._library, []
        phone = flite.relation_head(flite.utt_relation(utterance, b"Segment"))
        while phone:
            stressed = flite.ffeature_string(phone, b"R:SylStructure.parent.stress") == b"1"
            vowel = flite.ffeature_string(phone, b"ph_vc") == b"+"
            result.append((flite.path_to_item(phone, _WORD), flite.ffeature_float(phone, b"end"), stressed, vowel))
            phone = flite.item_next(phone)
        return result


def words(texts: tuple[str, ...], phones: list[tuple[int | None, float, bool, bool]]) -> list[Spoken] | None:
    """Words from ``(identity or None, end in seconds, stressed, vowel)`` phones; None if their number differs."""
    groups, begin = [], 0.0
    for identity, end, stressed, vowel in phones:
        if not groups or identity != groups[-1][0]:
            groups.append((identity, []))
        groups[-1][1].append((round(begin * SAMPLE_RATE), round(end * SAMPLE_RATE), stressed, vowel))
        begin = end
    said = [k for k, group in enumerate(groups) if group[0]]
    if len(said) != len(texts):
        return None
    result = []
    for text, k in zip(texts, said, strict=True):
        part = groups[k][1]
        vowels = [phone for phone in part if phone[3]] or part
        main = next((phone for phone in vowels if phone[2]), vowels[0])
        pause = -1
        if k + 1 < len(groups) and not groups[k + 1][0]:
            pause = (groups[k + 1][1][0][0] + groups[k + 1][1][-1][1]) // 2
        result.append(Spoken(text, part[0][0], part[-1][1], main[:2], 0 if text in FUNCTION else 2, pause))
    return result
