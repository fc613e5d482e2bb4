"""From points to the nine directions: the camera's view undone, arms, trunk, head and clavicles. Needs numpy alone."""

from dataclasses import dataclass

import numpy as np

from ...motion import skeleton
from . import film, viewpoint, weights
from .landmarks import Landmarks
from .viewpoint import HIPS, SHOULDERS, TO_CANONICAL

ELBOWS, WRISTS = (13, 14), (15, 16)
"""Points of the body, left and right."""
_SURE = 0.5
"""Least visibility of a point that counts as seen."""
_MARGIN = 0.01
_TURN_SECONDS, _TURNED = 2.0, 12.0
"""Width in seconds of the Gaussian that tells a turn of the body from a movement of the shoulders, and degrees by which a body
must turn away from where it usually looks to count as turned: a head that looks aside for a while turns it by less."""


@dataclass(frozen=True)
class Pose:
    """What each picture shows, in the canonical frame: ``directions`` ``(n, 9, 3)``; ``seen`` ``(n,)``, whether there is a
    body, ``arms`` ``(n, 2)``, how surely each arm is seen, 0..1, and ``view`` ``(n, 3, 3)`` from camera to body axes. ``gaze``:
    degrees by which the face usually leans ahead, by that view; None where none is seen.
    """

    directions: np.ndarray
    seen: np.ndarray
    arms: np.ndarray
    view: np.ndarray
    scenes: np.ndarray
    gaze: float | None = None

    @property
    def camera(self) -> tuple[float, float]:
        """Return degrees by which the camera usually stands to the left of where the body looks, and above it."""
        ahead = np.median(self.view[self.seen][:, :, 2], axis=0) if self.seen.any() else np.array([0.0, 0.0, 1.0])
        return float(np.degrees(np.arctan2(-ahead[0], ahead[2]))), float(np.degrees(np.arcsin(np.clip(-ahead[1], -1, 1))))


def read(found: Landmarks, view: np.ndarray | None = None) -> Pose:
    """Return the pose of every picture as the estimator saw it, by cameras with a known ``view`` or an estimated one."""
    points = found.world * TO_CANONICAL
    sure = np.nan_to_num(found.pose[..., 3]) * _inside(found.pose)
    seen = np.isfinite(points).all((1, 2)) & (sure[:, SHOULDERS].min(1) > _SURE)
    scenes = np.cumsum(film.is_cut(found.changes)) if len(found) else np.zeros(0, int)
    view = _views(points, sure, seen, scenes, found) if view is None else view
    turned = np.einsum("fij,fkj->fki", view, np.nan_to_num(points))
    directions = np.tile(skeleton.MEAN_UNIT.astype(float), (len(points), 1, 1))
    for side, edges in enumerate(skeleton.ARMS):
        arm = turned[:, [row[side] for row in (SHOULDERS, ELBOWS, WRISTS)]]
        directions[:, list(edges)] = skeleton.normalize(np.diff(arm, axis=1))
    _trunk(directions, turned, seen)
    gaze = _head(directions, found, view, seen)
    arms = np.stack([np.minimum(sure[:, ELBOWS[side]], sure[:, WRISTS[side]]) for side in (0, 1)], 1)
    return Pose(skeleton.normalize(directions), seen, np.where(arms > _SURE, arms, 0.0) * seen[:, None], view, scenes, gaze)


def _inside(points: np.ndarray) -> np.ndarray:
    """Return which points are within the picture ``(n, k)``."""
    with np.errstate(invalid="ignore"):
        return ((points[..., :2] > -_MARGIN) & (points[..., :2] < 1 + _MARGIN)).all(-1)


def _views(points: np.ndarray, sure: np.ndarray, seen: np.ndarray, scenes: np.ndarray, found: Landmarks) -> np.ndarray:
    """Return rotations ``(n, 3, 3)`` from the camera's axes to those of a body that stands upright and faces z."""
    result, known = np.tile(np.eye(3), (len(points), 1, 1)), weights.of("view")
    places = viewpoint.angles(found, known) if known else None
    for scene in np.unique(scenes[seen]):
        rows = np.flatnonzero(seen & (scenes == scene))
        up = skeleton.normalize(points[rows][:, SHOULDERS].mean(1) - points[rows][:, HIPS].mean(1))
        if places is not None:
            aside, above = np.median(places[rows], axis=0)
            turned = np.degrees(_slow(np.radians(places[rows, 0]), found.times[rows])) - aside
            aside = aside + np.sign(turned) * np.maximum(np.abs(turned) - _TURNED, 0)
            turn = viewpoint.view(np.stack([aside, np.full(len(rows), above)], 1))
            across, down, _ = np.median(np.einsum("fij,fj->fi", turn, up), axis=0)
            result[rows] = _shortest(np.array([across, down, 0]), np.array([0.0, -1.0, 0.0])) @ turn
            continue
        hips = np.median(sure[rows][:, HIPS].min(1)) > _SURE
        across = points[rows, SHOULDERS[0]] - points[rows, SHOULDERS[1]]
        if hips:
            across = across + points[rows, HIPS[0]] - points[rows, HIPS[1]]
        angle = _slow(np.arctan2(-across[:, 2], -across[:, 0]), found.times[rows])
        turn = _about_y(-angle)
        upright = np.median(np.einsum("fij,fj->fi", turn, up), axis=0)
        result[rows] = _shortest(upright, skeleton.MEAN_UNIT[0] * [0, 1, 1]) @ turn
    return result


def _slow(angle: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Return angles ``(n,)`` in radians without what changes within two seconds."""
    angle = np.unwrap(angle)
    step = max(len(times) // 20_000, 1)
    nodes = np.arange(0, len(times), step)
    smooth = np.array([_mean(angle, times, times[node]) for node in nodes])
    return np.interp(times, times[nodes], smooth)


def _mean(angle: np.ndarray, times: np.ndarray, at: float) -> float:
    low, high = np.searchsorted(times, (at - 3 * _TURN_SECONDS, at + 3 * _TURN_SECONDS))
    weight = np.exp(-0.5 * ((times[low:high] - at) / _TURN_SECONDS) ** 2)
    return float(weight @ angle[low:high] / weight.sum())


def _about_y(angle: np.ndarray) -> np.ndarray:
    cosine, sine, turn = np.cos(angle), np.sin(angle), np.zeros((len(angle), 3, 3))
    turn[:, 0, 0], turn[:, 0, 2], turn[:, 2, 0], turn[:, 2, 2], turn[:, 1, 1] = cosine, -sine, sine, cosine, 1
    return turn


def _shortest(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the smallest rotation (3, 3) from one direction to another."""
    start, end = skeleton.normalize(start), skeleton.normalize(end)
    axis, cosine = np.cross(start, end), float(start @ end)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + cross + cross @ cross / max(1 + cosine, 1e-6)


def _trunk(directions: np.ndarray, turned: np.ndarray, seen: np.ndarray) -> None:
    """Lean the trunk, and tilt and turn the clavicles, by what differs from the film's usual posture; not where the estimator
    sees the trunk upside down, as it may in the dark."""
    stands = turned[:, SHOULDERS, 1].mean(1) < turned[:, HIPS, 1].mean(1)
    seen = seen & stands
    if not seen.any():
        return
    up = skeleton.normalize(turned[:, SHOULDERS].mean(1) - turned[:, HIPS].mean(1))
    across = skeleton.normalize(turned[:, SHOULDERS[0]] - turned[:, SHOULDERS[1]])
    for edges, now, mirrored in (((0,), up, 1), ((3, 6), across, -1)):
        usual = np.median(now[seen], axis=0)
        for edge in edges:
            sign = mirrored if edge == 6 else 1
            directions[:, edge] += sign * np.where(stands[:, None], now - usual, 0)


def _head(directions: np.ndarray, found: Landmarks, view: np.ndarray, seen: np.ndarray) -> float | None:
    """Aim neck and head by the face: turned as it is seen, nodding about the film's usual height of the gaze, which is
    returned in degrees."""
    width, height = found.size
    face = found.face * TO_CANONICAL * [width, height, width]
    ok = seen & np.isfinite(face).all((1, 2))
    if not ok.any():
        return None
    face = np.einsum("fij,fkj->fki", view[ok], face[ok])
    across = skeleton.normalize(face[:, 3] - face[:, 2])  # from the right eye to the left one, which lies at -x
    up = face[:, 0] - face[:, 1]
    up = skeleton.normalize(up - across * np.sum(across * up, -1, keepdims=True))
    ahead = np.cross(across, up)
    level = np.median(np.arctan2(up[:, 2], -up[:, 1]))
    cosine, sine = np.cos(level), np.sin(level)
    tilt = np.array([[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]])  # brings the usual height of the gaze to that of rest
    up, ahead = up @ tilt.T, ahead @ tilt.T
    nose, crown = skeleton.MEAN_UNIT[1], skeleton.MEAN_UNIT[2]
    directions[ok, 1] = np.array([0.0, nose[1], 0.0]) + ahead * nose[2]
    directions[ok, 2] = -up * crown[1] + ahead * crown[2]
    rows = np.arange(len(found))
    for edge in (1, 2):
        for axis in range(3):
            directions[:, edge, axis] = np.interp(rows, rows[ok], directions[ok, edge, axis])
    return float(np.degrees(level))
