"""Guesses the pronunciation of words that are in no dictionary: letter rules to CMU phones."""

import unicodedata

_LETTERS = {
    "tious": "SH AH S", "cious": "SH AH S", "ought": "AO T", "aught": "AO T",
    "tion": "SH AH N", "sion": "ZH AH N", "ture": "CH ER", "eigh": "EY", "ough": "OW",
    "igh": "AY", "tch": "CH", "dge": "JH", "sch": "SH", "air": "EH R", "ear": "IH R", "eer": "IH R", "our": "AW ER",
    "ing": "IH NG", "oor": "AO R", "eau": "OW", "ous": "AH S",
    "ch": "CH", "sh": "SH", "th": "TH", "ph": "F", "gh": "G", "wh": "W", "wr": "R", "kn": "N", "ck": "K", "ng": "NG",
    "qu": "K W", "ee": "IY", "ea": "IY", "ie": "IY", "ei": "EY", "ai": "EY", "ay": "EY", "ey": "IY", "oa": "OW", "oe": "OW",
    "oo": "UW", "ou": "AW", "ow": "OW", "oi": "OY", "oy": "OY", "au": "AO", "aw": "AO", "eu": "Y UW", "ew": "Y UW", "ue": "UW",
    "ar": "AA R", "er": "ER", "ir": "ER", "or": "AO R", "ur": "ER", "ce": "S", "ci": "S IH", "cy": "S IY", "ge": "JH",
    "a": "AE", "b": "B", "c": "K", "d": "D", "e": "EH", "f": "F", "g": "G", "h": "HH", "i": "IH", "j": "JH", "k": "K", "l": "L",
    "m": "M", "n": "N", "o": "AA", "p": "P", "q": "K", "r": "R", "s": "S", "t": "T", "u": "AH", "v": "V", "w": "W", "x": "K S",
    "y": "IY", "z": "Z",
}  # fmt: skip
_NAMES = {
    "a": "EY", "e": "IY", "i": "AY", "o": "OW", "u": "Y UW", "y": "W AY",
    "b": "B IY", "c": "S IY", "d": "D IY", "f": "EH F", "g": "JH IY", "h": "EY CH", "j": "JH EY", "k": "K EY", "l": "EH L",
    "m": "EH M", "n": "EH N", "p": "P IY", "q": "K Y UW", "r": "AA R", "s": "EH S", "t": "T IY", "v": "V IY",
    "w": "D AH B AH L Y UW", "x": "EH K S", "z": "Z IY",
}  # fmt: skip


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
