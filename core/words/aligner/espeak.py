"""Pronounces words of other languages with the phones of the English acoustic model: eSpeak NG's IPA mapped to CMU phones.

The package ``espeakng-loader`` (extra ``languages``) provides eSpeak NG as a library, with rules for over a hundred languages
that cover numbers and signs, too. A sound that English lacks becomes the phone nearest in place and manner of articulation; if
two are equally near, both are alternatives and the search takes the one that fits the speaker."""

import ctypes
import importlib.util
import os
import re
import unicodedata
from pathlib import Path

from ...errors import TranscriptUnreadable
from ...files import read_bytes
from ...optional_packages import ESPEAK

MAX_PRONUNCIATIONS = 8
"""Maximum number of pronunciations of a word."""
_SOUNDS = {
    "i": "IY", "y": "UW|IY", "ɨ": "IH", "ʉ": "UW", "ɯ": "UW", "u": "UW", "ɪ": "IH", "ʏ": "UH|IH", "ʊ": "UH", "ᵻ": "IH",
    "e": "EY|EH", "ø": "ER|EH", "ɘ": "AH", "ɵ": "UH", "ɤ": "AH", "o": "OW", "ə": "AH", "ɛ": "EH", "œ": "ER|EH",
    "ɜ": "ER|AH", "ɞ": "ER", "ɚ": "ER", "ɝ": "ER", "ʌ": "AH", "ɔ": "AO", "æ": "AE", "ɐ": "AH", "a": "AA|AE", "ɶ": "AE",
    "ɑ": "AA", "ɒ": "AO",
    "p": "P", "b": "B", "t": "T", "d": "D", "ʈ": "T", "ɖ": "D", "c": "K", "ɟ": "G", "k": "K", "ɡ": "G", "g": "G", "q": "K",
    "ɢ": "G", "m": "M", "ɱ": "M", "n": "N", "ɳ": "N", "ɲ": "N Y", "ŋ": "NG", "ɴ": "NG", "ʙ": "B", "r": "R|D", "ʀ": "R",
    "ɾ": "D|R", "ɽ": "D", "ɸ": "F", "β": "V|B", "f": "F", "v": "V", "θ": "TH", "ð": "DH", "s": "S", "z": "Z", "ʃ": "SH",
    "ʒ": "ZH", "ʂ": "SH", "ʐ": "ZH", "ç": "HH|SH", "ʝ": "Y", "x": "HH|K", "ɣ": "G", "χ": "HH|K", "ʁ": "R|HH", "ħ": "HH",
    "ʕ": "AA", "h": "HH", "ɦ": "HH", "ɬ": "SH L", "ɮ": "L", "ʋ": "V", "ɹ": "R", "ɻ": "R", "j": "Y", "ɰ": "W", "l": "L",
    "ɭ": "L", "ɫ": "L", "ʎ": "L Y", "ʟ": "L", "w": "W", "ʍ": "W", "ɥ": "W", "ɕ": "SH", "ʑ": "ZH",
    "aɪ": "AY", "aʊ": "AW", "ɑɪ": "AY", "ɑʊ": "AW", "ai": "AY", "au": "AW", "ɔø": "OY", "ɔʏ": "OY", "ɔɪ": "OY", "oɪ": "OY",
    "oi": "OY", "eɪ": "EY", "ei": "EY", "ɛɪ": "EY", "oʊ": "OW", "ou": "OW", "əʊ": "OW", "tʃ": "CH", "dʒ": "JH", "tɕ": "CH",
    "dʑ": "JH",
}  # fmt: skip
"""IPA to CMU phones, alternatives separated by ``|``; marks of stress, length and tone are ignored."""
_NASAL = "\N{COMBINING TILDE}"
_CODE = re.compile(r"^language[ \t]+([\w-]+)", re.MULTILINE)
_SWITCH = re.compile(r"\([a-z-]+\)")
_PURPOSE, _UTF8, _IPA, _KEEP_ALIVE = 2, 1, 0x02, 0x8000
"""eSpeak NG's constants: no audio output, text in UTF-8, phonemes in IPA, and errors must not end the process."""


def find_voice(code: str) -> str:
    """Return eSpeak NG's voice for a language code in small letters, a file name; raise :class:`TranscriptUnreadable` if it has
    none."""
    spec = importlib.util.find_spec(ESPEAK)
    assert spec is not None and spec.origin is not None
    voices: dict[str, str] = {}
    for path in sorted(Path(spec.origin).with_name("espeak-ng-data").joinpath("lang").rglob("*")):
        if path.is_file():
            text = read_bytes(path).decode("utf-8", "replace")
            voices |= {name.lower(): path.name for name in _CODE.findall(text) if name.lower() not in voices}
            voices[path.name.lower()] = path.name
    if code not in voices:
        codes = ", ".join(sorted(name for name in voices if len(name) == 2))
        raise TranscriptUnreadable(f"eSpeak NG does not know the language {code}.", f"It knows {codes} and others.")
    return voices[code]


def ipa_to_cmu(ipa: str) -> list[str]:
    """Convert a word in IPA, its sounds separated by ``_`` or spaces, to pronunciations in CMU phones.

    The most likely comes first, then those in which one sound has another alternative."""
    sounds = [choices for piece in re.split(r"[_\s]+", _SWITCH.sub("", ipa)) for choices in _sounds(piece)]
    variants = [[choices[0] for choices in sounds]]
    for place, choices in enumerate(sounds):
        variants += [[*variants[0][:place], other, *variants[0][place + 1 :]] for other in choices[1:]]
    return list(dict.fromkeys(" ".join(variant) for variant in variants if variant))[:MAX_PRONUNCIATIONS]


def _sounds(piece: str) -> list[list[str]]:
    """Return the alternatives of every sound of a piece of IPA; unknown signs are skipped."""
    piece = unicodedata.normalize("NFC", piece)
    if piece not in _SOUNDS and "ç" not in piece:
        piece = unicodedata.normalize("NFD", piece)
    result: list[list[str]] = []
    while piece:
        size = 2 if piece[:2] in _SOUNDS else 1
        if piece[:size] in _SOUNDS:
            result.append(_SOUNDS[piece[:size]].split("|"))
        elif piece[0] == _NASAL and result:
            result[-1] = [f"{sound} N" for sound in result[-1]]
        piece = piece[size:]
    return result


class Espeak:
    """eSpeak NG with the voice of a language, as in ``de``; raises :class:`ValueError` if it has none."""

    def __init__(self, language: str):
        import espeakng_loader as package

        self._library = ctypes.CDLL(package.get_library_path())
        self._library.espeak_TextToPhonemes.restype = ctypes.c_char_p
        self._library.espeak_TextToPhonemes.argtypes = [ctypes.POINTER(ctypes.c_void_p), ctypes.c_int, ctypes.c_int]
        if self._library.espeak_Initialize(_PURPOSE, 0, os.fsencode(package.get_data_path()), _KEEP_ALIVE) < 0:
            raise ValueError("eSpeak NG does not start")
        if self._library.espeak_SetVoiceByName(language.encode()):
            raise ValueError(f"eSpeak NG does not speak {language!r}")

    def pronunciations(self, word: str) -> list[str]:
        """Return pronunciations of a word in CMU phones, most likely first; words in capitals are also spelt out."""
        texts = [word, " ".join(word)] if len(word) > 1 and word.isupper() else [word]
        return [variant for text in texts for variant in ipa_to_cmu(self.ipa(text))]

    def ipa(self, text: str) -> str:
        """Return the IPA of a text, sounds separated by ``_`` and spaces."""
        buffer = ctypes.create_string_buffer(text.encode())
        rest, clauses = ctypes.c_void_p(ctypes.addressof(buffer)), []
        while rest.value:
            clause = self._library.espeak_TextToPhonemes(ctypes.byref(rest), _UTF8, _IPA | ord("_") << 8)
            clauses.append((clause or b"").decode())
        return " ".join(clauses)
