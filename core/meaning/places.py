"""Remembers places within a talk: what was shown on one side is shown there again, and the other thing on the other side."""

import zlib
from collections.abc import Mapping, Sequence

from . import sentence
from .document import SIDES, Wanted
from .sentence import Token

_PLACING = ("contrast", "there", "left", "right")
_PAIR, _AGAIN, _CLAUSE = 40, 12, 6
"""Words within which one side needs its other, after which a thing is shown in its place again, and of a clause at most."""
_SURE = 0.6
"""How surely a thing that comes again is shown in its place."""


def remember(found: Mapping[int, Wanted], texts: Sequence[str], grammar: sentence.Grammar, forms: Mapping) -> dict[int, Wanted]:
    """Return what is ``found`` in a talk with sides: of contrasts, and of what is said of things that have a place.

    ``forms`` are the vocabulary's: gestures that need both hands have no side. Things that come again are found, too."""
    if not any(wanted.schema in _PLACING for wanted in found.values()):
        return dict(found)
    free = {name for name, each in forms.items() if all(form.arms != "both" and not form.side for form in each)}
    tokens = sentence.tokens(texts, grammar)
    result, marks = _pairs(found, tokens, {name: set(listed.split()) for name, listed in grammar.data["sides"].items()})
    spoken = {at for number, one in result.items() for at in range(number - one.before, number - one.before + one.count)}
    first = -1.0 if zlib.crc32(texts[min(found)].encode()) % 2 else 1.0
    last, places, shown = -first, dict[str, float](), dict[str, int]()
    for at, token in enumerate(tokens):
        wanted, own = result.get(token.word), _lemmas(token)
        if wanted is None:
            again = next((name for name in own if places.get(name) and at - shown[name] > _AGAIN), None)
            if again and at and token.word not in spoken and tokens[at - 1].forms & grammar.classes["det"]:
                result[token.word] = Wanted("contrast", 1, _SURE, places[again])
        elif wanted.side is None and wanted.schema in free:
            after, before = _clause(tokens, at)
            near = (name for one in (*after, *before[::-1]) for name in _lemmas(one))
            side = next((places[name] for name in near if places.get(name)), None)
            if wanted.schema == "contrast" and (side is None or marks[token.word]):
                side = {"one": first, "other": -first}.get(marks[token.word], -last)
            side = first if wanted.schema == "there" and side is None else side
            result[token.word] = wanted = wanted._replace(side=side)
        shown |= dict.fromkeys(own & places.keys(), at)
        if wanted is not None and wanted.schema in _PLACING and (side := SIDES.get(wanted.schema, wanted.side)):
            last = side
            for name in _things(tokens, at, grammar):
                places[name] = side if places.get(name, side) == side else 0.0  # on both sides: it has no place
                shown[name] = at
    return result


def _pairs(found: Mapping[int, Wanted], tokens: Sequence[Token], words: Mapping) -> tuple[dict[int, Wanted], dict]:
    """Return what is found, with "some" of "some ..., but others" on its own and without "this one" that has no other, and
    which side the words of each contrast name: "one", "other" or None."""
    result, marks, unpaired = dict(found), dict[int, str | None](), dict[int, bool]()
    forms = dict[int, frozenset]()
    for token in tokens:
        forms[token.word] = forms.get(token.word, frozenset()) | token.forms
    for number, wanted in found.items():
        if wanted.schema == "contrast" and wanted.before > 3 and forms[number - wanted.before] & words["one"]:
            result |= {at: wanted._replace(count=1, before=0) for at in (number - wanted.before, number)}
    for number, wanted in result.items():
        if wanted.schema == "contrast":
            said = frozenset().union(*(forms.get(at, ()) for at in range(number - min(wanted.before, 2), number + 1)))
            marks[number] = next((name for name in ("other", "one") if said & words[name]), None)
            unpaired[number] = marks[number] == "one" or bool(said & words["paired"])
    for number in [at for at, alone in unpaired.items() if alone]:
        way = 1 if marks[number] == "one" else -1
        if not any(0 < way * (at - number) < _PAIR and mark not in (None, marks[number]) for at, mark in marks.items()):
            del result[number]
    return result, marks


def _lemmas(token: Token) -> set[str]:
    return {form for form in token.forms if form[0].isalpha() and form.islower()}


def _clause(tokens: Sequence[Token], at: int) -> tuple[Sequence[Token], Sequence[Token]]:
    """Return the words of a clause from one on, and those before it."""
    stop = [token.pauses or token.ends for token in tokens[max(at - _CLAUSE, 0) : at + _CLAUSE]]
    begin = at - min(at, _CLAUSE)
    after = next((k for k in range(at - begin, len(stop)) if stop[k]), len(stop) - 1)
    before = next((k for k in range(at - begin - 1, -1, -1) if stop[k]), -1)
    return tokens[at : begin + after + 1], tokens[begin + before + 1 : at]


def _things(tokens: Sequence[Token], at: int, grammar: sentence.Grammar) -> set[str]:
    """Return the things that the clause of a placing gesture is about: they have an article, or are many."""
    small = grammar.classes["fun"] | grammar.classes.get("unit", frozenset())
    after, before = _clause(tokens, at)
    for part in after[1:], before:
        found, led = set[str](), False
        for token, following in zip(part, [*part[1:], None], strict=False):
            plain = not token.forms & small
            if plain and (led or "PL" in token.forms) and (following is None or following.forms & small):
                found |= _lemmas(token)
            led = (led and plain) or bool(token.forms & grammar.classes["det"])
        if found:
            return found
    return set()
