"""Made-up performers, as data: what they gesture with, how often, how large, how high, how they stand and rest."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Performer:
    """A fixed way of gesturing. Angles in degrees, times in seconds.

    ``families``: clip sets, most liked first. ``hand``: "left", "right" or "both", the one that does the everyday work.
    ``gap``: least time between strokes; ``threshold``: accent strength that earns a beat; ``semantic``: how readily a
    word's meaning is shown (0 seldom, 1 always). ``size`` scales amplitude; ``height``: beats "low", "mid" or "high".
    ``tempo`` scales the speed of preparation and retraction, ``hold`` stretches holds. ``rest``: where idle hands go
    ("sides" or "front"). Posture: ``lean`` forward, ``shoulders`` up, ``chin`` up. ``nod`` on an accent, ``drift``
    and ``tilt`` of the head, ``sway`` of the trunk. ``one_handed``: even strong accents are left to one hand.
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
    one_handed: bool = False

    def handed(self, preference: float) -> "Performer":
        """This performer asked to prefer a hand, from -1 (left) to 1 (right); small wishes change nothing."""
        if abs(preference) < _WISH:
            return self
        return replace(self, hand="left" if preference < 0 else "right", one_handed=self.one_handed or abs(preference) > 0.6)


_WISH = 0.25
_BRAD, _BRAD2, _WOMAN, _MAN, _NEURON = "Gestures", "Gestures2", "FemaleGestures", "MaleGestures", "PNGestures"

PERFORMERS = (
    Performer(
        "calm lecturer", "Measured beats at waist height with the right hand, long holds, still head.",
        (_BRAD2, _BRAD), "right", 1.5, 0.5, 0.6, 0.92, "mid", 0.85, 1.5, "sides", 0, 0, 0, 3.0, 2.5, 1.0, 0.8,
    ),
    Performer(
        "eager storyteller", "Large two-handed gestures that follow the meaning of every other word, lively head.",
        (_NEURON, _WOMAN, _BRAD2), "both", 1.0, 0.4, 0.95, 0.97, "high", 1.05, 0.9, "sides", 4, 1, 1, 5.5, 5.0, 3.0, 1.6,
    ),
    Performer(
        "stern", "Few, sharp chops and stops with one hand, upright, chin down, hardly any sway.",
        (_MAN, _BRAD), "right", 1.5, 0.54, 0.5, 0.95, "mid", 1.25, 1.2, "sides", -2, 0, -4, 3.5, 1.2, 0.4, 0.4, True,
    ),
    Performer(
        "tired", "Small, low and slow movements that sink early, shoulders and head hanging.",
        (_BRAD, _BRAD2), "left", 1.9, 0.55, 0.35, 0.62, "low", 0.72, 0.6, "sides", 6, -2, -7, 2.0, 2.0, 2.0, 1.2,
    ),
    Performer(
        "warm host", "Open, offering hands from a clasp in front of the body, soft nods and a tilted head.",
        (_BRAD2, _WOMAN), "both", 1.2, 0.44, 0.8, 0.9, "mid", 0.9, 1.2, "front", 2, 0, 1, 4.5, 3.5, 3.5, 1.2,
    ),
    Performer(
        "nervous", "Quick small beats close to the body, restless trunk and head, shoulders raised.",
        (_BRAD, _MAN), "both", 0.8, 0.38, 0.4, 0.6, "low", 1.3, 0.5, "front", 3, 4, -2, 3.0, 4.5, 1.5, 2.2,
    ),
    Performer(
        "left-handed joker", "Loose left-hand gestures, points at people, shrugs, head tilts.",
        (_BRAD2, _BRAD, _NEURON), "left", 1.1, 0.42, 0.9, 1.0, "mid", 1.1, 0.9, "sides", -1, 0, 2, 4.5, 5.0, 4.0, 1.8,
    ),
    Performer(
        "grand orator", "Wide and high with both arms, slow to rise, long proud holds, chin up.",
        (_NEURON, _WOMAN, _MAN), "both", 1.6, 0.44, 0.85, 1.02, "high", 0.9, 1.6, "sides", -3, 0, 4, 4.0, 3.0, 1.0, 1.2,
    ),
    Performer(
        "brisk presenter", "Right-handed, precise, at chest height, a stroke on nearly every accent.",
        (_WOMAN, _MAN), "right", 0.85, 0.38, 0.6, 0.85, "mid", 1.2, 0.8, "front", 1, 0, 1, 4.0, 2.5, 1.0, 0.8,
    ),
    Performer(
        "thoughtful explainer", "Shapes ideas between two hands, pauses with the head turned away, few beats.",
        (_BRAD, _NEURON, _BRAD2), "both", 1.4, 0.5, 1.0, 0.9, "mid", 0.8, 1.4, "front", 2, 0, -2, 3.0, 5.5, 2.5, 1.0,
    ),
    Performer(
        "news anchor", "Small, tidy strokes from folded hands at the waist, upright and composed.",
        (_WOMAN, _BRAD2), "both", 1.3, 0.5, 0.3, 0.66, "low", 1.0, 1.3, "front", -1, 0, 0, 4.5, 1.0, 1.5, 0.3,
    ),
    Performer(
        "street preacher", "Fast, high chops and points with the right hand that come down hard on every accent.",
        (_MAN, _NEURON, _BRAD), "right", 0.85, 0.36, 0.7, 1.05, "high", 1.35, 0.7, "sides", 7, 2, 3, 6.0, 4.0, 1.0, 2.2, True,
    ),
    Performer(
        "shy student", "Arms near the body, now and then a small left-hand gesture, chin down, head tilted.",
        (_BRAD2, _WOMAN), "left", 1.8, 0.52, 0.5, 0.5, "low", 0.95, 0.6, "front", 1, 3, -6, 2.5, 3.0, 5.0, 0.9,
    ),
    Performer(
        "sales rep", "Open two-handed offers and counts, chest high, leaning to the listener, nodding.",
        (_WOMAN, _NEURON), "both", 0.95, 0.38, 0.85, 0.9, "mid", 1.15, 0.8, "sides", 6, 0, 2, 6.5, 3.0, 2.5, 1.3,
    ),
    Performer(
        "old professor", "Slow explaining circles of the left hand with long holds, stooped, head leading.",
        (_BRAD, _BRAD2), "left", 1.6, 0.46, 0.7, 0.85, "mid", 0.7, 1.8, "sides", 8, 1, -3, 3.5, 4.5, 1.5, 0.9,
    ),
    Performer(
        "coach", "Both fists and chops pump at belly height, feet planted, short and often.",
        (_MAN, _BRAD), "both", 0.9, 0.4, 0.4, 0.88, "low", 1.3, 0.7, "sides", 5, 1, -1, 5.0, 2.0, 0.5, 1.0,
    ),
    Performer(
        "elegant host", "Light right-hand gestures at shoulder height with a lifted elbow, head high.",
        (_WOMAN, _BRAD2, _NEURON), "right", 1.3, 0.46, 0.65, 0.92, "high", 0.85, 1.2, "front", -3, -1, 5, 3.0, 3.5, 3.0, 1.1,
        True,
    ),
    Performer(
        "skeptic", "One-handed dismissals and shrugs from the right, leaning back, head aside.",
        (_BRAD2, _MAN), "right", 1.7, 0.5, 0.95, 0.85, "low", 0.95, 1.0, "sides", -5, 1, -1, 2.5, 4.0, 5.0, 0.7, True,
    ),
    Performer(
        "dreamer", "Slow floating movements of both hands, high holds, eyes in the distance.",
        (_NEURON, _BRAD), "both", 1.7, 0.44, 0.8, 0.9, "high", 0.68, 1.8, "sides", -2, 0, 6, 2.0, 6.0, 3.5, 1.8,
    ),
    Performer(
        "deadpan", "Hardly a gesture: the hands hang, a rare small turn of the right hand, still trunk.",
        (_BRAD2, _BRAD), "right", 2.6, 0.66, 0.3, 0.55, "low", 0.9, 0.7, "sides", 0, 0, 0, 1.5, 0.8, 0.5, 0.2, True,
    ),
    Performer(
        "excited teenager", "Left hand first, quick and large, many beats one after the other, bouncing trunk.",
        (_NEURON, _WOMAN, _BRAD), "left", 0.75, 0.32, 0.6, 1.0, "mid", 1.4, 0.5, "sides", 3, 2, 2, 6.0, 5.5, 3.0, 2.4,
    ),
    Performer(
        "diplomat", "Balanced two-handed gestures at the waist, even tempo, weighs one side against the other.",
        (_BRAD2, _WOMAN, _BRAD), "both", 1.4, 0.46, 0.7, 0.75, "low", 0.8, 1.5, "front", 0, 0, 2, 3.5, 2.5, 1.5, 0.8,
    ),
    Performer(
        "tour guide", "Points and shows with a long left arm, turns with it, cheerful nods.",
        (_WOMAN, _BRAD, _MAN), "left", 1.1, 0.4, 1.0, 1.02, "high", 1.05, 1.1, "sides", 1, 0, 3, 5.0, 6.0, 2.0, 2.0,
    ),
    Performer(
        "technician", "Sparse, exact right-hand placements in front of the chest, quick return to the side.",
        (_MAN, _BRAD2), "right", 1.3, 0.46, 0.55, 0.78, "mid", 1.2, 0.5, "sides", 3, 0, -3, 3.0, 1.5, 0.8, 0.5, True,
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
