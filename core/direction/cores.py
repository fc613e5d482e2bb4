"""The core of a gesture, its stroke and the first of its hold: it is kept to the bit while the ways around it are made anew."""

from dataclasses import dataclass, replace

import numpy as np

from ..errors import UsageError
from ..motion import limits, rest, skeleton
from ..motion.hands import Hands
from ..motion.motion import Motion, cubic
from . import gestures
from .gestures import Gesture

ARMS = (3, 4, 5, 6, 7, 8)
"""Edges from the neck to the wrists."""
_SIDES = ((3, 4, 5), (6, 7, 8))
_HELD = 0.2
"""Seconds of the hold that belong to the core."""
_UNHURRIED = 1.05
"""By how much longer than it must a stroke takes that would be too fast, since its way to and from it is, too."""
_SHORT = 3
"""Frames from the first to the last that a core has at least."""
_WHOLE = 1e-6
"""Frames by which rounding may miss a whole one."""
_PASSES = 6
"""Ways that are tried at most until a core is as large as it is to be."""
_EQUAL = 0.65
"""Share of the faster hand's speed at which the other one surely makes a gesture with it."""
_DRIFT = 0.25
"""Share of its quiet way through a span that an arm with nothing to do goes while the other one makes its stroke."""


@dataclass(frozen=True)
class Core:
    """``directions`` ``(n, 9, 3)`` and ``hands`` of frames from ``first`` on."""

    first: int
    directions: np.ndarray
    hands: Hands | None = None

    @property
    def frames(self) -> np.ndarray:
        """Numbers of its frames."""
        return self.first + np.arange(len(self.directions))

    @property
    def last(self) -> int:
        """The last of its frames."""
        return self.first + len(self.directions) - 1


def carried(motion: Motion, gesture: Gesture, to: float, trunk: bool = False) -> Core:
    """The core of a motion's gesture with its stroke at ``to`` seconds; head and trunk are those of there unless ``trunk``.

    Raises :class:`UsageError` where the recording has no room for it.
    """
    fps, frames = motion.fps, len(motion.directions)
    shift = (to - gesture.at) * fps
    start, stop = gesture.stroke * fps - 1, min(gesture.release, gesture.hold + _HELD) * fps + 1
    first, last = int(np.ceil(start + shift)), int(np.floor(stop + shift))
    if first < 1 or last > frames - 2:
        raise UsageError(f"There is no room for a gesture at {to:.2f} s.", f"Give a time within 0 to {motion.duration:.1f} s.")
    part = motion.at(np.arange(first, last + 1) - shift, fps)
    directions = part.directions.copy()
    if not trunk:
        directions[:, :3] = motion.directions[first : last + 1, :3]
    return Core(first, directions, part.hands)


def by_hand(core: Core, hand: str, asked: str, ends: np.ndarray, span: tuple[int, int]) -> Core:
    """A core made by another hand: ``hand`` did it, ``asked`` is to; an arm with nothing to do goes quietly from the first to
    the second of the poses ``ends`` ``(2, 9, 3)`` that stand at both ends of the ``span``.
    """
    directions = core.directions.copy()
    mirrored = skeleton.mirror(core.directions)
    source = _leader(core) if hand == "both" and asked != "both" else hand
    wanted = (asked in ("left", "both"), asked in ("right", "both"))
    had = (source in ("left", "both"), source in ("right", "both"))
    share = np.clip((core.frames - span[0] + 1) / (span[1] - span[0] + 1), 0, 1)
    share = np.median(share) + _DRIFT * (share - np.median(share))  # its way lies before and behind the stroke
    for side, edges in enumerate(_SIDES):
        edges = list(edges)
        if wanted[side] and not had[side]:
            directions[:, edges] = mirrored[:, edges]
        elif not wanted[side]:
            directions[:, edges] = rest.slerp(ends[0, edges], ends[1, edges], (share**2 * (3 - 2 * share))[:, None])
    hands = core.hands
    if hands is not None:
        other = hands.mirrored()
        swapped = [want and not has for want, has in zip(wanted, had, strict=True)]
        parts = [np.where(np.reshape(swapped, (1, 2, 1)), theirs, mine)
                 for mine, theirs in zip((hands.knuckles, hands.palms, hands.shape),
                                         (other.knuckles, other.palms, other.shape), strict=True)]  # fmt: skip
        hands = Hands.of(*parts)
    return replace(core, directions=_human(directions), hands=hands)


def _leader(core: Core) -> str:
    """The hand that is the faster one in a core of both."""
    left, right = gestures.speeds(core.directions).max(0)
    return "left" if left > right else "right"


def sized(core: Core, size: float, hand: str) -> Core:
    """A core whose leading wrist goes ``size`` times as far: the arms of its ``hand``, scaled about the middle of their way."""
    if abs(size - 1) < 1e-3:
        return core
    aim, factor = size * _way(core.directions), size
    low, high = (0.05, 1.0) if size < 1 else (1.0, 2.5 * size)
    arms = arm(hand if size > 1 else "both")  # smaller than the other arm it would no longer lead
    for _ in range(_PASSES):
        made = _scaled(core.directions, factor, arms)
        way = _way(made)
        if abs(way - aim) < 0.01 * aim:
            break
        factor = float(np.clip(factor * aim / max(way, 1e-6), low, high))
    if hand == "both" and size > 1:
        made = _balanced(core, made, factor)
    hands = core.hands.carried(core.directions, made) if core.hands is not None else None
    return replace(core, directions=made, hands=hands)


def _balanced(core: Core, made: np.ndarray, factor: float) -> np.ndarray:
    """A larger stroke of both hands whose slower one, which limits of the body may have held back, takes part as it did."""
    other = arm("right" if _leader(core) == "left" else "left")
    wanted = min(_share(core.directions), _EQUAL)
    for more in (1.15, 1.3, 1.5, 1.75, 2.0):
        if _share(made) >= wanted:
            break
        made = made.copy()
        made[:, other] = _scaled(core.directions, more * factor, other)[:, other]
    return made


def unhurried(core: Core, at: float, motion: Motion, fastest: tuple[float, float], trunk: bool = False) -> Core:
    """A core of a ``motion`` whose wrists are nowhere above the ``fastest`` speed and change of it, in metres from frame to
    frame: where they are, it takes longer, around its stroke ``at`` seconds. Head and trunk stay unless ``trunk``.
    """
    ways = skeleton.wrists(core.directions)
    over = [np.linalg.norm(np.diff(ways, n=n, axis=0), axis=-1).max(initial=0) / max(most, 1e-6)
            for n, most in enumerate(fastest, 1)]  # fmt: skip
    return core if max(over) <= 1 else paced(core, at, motion, max(over[0], np.sqrt(over[1])) * _UNHURRIED, trunk)


def paced(core: Core, at: float, motion: Motion, slower: float, trunk: bool = False, later: float = 0.0) -> Core:
    """A core that takes ``slower`` times as long around its stroke ``at`` seconds, and comes so many seconds ``later``, where
    the ``motion`` has room for it.
    """
    frame, to = at * motion.fps, (at + later) * motion.fps
    first, last = to - slower * (frame - core.first), to + slower * (core.last - frame)
    first, last = np.ceil(first - _WHOLE), np.floor(last + _WHOLE)
    if first < 1 or last > len(motion.directions) - 2 or last - first < _SHORT:
        return core
    times = np.arange(int(first), int(last) + 1)
    rows = np.clip((times - to) / slower + frame - core.first, 0, len(core.directions) - 1)
    directions = cubic(core.directions, rows)
    if not trunk:
        directions[:, :3] = motion.directions[times, :3]
    made = _human(directions)
    return Core(int(first), made, core.hands and core.hands.at(rows).carried(directions, made))


def nearer(core: Core, poses: np.ndarray, share: float) -> Core:
    """A core whose arms make the same stroke nearer to where other ``poses`` ``(n, 9, 3)`` have them, by a ``share`` of it."""
    made, arms = core.directions.copy(), list(ARMS)
    made[:, arms] += share * (poses[:, arms].astype(float) - core.directions[:, arms]).mean(0)
    made = _human(made)
    return replace(core, directions=made, hands=core.hands and core.hands.carried(core.directions, made))


def shared(core: Core, hand: str, share: float) -> Core:
    """A core whose other arm, the slower one where ``hand`` is both, goes ``share`` times as far."""
    if share == 1:
        return core
    made, other = core.directions.copy(), arm("right" if (_leader(core) if hand == "both" else hand) == "left" else "left")
    made[:, other] = _scaled(core.directions, share, other)[:, other]
    return replace(core, directions=made, hands=core.hands and core.hands.carried(core.directions, made))


def _share(directions: np.ndarray) -> float:
    """The slower wrist's highest speed as a share of the faster one's."""
    speed = gestures.speeds(directions).max(0)
    return float(speed.min() / max(speed.max(), 1e-6))


def _scaled(directions: np.ndarray, factor: float, arms: list[int]) -> np.ndarray:
    """Arms whose way is ``factor`` times as long, half of it taken before, half behind what was."""
    result, poses = directions.copy(), directions[:, arms].astype(float)
    centre = rest.slerp(poses[0], poses[-1], 0.5 * np.ones(len(arms)))
    result[:, arms] = rest.slerp(centre, poses, np.full(len(arms), factor))
    return _human(result)


def arm(hand: str) -> list[int]:
    """Edges of the arms that a hand is on."""
    return [edge for side, edges in zip(("left", "right"), _SIDES, strict=True) if hand in (side, "both") for edge in edges]


def _human(directions: np.ndarray) -> np.ndarray:
    return limits.keep_human(skeleton.normalize(directions).astype(np.float32))


def _way(directions: np.ndarray) -> float:
    return float(gestures.speeds(directions).sum(0).max() / skeleton.FPS)


def reaching(motion: Motion, side: int, first: int, last: int, place: np.ndarray) -> Core:
    """The core in which a wrist (0 left, 1 right) stays at ``place`` (metres from the spine joint) from ``first`` to ``last``.

    The elbow stays in the plane that it was in. Raises :class:`UsageError` for what no arm reaches.
    """
    directions = motion.directions[first : last + 1].astype(float).copy()
    upper, lower = skeleton.ARMS[side]
    lengths = skeleton.LENGTHS[[upper, lower]].astype(float)
    positions = skeleton.to_positions(directions)
    shoulder, elbow = (positions[:, edge_child] for edge_child in (skeleton.EDGES[upper][0], skeleton.EDGES[upper][1]))
    way = np.asarray(place, float) - shoulder
    reach = np.linalg.norm(way, axis=-1, keepdims=True)
    if (reach >= lengths.sum() - 1e-3).any() or (reach <= abs(lengths[0] - lengths[1]) + 0.05).any():
        raise UsageError("The hand cannot reach that place.", "Give one that is nearer to the shoulder, or farther from it.")
    along = way / reach
    bent = elbow - shoulder
    across = bent - (bent * along).sum(-1, keepdims=True) * along
    size = np.linalg.norm(across, axis=-1, keepdims=True)
    aside = np.where(size > 1e-4, across / np.maximum(size, 1e-4), np.cross(along, [0.0, 0.0, 1.0]))
    foot = (lengths[0] ** 2 - lengths[1] ** 2 + reach**2) / (2 * reach)
    height = np.sqrt(np.maximum(lengths[0] ** 2 - foot**2, 0))
    joint = foot * along + height * skeleton.normalize(aside)
    directions[:, upper] = skeleton.normalize(joint)
    directions[:, lower] = skeleton.normalize(way - joint)
    hands = motion.hands[first : last + 1] if motion.hands is not None else None
    made = directions.astype(np.float32)
    return Core(first, made, hands and hands.carried(motion.directions[first : last + 1], made))
