"""Made-up performers, as data: what they gesture with, how often, how large, how high, how they stand and rest."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Performer:
    """A taste in gestures: what the director's draws lean to. Angles in degrees, times in seconds.

    ``families``: clip sets, most liked first. ``hand``: "left", "right" or "both", the one that does the everyday work;
    ``both``: share of strokes by two hands. ``gap``: least time between strokes; ``threshold``: accent strength that is
    answered every other time; ``semantic``: how readily a word's meaning is shown (0 seldom, 1 always). ``size`` scales
    amplitude; ``height``: strokes "low", "mid" or "high". ``tempo`` scales the speed of preparation and retraction, ``hold``
    stretches holds. ``plane`` scales how far strokes are turned and displaced; ``apart``: how often the arms of a two-handed
    stroke go their own ways; ``chain``: strokes in a row, on average, before the hands pause; ``linger``: how often the hands
    wait before the body, rather than at ``rest`` ("sides" or "front"), between two strokes.
    Posture: ``lean`` forward, ``shoulders`` up, ``chin`` up. ``nod`` on an accent, ``drift`` and ``tilt`` of the head,
    ``sway`` of the trunk.
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
    sway: float
    both: float
    plane: float
    apart: float
    chain: float
    linger: float

    def handed(self, preference: float) -> "Performer":
        """This performer asked to prefer a hand, from -1 (left) to 1 (right); small wishes change nothing."""
        if abs(preference) < _WISH:
            return self
        return replace(self, hand="left" if preference < 0 else "right", both=self.both * (1 - abs(preference)))


_WISH = 0.25
_BRAD, _BRAD2, _WOMAN, _MAN, _NEURON = "Gestures", "Gestures2", "FemaleGestures", "MaleGestures", "PNGestures"

PERFORMERS = (
    Performer(
        "calm lecturer", "Measured strokes at waist height, mostly of the right hand, long holds, still head.",
        (_BRAD2, _BRAD), "right", 1.3, 0.46, 0.6, 0.95, "mid", 0.85, 1.5, "sides", 0, 0, 0, 3.0, 2.5, 1.0, 0.8,
        0.35, 1, 0.4, 2.5, 0.8,
    ),
    Performer(
        "eager storyteller", "Large, ever different gestures of both hands at chest height, chained, with a lively head.",
        (_NEURON, _WOMAN, _BRAD2), "both", 0.85, 0.36, 0.95, 1.06, "high", 1.05, 0.9, "sides", 4, 1, 1, 5.5, 5.0, 3.0, 1.6,
        0.75, 1.2, 0.5, 6, 0.7,
    ),
    Performer(
        "stern", "Few, quick and firm strokes of the right hand, upright, chin down, hardly any sway.",
        (_MAN, _BRAD), "right", 1.3, 0.5, 0.5, 1, "mid", 1.25, 1.2, "sides", -2, 0, -4, 3.5, 1.2, 0.4, 0.4,
        0.15, 1.1, 0.4, 2.5, 0.6,
    ),
    Performer(
        "tired", "Small, low and slow movements that sink early, shoulders and head hanging.",
        (_BRAD, _BRAD2), "left", 1.6, 0.5, 0.35, 0.75, "low", 0.72, 0.6, "sides", 6, -2, -7, 2.0, 2.0, 2.0, 1.2,
        0.45, 1.2, 0.4, 2, 0.8,
    ),
    Performer(
        "warm host", "Soft, rounded gestures of both hands that return before the body, soft nods and a tilted head.",
        (_BRAD2, _WOMAN), "both", 1.05, 0.42, 0.8, 0.96, "mid", 0.9, 1.2, "front", 2, 0, 1, 4.5, 3.5, 3.5, 1.2,
        0.75, 1.1, 0.45, 4, 0.85,
    ),
    Performer(
        "nervous", "Quick small strokes close to the body, restless trunk and head, shoulders raised.",
        (_BRAD, _MAN), "both", 0.7, 0.36, 0.4, 0.72, "low", 1.3, 0.5, "front", 3, 4, -2, 3.0, 4.5, 1.5, 2.2,
        0.6, 1.2, 0.6, 6, 0.8,
    ),
    Performer(
        "left-handed joker", "Loose gestures, mostly of the left hand, wide turns, head tilts.",
        (_BRAD2, _BRAD, _NEURON), "left", 1, 0.39, 0.9, 1.05, "mid", 1.1, 0.9, "sides", -1, 0, 2, 4.5, 5.0, 4.0, 1.8,
        0.35, 1.3, 0.5, 4, 0.7,
    ),
    Performer(
        "grand orator", "Wide and high with both arms, slow to rise, long proud holds, chin up.",
        (_NEURON, _WOMAN, _MAN), "both", 1.3, 0.4, 0.85, 1.1, "high", 0.9, 1.6, "sides", -3, 0, 4, 4.0, 3.0, 1.0, 1.2,
        0.8, 1.1, 0.4, 3, 0.5,
    ),
    Performer(
        "brisk presenter", "Brisk right-handed strokes before the body, often several in a row.",
        (_WOMAN, _MAN), "right", 0.75, 0.36, 0.6, 0.95, "mid", 1.2, 0.8, "front", 1, 0, 1, 4.0, 2.5, 1.0, 0.8,
        0.35, 1.1, 0.5, 6, 0.8,
    ),
    Performer(
        "thoughtful explainer", "Shapes ideas between two hands, pauses with the head turned away.",
        (_BRAD, _NEURON, _BRAD2), "both", 1.2, 0.45, 1.0, 0.96, "mid", 0.8, 1.4, "front", 2, 0, -2, 3.0, 5.5, 2.5, 1.0,
        0.8, 1.1, 0.5, 3, 0.85,
    ),
    Performer(
        "news anchor", "Small, tidy strokes from hands before the waist, upright and composed.",
        (_WOMAN, _BRAD2), "both", 1.1, 0.46, 0.3, 0.75, "low", 1.0, 1.3, "front", -1, 0, 0, 4.5, 1.0, 1.5, 0.3,
        0.7, 1.1, 0.4, 3.5, 0.9,
    ),
    Performer(
        "street preacher", "Fast, high and hard strokes led by the right hand, hardly a rest, leaning in.",
        (_MAN, _NEURON, _BRAD), "right", 0.75, 0.33, 0.7, 1.12, "high", 1.35, 0.7, "sides", 7, 2, 3, 6.0, 4.0, 1.0, 2.2,
        0.45, 1.2, 0.5, 8, 0.6,
    ),
    Performer(
        "shy student", "Arms near the body, now and then a small left-hand gesture, chin down, head tilted.",
        (_BRAD2, _WOMAN), "left", 1.5, 0.48, 0.5, 0.66, "low", 0.95, 0.6, "front", 1, 3, -6, 2.5, 3.0, 5.0, 0.9,
        0.4, 1.1, 0.4, 2, 0.8,
    ),
    Performer(
        "sales rep", "Open gestures of both hands, one after the other, leaning to the listener, nodding.",
        (_WOMAN, _NEURON), "both", 0.8, 0.36, 0.85, 1, "mid", 1.15, 0.8, "sides", 6, 0, 2, 6.5, 3.0, 2.5, 1.3,
        0.8, 1.1, 0.45, 6, 0.7,
    ),
    Performer(
        "old professor", "Slow explaining movements led by the left hand with long holds, stooped, head leading.",
        (_BRAD, _BRAD2), "left", 1.4, 0.43, 0.7, 0.95, "mid", 0.7, 1.8, "sides", 8, 1, -3, 3.5, 4.5, 1.5, 0.9,
        0.4, 1.3, 0.5, 2.5, 0.85,
    ),
    Performer(
        "coach", "Both hands beat at belly height, short and often, leaning in.",
        (_MAN, _BRAD), "both", 0.8, 0.37, 0.4, 1, "low", 1.3, 0.7, "sides", 5, 1, -1, 5.0, 2.0, 0.5, 1.0,
        0.8, 1.15, 0.4, 7, 0.7,
    ),
    Performer(
        "elegant host", "Light right-hand gestures at chest height and above, head high.",
        (_WOMAN, _BRAD2, _NEURON), "right", 1.15, 0.43, 0.65, 0.98, "high", 0.85, 1.2, "front", -3, -1, 5, 3.0, 3.5, 3.0, 1.1,
        0.25, 1.2, 0.4, 3.5, 0.75,
    ),
    Performer(
        "skeptic", "Spare low gestures of the right hand, leaning back, head aside.",
        (_BRAD2, _MAN), "right", 1.4, 0.46, 0.95, 0.9, "low", 0.95, 1.0, "sides", -5, 1, -1, 2.5, 4.0, 5.0, 0.7,
        0.2, 1.3, 0.4, 2.2, 0.75,
    ),
    Performer(
        "dreamer", "Slow floating movements of both hands, high holds, head up.",
        (_NEURON, _BRAD), "both", 1.4, 0.41, 0.8, 1, "high", 0.68, 1.8, "sides", -2, 0, 6, 2.0, 6.0, 3.5, 1.8,
        0.7, 1.3, 0.5, 3.5, 0.7,
    ),
    Performer(
        "deadpan", "Hardly a gesture: low, idle hands, a rare small movement of the right one, still trunk.",
        (_BRAD2, _BRAD), "right", 1.9, 0.58, 0.3, 0.72, "low", 0.9, 0.7, "sides", 0, 0, 0, 1.5, 0.8, 0.5, 0.2,
        0.3, 1.3, 0.4, 1.5, 0.6,
    ),
    Performer(
        "excited teenager", "Left hand first, quick and large, many strokes one after the other, bouncing trunk.",
        (_NEURON, _WOMAN, _BRAD), "left", 0.65, 0.29, 0.6, 1.1, "mid", 1.4, 0.5, "sides", 3, 2, 2, 6.0, 5.5, 3.0, 2.4,
        0.5, 1.2, 0.5, 9, 0.6,
    ),
    Performer(
        "diplomat", "Balanced two-handed gestures at the waist, even tempo, hands back before the body.",
        (_BRAD2, _WOMAN, _BRAD), "both", 1.2, 0.43, 0.7, 0.84, "low", 0.8, 1.5, "front", 0, 0, 2, 3.5, 2.5, 1.5, 0.8,
        0.85, 1, 0.45, 3.5, 0.85,
    ),
    Performer(
        "tour guide", "Shows the way with a long left arm, wide and high, turns with it, cheerful nods.",
        (_WOMAN, _BRAD, _MAN), "left", 1, 0.38, 1.0, 1.08, "high", 1.05, 1.1, "sides", 1, 0, 3, 5.0, 6.0, 2.0, 2.0,
        0.4, 1.3, 0.4, 4, 0.6,
    ),
    Performer(
        "technician", "Sparse right-hand gestures before the body, quick return to the side.",
        (_MAN, _BRAD2), "right", 1.1, 0.43, 0.55, 0.85, "mid", 1.2, 0.5, "sides", 3, 0, -3, 3.0, 1.5, 0.8, 0.5,
        0.25, 1.2, 0.4, 2.5, 0.5,
    ),
)  # fmt: skip


DEFAULT = "eager storyteller"
"""Who performs when the user asks for nobody in particular."""


def describe() -> list[dict]:
    """Names and descriptions in id order, as the data set's meta lists them; one is marked as the default."""
    return [
        {"name": performer.name, "description": performer.description, "default": performer.name == DEFAULT}
        for performer in PERFORMERS
    ]
