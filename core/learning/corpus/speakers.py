"""Invented performers as data: clip sets, gesture rate, size and height, hand, posture and rest."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Performer:
    """A performer's tastes, which weigh the director's random draws. Angles in degrees, times in seconds.

    Of talk (:mod:`manner` derives more from these) and of gestures of the library alike: ``hand``, "left", "right" or "both",
    the usual one; ``both``: share of two-handed strokes; ``gap``: shortest time between strokes; ``size`` scales movements;
    ``height``: hands "low", "mid" or "high"; ``tempo`` scales speed; ``plane``: how far strokes are rotated, hands apart.
    Of talk alone: ``rest``, where the hands go home, "sides" or "front" (before the belly); ``linger``: how far they stay away
    from home in pauses.
    Of gestures alone: ``families``, clip sets, the preferred one first; ``threshold``: accent strength at which half of the
    accents get a stroke; ``semantic``: how readily a word's meaning is shown (0 seldom, 1 always); ``hold`` stretches holds;
    ``apart``: how often the arms of a two-handed stroke follow different clips; ``chain``: mean number of strokes in a row.
    Of posture: ``lean`` forward, ``shoulders`` up, ``chin`` up; of the head: ``nod`` on an accent, ``drift`` and ``tilt``.
    """

    name: str
    description: str
    families: tuple[str, ...]
    hand: str
    gap: float
    threshold: float
    semantic: float
    size: float
    height: str
    tempo: float
    hold: float
    rest: str
    lean: float
    shoulders: float
    chin: float
    nod: float
    drift: float
    tilt: float
    both: float
    plane: float
    apart: float
    chain: float
    linger: float

    def with_hand(self, preference: float) -> "Performer":
        """Return this performer with a hand preference from -1 (left) to 1 (right); small values change nothing."""
        if abs(preference) < _MIN_PREFERENCE:
            return self
        return replace(self, hand="left" if preference < 0 else "right", both=self.both * (1 - abs(preference)))


_MIN_PREFERENCE = 0.25
_BRAD, _BRAD2, _WOMAN, _MAN, _NEURON = "Gestures", "Gestures2", "FemaleGestures", "MaleGestures", "PNGestures"

PERFORMERS = (
    Performer(
        "calm lecturer", "Measured strokes at waist height led by the right hand, long holds, still head.",
        (_BRAD2, _BRAD), "right", 1.85, 0.57, 0.6, 0.95, "mid", 0.85, 1.5, "sides", 0, 0, 0, 3.0, 2.5, 1.0,
        0.48, 1, 0.24, 2.5, 0.82,
    ),
    Performer(
        "eager storyteller", "Large, ever different gestures of both hands at chest height, chained, with a lively head.",
        (_NEURON, _WOMAN, _BRAD2), "both", 1.05, 0.45, 0.95, 1.02, "high", 1.05, 0.9, "sides", 4, 1, 1, 5.5, 5.0, 3.0,
        0.78, 1.2, 0.42, 6, 0.71,
    ),
    Performer(
        "stern", "Few, quick and firm strokes of the right hand, upright, chin down, hardly any sway.",
        (_MAN, _BRAD), "right", 1.85, 0.61, 0.5, 1, "mid", 1.25, 1.2, "sides", -2, 0, -4, 3.5, 1.2, 0.4,
        0.15, 1.1, 0.28, 2.5, 0.61,
    ),
    Performer(
        "tired", "Small, low and slow movements that sink early, shoulders and head hanging.",
        (_BRAD, _BRAD2), "left", 2.3, 0.61, 0.35, 0.75, "low", 0.72, 0.6, "sides", 6, -2, -7, 2.0, 2.0, 2.0,
        0.56, 1.2, 0.24, 2, 0.82,
    ),
    Performer(
        "warm host", "Soft, rounded gestures of both hands that return before the body, soft nods and a tilted head.",
        (_BRAD2, _WOMAN), "both", 1.5, 0.53, 0.8, 0.96, "mid", 0.9, 1.2, "front", 2, 0, 1, 4.5, 3.5, 3.5,
        0.78, 1.1, 0.38, 4, 0.87,
    ),
    Performer(
        "nervous", "Quick small strokes close to the body, restless trunk and head, shoulders raised.",
        (_BRAD, _MAN), "both", 0.95, 0.45, 0.4, 0.72, "low", 1.3, 0.5, "front", 3, 4, -2, 3.0, 4.5, 1.5,
        0.65, 1.2, 0.51, 6, 0.82,
    ),
    Performer(
        "left-handed joker", "Loose gestures led by the left hand, wide turns, head tilts.",
        (_BRAD2, _BRAD, _NEURON), "left", 1.45, 0.5, 0.9, 1.05, "mid", 1.1, 0.9, "sides", -1, 0, 2, 4.5, 5.0, 4.0,
        0.48, 1.3, 0.3, 4, 0.71,
    ),
    Performer(
        "grand orator", "Wide and high with both arms, slow to rise, long proud holds, chin up.",
        (_NEURON, _WOMAN, _MAN), "both", 1.85, 0.51, 0.85, 1.1, "high", 0.9, 1.6, "sides", -3, 0, 4, 4.0, 3.0, 1.0,
        0.82, 1.1, 0.34, 3, 0.51,
    ),
    Performer(
        "brisk presenter", "Brisk strokes before the body led by the right hand, often several in a row.",
        (_WOMAN, _MAN), "right", 1, 0.45, 0.6, 0.95, "mid", 1.2, 0.8, "front", 1, 0, 1, 4.0, 2.5, 1.0,
        0.48, 1.1, 0.3, 6, 0.82,
    ),
    Performer(
        "thoughtful explainer", "Shapes ideas between two hands, pauses with the head turned away.",
        (_BRAD, _NEURON, _BRAD2), "both", 1.7, 0.56, 1.0, 0.96, "mid", 0.8, 1.4, "front", 2, 0, -2, 3.0, 5.5, 2.5,
        0.82, 1.1, 0.42, 3, 0.87,
    ),
    Performer(
        "news anchor", "Small, tidy strokes from hands before the waist, upright and composed.",
        (_WOMAN, _BRAD2), "both", 1.55, 0.57, 0.3, 0.75, "low", 1.0, 1.3, "front", -1, 0, 0, 4.5, 1.0, 1.5,
        0.74, 1.1, 0.34, 3.5, 0.9,
    ),
    Performer(
        "street preacher", "Fast, high and hard strokes led by the right hand, hardly a rest, leaning in.",
        (_MAN, _NEURON, _BRAD), "right", 0.9, 0.42, 0.7, 1.12, "high", 1.35, 0.7, "sides", 7, 2, 3, 6.0, 4.0, 1.0,
        0.56, 1.2, 0.3, 8, 0.61,
    ),
    Performer(
        "shy student", "Arms near the body, now and then a small gesture led by the left hand, chin down, head tilted.",
        (_BRAD2, _WOMAN), "left", 2.15, 0.59, 0.5, 0.66, "low", 0.95, 0.6, "front", 1, 3, -6, 2.5, 3.0, 5.0,
        0.52, 1.1, 0.24, 2, 0.82,
    ),
    Performer(
        "sales rep", "Open gestures of both hands, one after the other, leaning to the listener, nodding.",
        (_WOMAN, _NEURON), "both", 1, 0.45, 0.85, 1, "mid", 1.15, 0.8, "sides", 6, 0, 2, 6.5, 3.0, 2.5,
        0.82, 1.1, 0.38, 6, 0.71,
    ),
    Performer(
        "old professor", "Slow explaining movements led by the left hand with long holds, stooped, head leading.",
        (_BRAD, _BRAD2), "left", 2, 0.54, 0.7, 0.95, "mid", 0.7, 1.8, "sides", 8, 1, -3, 3.5, 4.5, 1.5,
        0.52, 1.3, 0.3, 2.5, 0.87,
    ),
    Performer(
        "coach", "Both hands beat at belly height, short and often, leaning in.",
        (_MAN, _BRAD), "both", 1.1, 0.46, 0.4, 1, "low", 1.3, 0.7, "sides", 5, 1, -1, 5.0, 2.0, 0.5,
        0.82, 1.15, 0.34, 7, 0.71,
    ),
    Performer(
        "elegant host", "Light right-hand gestures at chest height and above, head high.",
        (_WOMAN, _BRAD2, _NEURON), "right", 1.65, 0.54, 0.65, 0.98, "high", 0.85, 1.2, "front", -3, -1, 5, 3.0, 3.5, 3.0,
        0.25, 1.2, 0.28, 3.5, 0.77,
    ),
    Performer(
        "skeptic", "Spare low gestures of the right hand, leaning back, head aside.",
        (_BRAD2, _MAN), "right", 2, 0.57, 0.95, 0.9, "low", 0.95, 1.0, "sides", -5, 1, -1, 2.5, 4.0, 5.0,
        0.2, 1.3, 0.28, 2.2, 0.77,
    ),
    Performer(
        "dreamer", "Slow floating movements of both hands, high holds, head up.",
        (_NEURON, _BRAD), "both", 2, 0.52, 0.8, 1, "high", 0.68, 1.8, "sides", -2, 0, 6, 2.0, 6.0, 3.5,
        0.74, 1.3, 0.42, 3.5, 0.71,
    ),
    Performer(
        "deadpan", "Hardly a gesture: low, idle hands, a rare small movement led by the right one, still trunk.",
        (_BRAD2, _BRAD), "right", 2.7, 0.69, 0.3, 0.72, "low", 0.9, 0.7, "sides", 0, 0, 0, 1.5, 0.8, 0.5,
        0.3, 1.3, 0.28, 1.5, 0.61,
    ),
    Performer(
        "excited teenager", "Left hand first, quick and large, many strokes one after the other, bouncing trunk.",
        (_NEURON, _WOMAN, _BRAD), "left", 0.8, 0.38, 0.6, 1.1, "mid", 1.4, 0.5, "sides", 3, 2, 2, 6.0, 5.5, 3.0,
        0.6, 1.2, 0.3, 9, 0.61,
    ),
    Performer(
        "diplomat", "Balanced two-handed gestures at the waist, even tempo, hands back before the body.",
        (_BRAD2, _WOMAN, _BRAD), "both", 1.7, 0.54, 0.7, 0.84, "low", 0.8, 1.5, "front", 0, 0, 2, 3.5, 2.5, 1.5,
        0.87, 1, 0.38, 3.5, 0.87,
    ),
    Performer(
        "tour guide", "Shows the way with a long left arm, wide and high, turns with it, cheerful nods.",
        (_WOMAN, _BRAD, _MAN), "left", 1.35, 0.47, 1.0, 1.08, "high", 1.05, 1.1, "sides", 1, 0, 3, 5.0, 6.0, 2.0,
        0.52, 1.3, 0.24, 4, 0.61,
    ),
    Performer(
        "technician", "Sparse right-hand gestures before the body, quick return to the side.",
        (_MAN, _BRAD2), "right", 1.55, 0.54, 0.55, 0.85, "mid", 1.2, 0.5, "sides", 3, 0, -3, 3.0, 1.5, 0.8,
        0.25, 1.2, 0.28, 2.5, 0.51,
    ),
)  # fmt: skip


NOISE_SCALES = {
    "shy student": 0.74, "deadpan": 0.76, "tired": 0.84, "skeptic": 0.86, "news anchor": 0.87, "stern": 0.87,
    "calm lecturer": 0.88,
}  # fmt: skip
"""Scale of the noise for performers that must be calm: sampled motion is livelier than the motion it was trained on."""
DEFAULT = "eager storyteller"
"""The performer of requests that name no style."""


def describe() -> list[dict]:
    """Return the performers' entries of the corpus's meta in id order; one is marked as the default."""
    return [
        {
            "name": performer.name,
            "description": performer.description,
            "default": performer.name == DEFAULT,
            "semantic": performer.semantic,
            "chance": NOISE_SCALES.get(performer.name, 1.0),
        }
        for performer in PERFORMERS
    ]
