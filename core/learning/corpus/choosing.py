"""Which accents get a stroke, and what it means: chains of strokes with pauses, some accents unanswered."""

import numpy as np

from ...sound.prosody import Accent
from . import phrases
from .lexicon import Lexicon
from .repertoire import BEAT, Repertoire
from .scene import Scene
from .speakers import Performer

_FIRST = 1.0
"""Seconds before which no stroke lands: the recording begins with the hands at rest."""
_SOFT = 0.06
"""Width of the step from accents that are never answered to those that always are."""
_MOOD = 0.24
"""Standard deviation of how much a phrase moves somebody to gesture: one take answers another phrase than the next."""
_IN_CHAIN = 0.14
"""How much weaker an accent may be that goes on with a chain."""
_WHIM = 0.18
"""Standard deviation of how much one accent, rather than its neighbours, calls for a stroke this time."""
_MEANT = 0.7
"""How much a meaning adds to an accent's strength: what can be shown goes before beats."""
_STATED = 0.75
"""Chance, beyond the performer's own readiness, that a phrase of a meaning is shown."""
_UNSAID = 0.1
"""Share of the other strokes that show a meaning which is not in the words: what a gesture looks like, apart from its words."""


def meanings(lexicon: Lexicon, repertoire: Repertoire, scene: Scene, random: np.random.Generator) -> dict[int, str]:
    """What this performer shows for words of a talk, by number of the word; phrases go before words."""
    known, words = repertoire.meanings(), scene.speech.words
    texts = [word.text.lower() for word in words]
    semantic, result, taken = repertoire.performer.semantic, {}, set()
    for bearer, (meaning, span) in phrases.find(texts, [bool(word.closing) for word in words]).items():
        taken.update(span)
        if meaning in known and random.random() < semantic + (1 - semantic) * _STATED:
            result[bearer] = meaning
    for number, text in enumerate(texts):
        meaning = None if number in taken else lexicon.meaning(text)
        if meaning in known and random.random() < (0.4 * semantic if text in _FREQUENT else 0.3 + 0.65 * semantic):
            result[number] = meaning
    return result


def accents(performer: Performer, scene: Scene, shown: dict[int, str], random: np.random.Generator) -> list[Accent]:
    """Accents that get a stroke, in order of time.

    Strokes come in chains: within one the next accent is answered sooner, even if weaker; after it the hands pause,
    unless something strong or meant calls them.
    """
    taken: list[Accent] = []
    last, left, until = -9.0, _length(performer, random), 0.0
    scores = np.array([_score(accent, shown, random) for accent in scene.accents])
    times = np.array([accent.time for accent in scene.accents])
    mood = random.normal(0, _MOOD, 1 + max((accent.phrase for accent in scene.accents), default=0))
    for number, accent in enumerate(scene.accents):
        lively = scene.arousal(accent) - 0.5
        chained = left > 0 and bool(taken) and accent.time - last < 3.0
        gap = performer.gap * (0.68 if chained else 1.0) * (1 - 0.5 * lively) * (1 - 0.4 * scene.rate)
        gap = max(gap * float(np.exp(random.normal(0, 0.15))), 0.42)
        need = performer.threshold - 0.16 * lively - 0.2 * scene.rate - (_IN_CHAIN if chained else 0.0) + mood[accent.phrase]
        need += 0.06 * scene.dominance - 0.06 * scene.valence
        if accent.time < until:
            need += 0.25
        near = (times > accent.time) & (times < accent.time + 0.75 * gap)
        outdone = scores[near].max(initial=0.0) > scores[number] + 0.05
        answered = random.random() < 1 / (1 + np.exp(-(scores[number] - need) / _SOFT))
        if accent.time <= _FIRST or accent.time - last < gap or outdone or not answered:
            continue
        taken.append(accent)
        last, left = accent.time, left - 1
        if left <= 0:
            left = _length(performer, random)
            until = last + float(random.exponential(_pause(performer))) * (1 - 0.5 * scene.rate) * (1 - 0.4 * lively)
    return taken


def meaning(accent: Accent, shown: dict[int, str], repertoire: Repertoire, random: np.random.Generator) -> tuple[str, bool]:
    """What a stroke on an accent means, and whether the words say so: now and then any meaning is shown without them."""
    if accent.word in shown:
        return shown[accent.word], True
    if random.random() < _UNSAID:
        return str(random.choice(sorted(repertoire.meanings() - {BEAT}))), False
    return BEAT, True


def _score(accent: Accent, shown: dict[int, str], random: np.random.Generator) -> float:
    meant = accent.word in shown and accent.strength > 0.08
    return accent.strength + 0.15 * accent.main + (_MEANT if meant else 0) + float(random.normal(0, _WHIM))


def _length(performer: Performer, random: np.random.Generator) -> int:
    return int(random.geometric(1 / performer.chain))


def _pause(performer: Performer) -> float:
    """Seconds that the hands pause after a chain, on average."""
    return 2.0 * performer.gap


_OFTEN = "i me my you your we us our it what how who now this these one get would could right"
_FREQUENT = frozenset(_OFTEN.split())
"""Words so frequent that they are mostly said without their gesture."""
