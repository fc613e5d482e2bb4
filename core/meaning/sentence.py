"""Understands sentences: which words call for which schema (an image such as rise or split, or a speech act).

A grammar of a language (assets/meanings/LANGUAGE.json, written by hand) holds frames, sequences of words that decide; a table
of its lemmas (LANGUAGE.words.json, made from a thesaurus) says which words mean a schema on their own. docs/meaning.md has the
notation."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

FOLDER = Path(__file__).parents[1] / "assets" / "meanings"
SILENT = "-"
"""The schema of frames that show nothing and keep their words from others."""
_STOPS, _PAUSES = ".;:!?…", ",–—"
_GAP = 3
"""Words that ``~`` may leave out unless it says how many."""
_LEAST_STEM = 3
"""Letters of the shortest word that has endings."""
_PASSIVE = 3
"""Tenths less for what is done to somebody, which hands show less."""
_LEAST_IN_FRAME = 3
"""Least tenths of a lemma's uses where a frame supports it."""


class Occasion(NamedTuple):
    """Words ``first`` to ``last`` call for ``schema``, shown at word ``bearer``; ``score`` 0..1 is how surely."""

    bearer: int
    schema: str
    first: int
    last: int
    score: float


class Token(NamedTuple):
    """A word, or a part of one, with all that it may be."""

    word: int
    forms: frozenset
    tags: Mapping[str, int]
    starts: bool
    pauses: bool
    ends: bool
    asked: bool


class _Frame(NamedTuple):
    schema: str
    elements: tuple
    order: int


@dataclass(frozen=True)
class Grammar:
    """What decides in a language: ``frames`` by the word or tag that they begin with, ``lemmas`` -> ``(schema, part of speech,
    tenths)``, and the language's own data."""

    frames: Mapping[str, Sequence[_Frame]]
    lemmas: Mapping[str, Sequence[tuple[str, str, int]]]
    known: frozenset
    data: Mapping[str, Any]
    irregular: Mapping[str, str]
    classes: Mapping[str, frozenset]


def files(language: str | None = None) -> list[Path]:
    """Return the files of what is known of a language, by its code as in ``de`` or ``pt-br`` (None: English)."""
    code = (language or "en").strip().lower().replace("_", "-").split("-")[0]
    return [path for path in (FOLDER / f"{code}.json", FOLDER / f"{code}.words.json") if path.is_file()]


@lru_cache(maxsize=8)
def load_grammar(language: str | None = None) -> Grammar | None:
    """Load the grammar of a language as in ``de``; None where there is none."""
    found = [json.loads(path.read_text("utf-8")) for path in files(language)]
    if not found:
        return None
    data, words = (*found, {"schemas": {}, "irregular": {}})[:2]
    classes = {name: frozenset(listed.split()) for name, listed in data["classes"].items()}
    lemmas: dict[str, list] = {}
    for schema, each in words["schemas"].items():
        for pos, listed in each.items():
            for entry in listed.split():
                if entry[:-1] not in data.get("unfit", ()):
                    lemmas.setdefault(entry[:-1], []).append((schema, pos, int(entry[-1])))
    frames: dict[str, list[_Frame]] = {}
    known = set(lemmas)
    listed = [(schema, text) for schema, each in data["frames"].items() for text in each]
    listed += [  # words of several parts, as in "go up"
        (schema, lemma.replace("_", " "))
        for lemma, each in lemmas.items()
        for schema, _, tenths in each
        if "_" in lemma and tenths >= data["lone"]["least"]
    ]
    for order, (schema, text) in enumerate(listed):
        for elements in _variants(text, classes, data["numbers"]):
            key = next(element for element in elements if element[0] == "word")
            known |= key[1]
            for element in elements:
                known |= element[1] if element[0] == "word" else frozenset()
            for first in key[1]:
                frames.setdefault(first, []).append(_Frame(schema, elements, order))
    return Grammar(frames, lemmas, frozenset(known), data, {**words["irregular"], **data["forms"]}, classes)


def _variants(text: str, classes: Mapping[str, frozenset], numbers: Mapping[str, int]) -> list[tuple]:
    """Read a frame; return it with and without each of its optional words, as tuples of ``(kind, words, number, bears)``."""
    choices = []
    for part in text.split():
        optional, part = part.endswith("?"), part.removesuffix("?")
        if part in ("^", "$", ","):
            element = (part, frozenset(), 0, False)
        elif part.startswith("~"):
            element = ("~", frozenset(), int(part[1:] or _GAP), False)
        else:
            refused, bears = part.startswith("!"), "*" in part
            words: set[str] = set()
            for one in part.lstrip("!").replace("*", "").split("|"):
                words |= classes[one[1:-1]] if one[1:-1] in classes and one[0] == "<" else {one}
            element = ("!" if refused else "word", frozenset(words), 0, bears)
        choices.append([(element,), ()] if optional else [(element,)])
    return [tuple(element for part in each for element in part) for each in product(*choices)]


def understand(words: Sequence[str], grammar: Grammar) -> list[Occasion]:
    """Find what the ``words`` of a text, with their punctuation, call for; occasions do not overlap and are in order."""
    read = tokens(words, grammar)
    found = []
    for start in range(len(read)):
        found += _matches(read, start, grammar)
    found.sort(key=lambda one: (-one[0], one[1]))
    taken: set[int] = set()
    kept = []
    for _, _, frame, places, bearer, score in found:
        if not taken.isdisjoint(places):
            continue
        taken |= set(places)
        if frame.schema != SILENT and not _negated(read, places, frame.schema, grammar):
            schema = frame.schema
            if schema == "count":
                schema = next(name for word, name in grammar.data["counts"].items() if word in read[bearer].forms)
            kept.append(Occasion(read[bearer].word, schema, read[places[0]].word, read[places[-1]].word, score))
    return sorted(kept)


def tokens(words: Sequence[str], grammar: Grammar) -> list[Token]:
    """Split words into tokens (a contraction is two) with their lemmas and what these may mean."""
    raw: list[tuple] = []
    split = grammar.data["contractions"]
    for number, word in enumerate(words):
        bare = word.lower().replace("’", "'").rstrip("\"')]”")
        ends, pauses = "".join(one for one in bare[-2:] if one in _STOPS), bare[-1:] in _PAUSES and bool(bare)
        text = bare.strip(_STOPS + _PAUSES + "\"'()[]“”„«»¡¿-‘")
        if not text:
            if raw and bare:
                raw[-1] = (*raw[-1][:2], raw[-1][2] or pauses or bare == "-", raw[-1][3] or ends)
            continue
        ending = next((tail for tail in split if tail != text and tail[0] in "n'" and text.endswith(tail)), None)
        parts = split[text].split() if text in split else [text[: -len(ending)], split[ending]] if ending else [text]
        head, _, rest = text.partition("'")
        if rest and head in grammar.data.get("elided", ()):  # l'eau
            parts = [grammar.data["elided"][head], rest]
        raw += [(number, part, pauses and part is parts[-1], ends if part is parts[-1] else "") for part in parts]
    lemmas = [_forms(text, grammar) for _, text, *_ in raw]
    marks, mark = [], "?"  # what is not marked may be a question
    for *_, ends in reversed(raw):
        mark = ends or mark
        marks.append(mark)
    result = []
    for place, (number, text, pauses, ends) in enumerate(raw):
        start = place == 0 or raw[place - 1][3]
        before = "" if start else raw[place - 1][1]
        after = "" if ends or pauses or place + 1 == len(raw) else raw[place + 1][1]
        tags = _tags(text, lemmas[place], before, after, grammar)
        forms = {text, *lemmas[place], *(f"@{schema}" for schema in tags), "<any>"}
        if text not in grammar.classes["fun"]:
            forms.add("<other>")
        if text in grammar.data["counts"]:
            forms.add("#")
        ending = text[-1] == "s" and text[-2:] not in ("ss", "us", "is", "'s") and len(text) > _LEAST_STEM
        unfit = grammar.classes["unit"] | grammar.classes["fun"]
        if (ending or text in grammar.data["plurals"]) and text not in unfit:
            forms.add("PL")
        result.append(Token(number, frozenset(forms), tags, start, pauses, bool(ends), "?" in marks[-1 - place]))
    return result


def _forms(text: str, grammar: Grammar) -> list[str]:
    """Return the lemmas that a word may be a form of, itself first."""
    found = [text]
    if text in grammar.irregular:
        found.append(grammar.irregular[text])
    for ending, other in grammar.data["endings"]:
        found += [one for one in _stems(text, ending, other, grammar) if one in grammar.known and one not in found]
    for ending, other in grammar.data["comparing"]:
        for one in _stems(text, ending, other, grammar):
            if any(pos in "ar" for _, pos, _ in grammar.lemmas.get(one, ())) and one not in found:
                found.append(one)
    return found


def _stems(text: str, ending: str, other: str, grammar: Grammar) -> list[str]:
    """Return what a word may be without an ending; a doubled consonant before it may be single."""
    if not text.endswith(ending) or len(text) - len(ending) < _LEAST_STEM:
        return []
    stem = text[: -len(ending)]
    doubled = grammar.data.get("doubled") and stem[-1] == stem[-2] and not other
    return [stem + other, stem[:-1]] if doubled else [stem + other]


def _tags(text: str, lemmas: Sequence[str], before: str, after: str, grammar: Grammar) -> dict[str, int]:
    """Return the schemas that a word may call for here, with tenths, by its neighbours' parts of speech."""
    classes, free, tags = grammar.classes, grammar.data.get("free"), {}
    for lemma in lemmas:
        for schema, pos, tenths in grammar.lemmas.get(lemma, ()):
            determined = before in classes["det"]
            if pos == "v":
                agent = lemma != text or not before or before in classes["modal"] | classes["pro"]
                fits = agent and not determined and before not in classes["prep"] - {"to"}
                if text[-1] == "s" and lemma != text:  # of the third person, rather than a plural
                    fits = fits and (before in classes["pro"] or before not in classes["fun"]) and bool(before) and bool(after)
            elif pos == "n":
                fits = lemma == text or text.endswith("s")
                fits = fits and bool(before) and before not in classes["pro"] and (not after or after in classes["fun"])
            elif pos == "a":
                noun = bool(after) and after not in classes["fun"]
                fits = noun or before in classes["be"] or not (before or after)
            else:
                fits = lemma == text and before not in classes["pro"]
            fits |= bool(free) and not (pos == "v" and before in classes["det"])
            passive = pos == "v" and before in classes["passive"] and text[-3:] != "ing"
            if fits:
                tenths = max(tenths - _PASSIVE * passive, 1)
                tags[schema] = max(tags.get(schema, 0), tenths)
    return tags


def _matches(tokens: Sequence[Token], start: int, grammar: Grammar) -> list[tuple]:
    """Return the frames that match from a token on: how many words they fix, order, frame, places, bearer, score."""
    found = []
    for form in tokens[start].forms:
        for frame in grammar.frames.get(form, ()):
            places = _match(tokens, frame.elements, 0, start)
            if places is None:
                continue
            fixed = [element for element in frame.elements if element[0] == "word"]
            marked = [place for place, element in zip(places, fixed, strict=True) if element[3]]
            bearer = marked[0] if marked else places[-1]
            sure = [_certainty(tokens[place], element[1]) for place, element in zip(places, fixed, strict=True)]
            alone = len(fixed) == 1 and any(one.startswith("@") for one in fixed[0][1])
            if min(sure) < (grammar.data["lone"]["least"] if alone else _LEAST_IN_FRAME):
                continue
            if frame.schema in grammar.data["asked"] and not tokens[start].asked:
                continue
            weak = all("<any>" in element[1] for element in fixed[1:])
            score = 0.06 * min(sure) if alone else min(0.7 + 0.1 * len(fixed), 1) - 0.2 * (weak and not alone)
            score = round(score, 2)
            found.append((len(fixed) + 0.5 * ("^" in frame.elements[0]), frame.order, frame, places, bearer, score))
    return found


def _certainty(token: Token, wanted: frozenset) -> int:
    """Return the tenths of its uses in which the word means what a frame wants; 10 for a word of the frame itself."""
    if any(not one.startswith("@") and one in token.forms for one in wanted):
        return 10
    return max(token.tags.get(one[1:], 0) for one in wanted)


def _match(tokens: Sequence[Token], elements: tuple, at: int, place: int) -> tuple[int, ...] | None:
    """Return the places of the words that a frame fixes, from its element ``at`` and a token on; None where it does not fit."""
    if at == len(elements):
        return ()
    kind, words, most, _ = elements[at]
    last = place > 0 and tokens[place - 1].ends
    if kind == "^":
        fits = place < len(tokens) and tokens[place].starts
    elif kind == "$":
        fits = place == len(tokens) or last
    elif kind == ",":
        fits = place == len(tokens) or (place > 0 and (tokens[place - 1].pauses or last))
    elif kind == "!":
        fits = place == len(tokens) or last or words.isdisjoint(tokens[place].forms)
    elif kind == "~":
        for skipped in range(most + 1):
            rest = _match(tokens, elements, at + 1, place + skipped)
            if rest is not None:
                return rest
            if place + skipped >= len(tokens) or tokens[place + skipped].ends:
                return None
        return None
    else:
        begins = all(element[0] != "word" for element in elements[:at])
        last |= place > 0 and tokens[place - 1].pauses and elements[at - 1][0] == "word"
        if place >= len(tokens) or (last and not begins) or words.isdisjoint(tokens[place].forms):
            return None
        rest = _match(tokens, elements, at + 1, place + 1)
        return None if rest is None else (place, *rest)
    return _match(tokens, elements, at + 1, place) if fits else None


def _negated(tokens: Sequence[Token], places: Sequence[int], schema: str, grammar: Grammar) -> bool:
    """Return whether a negation that the frame does not hold itself reaches its words."""
    if schema in grammar.data["unscoped"]:
        return False
    for place in range(places[0] - 1, max(places[0] - 1 - grammar.data["scope"], -1), -1):
        if tokens[place].ends or tokens[place].pauses:
            return False
        if not tokens[place].forms.isdisjoint(grammar.data["negators"]):
            return True
    return False
