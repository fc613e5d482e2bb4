"""Head and shoulders that go with the speech and the gestures: nods, melody, head shakes, shrugs.

Measured heads nod on accents and follow the voice's pitch.
"""

import numpy as np

from ...motion import skeleton
from ...motion.interpolation import ramp
from . import rotation
from .planning import Stroke
from .scene import Scene
from .speakers import Performer

_Degrees = float | np.ndarray
_NOD = 0.7
"""Share of a performer's nods beside the captured head's own."""
_SHAKES = frozenset({"not", "none"})
"""Meanings with a head shake."""
_SHRUGS = {"unknown": 1.0, "maybe": 0.55}
"""Meanings that raise the shoulders, and how much."""


def move_head(body: np.ndarray, performer: Performer, scene: Scene, strokes: list[Stroke], time: np.ndarray) -> None:
    """Nod on accents, follow the voice's melody, shake for a negation and shrug, in place on ``(frames, 9, 3)``.

    The captured phrase's own head goes on below this.
    """
    pitch = np.zeros(len(time))
    for accent in scene.accents:
        size = _NOD * performer.nod * (0.5 + scene.arousal(accent)) * np.clip((accent.strength - 0.3) / 0.4, 0, 1.2)
        if size > 0:
            down = ramp(time, accent.time - 0.22, accent.time + 0.04) * (1 - ramp(time, accent.time + 0.04, accent.time + 0.5))
            before = ramp(time, accent.time - 0.5, accent.time - 0.24) * (1 - ramp(time, accent.time - 0.24, accent.time))
            pitch = np.maximum(pitch, size * down) - 0.3 * size * before
    melody = np.clip(scene.track(scene.prosody.pitch, 0.2, time) / 4, -1.5, 1.5)
    trend = np.clip(scene.track(scene.prosody.pitch, 0.7, time) / 3, -1.5, 1.5)
    loud = np.clip(scene.track(np.maximum(scene.prosody.level, -20), 0.6, time) / 8, -1.5, 1)
    question = np.zeros(len(time))
    for word in scene.speech.words:
        if word.closing == "?":
            rise = ramp(time, word.start - 0.6, word.end) * (1 - ramp(time, word.end + 0.3, word.end + 1.3))
            question = np.maximum(question, rise)
    side = 1.0 if sum(map(ord, performer.name)) % 2 else -1.0
    shrug = _meaning_envelope(strokes, time, _SHRUGS)
    turn(body, (3,), roll=-13 * shrug)
    turn(body, (6,), roll=13 * shrug)
    roll = side * performer.tilt * (0.7 * loud + 1.6 * question) + side * 9 * shrug
    yaw = side * 0.9 * performer.drift * trend + _head_shake(strokes, time)
    turn(body, skeleton.HEAD, pitch - 0.5 * performer.drift * melody, yaw, roll)


def _meaning_envelope(strokes: list[Stroke], time: np.ndarray, meanings: dict[str, float]) -> np.ndarray:
    """Return an envelope ``(frames,)``, 0..1, over the strokes of some meanings: up with the stroke, down after it."""
    held = np.zeros(len(time))
    for stroke in strokes:
        if stroke.meaning in meanings:
            rise = ramp(time, stroke.ready - 0.15, stroke.emphasis + 0.1)
            fall = 1 - ramp(time, stroke.end + 0.25, stroke.end + 0.9)
            held = np.maximum(held, meanings[stroke.meaning] * rise * fall)
    return held


def _head_shake(strokes: list[Stroke], time: np.ndarray) -> np.ndarray:
    """Return yaw in degrees ``(frames,)`` of a head shake: twice to and fro around each stroke of negation."""
    yaw = np.zeros(len(time))
    for number, stroke in enumerate(strokes):
        if stroke.meaning in _SHAKES:
            within = np.clip((time - stroke.emphasis + 0.35) / 1.3, 0, 1)
            size = 5 + 5 * stroke.amplitude
            yaw += (1, -1)[number % 2] * size * np.sin(4 * np.pi * within) * np.sin(np.pi * within)
    return yaw


def turn(body: np.ndarray, edges: tuple[int, ...], pitch: _Degrees = 0.0, yaw: _Degrees = 0.0, roll: _Degrees = 0.0) -> None:
    """Rotate edges by angles in degrees ``(frames,)``, in place: forwards, to the left, and tilting the top to the left."""
    shape = body.shape[:1]
    # canonical y points down: forward nods turn x negatively, left is -x
    q = rotation.about(0, -np.radians(np.broadcast_to(pitch, shape)))
    q = rotation.multiply(rotation.about(2, -np.radians(np.broadcast_to(roll, shape))), q)
    q = rotation.multiply(rotation.about(1, -np.radians(np.broadcast_to(yaw, shape))), q)
    for edge in edges:
        body[:, edge] = rotation.rotate(q, body[:, edge])
