"""Quiets parts of a take: strokes are taken out, and the arms go on to the next one, or home, without making another.

Ways are tried from the most natural to the slowest, and the first that leaves the strokes that are to stay, no other one, and
no sudden join is used."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import UsageError
from ..motion import limits, rest, skeleton, ways
from ..motion.interpolation import true_runs
from ..motion.motion import Motion
from ..synthesis import strokes
from ..words import hints
from . import frame_ranges, gestures, regeneration, semantic_gestures, transitions
from .edits import RESTS
from .gestures import BEAT, Gesture
from .regeneration import Regenerator
from .stroke_core import ARMS, StrokeCore
from .targets import LANDS, LOOSE, State

_PAUSE = 2.4
"""Seconds between strokes from which hands go home meanwhile."""
_BESIDE = 1.6
"""Seconds beside what is taken out that a way may use where no other stroke lies."""
_STOP_FRAMES = (8, 5)
"""Frames in which the speed at either end of a way is lost or gained."""
_DEPTHS = (1.0, 0.7, 0.45)
"""Shares of the way home that are tried in a range at rest: where little time is left, a whole one may be a stroke."""
_AROUND = 2.0
"""Seconds around a way in which strokes are counted."""
_SUDDEN = 4.0
"""What joins that are twice as sudden as the take cost, in strokes too many."""


@dataclass(frozen=True)
class _Gap:
    """A part of a take without strokes: it may begin and end at these frames, and ``free`` strokes within cost nothing."""

    starts: tuple[int, ...]
    stops: tuple[int, ...]
    free: int = 0
    over_home: bool = False


def delete(filler: Regenerator, state: State, edit: dict, apart: float) -> tuple[State, float]:
    """Take out the gestures at ``at`` (seconds, or several), and no other."""
    if apart:
        return state, np.inf  # all ways were tried
    times = edit["at"] if isinstance(edit["at"], list) else [edit["at"]]
    found, missing = gestures.find_gestures(state.motion), []
    gone: list[Gesture] = []
    for at in times:
        one = gestures.nearest_of(found, at)
        missing += [at] if one is None else []
        gone += [one] if one is not None and one not in gone else []
    if not gone:
        nearest = gestures.nearest_of(found, times[0], np.inf)
        remedy = f"The nearest is at {nearest.at:.2f} s." if nearest else "The take has none at all."
        raise UsageError(f"there is no gesture at {times[0]:.2f} s.", remedy)
    if missing:
        which = ", ".join(f"{at:.2f}" for at in missing)
        state = replace(state, warnings=(*state.warnings, f"There is no gesture to delete at {which} s."))
    return _without(filler, state, edit, found, gone)


def rest_range(filler: Regenerator, state: State, edit: dict, apart: float) -> tuple[State, float]:
    """Quiet the range from ``from`` to ``to`` seconds, as ``how`` says."""
    if apart:
        return state, np.inf
    motion, how = state.motion, edit.get("how", RESTS[0])
    start, stop = edit["from"], min(edit["to"], motion.duration)
    if stop <= start:
        raise UsageError("the recording ends before that.", f"Give times within 0 to {motion.duration:.1f} s.")
    if how == "calmer":
        return _calm(filler, state, start, stop), 0.0
    found = gestures.find_gestures(motion)
    inside = [one for one in found if start <= one.at <= stop]
    if how == "fewer":
        least = sorted(inside, key=lambda one: (one.kind != BEAT, one.size))[: (len(inside) + 1) // 2]
        return _without(filler, state, edit, found, least) if least else (state, 0.0)
    return _bridge(filler, state, edit, found, inside, [_range_gap(motion, found, inside, start, stop)])


def _range_gap(motion: Motion, found: Sequence[Gesture], inside: Sequence[Gesture], start: float, stop: float) -> _Gap:
    """Return the gap of a range at rest; it may end where the next stroke begins. Going home may be a stroke of its own."""
    frames, fps = len(motion.directions), motion.fps
    before = [one.hold for one in found if one not in inside and one.at < start]
    after = [one for one in found if one not in inside and one.at > stop]
    first = max(round(start * fps), int(np.ceil(before[-1] * fps)) + 1 if before else 1, 1)
    ends = [stop, after[0].begin, after[0].stroke] if after else [stop, motion.duration]
    stops = [round(min(max(end, stop - 1), stop + _BESIDE, after[0].stroke if after else np.inf) * fps) for end in ends]
    if not after and frames - stops[-1] < 2 * fps:
        stops = [frames]
    stops = sorted({min(max(one, first + 1), frames) for one in stops}, key=lambda one: abs(one - stop * fps))
    return _Gap((first,), tuple(stops), 1, True)


def _without(
    filler: Regenerator, state: State, edit: dict, found: Sequence[Gesture], gone: Sequence[Gesture]
) -> tuple[State, float]:
    """Take out the gestures ``gone`` of those ``found``."""
    gaps, fps, frames = [], state.motion.fps, len(state.motion.directions)
    for is_gone, run in itertools.groupby(range(len(found)), key=lambda row: found[row] in gone):
        rows = list(run)
        if not is_gone:
            continue
        low = int(np.ceil(found[rows[0] - 1].hold * fps)) + 1 if rows[0] else 1
        high = int(found[rows[-1] + 1].stroke * fps) if rows[-1] + 1 < len(found) else frames
        first, last = found[rows[0]], found[rows[-1]]
        starts = [first.stroke - seconds for seconds in (frame_ranges.LEAST, frame_ranges.WANTED, _BESIDE)]
        stops = [last.hold + seconds for seconds in (frame_ranges.LEAST, frame_ranges.WANTED, _BESIDE)]
        starts = [int(min(max(one * fps, low), first.stroke * fps)) for one in starts]
        stops = [min(int(np.ceil(max(min(one * fps, high), last.hold * fps + 1))), frames) for one in stops]
        if rows[0] and starts[-1] <= low:  # from within the end of the stroke before, and into the beginning of the next one
            starts.append(int(np.ceil(found[rows[0] - 1].at * fps)) + 1)
        if rows[-1] + 1 < len(found) and stops[-1] >= high:
            stops.append(int(found[rows[-1] + 1].at * fps) - 1)
        starts, stops = (ends + ends[-1:] * (4 - len(ends)) for ends in (starts, stops))
        gaps.append(_Gap(tuple(starts), tuple(stops)))
    return _bridge(filler, state, edit, found, gone, gaps)


def _bridge(
    filler: Regenerator, state: State, edit: dict, found: Sequence[Gesture], gone: Sequence[Gesture], gaps: Sequence[_Gap]
) -> tuple[State, float]:
    """Lead the arms through ``gaps`` without the gestures ``gone``; return the state, and its miss."""
    before, held = state.motion, state.held
    stay = [one.at for one in found if one not in gone]
    seed, spans = filler.attempt_seed(edit, 0), [(min(one.starts), max(one.stops)) for one in gaps]
    meant = [span for span in spans if any(one.kind != BEAT and span[0] <= one.at * before.fps < span[1] for one in gone)]
    performed = before
    if any(not one.over_home for one in gaps) or meant:
        performed = filler.fill(before, spans, None, seed, held, whole=bool(meant))[0]
    made = before.directions.copy()
    inside = frame_ranges.frame_mask(meant, len(made)) & ~held
    made[inside, :3] = performed.directions[inside, :3]  # a nod that belonged to a gesture goes with it
    home = filler.rest_pose(before)
    excess, places = 0, []
    for gap, span in zip(gaps, spans, strict=True):
        there = stay + [one.at for one in gone if one.at * before.fps >= span[1]]  # those of later gaps still are
        made, place, cost = _best_way(replace(before, directions=made), performed, home, gap, span, held, there)
        places.append(place)
        excess += cost >= 1
    motion = replace(before, directions=made)
    if before.hands is not None:  # fingers as the network moves them with arms on these ways
        first, last = min(start for start, _ in places), max(stop for _, stop in places)
        core = StrokeCore(first, made[first:last])
        motion = replace(filler.fill(before, places, core, seed, held)[0], directions=made)
    stayed = [one for one in gestures.meant_gestures(before) if gestures.nearest_of(gone, one[1], LOOSE) is None]
    motion = semantic_gestures.record_meant(motion, [(0, len(made))], stayed)
    return replace(state, motion=motion), 1.0 + excess if excess else 0.0


def _best_way(
    before: Motion, performed: Motion, home: np.ndarray, gap: _Gap, span: frame_ranges.FrameRange, held: np.ndarray,
    stay: Sequence[float]
) -> tuple[np.ndarray, frame_ranges.FrameRange, float]:  # fmt: skip
    """Return directions with the best way through a gap, the frames that it changes, and the strokes by which it misses."""
    best, least, place = before.directions, np.inf, span
    impossible = float(regeneration.is_implausible(before.directions[max(span[0] - 2, 0) : span[1] + 2]))
    for start, stop, way in _ways(before.directions, performed, home, gap, span, held):
        if _cost(before, way, span, stay, gap.free) >= least:
            continue
        way[start:stop][~held[start:stop]] = limits.enforce_limits(way[start:stop])[~held[start:stop]]
        made, places = replace(before, directions=way), [(start, stop)]
        strain = max(regeneration.join_strain(before, made, places) - impossible, 0)
        if strain > 0:
            kept = held.copy()
            kept[:start], kept[stop:] = True, True
            made, strain = transitions.ease_joins(before, made, places, kept)
            if strain > impossible:  # the strokes beside it may end sooner or begin later
                made, strain = transitions.ease_joins(before, made, places, held)
                changed = np.flatnonzero((made.directions != before.directions).any(axis=(1, 2)))
                start, stop = min(start, int(changed[0])), max(stop, int(changed[-1]) + 1)
            strain = max(strain - impossible, 0)
        cost = _cost(before, made.directions, span, stay, gap.free) + _SUDDEN * strain
        if cost < least - 1e-6:
            best, least, place = made.directions, cost, (start, stop)
        if least <= 0:
            break
    return best, place, least


def _ways(
    directions: np.ndarray, performed: Motion, home: np.ndarray, gap: _Gap, span: frame_ranges.FrameRange, held: np.ndarray
) -> Iterator[tuple[int, int, np.ndarray]]:
    """Yield (first frame, the one after the last, directions) of ways through a gap, the most natural ones first."""
    arms, fps = np.array(ARMS), skeleton.FPS
    if not gap.over_home:
        made = directions.copy()
        free = np.arange(*span)[~held[slice(*span)]]
        made[np.ix_(free, arms)] = performed.directions[np.ix_(free, arms)]
        yield *span, made
    depths = _DEPTHS if gap.over_home else _DEPTHS[:1]
    for depth, (start, stop), frames in itertools.product(depths, _bounds(gap), _STOP_FRAMES):
        low = home if depth == 1 else _raised(directions, home, start, stop, depth)
        count = (stop - start) / fps
        over_home = [one for one in itertools.product(ways.HOME, ways.RISE) if sum(one) <= count]
        over_home = sorted(over_home, key=sum) if gap.over_home else over_home[:: len(ways.RISE) + 1]
        if gap.over_home and not over_home:
            over_home = [(ways.HOME[0], ways.RISE[0])]
        straight = [] if gap.over_home else list(ways.WAYS)
        plans = [*itertools.product(over_home, ways.PACES)], [(way, ways.PACES[0]) for way in straight]
        for plan, pace in itertools.chain(*plans) if count > _PAUSE else itertools.chain(*plans[::-1]):
            made = directions.copy()
            for begin, end in true_runs(~held[start:stop]).tolist():
                part = ways.path(directions, low, start + begin, start + end, plan, pace, frames)
                made[start + begin : start + end, arms] = part[:, arms]
            yield start, stop, made


def _raised(directions: np.ndarray, home: np.ndarray, start: int, stop: int, depth: float) -> np.ndarray:
    """Return the body at rest ``(frames, 9, 3)``, in a gap only so far on the way there from the poses at its ends."""
    ends = directions[[max(start - 1, 0), min(stop, len(directions) - 1)]]
    between = rest.slerp(ends[0], ends[1], np.linspace(0, 1, stop - start)[:, None])
    low = home.copy()
    low[start:stop] = rest.slerp(between, home[start:stop], depth)
    return low


def _bounds(gap: _Gap) -> list[tuple[int, int]]:
    """Return the frames from which and to which ways through a gap are tried: narrow ones, then wider ones."""
    if len(gap.starts) == 1 or len(gap.stops) == 1:
        return list(itertools.product(gap.starts, gap.stops))
    pairs = list(zip(gap.starts, gap.stops, strict=True))
    return [*pairs, (gap.starts[-2], gap.stops[-1]), (gap.starts[-1], gap.stops[-2])]


def _cost(before: Motion, directions: np.ndarray, span: frame_ranges.FrameRange, stay: Sequence[float], free: int) -> float:
    """Return how many strokes a way adds around a span beyond those that ``stay``, and of those how many it moves or loses."""
    reach = round(_AROUND * before.fps)
    low, high = max(span[0] - 2 * reach, 0), min(span[1] + 2 * reach, len(directions))
    inner = (span[0] - reach) / before.fps, (span[1] + reach) / before.fps
    found = [low / before.fps + one for one in strokes.stroke_times(directions[low:high], before.fps)]
    near = [at for at in stay if inner[0] <= at <= inner[1]]
    lost = sum(all(abs(one - at) > LANDS for one in found) for at in near)
    others = [one for one in found if inner[0] <= one <= inner[1] and all(abs(one - at) > LANDS for at in stay)]
    within = sum(span[0] <= one * before.fps < span[1] for one in others)
    return lost + len(others) - min(within, free)


def _calm(filler: Regenerator, state: State, start: float, stop: float) -> State:
    """Bring the arms nearer to rest in a range, as ``{calm}`` does in a transcript."""
    motion, arms = state.motion, np.array(ARMS)
    time = np.arange(len(motion.directions)) / motion.fps
    share = hints.envelope(time, start, stop) * ~state.held
    size = 1 + (hints.SIZES["calm"] - 1) * share
    scaled = rest.scale_amplitude(motion.directions, size, filler.rest_pose(motion))
    directions = motion.directions.copy()
    rows = np.flatnonzero(share > 0)
    directions[np.ix_(rows, arms)] = limits.enforce_limits(scaled)[np.ix_(rows, arms)]
    hands = motion.hands and motion.hands.moved_with_arms(motion.directions, directions)
    if hands is not None and motion.hands is not None and len(rows):
        first, last = int(rows[0]), int(rows[-1]) + 1
        hands = regeneration.splice_hands(motion.hands, first, hands[first:last], share[first:last] > 0)
    return replace(state, motion=replace(motion, directions=directions, hands=hands))
