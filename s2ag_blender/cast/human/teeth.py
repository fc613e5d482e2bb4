"""Teeth painted on the two arches of the base mesh, which are bands without teeth: crowns, gaps between them, gums.

An arch is taken for half an ellipse. Crowns get darker the farther back they are, for light through the lips does not
reach them.
"""

import numpy as np

WIDTH, HEIGHT = 512, 96
"""Pixels of the image: from the left end of an arch to the right, lower teeth in its lower half."""
_SPAN = 0.15
"""Metres of an arch that the image shows."""
_CROWNS = ((5.2, 5.8, 6.8, 7.0, 7.0, 11.0, 10.5), (8.5, 6.5, 7.5, 7.0, 7.0, 10.0, 10.0))
"""Millimetres by which crowns are wide from the middle on, lower and upper (Wheeler's Dental Anatomy)."""
_ENAMEL, _GUM, _GAP = (0.66, 0.61, 0.51), (0.30, 0.085, 0.08), (0.16, 0.10, 0.075)
_ROOT, _EDGE = 0.62, 0.12
"""Where the gum begins between the cutting edge, 0, and the root, 1, and up to where corners of crowns are round."""
_INSIDE = 0.84
"""Share of the ellipse's radii within which a point is not on the outer side of the teeth."""
_STEPS = 400


def uvs(points: np.ndarray, quads: np.ndarray, upper: bool) -> np.ndarray:
    """Texture coordinates ``(m, 4, 2)`` of the ``quads`` (m, 4) of one arch, rows of ``points`` (n, 3) in metres."""
    used = points[np.unique(quads)]
    wide, front, low = np.abs(used[:, 0]).max(), *used[:, 1:].min(0)
    back, high = used[:, 1:].max(0)
    corners = points[quads]
    across, ahead = corners[..., 0] / wide, 1 - (corners[..., 1] - front) / (back - front)
    turn = np.arctan2(across, np.maximum(ahead, 0))
    along = np.interp(np.abs(turn), *_length(wide, back - front)) * np.sign(turn)
    height = (corners[..., 2] - low) / (high - low)
    height = np.where(np.hypot(across, ahead) < _INSIDE, 1.0, height if upper else 1 - height)  # the tongue's side is gum
    inset = 0.03 + 0.94 * np.clip(height, 0, 1)
    return np.stack([0.5 + along / _SPAN, (upper + inset) / 2], -1)


def image() -> np.ndarray:
    """The image ``(HEIGHT, WIDTH, 3)`` of both arches in linear RGB, for coordinates of :func:`uvs`."""
    along = (np.arange(WIDTH) + 0.5) / WIDTH * 1000 * _SPAN - 500 * _SPAN
    height = np.clip(((np.arange(HEIGHT // 2) + 0.5) / (HEIGHT // 2) - 0.03) / 0.94, 0, 1)[:, None]
    return np.concatenate([_arch(along, height, crowns) for crowns in _CROWNS])


def _arch(along: np.ndarray, height: np.ndarray, crowns: tuple[float, ...]) -> np.ndarray:
    """Colours ``(rows, columns, 3)`` at millimetres ``along`` the arch from its middle and ``height`` (rows, 1), 0 to 1."""
    borders = np.concatenate([[0], np.cumsum(crowns)])
    number = np.clip(np.searchsorted(borders, np.abs(along), "right") - 1, 0, len(crowns) - 1)
    beside = (np.abs(along) - borders[number]) / np.diff(borders)[number]
    away = np.minimum(beside, 1 - beside) * np.diff(borders)[number]  # millimetres to the next gap
    edge, root = _EDGE * np.clip(1 - away / 1.2, 0, 1) ** 2, _ROOT - 0.16 * np.clip(1 - away / 2.5, 0, 1) ** 1.5
    dark = np.clip(1.12 - np.abs(along) / 27, 0.1, 1)[:, None]
    enamel = (1 - 0.25 * height + 0 * along)[..., None] * _ENAMEL
    gap = np.clip(1 - (away - 0.12) / 0.3, 0, 1) * (0.55 + 0.45 * height)
    colour = _mix(enamel, _GAP, np.maximum(gap, np.clip((edge - height) / 0.05, 0, 1)))
    return _mix(colour, _GUM, np.clip((height - root) / 0.06, 0, 1)) * dark


def _mix(colour: np.ndarray, other, weight: np.ndarray) -> np.ndarray:
    return colour + weight[..., None] * (np.asarray(other) - colour)


def _length(wide: float, deep: float) -> tuple[np.ndarray, np.ndarray]:
    """Angles from the middle of half an ellipse to its end, and metres from there to each."""
    turn = np.linspace(0, np.pi / 2, _STEPS)
    steps = np.hypot(np.diff(wide * np.sin(turn)), np.diff(deep * np.cos(turn)))
    return turn, np.concatenate([[0], np.cumsum(steps)])
