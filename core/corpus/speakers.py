"""Made-up performers, as data: what they gesture with, how often, how large, how high, how they stand and rest."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Performer:
    """A fixed way of gesturing. Angles in degrees, times in seconds.

    ``families``: clip sets, most liked first. ``hand``: "left", "right" or "both", the one that does the everyday work.
    ``gap``: least time between strokes; ``threshold``: accent strength that earns a beat; ``semantic``: how readily a
    word's meaning is shown (0 seldom, 1 always). ``size`` scales amplitude; ``height``: beats "low", "mid" or "high".
    ``tempo`` scales the speed of preparation and retraction, ``hold`` stretches holds. ``rest``: where idle hands go
    ("sides" or "front"). Posture: ``lean`` forward, ``shoulders`` up, ``chin`` up. ``nod`` on an accent, ``drift``
    and ``tilt`` of the head, ``sway`` of the trunk.
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


_BRAD, _BRAD2, _WOMAN, _MAN, _NEURON = "Gestures", "Gestures2", "FemaleGestures", "MaleGestures", "PNGestures"

PERFORMERS = (
    Performer(
        "calm lecturer", "Measured beats at waist height with the right hand, long holds, still head.",
        (_BRAD2, _BRAD), "right", 1.5, 0.42, 0.6, 0.95, "mid", 0.85, 1.5, "sides", 0, 0, 0, 3.0, 2.5, 1.0, 0.8,
    ),
    Performer(
        "eager storyteller", "Large two-handed gestures that follow the meaning of every other word, lively head.",
        (_NEURON, _WOMAN, _BRAD2), "both", 1.0, 0.34, 0.95, 0.97, "high", 1.05, 0.9, "sides", 4, 1, 1, 5.5, 5.0, 3.0, 1.6,
    ),
    Performer(
        "stern", "Few, sharp chops and stops with one hand, upright, chin down, hardly any sway.",
        (_MAN, _BRAD), "right", 1.5, 0.46, 0.5, 0.95, "mid", 1.25, 1.2, "sides", -2, 0, -4, 3.5, 1.2, 0.4, 0.4,
    ),
    Performer(
        "tired", "Small, low and slow movements that sink early, shoulders and head hanging.",
        (_BRAD, _BRAD2), "left", 1.9, 0.5, 0.35, 0.62, "low", 0.72, 0.6, "sides", 6, -2, -7, 2.0, 2.0, 2.0, 1.2,
    ),
    Performer(
        "warm host", "Open, offering hands from a clasp in front of the body, soft nods and a tilted head.",
        (_BRAD2, _WOMAN), "both", 1.2, 0.4, 0.8, 0.9, "mid", 0.9, 1.2, "front", 2, 0, 1, 4.5, 3.5, 3.5, 1.2,
    ),
    Performer(
        "nervous", "Quick small beats close to the body, restless trunk and head, shoulders raised.",
        (_BRAD, _MAN), "both", 0.8, 0.36, 0.4, 0.6, "low", 1.3, 0.5, "front", 3, 3, -2, 3.0, 4.5, 1.5, 2.2,
    ),
    Performer(
        "left-handed joker", "Loose left-hand gestures, points at people, shrugs, head tilts.",
        (_BRAD2, _BRAD, _NEURON), "left", 1.1, 0.38, 0.9, 1.05, "mid", 1.1, 0.9, "sides", -1, 0, 2, 4.5, 5.0, 4.0, 1.8,
    ),
    Performer(
        "grand orator", "Wide and high with both arms, slow to rise, long proud holds, chin up.",
        (_NEURON, _MAN, _WOMAN), "both", 1.5, 0.38, 0.85, 1.1, "high", 0.9, 1.6, "sides", -3, 0, 4, 4.0, 3.0, 1.0, 1.2,
    ),
    Performer(
        "brisk presenter", "Right-handed, precise, at chest height, a stroke on nearly every accent.",
        (_WOMAN, _MAN), "right", 0.85, 0.34, 0.6, 0.85, "mid", 1.2, 0.8, "front", 1, 0, 1, 4.0, 2.5, 1.0, 0.8,
    ),
    Performer(
        "thoughtful explainer", "Shapes ideas between two hands, pauses with the head turned away, few beats.",
        (_BRAD, _NEURON, _BRAD2), "both", 1.4, 0.45, 1.0, 0.9, "mid", 0.8, 1.4, "front", 2, 0, -2, 3.0, 5.5, 2.5, 1.0,
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
