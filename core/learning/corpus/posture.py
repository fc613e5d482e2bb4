"""Trunk, shoulder and head motion of a performer, derived from the speech, the strokes and the controls.

The head nods on accents and follows the voice's pitch, as measured heads do; the trunk leans with arousal and turns towards
the gesturing hand; raised arms open or close with the controls of valence and dominance.
"""

import numpy as np

from ...motion import rest, skeleton
from ...motion.interpolation import ramp
from . import rotation
from .planning import Stroke
from .scene import Scene
from .smoothing import smooth
from .speakers import Performer

_Degrees = float | np.ndarray
_UPPER = tuple(range(9))
_HEAD = (1, 2)
_SHAPES = {
    "pleased": [[-0.34, 0.78, 0.52], [-0.5, -0.25, 0.83], [0.34, 0.78, 0.52], [0.5, -0.25, 0.83]],
    "displeased": [[-0.1, 0.99, 0.08], [0.5, 0.72, 0.48], [0.1, 0.99, 0.08], [-0.5, 0.72, 0.48]],
    "dominant": [[-0.86, 0.48, 0.16], [0.12, 0.45, 0.88], [0.86, 0.48, 0.16], [-0.12, 0.45, 0.88]],
    "timid": [[-0.04, 0.97, 0.24], [0.3, 0.05, 0.95], [0.04, 0.97, 0.24], [-0.3, 0.05, 0.95]],
}
_SHAPES = {name: skeleton.normalize(np.array(shape)) for name, shape in _SHAPES.items()}
"""Arm directions towards which affect moves the arms: pleased arms lift and open, dominant ones spread the elbows."""
_SHAKES = frozenset({"not", "none"})
"""Meanings with a head shake."""
_SHRUGS = {"unknown": 1.0, "maybe": 0.55}
"""Meanings that raise the shoulders, and how much."""


def apply_posture(body: np.ndarray, performer: Performer, scene: Scene, strokes: list[Stroke], time: np.ndarray) -> None:
    """Move shoulders, head and trunk of directions ``(frames, 9, 3)``, in place."""
    valence, arousal, dominance = (smooth(column, 0.6) - 0.5 for column in scene.affect(time).T)
    lift = performer.shoulders + 4 * arousal - 3 * dominance
    lift = lift + 13 * _meaning_envelope(strokes, time, _SHRUGS)
    _turn(body, (3,), roll=-lift)
    _turn(body, (6,), roll=lift)
    _move_head(body, performer, scene, strokes, time, valence, dominance)
    _move_trunk(body, performer, scene, strokes, time, arousal, dominance)


def apply_affect(body: np.ndarray, scene: Scene) -> None:
    """Lift, drop, spread or narrow raised arms ``(frames, 9, 3)`` by the controls of valence and dominance, in place."""
    arms = list(skeleton.ARM_EDGES)
    for value, shapes in ((scene.valence, ("displeased", "pleased")), (scene.dominance, ("timid", "dominant"))):
        if value:
            towards = np.broadcast_to(_SHAPES[shapes[int(value > 0)]], body[:, arms].shape)
            away = np.degrees(np.arccos(np.clip((body[:, arms] * rest.REST[arms]).sum(-1), -1, 1)))
            raised = np.clip(away.reshape(-1, 2, 2).max(axis=-1) / 50, 0.12, 1).repeat(2, axis=1)
            body[:, arms] = rest.slerp(body[:, arms], towards, 0.3 * abs(value) * raised)


def _move_head(
    body: np.ndarray,
    performer: Performer,
    scene: Scene,
    strokes: list[Stroke],
    time: np.ndarray,
    valence: np.ndarray,
    dominance: np.ndarray,
) -> None:
    pitch = np.zeros(len(time))
    for accent in scene.accents:
        size = performer.nod * (0.5 + scene.arousal(accent)) * np.clip((accent.strength - 0.3) / 0.4, 0, 1.2)
        if size > 0:
            down = ramp(time, accent.time - 0.22, accent.time + 0.04) * (1 - ramp(time, accent.time + 0.04, accent.time + 0.5))
            before = ramp(time, accent.time - 0.5, accent.time - 0.24) * (1 - ramp(time, accent.time - 0.24, accent.time))
            pitch = np.maximum(pitch, size * down) - 0.3 * size * before
    melody = np.clip(scene.track(scene.prosody.pitch, 0.2, time) / 4, -1.5, 1.5)
    trend = np.clip(scene.track(scene.prosody.pitch, 0.7, time) / 3, -1.5, 1.5)
    loud = np.clip(scene.track(np.maximum(scene.prosody.level, -20), 0.6, time) / 8, -1.5, 1)
    away = 1 - scene.speaking(time)
    side = 1.0 if sum(map(ord, performer.name)) % 2 else -1.0
    question = np.zeros(len(time))
    for word in scene.speech.words:
        if word.closing == "?":
            rise = ramp(time, word.start - 0.6, word.end) * (1 - ramp(time, word.end + 0.3, word.end + 1.3))
            question = np.maximum(question, rise)
    steady = 1 - 0.5 * scene.dominance
    pitch *= steady
    chin = performer.chin + 2.5 * dominance + 6 * valence
    pitch = pitch - chin + 3 * away - 0.5 * performer.drift * melody
    yaw = side * (2.2 * performer.drift * away + 0.9 * performer.drift * trend) * steady + _head_shake(strokes, time)
    roll = side * performer.tilt * (0.7 * loud + 1.6 * question) * steady * (1 + 0.5 * scene.valence)
    roll = roll + side * (9 * _meaning_envelope(strokes, time, _SHRUGS) + 2.5 * scene.valence)
    _turn(body, _HEAD, pitch, yaw, roll)


def _move_trunk(
    body: np.ndarray,
    performer: Performer,
    scene: Scene,
    strokes: list[Stroke],
    time: np.ndarray,
    arousal: np.ndarray,
    dominance: np.ndarray,
) -> None:
    pitch = performer.lean * (1 - 0.5 * scene.dominance) + 5.0 * arousal - 4.0 * dominance
    for accent in scene.accents:
        if accent.main:
            bump = ramp(time, accent.time - 0.3, accent.time + 0.05) * (1 - ramp(time, accent.time + 0.05, accent.time + 0.8))
            pitch = pitch + 0.9 * performer.sway * accent.strength * bump
    turn = np.zeros(len(time))
    for stroke in strokes:
        left, right = stroke.hands
        weight = ramp(time, stroke.onset, stroke.ready + 0.2) * (1 - ramp(time, max(stroke.until), max(stroke.rest)))
        turn += np.clip(left - right, -1, 1) * weight * stroke.amplitude
    turn = smooth(np.clip(turn, -1.2, 1.2), 0.15)
    _turn(body, _UPPER, pitch=0.5 * pitch, yaw=-2.8 * performer.sway * turn, roll=1.0 * performer.sway * turn)
    _turn(body, (0, 1, 2, 3, 6), pitch=0.5 * pitch)


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


def _turn(body: np.ndarray, edges: tuple[int, ...], pitch: _Degrees = 0.0, yaw: _Degrees = 0.0, roll: _Degrees = 0.0) -> None:
    """Rotate edges by angles in degrees ``(frames,)``, in place: forwards, to the left, and tilting the top to the left."""
    shape = body.shape[:1]
    # canonical y points down: forward nods turn x negatively, left is -x
    q = rotation.about(0, -np.radians(np.broadcast_to(pitch, shape)))
    q = rotation.multiply(rotation.about(2, -np.radians(np.broadcast_to(roll, shape))), q)
    q = rotation.multiply(rotation.about(1, -np.radians(np.broadcast_to(yaw, shape))), q)
    for edge in edges:
        body[:, edge] = rotation.rotate(q, body[:, edge])
