"""Windows of talk as the judge sees them: how the hands move, and nothing that tells a capture from another.

Left out on purpose: jerk (a capture's noise), the resting pose and the places of hands, how fast head and trunk move. All
motion is smoothed alike first. Nor how much the other hand does, which differs more between people than from ours.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...motion import skeleton
from ...smoothing import gaussian

SECONDS = 3.0
HOP, SHORT_HOP = 0.5, 0.25
"""Seconds from one window to the next, of performances and of people, of whom there is little."""
SMOOTHING = 0.08
"""Seconds: standard deviation of the Gaussian by which all motion is smoothed."""
LEAST_SPEED = 0.08
"""Metres a second: windows whose faster wrist is slower in the mean are waiting, not talk."""
LEAST_PEAK, LEAST_RISE = 0.1, 0.25
"""Metres a second of the peak of a bell, and the share of the peak by which speed falls to both sides."""
BANDS = ((0.0, 0.6), (0.6, 1.2), (1.2, 2.5))
"""Hz: slow movement, beats, what is quicker."""
_SIZE = round(SECONDS * skeleton.FPS)
_UP = np.array([0.0, -1.0, 0.0])

FEATURES = (
    *("bells a second", "length of bells", "way of bells", "rise of bells"),
    *("slow", "beats", "quick", "beats of the other hand", "unevenness", "waiting"),
    *("net way", "sideways", "upright", "size for its way", "turning", "up over down"),
    *("trunk with arms", "head with arms", "both in time", "both mirrored", "share of the forearm"),
)


@dataclass(frozen=True)
class Windows:
    """Windows of recordings: ``features`` ``(n, 21)``, ``velocity`` ``(n, frames, 3)`` of the leading wrist over its mean
    speed, mirrored to the left; mean ``speed`` ``(n,)`` in m/s, the number of the ``recording``, and
    the second in it at which a window ``begins``.
    """

    features: np.ndarray
    velocity: np.ndarray
    speed: np.ndarray
    recording: np.ndarray
    begins: np.ndarray

    def __len__(self) -> int:
        return len(self.speed)

    def __getitem__(self, rows: np.ndarray) -> "Windows":
        return Windows(*(getattr(self, name)[rows] for name in Windows.__dataclass_fields__))


def joined(parts: Sequence[Windows]) -> Windows:
    """Return several as one."""
    return Windows(*(np.concatenate([getattr(part, name) for part in parts]) for name in Windows.__dataclass_fields__))


def cut(motions: Sequence[np.ndarray], hop: float = HOP) -> Windows:
    """Cut motions ``(frames, 9, 3)`` at 15 fps into windows in which a hand moves, one every ``hop`` seconds."""
    rows: list[tuple[np.ndarray, np.ndarray, float, int, float]] = []
    for number, motion in enumerate(motions):
        motion = smoothed(motion)
        for begin in np.round(np.arange(0, len(motion) - _SIZE - 0.5, hop * skeleton.FPS)).astype(int).tolist():
            part = motion[begin : begin + _SIZE + 1]
            way = np.linalg.norm(np.diff(skeleton.wrists(part), axis=0), axis=-1).sum(0)
            if way.max() < LEAST_SPEED * SECONDS:
                continue
            described = _describe(part if way[0] >= way[1] else skeleton.mirror(part))
            rows.append((*described, float(way.max()) / SECONDS, number, begin / skeleton.FPS))
    if not rows:
        return Windows(np.zeros((0, len(FEATURES))), np.zeros((0, _SIZE, 3)), np.zeros(0), np.zeros(0, int), np.zeros(0))
    return Windows(*(np.array(column) for column in zip(*rows, strict=True)))


def smoothed(motion: np.ndarray) -> np.ndarray:
    """Return unit directions smoothed by :data:`SMOOTHING`."""
    return skeleton.normalize(gaussian(motion, SMOOTHING * skeleton.FPS))


def bells(speed: np.ndarray, least: float = LEAST_PEAK) -> np.ndarray:
    """Return the start, peak and end (frames) ``(n, 3)`` of the bells of a wrist's speed ``(frames,)`` in m/s.

    ``least``: m/s of a bell's peak. Of neighbours between which it falls by less than :data:`LEAST_RISE` of the lower peak,
    the higher one counts for both.
    """
    inner = speed[1:-1]
    tops = np.flatnonzero((inner > speed[:-2]) & (inner >= speed[2:]) & (inner > least)) + 1
    kept: list[int] = []
    for top in tops.tolist():
        while kept and speed[kept[-1] : top].min() > (1 - LEAST_RISE) * min(speed[kept[-1]], speed[top]):
            if speed[kept[-1]] >= speed[top]:
                break
            kept.pop()
        else:
            kept.append(top)
    edges = [0, *(int(a + np.argmin(speed[a:b])) for a, b in zip(kept, kept[1:], strict=False)), len(speed) - 1]
    return np.array([_foot(speed, *each) for each in zip(edges, kept, edges[1:], strict=False)], int).reshape(-1, 3)


def _foot(speed: np.ndarray, start: int, top: int, end: int) -> tuple[int, int, int]:
    """Cut a bell where its speed first falls below a tenth of its peak: what lies beyond is waiting."""
    low = np.flatnonzero(speed[start : end + 1] < 0.1 * speed[top]) + start
    before, after = low[low < top], low[low > top]
    return int(before[-1]) if len(before) else start, top, int(after[0]) if len(after) else end


def band_shares(velocity: np.ndarray) -> list[float]:
    """Return the shares of the power of a velocity ``(frames, 3)`` in each of :data:`BANDS`."""
    power = (np.abs(np.fft.rfft(velocity * np.hanning(len(velocity) + 2)[1:-1, None], n=256, axis=0)) ** 2).sum(-1)
    hertz = np.fft.rfftfreq(256, 1 / skeleton.FPS)
    return [float(power[(hertz >= low) & (hertz < high)].sum() / max(power.sum(), 1e-12)) for low, high in BANDS]


def trunk_speed(motion: np.ndarray) -> np.ndarray:
    """Return how fast the trunk turns and leans ``(frames - 1,)``, of its axis and the line of the shoulders."""
    points = skeleton.to_positions(motion)
    line = skeleton.normalize(points[:, 7] - points[:, 4])
    return np.sqrt(sum((np.diff(axis, axis=0) ** 2).sum(-1) for axis in (motion[:, 0], line)))


def head_speed(motion: np.ndarray) -> np.ndarray:
    """Return how fast the head turns and nods ``(frames - 1,)``."""
    return np.sqrt((np.diff(motion[:, 1:3], axis=0) ** 2).sum((-1, -2)))


def correlation(one: np.ndarray, other: np.ndarray) -> float:
    """Return the correlation of two tracks; 0 where one does not vary."""
    one, other = one - one.mean(), other - other.mean()
    size = np.sqrt((one**2).sum() * (other**2).sum())
    return float((one * other).sum() / size) if size > 1e-9 else 0.0


def _describe(motion: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the features and the velocity of a window whose left hand leads."""
    points = skeleton.wrists(motion)
    velocity = np.diff(points, axis=0) * skeleton.FPS
    speed = np.linalg.norm(velocity, axis=-1)
    lead, path = speed[:, 0], speed.sum(0) / skeleton.FPS
    own, other = bells(lead), bells(speed[:, 1])
    lengths = (own[:, 2] - own[:, 0]) / skeleton.FPS
    ways = [lead[start:end].sum() / skeleton.FPS for start, _, end in own]
    rises = (own[:, 1] - own[:, 0]) / np.maximum(own[:, 2] - own[:, 0], 1)
    spread = points[:, 0].std(0)
    heading = skeleton.normalize(velocity[:, 0])
    turns = (heading[1:] * heading[:-1]).sum(-1)
    up = velocity[:, 0] @ _UP
    mirrored = velocity[:, 1] * [-1, 1, 1]
    angular = np.linalg.norm(np.diff(motion[:, [4, 5]], axis=0), axis=-1).sum(0)
    arms = speed.sum(1)
    features = [
        (len(own) + len(other)) / SECONDS,
        float(np.median(lengths)) if len(own) else SECONDS,
        np.log(max(float(np.median(ways)) if len(own) else path[0], 0.01)),
        float(rises.mean()) if len(own) else 0.5,
        *band_shares(velocity[:, 0]),
        band_shares(velocity[:, 1])[1],
        float(lead.std() / max(lead.mean(), 1e-6)),
        float((lead < 0.3 * lead.mean()).mean()),
        float(np.linalg.norm(points[-1, 0] - points[0, 0]) / max(path[0], 1e-6)),
        float(spread[0] / max(spread.sum(), 1e-6)),
        float(spread[1] / max(spread.sum(), 1e-6)),
        np.log(max(float(np.linalg.norm(spread)), 1e-3) / max(path[0], 1e-3)),
        float((turns * lead[1:]).sum() / max(lead[1:].sum(), 1e-6)),
        np.log(max(up.max(), 0.02) / max((-up).max(), 0.02)),
        correlation(trunk_speed(motion), arms),
        correlation(head_speed(motion), arms),
        correlation(speed[:, 0], speed[:, 1]),
        float((velocity[:, 0] * mirrored).sum() / max(np.sqrt((speed**2).sum(0).prod()), 1e-6)),
        angular[1] / max(angular.sum(), 1e-6),
    ]
    return np.array(features), velocity[:, 0] / max(lead.mean(), 1e-6)
