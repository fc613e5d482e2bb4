"""How a voice acts a mood, beside the speaker's own neutral, and which moods the sentences of a talk are acted in.

Measured on people who act five emotions: their register, tilt and rate beside their own neutral reading (the table below);
low arousal is slower, high arousal is not faster. Moods are valence, arousal, dominance as ranks 0..1, neutral 0.5.
"""

from dataclasses import dataclass

import numpy as np

NEUTRAL = 0.5
KINDS = ("plain", "talk", "paragraph", "sentence")
"""Ways to act a talk: near neutral; in one mood; in moods that change every two to four sentences, or with each sentence."""
_SHARES = (0.42, 0.3, 0.16, 0.12)

MOODS = {
    "anger": (0.1, 0.95, 0.9),
    "joy": (0.95, 0.9, 0.65),
    "fear": (0.12, 0.85, 0.1),
    "boredom": (0.4, 0.1, 0.5),
    "sadness": (0.1, 0.12, 0.1),
}
"""Valence, arousal and dominance of the emotions of :data:`SHIFTS` as ranks, where studies of emotion place them."""
SHIFTS = {
    "anger": (9.3, 10.0, -2.2, -0.1, 0.9, 1.4),
    "joy": (8.7, 7.0, -0.6, 0.0, 2.6, 1.2),
    "fear": (6.4, 3.5, -0.3, 0.2, 0.5, 0.9),
    "boredom": (-0.3, -0.4, 2.7, -0.8, -0.5, 0.0),
    "sadness": (-1.6, -3.3, 0.6, -0.7, -0.5, 0.0),
}
"""What people change: pitch (semitones), tilt (dB), harmonicity (dB), syllables a second, range and formants (semitones)."""


@dataclass(frozen=True)
class Shift:
    """What acting changes beside the speaker's own neutral, in the units of :data:`SHIFTS`."""

    pitch: float
    tilt: float
    harmonicity: float
    rate: float
    range: float
    formants: float


def shift(affect: np.ndarray) -> Shift:
    """Return the change for valence, arousal, dominance (ranks); zero at neutral, :data:`SHIFTS` at :data:`MOODS`.

    It grows in proportion to the arousal over neutral, by an amount that depends on valence and dominance, and under neutral
    by one that depends on submission.
    """
    basis, limits = _basis(np.asarray(affect, float)), np.array(list(SHIFTS.values()))
    values = np.clip(basis @ _WEIGHTS, limits.min(0) * 1.15 - 0.1, limits.max(0) * 1.15 + 0.1)
    return Shift(*map(float, values))


def _basis(affect: np.ndarray) -> np.ndarray:
    valence, arousal, dominance = 2 * (affect - NEUTRAL)
    high, low = max(arousal, 0.0), max(-arousal, 0.0)
    return np.array([high, high * valence, high * dominance, low, low * min(dominance, 0.0)])


_WEIGHTS = np.linalg.solve(
    np.array([_basis(np.array(mood)) for mood in MOODS.values()]), np.array([SHIFTS[name] for name in MOODS])
)


def draw_kind(random: np.random.Generator) -> str:
    """Draw the way to act a talk; two of five stay near neutral."""
    return str(random.choice(KINDS, p=_SHARES))


def act(texts: np.ndarray, kind: str, random: np.random.Generator, mood: str = "") -> np.ndarray:
    """Draw what is acted in each sentence of a talk ``(s, 3)``, given what its ``texts`` ``(s, 3)`` express.

    ``kind`` is one of :data:`KINDS`; ``mood`` names the mood of a whole talk, "" draws one.
    """
    count = len(texts)
    if kind == "plain":
        level = random.normal(0, 0.04, 3)
        return np.clip(NEUTRAL + level + random.normal(0, 0.04, (count, 3)), 0, 1)
    rows, spread = [], 0.04
    while len(rows) < count:
        lengths = {"talk": count, "sentence": 1, "paragraph": int(random.integers(2, 5))}
        part = texts[len(rows) : len(rows) + lengths[kind]]
        middle = draw_mood(part.mean(axis=0), random, mood if kind == "talk" else "", neutral=kind != "talk")
        rows += list(middle + random.normal(0, spread, (len(part), 3)))
    return np.clip(np.array(rows), 0, 1)


def draw_mood(text: np.ndarray, random: np.random.Generator, name: str = "", neutral: bool = False) -> np.ndarray:
    """Draw a mood ``(3,)``: near one of :data:`MOODS`, ``name`` or the one of three that suits the ``text`` best, somewhat
    weaker or not; ``neutral`` allows none in a quarter of the draws; a fifth lies anywhere."""
    if neutral and random.random() < 0.25:
        return NEUTRAL + random.normal(0, 0.05, 3)
    if not name and random.random() < 0.2:
        return random.uniform(0, 1, 3)
    # speech is often at odds with its words, as in people: a third of the moods is drawn without them
    choices = [name] if name else list(random.choice(list(MOODS), 1 if random.random() < 0.35 else 3, replace=False))
    place = min((np.array(MOODS[choice]) for choice in choices), key=lambda mood: float(np.square(mood - text).sum()))
    return NEUTRAL + random.uniform(0.65, 1.1) * (place - NEUTRAL) + random.normal(0, 0.05, 3)
