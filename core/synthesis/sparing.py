"""Spares strokes where the control of rate is below 0, which networks hardly follow: arms go home instead.

Of neighbouring strokes the most telling one stays, in its own frames; between those that stay, both hands go home together,
as far as there is time for it, and rise again (:mod:`ways`)."""

import itertools
from collections.abc import Sequence

import numpy as np

from ..motion import limits, rest, skeleton, ways
from ..motion.interpolation import true_runs
from . import strokes

LEAST = 0.2
"""Share of strokes that stay at a rate of -1: less than a quarter, since a way home can look like a stroke."""
_MEANT = 2.0
"""How much faster a beat must be than a gesture with a meaning to stay instead of it."""
_HOLD, _FADES, _FAR = 0.5, (4, 7, 11), (1.0, 0.6, 0.3)
"""Longest time in seconds for which arms stay where a stroke led them; frames in which their speed at a join is lost; shares
of the way home that are tried, since whole ones may lead past the body in haste."""
_SLOW = 0.85 * ways.SLOW
"""Metres a frame at which hands go home; idle arms sway, too."""
_BESIDE, _AROUND = 2, 30
"""Frames beside a way with which its joins are measured, and its strokes counted."""
_ROUNDS = 12
"""Most times that one stroke more is given up where ways home are strokes."""


def spare(
    directions: np.ndarray, rate: np.ndarray | float, home: np.ndarray, meant: Sequence[float] = (),
    fixed: Sequence[int] | np.ndarray = ()
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return directions ``(frames, 9, 3)`` with fewer strokes where ``rate`` is below 0, and how far arms rest ``(frames,)``.

    ``rate`` is a number or ``(frames,)``: from 0 on nothing changes, at -1 a quarter of the strokes stays at most, between
    them proportionally many. ``home`` ``(frames, 9, 3)`` is the body at rest, ``meant`` the seconds of strokes with a meaning,
    ``fixed`` the numbers of frames that are given: neither they nor strokes in them change."""
    share = 1 + (1 - LEAST) * np.clip(np.broadcast_to(rate, len(directions)), -1, 0)
    speed = strokes.wrist_speeds(directions).max(1)
    places = np.array(strokes.stroke_places(speed, skeleton.FPS), int)
    free = np.ones(len(directions), bool)
    free[np.asarray(fixed, int)] = False
    if not (share < 1).any() or not len(places):
        return directions, np.zeros(len(directions))
    near = np.abs(places[:, None] / skeleton.FPS - np.reshape(meant, (1, -1))).min(1, initial=np.inf) < strokes.APART
    telling = speed[places] * np.where(near, _MEANT, 1.0)
    spans, may_go = _spans(speed, places), free[places] & (share[places] < 1)
    stays = _chosen(share[places], telling, may_go)
    most = int(np.ceil(share[places].sum()))
    best: tuple = ()
    for _ in range(_ROUNDS):
        made, away = _led(directions, home, spans, stays, free)
        found = np.array(strokes.stroke_places(strokes.wrist_speeds(made).max(1), skeleton.FPS), int)
        off = 2 * max(len(found) - most, 0) + max(most - len(found), 0), len(found), made, away
        best = min(best or off, off, key=lambda one: one[:2])
        if len(found) <= most or not (stays & may_go).any():
            break
        stays[_dispensable(places, telling, stays, may_go, found)[: max((len(found) - most) // 2, 1)]] = False
    return best[2:]


def _chosen(share: np.ndarray, telling: np.ndarray, may_go: np.ndarray) -> np.ndarray:
    """Return which strokes stay ``(n,)``: of each run whose shares add up to one, the most telling one."""
    stays, due, run = ~may_go, 0.5, []
    for number, part in enumerate(share.tolist()):
        due += part
        run += [number] if may_go[number] else []
        if due >= 1:
            due -= 1
            if run and not stays[number]:
                stays[max(run, key=lambda one: telling[one])] = True
            run = []
    return stays


def _dispensable(
    places: np.ndarray, telling: np.ndarray, stays: np.ndarray, may_go: np.ndarray, found: np.ndarray
) -> list[int]:
    """Return the strokes to give up next, in order: the less telling one on either side of a way that is a stroke, or any."""
    kept = np.flatnonzero(stays)
    ways_between = [at for at in found.tolist() if np.abs(places[kept] - at).min(initial=len(found) + 99) > 3]
    sides = {int(np.searchsorted(places[kept], at)) for at in ways_between}
    beside = {int(kept[one]) for side in sides for one in (side - 1, side) if 0 <= one < len(kept)}
    choice = [one for one in beside if may_go[one]] or [int(one) for one in kept if may_go[one]]
    ordered = sorted(choice, key=lambda one: telling[one])
    return ordered[: (len(ordered) + 1) // 2]


def _spans(speed: np.ndarray, places: np.ndarray) -> list[tuple[int, int]]:
    """Return first frame and the one after the last of each stroke: where wrists are slowest before it, and in a short hold."""
    cores, fps = [strokes.stroke_span(speed.tolist(), int(place)) for place in places], skeleton.FPS
    ends = [(0, 0), *cores, (len(speed) - 1, len(speed) - 1)]
    spans = []
    for (_, before), (start, hold), (after, _) in zip(ends, cores, ends[2:], strict=False):
        low = min(max(before, start - round(strokes.MAX_PREPARATION * fps)), start)
        high = max(min(after, hold + round(_HOLD * fps)), hold)
        begin = start - int(speed[low : start + 1][::-1].argmin())
        spans.append((begin, max(hold + int(speed[hold : high + 1].argmin()), begin) + 1))
    return spans


def _led(
    directions: np.ndarray, home: np.ndarray, spans: Sequence[tuple[int, int]], stays: np.ndarray, free: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return directions whose arms are led past the strokes that do not stay, and how far they rest."""
    made, away, sudden = directions.copy(), np.zeros(len(directions)), _sudden(directions)
    for first, last in true_runs(~stays).tolist():
        start = spans[first - 1][1] if first else 0
        stop = spans[last][0] if last < len(spans) else len(directions)
        for begin, end in (start + true_runs(free[start:stop])).tolist():
            if begin == 0:
                made[0, ways.ARMS] = home[0, ways.ARMS]
            best = np.inf, made[begin:end].copy(), away[begin:end]  # where there is no time for a way that nobody would notice
            for far, fade in itertools.product(_FAR, _FADES):
                part, depth = _way(made, home, begin, end, far, fade)
                made[begin:end, ways.ARMS] = limits.enforce_limits(part)[:, ways.ARMS]
                if _sudden(made[max(begin - _BESIDE, 0) : end + _BESIDE]) <= sudden:
                    best = min(best, (_strokes_in(made, begin, end), made[begin:end].copy(), depth), key=lambda one: one[0])
                made[begin:end] = directions[begin:end]
                if best[0] <= 0:
                    break
            _, made[begin:end], away[begin:end] = best
    return made, away


def _strokes_in(directions: np.ndarray, start: int, stop: int) -> int:
    """Return how many strokes the frames ``start`` to ``stop`` have."""
    near = slice(max(start - _AROUND, 0), stop + _AROUND)
    found = np.array(strokes.stroke_places(strokes.wrist_speeds(directions[near]).max(1), skeleton.FPS), int) + near.start
    return int(((found >= start) & (found < stop)).sum())


def _sudden(directions: np.ndarray) -> float:
    """Return the highest acceleration of a wrist in metres per frame squared."""
    return float(np.linalg.norm(np.diff(skeleton.wrists(directions), n=2, axis=0), axis=-1).max(initial=0))


def _way(
    directions: np.ndarray, home: np.ndarray, start: int, stop: int, far: float, fade: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return directions ``(stop - start, 9, 3)`` of a way home, ``far`` of it where there is time, and how far that is in each
    frame."""
    count, low, high = stop - start, directions[max(start - 1, 0)], directions[min(stop, len(directions) - 1)]
    ends = np.stack([low, high]), home[[start, stop - 1]]
    long = np.linalg.norm(np.diff([skeleton.wrists(one) for one in ends], axis=0)[0], axis=-1).max(-1)
    down, up = long / _SLOW + 4
    up = up if stop < len(directions) else 0.0
    depth = min(far, (count + 1) / (down + up))
    t = np.arange(1, count + 1)
    between = rest.slerp(low, high, (t / (count + 1))[:, None]) if up else np.broadcast_to(low, (count, 9, 3))
    low_point = home.copy()
    low_point[start:stop] = rest.slerp(between, home[start:stop], depth)
    plan = down / skeleton.FPS, up / skeleton.FPS
    inside = np.minimum(t / down, (count + 1 - t) / up if up else 1.0)
    return ways.path(directions, low_point, start, stop, plan, "even", fade), depth * np.clip(inside, 0, 1)
