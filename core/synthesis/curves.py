"""Controls and intensity of a request at every frame, where they change over time."""

import numpy as np

from ..motion import skeleton
from ..settings import AFFECTS, CONTROLS, Settings
from ..smoothing import gaussian

_EASE = 0.2
"""Standard deviation in seconds by which curves are smoothed: a body cannot change its mind at once."""


def sample(request: Settings, name: str, frames: int, rate: float = skeleton.FPS) -> np.ndarray | float:
    """Return the smoothed values ``(frames,)`` of a control or of intensity, or a number where it is constant."""
    points = request.curves.get(name)
    if points is None:
        return request.affect.get(name, 0.0) if name in AFFECTS else getattr(request, name)
    seconds, values = np.array(points).T
    return gaussian(np.interp(np.arange(frames) / rate, seconds, values), _EASE * rate)


def affects(request: Settings, frames: int, rate: float) -> dict[str, np.ndarray | float]:
    """Return the affects of a request at every frame, as :func:`sample` has them, by name; those that it does not mention are
    left out.
    """
    return {name: sample(request, name, frames, rate) for name in (*request.affect, *request.curves) if name in AFFECTS}


def has_control_curves(request: Settings) -> bool:
    """Return whether curves of a request steer its style."""
    return any(name in request.curves for name in CONTROLS)


def controls(request: Settings, frames: int) -> np.ndarray:
    """Return the controls at every frame ``(frames, 5)`` float32, in the order of :data:`settings.CONTROLS`."""
    columns = [np.broadcast_to(sample(request, name, frames), (frames,)) for name in CONTROLS]
    return np.stack(columns, 1).astype(np.float32)
