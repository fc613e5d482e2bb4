"""Controls and intensity of a request at every frame, where they change over time."""

from collections.abc import Sequence

import numpy as np

from ..motion import skeleton
from ..settings import AFFECTS, CONTROLS, Settings
from ..smoothing import gaussian

REACH = 1.5
"""Highest and lowest control that a slider and what is heard make together, as in training."""
FOLLOWED, MOST = np.array([1.0, 2.2, 1.0]), np.array([1.0, 0.9, 1.0])
"""How much of each affect that is heard a body shows (of openness much is chance), and how much at most: more spreads arms."""
_EASE = 0.2
"""Standard deviation in seconds by which curves are smoothed: a body cannot change its mind at once."""


def sample(request: Settings, name: str, frames: int, rate: float = skeleton.FPS) -> np.ndarray | float:
    """Return the smoothed values ``(frames,)`` of a control or of intensity, or a number where it is constant."""
    points = request.curves.get(name)
    if points is None:
        return request.affect.get(name, 0.0) if name in AFFECTS else getattr(request, name)
    seconds, values = np.array(points).T
    return gaussian(np.interp(np.arange(frames) / rate, seconds, values), _EASE * rate)


def asked_and_heard(request: Settings, names: Sequence[str], heard: np.ndarray | None, frames: int, rate: float) -> dict:
    """Return the controls of these names ``(frames,)``, each with what is ``heard`` of it (:func:`following`)."""
    follows, none = following(request, heard, frames, rate), np.zeros(frames)
    return {name: np.clip(sample(request, name, frames, rate) + follows.get(name, none), -1, 1) for name in names}


def following(request: Settings, heard: np.ndarray | None, frames: int, rate: float = skeleton.FPS) -> dict[str, np.ndarray]:
    """Return what is heard of each affect ``(frames,)`` as far as the request follows it, by name; ``heard`` ``(n, 3)`` at 15
    frames a second, or None. An affect that has a curve is left out: what somebody has drawn is what he wants."""
    if heard is None or not request.follow:
        return {}
    at, own = np.arange(frames) / rate, np.arange(len(heard)) / skeleton.FPS
    columns = zip(AFFECTS, shown(heard, request.follow).T, strict=True)
    return {name: np.interp(at, own, track) for name, track in columns if name not in request.curves}


def shown(heard: np.ndarray, follow: float) -> np.ndarray:
    """Return what a body shows of affects that are ``heard`` ``(n, 3)``, of a performer who follows the voice so far."""
    return follow * np.minimum(heard * FOLLOWED, MOST)


def has_control_curves(request: Settings) -> bool:
    """Return whether curves of a request steer its style."""
    return any(name in request.curves for name in CONTROLS)


def controls(request: Settings, frames: int) -> np.ndarray:
    """Return the controls at every frame ``(frames, 5)`` float32, in the order of :data:`settings.CONTROLS`."""
    columns = [np.broadcast_to(sample(request, name, frames), (frames,)) for name in CONTROLS]
    return np.stack(columns, 1).astype(np.float32)
