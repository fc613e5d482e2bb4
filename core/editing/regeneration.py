"""Regenerates spans of a take: the generator leads from the poses before to those after, through the frames kept in between."""

import json
import zlib
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..motion import face, limits, rest, skeleton
from ..motion.hands import Hands
from ..motion.interpolation import ramp, simplify_polyline
from ..motion.motion import Motion
from ..synthesis import curves as curves_
from ..synthesis import generation, postprocess
from ..synthesis.request import Request
from ..synthesis.session import Session
from ..synthesis.stages import Stages
from . import frame_ranges, gestures
from .stroke_core import ARMS, StrokeCore

ALL = tuple(range(len(skeleton.EDGES)))
"""All edges of the skeleton."""
PEAKS = "peaks"
"""Key of the provenance of an edited take for its :func:`usual_peaks`."""
_LEAST_PEAKS = 0.05, 0.02
"""Least :func:`usual_peaks`, what nine in ten performances exceed: in a take that hardly moves nothing could be added else."""
_BLEND_FRAMES = 5
"""Frames over which hands blend between their old and their new pose."""
_STRAIGHT, _FACE_EASE = 2e-3, 0.3
"""Most deviation of a feeling from straight lines between its points, and seconds in which a face changes its mood."""
_MARGIN = 2
"""Frames outside a span at either end that its joins are measured with."""


class Regenerator:
    """Regenerates spans of a take of ``request`` with the network of ``session``."""

    def __init__(self, session: Session, request: Request, stages: Stages):
        self.session, self.stages = session, stages
        self.heard, self.performers = session.hear(request, stages)
        self.request = self.performers.request  # with the recording's chance
        self._generated, self._last = np.zeros(self.heard.frames, bool), None

    def turned(self, changes: Sequence[tuple[float, str]], feelings: Sequence[tuple[float, dict]] = ()) -> "Regenerator":
        """Return a regenerator with further changes of style, as (seconds, style), and of feeling, as (seconds, affects), or
        itself if there are none."""
        if not changes and not feelings:
            return self
        return Regenerator(self.session, self.request.turned(changes, self._felt(feelings)), self.stages)

    def _felt(self, feelings: Sequence[tuple[float, dict]]) -> dict[str, list[list[float]]]:
        """Return the curves of the affects that change: before that what slider and voice are together."""
        frames, felt = self.heard.frames, {}
        follows, seconds = curves_.following(self.request, self.heard.affect, frames), np.arange(frames) / skeleton.FPS
        for name in sorted({name for _, values in feelings for name in values}):
            own = np.clip(curves_.sample(self.request, name, frames) + follows.get(name, 0.0), -1, 1) + np.zeros(frames)
            for at, values in sorted((one for one in feelings if name in one[1]), key=lambda one: one[0]):
                own[seconds >= at] = values[name]
            kept = simplify_polyline(own, _STRAIGHT)
            felt[name] = np.stack([seconds[kept], own[kept]], 1).tolist()
        return felt

    def feeling_face(self, motion: Motion, start: float, stop: float) -> Motion:
        """Return the take with its face made anew from ``start`` to ``stop`` seconds."""
        own = self.request.as_performed(motion.directions)
        made = motion.face and postprocess.synthesize_face(self.request, self.heard, motion.meta.get("take", 0), own)
        if motion.face is None or made is None:
            return motion
        made = made.mirrored() if own is not motion.directions else made
        time = np.arange(len(made.weights)) / face.RATE
        share = ramp(time, start - _FACE_EASE, start) * (1 - ramp(time, stop, stop + _FACE_EASE))
        mixed = motion.face.weights + share[:, None] * (made.weights - motion.face.weights)
        return replace(motion, face=replace(motion.face, weights=face.round_weights(mixed)))

    @property
    def style_times(self) -> list[float]:
        """Seconds at which the style changes."""
        return [at for at, _ in self.request.changes]

    def rest_pose(self, motion: Motion) -> np.ndarray:
        """Return the performer's rest pose in every frame of a motion ``(frames, 9, 3)``, breathing and swaying."""
        frames, request = len(motion.directions), self.request
        pose = self.performers.rest(frames) + rest.idle_offsets(frames, motion.fps, request.keyed_seed + request.take)
        return request.as_performed(skeleton.normalize(pose))

    def attempt_seed(self, edit: dict, attempt: int) -> int:
        """Return the seed of an attempt at an edit of this take."""
        request = self.request
        return zlib.crc32(json.dumps([request.seed, request.take, edit, attempt], sort_keys=True).encode())

    def fill(
        self, motion: Motion, places: Sequence[frame_ranges.FrameRange], core: StrokeCore | None, seed: int, held: np.ndarray,
        *, plain: bool = True, whole: bool = False, again: bool = False
    ) -> tuple[Motion, list[tuple[str, float]]]:  # fmt: skip
        """Return the take with ``places`` regenerated through ``core``, and the semantic gestures that appear there.

        Frames marked in ``held`` ``(frames,)`` stay unchanged. ``plain`` allows no requested strokes and no semantic gestures
        (:func:`gestures.meant_gestures`) in the places. ``whole`` regenerates head and trunk too, not the arms alone.
        ``again`` reuses the last generated motion if it covers these places and bends it to this core, since a new one takes
        0.1 s."""
        frames = len(motion.directions)
        poses, kept = motion.directions.copy(), ~frame_ranges.frame_mask(places, frames) | held
        free = np.zeros(0, int) if core is None else core.frames[~held[core.frames]]
        if core is not None:
            poses[free], kept[free] = core.directions[free - core.first], True
        numbers = np.flatnonzero(kept)
        request = replace(self.request, kept=(numbers, poses[numbers]) if len(numbers) else None)
        if self._last is None or not again or (frame_ranges.frame_mask(places, frames) & ~self._generated).any():
            self._generated = frame_ranges.frame_mask(places, frames)
            self._last = self._generate(request, seed, places if plain else ())
        generated = self._last
        directions = motion.directions.copy()
        edges = np.array(ALL if whole else ARMS)
        fresh = np.flatnonzero(~kept)
        directions[np.ix_(fresh, edges)] = generated.directions[np.ix_(fresh, edges)]
        if core is not None:
            if again:
                bent = _bend(generated.directions, places, core)
                directions[np.ix_(fresh, edges)] = bent[np.ix_(fresh, edges)]
            directions[free] = core.directions[free - core.first]
        hands = _hands(motion, generated, directions, places, core, held)
        fps = generated.fps
        inside = [
            one for one in gestures.meant_gestures(generated) if any(start <= one[1] * fps < stop for start, stop in places)
        ]
        return replace(motion, directions=directions, hands=hands), inside

    def _generate(self, request: Request, seed: int, calm: Sequence[frame_ranges.FrameRange]) -> Motion:
        """Generate arms, trunk and hands with the kept frames of a request and the random numbers of ``seed``.

        There are no requested strokes in ``calm`` spans."""
        request = request.of_arms()  # face and pelvis of the take stay
        checkpoint, heard, drawn_from = self.session.checkpoint, self.heard, self.heard
        if calm:
            quiet = tuple((start / skeleton.FPS, stop / skeleton.FPS) for start, stop in calm)
            wishes = replace(heard.wishes, gestures={})
            heard = replace(heard, shows=None, wishes=wishes)
            drawn_from = replace(heard, wishes=replace(wishes, rests=wishes.rests + quiet))
        seeded = replace(self.performers, request=replace(request, seed=seed))
        progress = self.stages.within("generate")
        drawn = generation.generate(checkpoint, drawn_from, [seeded], progress, self.stages.cancelled)
        if calm:  # nobody is there to be spared
            request = request.at_usual_rate()
        performers = replace(self.performers, request=request)
        return postprocess.express(checkpoint, heard, performers, drawn)[0]


def interpolate_arms(
    motion: Motion, place: frame_ranges.FrameRange, held: np.ndarray, arms: Sequence[int] = ARMS,
    still: Sequence[int] | np.ndarray | None = ()
) -> Motion:  # fmt: skip
    """Return the take with the edges ``arms`` interpolated through a span (cubic Hermite with the speeds at its ends).

    They stop at the frames ``still``, if those are ends of the span. With ``still`` None directions are blended linearly, not
    along the sphere. Frames marked in ``held`` stay."""
    start, stop = place
    directions, edges = motion.directions.copy(), np.array(arms)
    low, high = max(start - 1, 0), min(stop, len(directions) - 1)
    length = high - low
    if length < 2:
        return motion
    poses = directions[:, edges].astype(float)
    halts = {0, len(directions) - 1, *(() if still is None else still)}
    slopes = [poses[high] * 0 if at in halts else (poses[at + step] - poses[at]) * step
              for at, step in ((low, -1), (high, 1))]  # fmt: skip
    t = (np.arange(1, length) / length)[:, None, None]
    rise = 3 * t**2 - 2 * t**3
    straight = still is None
    path = (1 - rise) * poses[low] + rise * poses[high] if straight else rest.slerp(poses[low], poses[high], rise[..., 0])
    path = path + (t**3 - 2 * t**2 + t) * length * slopes[0] + (t**3 - t**2) * length * slopes[1]
    inner = np.arange(low + 1, high)
    free = ~held[inner]
    directions[np.ix_(inner[free], edges)] = skeleton.normalize(path)[free].astype(np.float32)
    hands = motion.hands
    if hands is not None:
        carried = hands[start:stop].moved_with_arms(motion.directions[start:stop], directions[start:stop])
        hands = splice_hands(hands, start, carried)
    return replace(motion, directions=directions, hands=hands)


def _bend(directions: np.ndarray, places: Sequence[frame_ranges.FrameRange], core: StrokeCore) -> np.ndarray:
    """Bend generated directions ``(frames, 9, 3)`` so that their spans lead into this core and out of it at its speeds.

    At the ends of the spans they stay."""
    bent, off = directions.copy(), core.directions - directions[core.frames].astype(float)
    for start, stop in places:
        if not start <= core.first < stop:
            continue
        for rows, ends in ((np.arange(start, core.first), off[:2]), (np.arange(stop - 1, core.last, -1), off[:-3:-1])):
            t = (np.arange(1, len(rows) + 1) / (len(rows) + 1))[:, None, None]
            slope = (len(rows) + 1) * (ends[-1] - ends[0])
            bent[rows] += (3 - 2 * t) * t**2 * ends[0] + (t**3 - t**2) * slope
        bent[start:stop] = limits.enforce_limits(skeleton.normalize(bent[start:stop]).astype(np.float32))
    return bent


def join_strain(before: Motion, after: Motion, places: Sequence[frame_ranges.FrameRange]) -> float:
    """Return the :func:`speed_excess` of spans and their joins, plus one for each span with an impossible pose."""
    parts = [after.directions[max(start - _MARGIN, 0) : stop + _MARGIN] for start, stop in places]
    return speed_excess(before, after, places) + sum(map(is_implausible, parts))


def is_implausible(directions: np.ndarray) -> bool:
    """Return whether any of the poses ``(frames, 9, 3)`` has arms inside the body or elbows bent backward."""
    return bool((limits.penetration(directions) > 2 * limits.MAX_PENETRATION).any() or limits.backward_elbows(directions).any())


def speed_excess(before: Motion, after: Motion, places: Sequence[frame_ranges.FrameRange]) -> float:
    """Return by what share spans and their joins exceed the take's :func:`usual_peaks`, at least 0."""
    most, own = 0.0, usual_peaks(before)
    for start, stop in places:
        here = peak_motion(after.directions[max(start - _MARGIN, 0) : stop + _MARGIN])
        most = max(most, *(new / max(old, 1e-6) - 1 for new, old in zip(here, own, strict=True)))
    return most


def usual_peaks(before: Motion) -> Sequence[float]:
    """Return the :func:`peak_motion` of a take as it was before its edits: what one may do is not changed by the others."""
    peaks = np.maximum(peak_motion(before.directions), _LEAST_PEAKS)
    return before.meta.get(PEAKS) or (np.ceil(1e5 * peaks) / 1e5).tolist()


def peak_motion(directions: np.ndarray) -> tuple[float, float]:
    """Return the highest speed and acceleration of the wrists, in metres per frame and per frame squared."""
    wrists = skeleton.wrists(directions)
    speed, change = (float(np.linalg.norm(np.diff(wrists, n=n, axis=0), axis=-1).max(initial=0)) for n in (1, 2))
    return speed, change


def _hands(
    motion: Motion, generated: Motion, directions: np.ndarray, places: Sequence[frame_ranges.FrameRange],
    core: StrokeCore | None, held: np.ndarray
) -> Hands | None:  # fmt: skip
    """Blend the hands of a take into the generated ones inside the spans, and into those of the core in its frames.

    They are attached to the new arms ``directions`` ``(frames, 9, 3)``."""
    if motion.hands is None or generated.hands is None:
        return motion.hands
    hands = motion.hands
    for start, stop in places:
        here, at = slice(start, stop), np.arange(start, stop)
        arms = directions[here]
        old = motion.hands[here].moved_with_arms(motion.directions[here], arms)
        new = generated.hands[here].moved_with_arms(generated.directions[here], arms)
        share = ramp(at - start + 1, 0, _BLEND_FRAMES) * ramp(stop - at, 0, _BLEND_FRAMES)
        mixed = old.mixed(new, share)
        if core is not None and core.hands is not None:
            row = np.clip(at, core.first, core.last) - core.first
            own = core.hands[row].moved_with_arms(core.directions[row], arms)
            away = np.maximum(core.first - at, 0) + np.maximum(at - core.last, 0)
            mixed = mixed.mixed(own, 1 - ramp(away, 0, _BLEND_FRAMES))
        hands = splice_hands(hands, start, mixed, ~held[here])
    return hands


def splice_hands(hands: Hands, start: int, part: Hands, rows: np.ndarray | None = None) -> Hands:
    """Return hands with ``part`` inserted at frame ``start``, in its ``rows`` ``(len(part),)`` only; all else is unchanged."""
    rows = np.ones(len(part), bool) if rows is None else rows
    result = []
    for old, new in zip((hands.knuckles, hands.palms, hands.shape), (part.knuckles, part.palms, part.shape), strict=True):
        values = old.copy()
        values[start : start + len(part)][rows] = new[rows]
        result.append(values)
    return Hands(*result)
