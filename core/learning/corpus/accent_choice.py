"""Chooses the accents that may get a gesture of the library, in chains with pauses, and the gestures' meanings.

:mod:`directing` performs those of them that are far enough apart; on the other accents land movements of captured talk.
"""

import numpy as np

from ...sound.prosody import Accent
from . import phrases
from .lexicon import Lexicon
from .repertoire import BEAT, Repertoire
from .scene import Scene
from .speakers import Performer

_MIN_TIME = 1.0
"""Seconds before which no stroke lands: it has to be prepared."""
_SOFTNESS = 0.06
"""Width of the logistic step between accents without and with a stroke."""
_PHRASE_DEVIATION = 0.24
"""Standard deviation of a phrase's threshold: takes differ in the phrases with strokes."""
_CHAIN_DISCOUNT = 0.14
"""Reduction of the threshold within a chain."""
_ACCENT_DEVIATION = 0.18
"""Standard deviation of an accent's score: takes differ in the accents with strokes."""
_MEANING_BONUS = 0.7
"""Added to the score of an accent whose word has a meaning: such words go before beats."""
_AUDIBLE = 0.08
"""Strength of an accent under which its word's meaning counts nothing."""
_MAIN_BONUS, _OUTDONE = 0.15, 0.05
"""Added to the score of a phrase's main accent, and how much higher a score soon after an accent takes the stroke from it."""
_AROUSAL, _RATE, _FIRM = 0.16, 0.2, 0.06
"""How much arousal, from calm to aroused, and gesture rate lower the threshold, and dominance raises and valence lowers it."""
_CHAIN_GAP, _CHAIN_BREAK, _SHORTEST_GAP = 0.68, 3.0, 0.42
"""The shortest time between strokes within a chain, as a factor; seconds without a stroke that end it; the shortest gap (s)."""
_PAUSE_THRESHOLD, _PAUSE_GAPS = 0.25, 2.0
"""What a pause after a chain adds to the threshold, and its mean length in gaps between strokes."""
_PHRASE_CHANCE = 0.75
"""Chance, in addition to the performer's own, that a phrase's meaning is shown."""
_UNSAID_SHARE = 0.6
"""Share of the other strokes with a random meaning, so that the network learns the gestures apart from their words."""


def draw_meanings(lexicon: Lexicon, repertoire: Repertoire, scene: Scene, random: np.random.Generator) -> dict[int, str]:
    """Draw the meanings that a performer shows, by index of the word; phrases go before words."""
    showable, words = repertoire.meanings(), scene.speech.words
    texts = [word.text.lower() for word in words]
    semantic, result, phrase_words = repertoire.performer.semantic, {}, set()
    for bearer, (meaning, span) in phrases.find_phrases(texts, [bool(word.closing) for word in words]).items():
        phrase_words.update(span)
        if meaning in showable and random.random() < semantic + (1 - semantic) * _PHRASE_CHANCE:
            result[bearer] = meaning
    for number, text in enumerate(texts):
        meaning = None if number in phrase_words else lexicon.meaning(text)
        if meaning in showable and random.random() < (0.4 * semantic if text in _FREQUENT else 0.3 + 0.65 * semantic):
            result[number] = meaning
    return result


def draw_accents(performer: Performer, scene: Scene, shown: dict[int, str], random: np.random.Generator) -> list[Accent]:
    """Draw the accents that get a stroke, in order of time.

    Strokes come in chains: within one the next accent gets a stroke sooner, even if weaker; after it the hands pause,
    unless an accent is strong or has a meaning.
    """
    chosen: list[Accent] = []
    last, left, pause_end = -9.0, _chain_length(performer, random), 0.0
    scores = np.array([_score(accent, shown, random) for accent in scene.accents])
    times = np.array([accent.time for accent in scene.accents])
    offsets = random.normal(0, _PHRASE_DEVIATION, 1 + max((accent.phrase for accent in scene.accents), default=0))
    for number, accent in enumerate(scene.accents):
        lively = scene.arousal(accent) - 0.5
        chained = left > 0 and bool(chosen) and accent.time - last < _CHAIN_BREAK
        gap = performer.gap * (_CHAIN_GAP if chained else 1.0) * (1 - 0.5 * lively) * (1 - 0.4 * scene.rate)
        gap = max(gap * float(np.exp(random.normal(0, 0.15))), _SHORTEST_GAP)
        threshold = performer.threshold - _AROUSAL * lively - _RATE * scene.rate - (_CHAIN_DISCOUNT if chained else 0.0)
        threshold += offsets[accent.phrase]
        threshold += _FIRM * scene.dominance - _FIRM * scene.valence
        if accent.time < pause_end:
            threshold += _PAUSE_THRESHOLD
        near = (times > accent.time) & (times < accent.time + 0.75 * gap)
        outdone = scores[near].max(initial=0.0) > scores[number] + _OUTDONE
        drawn = random.random() < 1 / (1 + np.exp(-(scores[number] - threshold) / _SOFTNESS))
        if accent.time <= _MIN_TIME or accent.time - last < gap or outdone or not drawn:
            continue
        chosen.append(accent)
        last, left = accent.time, left - 1
        if left <= 0:
            left = _chain_length(performer, random)
            pause = float(random.exponential(_PAUSE_GAPS * performer.gap))
            pause_end = last + pause * (1 - 0.5 * scene.rate) * (1 - 0.4 * lively)
    return chosen


def draw_meaning(
    accent: Accent, shown: dict[int, str], repertoire: Repertoire, random: np.random.Generator
) -> tuple[str, bool]:
    """Return a stroke's meaning and whether it comes from the words; some strokes get a random meaning."""
    if accent.word in shown:
        return shown[accent.word], True
    if random.random() < _UNSAID_SHARE:
        return str(random.choice(sorted(repertoire.meanings() - {BEAT}))), False
    return BEAT, True


def _score(accent: Accent, shown: dict[int, str], random: np.random.Generator) -> float:
    bonus = _MEANING_BONUS if accent.word in shown and accent.strength > _AUDIBLE else 0
    return accent.strength + _MAIN_BONUS * accent.main + bonus + float(random.normal(0, _ACCENT_DEVIATION))


def _chain_length(performer: Performer, random: np.random.Generator) -> int:
    return int(random.geometric(1 / performer.chain))


_FREQUENT_WORDS = "i me my you your we us our it what how who now this these one get would could right"
_FREQUENT = frozenset(_FREQUENT_WORDS.split())
"""Words so frequent that they mostly get no gesture of their meaning."""
