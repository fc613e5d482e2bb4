"""The core of a gesture: its stroke and early hold, kept unchanged while the transitions around it are regenerated."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import UsageError
from ..motion import limits, rest, skeleton
from ..motion.hands import Hands
from ..motion.motion import Motion, sample_directions
from ..motion.ways import ARMS
from . import gestures
from .gestures import Gesture

_SIDES = ((3, 4, 5), (6, 7, 8))
_HOLD_SECONDS = 0.2
"""Seconds of the hold that belong to the core, at most."""
_SLOWDOWN_MARGIN = 1.05
"""Extra factor on the duration of a stroke that is slowed down, since its transitions are fast, too."""
_MIN_FRAMES = 3
"""Least distance in frames between the first and the last frame of a core."""
_ROUNDING = 1e-6
"""Tolerance in frames against rounding errors."""
_MAX_PASSES = 6
"""Most scale factors tried until a core has the requested size."""
_BOTH_SHARE = 0.65
"""Share of the faster hand's speed from which the slower hand surely counts as part of the gesture."""
_DRIFT = 0.25
"""Share of its path through a span that an idle arm travels during the other arm's stroke."""


@dataclass(frozen=True)
class StrokeCore:
    """Edge ``directions`` ``(n, 9, 3)`` and ``hands`` of ``n`` consecutive frames, from frame ``first`` on."""

    first: int
    directions: np.ndarray
    hands: Hands | None = None

    @property
    def frames(self) -> np.ndarray:
        """The frame numbers ``(n,)``."""
        return self.first + np.arange(len(self.directions))

    @property
    def last(self) -> int:
        """The number of the last frame."""
        return self.first + len(self.directions) - 1


def core_at(motion: Motion, gesture: Gesture, to: float, trunk: bool = False) -> StrokeCore:
    """Return the core of a gesture, moved in time so that its stroke is at ``to`` seconds.

    Head and trunk are those of the motion at the new time, or move along if ``trunk`` is set. Raises :class:`UsageError`
    where the recording has no room for it."""
    fps, frames = motion.fps, len(motion.directions)
    shift = (to - gesture.at) * fps
    start, stop = gesture.stroke * fps - 1, min(gesture.release, gesture.hold + _HOLD_SECONDS) * fps + 1
    first, last = int(np.ceil(start + shift)), int(np.floor(stop + shift))
    if first < 1 or last > frames - 2:
        raise UsageError(f"There is no room for a gesture at {to:.2f} s.", "Choose a time farther from beginning and end.")
    part = motion.at(np.arange(first, last + 1) - shift, fps)
    directions = part.directions.copy()
    if not trunk:
        directions[:, :3] = motion.directions[first : last + 1, :3]
    return StrokeCore(first, directions, part.hands)


def swap_hand(core: StrokeCore, hand: str, asked: str, ends: np.ndarray, span: tuple[int, int]) -> StrokeCore:
    """Return a core was_active by the hand ``asked`` instead of ``hand``.

    An arm that becomes idle is interpolated from the first to the second of the poses ``ends`` ``(2, 9, 3)``, which are those
    at both ends of the ``span`` (first frame, and the one after the last)."""
    directions = core.directions.copy()
    mirrored = skeleton.mirror(core.directions)
    source = _leader(core) if hand == "both" and asked != "both" else hand
    active = (asked in ("left", "both"), asked in ("right", "both"))
    was_active = (source in ("left", "both"), source in ("right", "both"))
    share = np.clip((core.frames - span[0] + 1) / (span[1] - span[0] + 1), 0, 1)
    share = np.median(share) + _DRIFT * (share - np.median(share))  # most of its path lies before and after the stroke
    for side, edges in enumerate(_SIDES):
        edges = list(edges)
        if active[side] and not was_active[side]:
            directions[:, edges] = mirrored[:, edges]
        elif not active[side]:
            directions[:, edges] = rest.slerp(ends[0, edges], ends[1, edges], (share**2 * (3 - 2 * share))[:, None])
    hands = core.hands
    if hands is not None:
        opposite = hands.mirrored()
        swapped = [new and not old for new, old in zip(active, was_active, strict=True)]
        parts = [np.where(np.reshape(swapped, (1, 2, 1)), mirror, own)
                 for own, mirror in zip((hands.knuckles, hands.palms, hands.shape),
                                         (opposite.knuckles, opposite.palms, opposite.shape), strict=True)]  # fmt: skip
        hands = Hands.of(*parts)
    return replace(core, directions=_limit(directions), hands=hands)


def _leader(core: StrokeCore) -> str:
    """Return the faster hand of a core of both."""
    left, right = gestures.wrist_speeds(core.directions).max(0)
    return "left" if left > right else "right"


def scale_core(core: StrokeCore, size: float, hand: str) -> StrokeCore:
    """Return a core whose leading wrist travels ``size`` times as far; its arms are scaled about the middle of their motion."""
    if abs(size - 1) < 1e-3:
        return core
    target, factor = size * _travel(core.directions), size
    low, high = (0.05, 1.0) if size < 1 else (1.0, 2.5 * size)
    arms = arm_edges(hand if size > 1 else "both")  # a stroke smaller than that of the other arm would no longer lead
    for _ in range(_MAX_PASSES):
        scaled = _scale(core.directions, factor, arms)
        travel = _travel(scaled)
        if abs(travel - target) < 0.01 * target:
            break
        factor = float(np.clip(factor * target / max(travel, 1e-6), low, high))
    if hand == "both" and size > 1:
        scaled = _balance(core, scaled, factor)
    hands = core.hands.moved_with_arms(core.directions, scaled) if core.hands is not None else None
    return replace(core, directions=scaled, hands=hands)


def _balance(core: StrokeCore, scaled: np.ndarray, factor: float) -> np.ndarray:
    """Enlarge the slower arm of a scaled stroke of both hands, if joint limits held it back, until it takes part as before."""
    slower = arm_edges("right" if _leader(core) == "left" else "left")
    share = min(_speed_share(core.directions), _BOTH_SHARE)
    for more in (1.15, 1.3, 1.5, 1.75, 2.0):
        if _speed_share(scaled) >= share:
            break
        scaled = scaled.copy()
        scaled[:, slower] = _scale(core.directions, more * factor, slower)[:, slower]
    return scaled


def limit_core_speed(core: StrokeCore, at: float, motion: Motion, fastest: Sequence[float], trunk: bool = False) -> StrokeCore:
    """Return a core whose wrists do not exceed the ``fastest`` speed and acceleration, in metres and frames.

    If they do, it is stretched around its stroke at ``at`` seconds. Head and trunk are those of the ``motion`` unless
    ``trunk`` is set."""
    paths = skeleton.wrists(core.directions)
    over = [np.linalg.norm(np.diff(paths, n=n, axis=0), axis=-1).max(initial=0) / max(limit, 1e-6)
            for n, limit in enumerate(fastest, 1)]  # fmt: skip
    return core if max(over) <= 1 else stretch_core(core, at, motion, max(over[0], np.sqrt(over[1])) * _SLOWDOWN_MARGIN, trunk)


def stretch_core(
    core: StrokeCore, at: float, motion: Motion, slower: float, trunk: bool = False, later: float = 0.0
) -> StrokeCore:
    """Return a core stretched in time by ``slower`` around its stroke at ``at`` seconds, and delayed by ``later`` seconds.

    It is returned unchanged where the ``motion`` has no room for that, or it would be too short."""
    frame, to = at * motion.fps, (at + later) * motion.fps
    first, last = to - slower * (frame - core.first), to + slower * (core.last - frame)
    first, last = np.ceil(first - _ROUNDING), np.floor(last + _ROUNDING)
    if first < 1 or last > len(motion.directions) - 2 or last - first < _MIN_FRAMES:
        return core
    times = np.arange(int(first), int(last) + 1)
    rows = np.clip((times - to) / slower + frame - core.first, 0, len(core.directions) - 1)
    directions = sample_directions(core.directions, rows)
    if not trunk:
        directions[:, :3] = motion.directions[times, :3]
    limited = _limit(directions)
    return StrokeCore(int(first), limited, core.hands and core.hands.at(rows).moved_with_arms(directions, limited))


def blend_core(core: StrokeCore, poses: np.ndarray, share: float) -> StrokeCore:
    """Return a core with the arms' mean directions moved by a ``share`` towards those of other ``poses`` ``(n, 9, 3)``."""
    shifted, arms = core.directions.copy(), list(ARMS)
    shifted[:, arms] += share * (poses[:, arms].astype(float) - core.directions[:, arms]).mean(0)
    shifted = _limit(shifted)
    return replace(core, directions=shifted, hands=core.hands and core.hands.moved_with_arms(core.directions, shifted))


def scale_other_arm(core: StrokeCore, hand: str, share: float) -> StrokeCore:
    """Return a core whose other arm (the slower one if ``hand`` is both) travels ``share`` times as far."""
    if share == 1:
        return core
    scaled = core.directions.copy()
    other = arm_edges("right" if (_leader(core) if hand == "both" else hand) == "left" else "left")
    scaled[:, other] = _scale(core.directions, share, other)[:, other]
    return replace(core, directions=scaled, hands=core.hands and core.hands.moved_with_arms(core.directions, scaled))


def _speed_share(directions: np.ndarray) -> float:
    """Return the slower wrist's highest speed as a share of the faster one's."""
    speed = gestures.wrist_speeds(directions).max(0)
    return float(speed.min() / max(speed.max(), 1e-6))


def _scale(directions: np.ndarray, factor: float, arms: list[int]) -> np.ndarray:
    """Scale the motion of some arms by ``factor`` about the pose halfway between their first and last one."""
    result, poses = directions.copy(), directions[:, arms].astype(float)
    centre = rest.slerp(poses[0], poses[-1], 0.5 * np.ones(len(arms)))
    result[:, arms] = rest.slerp(centre, poses, np.full(len(arms), factor))
    return _limit(result)


def arm_edges(hand: str) -> list[int]:
    """Return the edges of the arm of a hand, or of both arms."""
    return [edge for side, edges in zip(("left", "right"), _SIDES, strict=True) if hand in (side, "both") for edge in edges]


def _limit(directions: np.ndarray) -> np.ndarray:
    """Normalize directions and keep them within the limits of joints and body."""
    return limits.enforce_limits(skeleton.normalize(directions).astype(np.float32))


def _travel(directions: np.ndarray) -> float:
    """Return the metres that the wrist that moves more travels."""
    return float(gestures.wrist_speeds(directions).sum(0).max() / skeleton.FPS)


def reach_core(motion: Motion, side: int, first: int, last: int, place: np.ndarray) -> StrokeCore:
    """Return a core that holds a wrist (0 left, 1 right) at ``place`` from frame ``first`` to ``last``.

    ``place`` is in metres from the spine joint. The elbow stays in its plane. Where the shoulder moves too far from it the arm
    is stretched towards it. Raises :class:`UsageError` for a place that most frames cannot reach."""
    directions = motion.directions[first : last + 1].astype(float).copy()
    upper, lower = skeleton.ARMS[side]
    lengths = skeleton.LENGTHS[[upper, lower]].astype(float)
    positions = skeleton.to_positions(directions)
    shoulder, elbow = (positions[:, edge_child] for edge_child in (skeleton.EDGES[upper][0], skeleton.EDGES[upper][1]))
    offset = np.asarray(place, float) - shoulder
    reach = np.linalg.norm(offset, axis=-1, keepdims=True)
    least, most = abs(lengths[0] - lengths[1]) + 0.05, lengths.sum() - 1e-3
    if 2 * (reach >= most).sum() > len(reach) or (reach <= least).any():
        raise UsageError("The hand cannot reach that place.", "Give one that is nearer to the shoulder, or farther from it.")
    upper_arm = elbow - shoulder
    bends = skeleton.length(np.cross(offset / reach, upper_arm))[:, None] > 1e-4
    aside = np.where(bends, upper_arm, np.cross(offset, [0.0, 0.0, 1.0]))
    bent = skeleton.bent_limb(offset, aside, *lengths.tolist(), most=most / lengths.sum())
    directions[:, [upper, lower]] = np.stack(bent, 1)
    hands = motion.hands[first : last + 1] if motion.hands is not None else None
    directions = directions.astype(np.float32)
    return StrokeCore(first, directions, hands and hands.moved_with_arms(motion.directions[first : last + 1], directions))
