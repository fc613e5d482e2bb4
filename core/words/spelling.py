"""Converts written words to spoken ones: numbers, signs and abbreviations become lower-case English words."""

import re
import unicodedata

_ONES = (
    *("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve"),
    *("thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen", "nineteen"),
)
_TENS = ("", "", "twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")
_SCALES = ((10**12, "trillion"), (10**9, "billion"), (10**6, "million"), (1000, "thousand"), (100, "hundred"))
_ORDINALS = {
    "one": "first", "two": "second", "three": "third", "five": "fifth", "eight": "eighth", "nine": "ninth", "twelve": "twelfth"
}  # fmt: skip
_SIGNS = {"&": "and", "%": "percent", "+": "plus", "=": "equals", "@": "at"}
_CURRENCIES = {"$": ("dollar", "dollars"), "€": ("euro", "euros"), "£": ("pound", "pounds")}
_ABBREVIATIONS = {
    "dr": "doctor", "mr": "mister", "mrs": "missus", "prof": "professor", "vs": "versus", "etc": "et cetera", "jr": "junior",
    "approx": "approximately", "w/o": "without",
}  # fmt: skip
_UNITS = {
    "km": "kilometers", "kg": "kilograms", "cm": "centimeters", "mm": "millimeters", "m": "meters", "g": "grams",
    "lb": "pounds", "lbs": "pounds", "ft": "feet", "mi": "miles", "mph": "miles an hour", "kmh": "kilometers an hour",
    "ms": "milliseconds", "hz": "hertz", "khz": "kilohertz", "mb": "megabytes", "gb": "gigabytes", "°": "degrees",
    "°c": "degrees celsius", "°f": "degrees fahrenheit",
}  # fmt: skip
"""Expanded only after a number."""
_THOUSANDS = {"k": "thousand", "m": "million", "mn": "million", "bn": "billion", "b": "billion", "tn": "trillion"}
"""Expanded after an amount of money; ``k`` after any number."""
_FRACTIONS = {"2": "half", "3": "third", "4": "quarter"}
_APOSTROPHES = str.maketrans({"’": "'", "‘": "'", "ʼ": "'", "`": "'", "´": "'"})
_NUMBER = re.compile(r"(-?)([$€£]?)(\d{1,3}(?:,\d{3})+|\d+)(?:\.(\d+))?(st|nd|rd|th|s)?(%?)", re.IGNORECASE)
_AMOUNT = re.compile(r"([$€£]?)([\d.,]*\d)(k|m|mn|bn|b|tn)")
_MEASURE = re.compile(rf"(-?[\d.,]*\d)({'|'.join(sorted(map(re.escape, _UNITS), key=len, reverse=True))})")
_FRACTION = re.compile(r"(\d*)\s*(\d)⁄(\d)")
_RANGE = re.compile(r"([$€£]?\d{1,4}(?:\.\d+)?)[-–]([$€£]?\d{1,4}(?:\.\d+)?[%a-z°]*)")
_YEARS = range(1100, 2000)
_MAX_CARDINAL = 10**15


def normalise(word: str) -> str:
    """Return the word in lower case, with straight apostrophes and without punctuation around it, as in ``don't``."""
    word = unicodedata.normalize("NFKC", word).translate(_APOSTROPHES).lower()
    return re.sub(r"^[\W_]+|[\W_]+$", "", word)


def spoken_words(word: str) -> list[str]:
    """Return the spoken words of one written word.

    ``don't`` gives one word, ``well-known`` two, ``$25`` "twenty five dollars", ``—`` none."""
    word = unicodedata.normalize("NFKC", word).translate(_APOSTROPHES).lower()
    if (match := _RANGE.fullmatch(word.rstrip(".,;:!?"))) and not re.fullmatch(r"[$€£]?0.*", match[2]):
        return [*_speak(match[1]), "to", *_speak(match[2])]
    result = []
    for part in re.split(r"(?<=[^\W\d])[-–—/_]+(?=\w)|[–—…]+|\.{2,}", word):
        result += _speak(part.strip("\"'()[]{}<>“”«»„.,;:!?*~"))
    return result


def split_foreign(word: str) -> list[str]:
    """Split a written word of another language without spelling out numbers.

    ``Vor-Ort-Termin`` gives three words, ``3,5`` and ``20€`` one each."""
    word = unicodedata.normalize("NFKC", word).translate(_APOSTROPHES).lower()
    parts = re.split(r"(?<=[^\W\d])[-–—/_]+(?=\w)|(?<=\d)[-–]+(?=\d)|[–—…]+|\.{2,}", word)
    plain = (re.sub(r"^[^\w$€£%§&@]+|[^\w$€£%°']+$", "", re.sub(r"[()\[\]<>{}*\s]", "", part)) for part in parts)
    return [part for part in plain if part.strip("'_")]


def cardinal(number: int) -> list[str]:
    """Spell a whole number of at most fifteen digits in words, without "and"; longer ones digit by digit."""
    if number < 0:
        return ["minus", *cardinal(-number)]
    if number >= _MAX_CARDINAL:
        return [_ONES[int(digit)] for digit in str(number)]
    if number < 20:
        return [_ONES[number]]
    if number < 100:
        return [_TENS[number // 10]] + ([_ONES[number % 10]] if number % 10 else [])
    size, name = next(scale for scale in _SCALES if number >= scale[0])
    rest = number % size
    return cardinal(number // size) + [name] + (cardinal(rest) if rest else [])


def _speak(part: str) -> list[str]:
    """Return the spoken words of a part without punctuation around it."""
    if part in _ABBREVIATIONS:
        return _ABBREVIATIONS[part].split()
    if match := _NUMBER.fullmatch(part):
        return _number(*match.groups())
    if (match := _AMOUNT.fullmatch(part)) and (match[1] or match[3] == "k"):
        unit = [_CURRENCIES[match[1]][1]] if match[1] else []
        return [*_speak(match[2]), _THOUSANDS[match[3]], *unit]
    if match := _MEASURE.fullmatch(part):
        return [*_speak(match[1]), *_UNITS[match[2]].split()]
    if match := _FRACTION.fullmatch(part):
        return _fraction(*match.groups())
    if re.fullmatch(r"#\d+", part):
        return ["number", *_speak(part[1:])]
    if part in _SIGNS:
        return [_SIGNS[part]]
    pieces = re.findall(r"\d+|[^\W\d_]+(?:'[^\W\d_]+)*", re.sub(r"[&%+=@]", lambda sign: f" {_SIGNS[sign[0]]} ", part))
    return [word for piece in pieces for word in (cardinal(int(piece)) if piece.isdecimal() else [piece])]


def _number(minus: str, currency: str, whole: str, decimals: str | None, ending: str | None, percent: str) -> list[str]:
    """Spell the groups of :data:`_NUMBER`."""
    value = int(whole.replace(",", ""))
    year = value in _YEARS and ending in (None, "s") and not (minus or currency or decimals or percent or "," in whole)
    words = _year(value) if year else cardinal(value)
    if decimals:
        words = [*words, "point", *(_ONES[int(digit)] for digit in decimals)]
    if ending == "s":
        words[-1] = words[-1][:-1] + "ies" if words[-1].endswith("y") else words[-1] + "s"
    elif ending:
        words[-1] = _ordinal(words[-1])
    if minus:
        words = ["minus", *words]
    if percent:
        words.append("percent")
    if currency:
        words.append(_CURRENCIES[currency][value != 1 or bool(decimals)])
    return words


def _fraction(whole: str, upper: str, lower: str) -> list[str]:
    """Spell a fraction: ``½`` "one half", ``2¾`` "two and three quarters"."""
    name = _FRACTIONS.get(lower) or _ordinal(_ONES[int(lower)])
    plural = "halves" if lower == "2" else name + "s"
    return [*([*cardinal(int(whole)), "and"] if whole else []), _ONES[int(upper)], name if upper == "1" else plural]


def _year(value: int) -> list[str]:
    """Spell a year: 1905 "nineteen oh five"."""
    century, rest = divmod(value, 100)
    if not rest:
        return cardinal(century) + ["hundred"]
    return cardinal(century) + (["oh"] if rest < 10 else []) + cardinal(rest)


def _ordinal(word: str) -> str:
    if word in _ORDINALS:
        return _ORDINALS[word]
    return word[:-1] + "ieth" if word.endswith("y") else word + "th"
