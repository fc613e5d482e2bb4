"""How a performer bears trunk, shoulders and head while speaking: all of it follows from what is heard and shown.

The head nods on accents and follows the voice's melody, as measured heads do; the trunk leans with arousal, turns with
the hand that works, and opens or closes with the affect that is asked for.
"""

import numpy as np

from ...motion import rest, skeleton
from . import rotation
from .curves import ramp, smooth
from .planning import Stroke
from .scene import Scene
from .speakers import Performer

_UPPER = tuple(range(9))
_HEAD = (1, 2)
_OPEN = skeleton.normalize(np.array([[-0.75, 0.6, 0.25], [-0.6, 0.25, 0.75], [0.75, 0.6, 0.25], [0.6, 0.25, 0.75]]))
_CLOSED = skeleton.normalize(np.array([[-0.12, 0.98, 0.15], [0.35, 0.6, 0.7], [0.12, 0.98, 0.15], [-0.35, 0.6, 0.7]]))
"""Arm directions that open and closed postures lean to."""


def carry(body: np.ndarray, performer: Performer, scene: Scene, strokes: list[Stroke], time: np.ndarray) -> None:
    """Shoulders, head and trunk of directions ``(frames, 9, 3)``, in place."""
    valence, arousal, dominance = (smooth(column, 0.6) - 0.5 for column in scene.affect(time).T)
    lift = performer.shoulders + 4 * arousal - 3 * dominance
    _turn(body, (3,), roll=-lift)
    _turn(body, (6,), roll=lift)
    _head(body, performer, scene, time, valence, arousal, dominance)
    _trunk(body, performer, scene, strokes, time, arousal, dominance)


def open_arms(body: np.ndarray, scene: Scene) -> None:
    """Spread or fold the arms as the controls of valence and dominance ask, in place."""
    share = scene.openness
    if share:
        towards = _OPEN if share > 0 else _CLOSED
        arms = list(skeleton.ARM_EDGES)
        raised = np.clip(np.degrees(np.arccos(np.clip((body[:, arms] * rest.REST[arms]).sum(-1), -1, 1))) / 60, 0.25, 1)
        body[:, arms] = rest.slerp(body[:, arms], np.broadcast_to(towards, body[:, arms].shape), 0.3 * abs(share) * raised)


def _head(body, performer: Performer, scene: Scene, time: np.ndarray, valence, arousal, dominance) -> None:
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
    chin = performer.chin + 4 * dominance + 3 * valence
    pitch = pitch - chin + 3 * away - 0.5 * performer.drift * melody
    yaw = side * (2.2 * performer.drift * away + 0.9 * performer.drift * trend)
    roll = side * performer.tilt * (0.7 * loud + 1.6 * question)
    _turn(body, _HEAD, pitch, yaw, roll)


def _trunk(body, performer: Performer, scene: Scene, strokes: list[Stroke], time: np.ndarray, arousal, dominance) -> None:
    pitch = performer.lean + 5.0 * arousal - 3.0 * dominance
    for accent in scene.accents:
        if accent.main:
            bump = ramp(time, accent.time - 0.3, accent.time + 0.05) * (1 - ramp(time, accent.time + 0.05, accent.time + 0.8))
            pitch = pitch + 0.9 * performer.sway * accent.strength * bump
    turn = np.zeros(len(time))
    for stroke in strokes:
        left, right = stroke.gesture.clip.hands
        weight = ramp(time, stroke.onset, stroke.ready + 0.2) * (1 - ramp(time, max(stroke.until), max(stroke.rest)))
        turn += np.clip(left - right, -1, 1) * weight * stroke.amplitude
    turn = smooth(np.clip(turn, -1.2, 1.2), 0.15)
    _turn(body, _UPPER, pitch=0.5 * pitch, yaw=-2.8 * performer.sway * turn, roll=1.0 * performer.sway * turn)
    _turn(body, (0, 1, 2, 3, 6), pitch=0.5 * pitch)


def _turn(body: np.ndarray, edges: tuple[int, ...], pitch=0.0, yaw=0.0, roll=0.0) -> None:
    """Turn edges by angles in degrees ``(frames,)``: nod forward, turn to the left, lean the top to the left."""
    shape = body.shape[:1]
    # canonical y points down: forward nods turn x negatively, left is -x
    q = rotation.about(0, -np.radians(np.broadcast_to(pitch, shape)))
    q = rotation.multiply(rotation.about(2, -np.radians(np.broadcast_to(roll, shape))), q)
    q = rotation.multiply(rotation.about(1, -np.radians(np.broadcast_to(yaw, shape))), q)
    for edge in edges:
        body[:, edge] = rotation.rotate(q, body[:, edge])
