"""From what is written to what is said: apostrophes, punctuation, numbers and signs as lower-case English words."""

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
_APOSTROPHES = str.maketrans({"’": "'", "‘": "'", "ʼ": "'", "`": "'", "´": "'"})
_NUMBER = re.compile(r"(-?)([$€£]?)(\d{1,3}(?:,\d{3})+|\d+)(?:\.(\d+))?(st|nd|rd|th|s)?(%?)", re.IGNORECASE)
_YEARS = range(1100, 2000)
_LARGEST = 10**15


def normalise(word: str) -> str:
    """Lower case, straight apostrophes, no punctuation around it; inner apostrophes and hyphens stay, as in ``don't``."""
    word = unicodedata.normalize("NFKC", word).translate(_APOSTROPHES).lower()
    return re.sub(r"^[\W_]+|[\W_]+$", "", word)


def spoken(word: str) -> list[str]:
    """The words said for one written word: ``don't`` one, ``well-known`` two, ``$25`` twenty five dollars, ``—`` none."""
    word = unicodedata.normalize("NFKC", word).translate(_APOSTROPHES).lower()
    result = []
    for part in re.split(r"(?<=[^\W\d])[-–—/_]+(?=\w)|[–—…]+|\.{2,}", word):
        result += _said(part.strip("\"'()[]{}<>“”«»„.,;:!?*~"))
    return result


def cardinal(number: int) -> list[str]:
    """A whole number of at most fifteen digits in words, without "and"; longer ones digit by digit."""
    if number < 0:
        return ["minus", *cardinal(-number)]
    if number >= _LARGEST:
        return [_ONES[int(digit)] for digit in str(number)]
    if number < 20:
        return [_ONES[number]]
    if number < 100:
        return [_TENS[number // 10]] + ([_ONES[number % 10]] if number % 10 else [])
    size, name = next(scale for scale in _SCALES if number >= scale[0])
    rest = number % size
    return cardinal(number // size) + [name] + (cardinal(rest) if rest else [])


def _said(part: str) -> list[str]:
    match = _NUMBER.fullmatch(part)
    if match:
        return _number(*match.groups())
    if part in _SIGNS:
        return [_SIGNS[part]]
    pieces = re.findall(r"\d+|[^\W\d_]+(?:'[^\W\d_]+)*", re.sub(r"[&%+=@]", lambda sign: f" {_SIGNS[sign[0]]} ", part))
    return [said for piece in pieces for said in (cardinal(int(piece)) if piece.isdigit() else [piece])]


def _number(minus, currency, whole, decimals, ending, percent) -> list[str]:
    value = int(whole.replace(",", ""))
    year = value in _YEARS and ending in (None, "s") and not (minus or currency or decimals or percent or "," in whole)
    said = _year(value) if year else cardinal(value)
    if decimals:
        said = [*said, "point", *(_ONES[int(digit)] for digit in decimals)]
    if ending == "s":
        said[-1] = said[-1][:-1] + "ies" if said[-1].endswith("y") else said[-1] + "s"
    elif ending:
        said[-1] = _ordinal(said[-1])
    if minus:
        said = ["minus", *said]
    if percent:
        said.append("percent")
    if currency:
        said.append(_CURRENCIES[currency][value != 1 or bool(decimals)])
    return said


def _year(value: int) -> list[str]:
    century, rest = divmod(value, 100)
    if not rest:
        return cardinal(century) + ["hundred"]
    return cardinal(century) + (["oh"] if rest < 10 else []) + cardinal(rest)


def _ordinal(word: str) -> str:
    if word in _ORDINALS:
        return _ORDINALS[word]
    return word[:-1] + "ieth" if word.endswith("y") else word + "th"
