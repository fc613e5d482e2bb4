"""Phrases of several words that have a gesture meaning of their own."""

from collections.abc import Sequence

PHRASES = {
    "unknown": "i don't know*|i do not know*|don't know*|do not know*|didn't know*|no idea*|not sure*|who knows*|who cares*|"
    "no clue*|can't say*|cannot say*|hard to say*|i wonder*|wonder why*|god knows*|beats me*|what can i do*|"
    "nobody knows*|no one knows*|you never know*|doesn't matter*|does not matter*|never mind*",
    "not": "no no*|not at all*|no way*|of course not*|certainly not*|absolutely not*|not true*|not yet*|never again*|"
    "will not*|do not*|is not*|was not*|can not*|must not*|no more*|no longer*|never ever*|under no*",
    "none": "no one*|not one*|none of it*|nothing at all*|not a thing*|not a word*|all gone*",
    "big": "this big*|that big*|so big*|very big*|so much*|so many*|a lot*|lots of*|great deal*|huge amount*|so large*|"
    "as big as*",
    "small": "a little*|a bit*|a few*|tiny bit*|this small*|so small*|very small*|a touch*|little by little*|"
    "a single*|only one*",
    "count": "first of all*|number one*|number two*|the first*|the second*|the third*|one two*|two things*|three things*|"
    "step by step*|one by one*|one after another*|and finally*|last of all*",
    "however": "on the other* hand|on one* hand|but then*|even though*|and yet*|in spite* of|rather than*|instead of*|"
    "more or less*|either or*|back and forth*",
    "all": "all of us*|all of them*|all of it*|all over*|all the time*|the whole*|every one*|each and every*|whole world*|"
    "everything else*|from top* to bottom|all around*",
    "we": "you and i*|you and me*|both of us*|each other*|one another*|two of us*|let us*",
    "me": "as for me*|if you ask me*|to me*|for my part*|in my opinion*|i myself*|my own*",
    "you": "as for you*|thank you*|i tell you*|listen to me*|if you like*|all of you*|you too*|look at you*",
    "here": "right here*|over here*|right now*|in here*|at this moment*|come here*|here and now*",
    "there": "over there*|up there*|down there*|out there*|far away*|a long way*|long ago*|go away*|go there*",
    "think": "i think*|i believe*|i suppose*|let me see*|let me think*|i remember*|to my mind*|come to think*|it seems*",
    "example": "for example*|for instance*|such as*|let's say*|imagine that*",
    "stop": "that's enough*|hold on*|wait a minute*|that will do*|no further*|not so fast*",
    "question": "why not*|what if*|how come*|what for*|who says*|how much*|how many*",
}
"""Meaning -> phrases in lower case, separated by bars; a star marks the word on which the gesture falls."""


def _compile() -> dict[str, list[tuple[tuple[str, ...], int, str]]]:
    table: dict[str, list[tuple[tuple[str, ...], int, str]]] = {}
    for meaning, phrases in PHRASES.items():
        for phrase in phrases.split("|"):
            words = phrase.split()
            bearer = next(k for k, word in enumerate(words) if word.endswith("*"))
            plain = tuple(word.rstrip("*") for word in words)
            table.setdefault(plain[0], []).append((plain, bearer, meaning))
    for options in table.values():
        options.sort(key=lambda option: -len(option[0]))
    return table


_TABLE = _compile()


def find_phrases(words: Sequence[str], breaks: Sequence[bool] = ()) -> dict[int, tuple[str, range]]:
    """Find phrases: index of the word on which the gesture falls -> meaning and the indices of the phrase's words.

    ``words`` in lower case without punctuation; ``breaks[k]``: the sentence ends after word ``k``. Longer phrases win, and
    phrases do not overlap.
    """
    meanings, at = {}, 0
    while at < len(words):
        for phrase, bearer, meaning in _TABLE.get(words[at], ()):
            span = range(at, at + len(phrase))
            broken = any(breaks[k] for k in span[:-1] if k < len(breaks))
            if tuple(words[at : at + len(phrase)]) == phrase and not broken:
                meanings[at + bearer] = (meaning, span)
                at = span[-1]
                break
        at += 1
    return meanings
