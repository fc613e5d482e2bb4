"""Paints teeth on the two arches of the base mesh, which are plain bands: crowns, gaps between them, gums.

An arch is approximated by half an ellipse. Crowns get darker towards the back, where light through the lips does not reach."""

import numpy as np

WIDTH, HEIGHT = 512, 96
"""Pixels of the image: an arch from left to right, lower teeth in the lower half."""
_SPAN = 0.15
"""Metres of an arch that the image shows."""
_CROWNS = ((5.2, 5.8, 6.8, 7.0, 7.0, 11.0, 10.5), (8.5, 6.5, 7.5, 7.0, 7.0, 10.0, 10.0))
"""Widths of the crowns in millimetres from the middle outwards, lower and upper (Wheeler's Dental Anatomy)."""
_ENAMEL, _GUM, _GAP = (0.66, 0.61, 0.51), (0.30, 0.085, 0.08), (0.16, 0.10, 0.075)
_ROOT, _EDGE = 0.62, 0.12
"""Between cutting edge (0) and root (1): where the gum begins, and up to where the corners of crowns are round."""
_INSIDE = 0.84
"""Points within this share of the ellipse's radii are on the inner side of the teeth."""
_STEPS = 400


def uvs(points: np.ndarray, quads: np.ndarray, upper: bool) -> np.ndarray:
    """Return texture coordinates ``(m, 4, 2)`` of the ``quads`` (m, 4) of one arch, rows of ``points`` (n, 3) in metres."""
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
    """Return the image ``(HEIGHT, WIDTH, 3)`` of both arches in linear RGB, for coordinates of :func:`uvs`."""
    along = (np.arange(WIDTH) + 0.5) / WIDTH * 1000 * _SPAN - 500 * _SPAN
    height = np.clip(((np.arange(HEIGHT // 2) + 0.5) / (HEIGHT // 2) - 0.03) / 0.94, 0, 1)[:, None]
    return np.concatenate([_arch(along, height, crowns) for crowns in _CROWNS])


def _arch(along: np.ndarray, height: np.ndarray, crowns: tuple[float, ...]) -> np.ndarray:
    """Return colours ``(rows, columns, 3)`` at ``along`` (mm from the arch's middle) and ``height`` (rows, 1), 0..1."""
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


def _mix(colour: np.ndarray, other: tuple[float, float, float], weight: np.ndarray) -> np.ndarray:
    return colour + weight[..., None] * (np.asarray(other) - colour)


def _length(wide: float, deep: float) -> tuple[np.ndarray, np.ndarray]:
    """Return angles from the middle of half an ellipse to its end, and the arc lengths to them in metres."""
    turn = np.linspace(0, np.pi / 2, _STEPS)
    steps = np.hypot(np.diff(wide * np.sin(turn)), np.diff(deep * np.cos(turn)))
    return turn, np.concatenate([[0], np.cumsum(steps)])
