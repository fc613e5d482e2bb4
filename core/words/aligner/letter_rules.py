"""Guesses the pronunciation of words that are in no dictionary: letter rules to CMU phones."""

import json
import unicodedata
from pathlib import Path

_ENGLISH = json.loads(Path(__file__).with_suffix(".json").read_text("utf-8"))
_LETTERS, _NAMES = _ENGLISH["rules"], _ENGLISH["names"]
"""Phones of letters in a word, and of the names of single letters."""


def guess_phones(word: str, letters: dict[str, str] | None = None) -> str:
    """Guess the CMU phones of a word from its spelling; "" for a word without Latin letters.

    Words in capitals and words without vowels are spelt out. ``letters`` replaces the English rules by those of another
    language: from lower-case letters to phones (which may be ""); the longest match wins and unknown letters are skipped."""
    if letters is not None:
        return _by_rules("".join(char for char in unicodedata.normalize("NFC", word.lower()) if char.isalpha()), letters)
    plain = [char for char in unicodedata.normalize("NFKD", word.lower()) if "a" <= char <= "z"]
    if plain and (len(word) > 1 and word.isupper() or not set(plain) & set("aeiouy")):
        return " ".join(_NAMES[char] for char in plain)
    if len(plain) > 2 and plain[-1] == "e" and "".join(plain[-2:]) not in _LETTERS:
        plain.pop()
    plain = [char for place, char in enumerate(plain) if place == 0 or char != plain[place - 1] or char in "eo"]
    return _by_rules("".join(plain), _LETTERS)


def _by_rules(text: str, rules: dict[str, str]) -> str:
    """Apply letter rules from left to right, the longest match first."""
    longest, result = max(map(len, rules), default=0), []
    while text:
        size = next((size for size in range(min(longest, len(text)), 0, -1) if text[:size] in rules), 0)
        result += rules[text[:size]].split() if size else []
        text = text[size or 1 :]
    return " ".join(result)
