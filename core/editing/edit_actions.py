"""Applies single edits to a take: one function for each kind of edit."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..errors import UsageError
from ..motion import skeleton
from ..motion.motion import Motion
from ..synthesis import strokes
from . import frame_ranges, gestures, quieting, regeneration, semantic_gestures, stroke_core, stroke_placement
from .edits import OFF, TURNS
from .gestures import BEAT, Gesture
from .regeneration import Regenerator
from .targets import LOOSE, State, StrokeTarget, best_attempt, turns

GIVE_WAY = 0.8
"""Seconds around a stroke in which other gestures are given up in a second try, where the first one failed beside them."""
_REST_AROUND = 1.2
"""Seconds before and after the moment of a rest that is added."""
SHORTEST = 0.6
"""Least seconds of a range that can be regenerated."""
_WARN_EXCESS = 0.005
"""Share by which joins may be more sudden than the take without a warning."""
_NEAR = 0.02
"""Metres by which a hand may miss its place without a warning."""
_ROUNDING = 1e-4
"""Difference of a direction, or of a handshape in degrees, that another processor makes and that nobody sees."""
_LEAD_SECONDS = (0.8, 1.2, 1.6, 2.0, 2.5, 3.0)
"""Lengths of the transitions to and from a fixed pose; the shortest one with joins as smooth as the take is used."""


def apply_edit(filler: Regenerator, state: State, edit: dict, number: int, forgiven: bool = False) -> State:
    """Apply one more edit, the ``number``-th, unless it is switched off.

    Raises :class:`UsageError` if it cannot be applied; if that is ``forgiven``, it is passed over with a warning."""
    if edit.get(OFF):
        return _noted(state, state, edit)
    filler = filler if edit["do"] in TURNS else filler.turned(state.changes, state.feelings)
    try:
        result, miss = _ACTIONS[edit["do"]](filler, state, edit, 0.0)
        if miss > 1:
            second, off = _ACTIONS[edit["do"]](filler, state, edit, GIVE_WAY)
            result, miss = (second, off) if off < miss else (result, miss)
    except UsageError as error:
        if not forgiven:
            raise UsageError(f"Decision {number} cannot be done: {error.message}", error.remedy) from error
        warning = f"Decision {number} was left out: {error.message}"
        meta = {**state.motion.meta, "unmet": [*state.motion.meta.get("unmet", []), number - 1]}
        passed = replace(state, motion=replace(state.motion, meta=meta), warnings=(*state.warnings, warning))
        return _noted(state, passed, edit)
    warnings = result.warnings
    if miss > 1:
        warnings += (f"Decision {number} came only near to what was asked for: its neighbors leave no room.",)
    places = [(round(a * skeleton.FPS), round(b * skeleton.FPS) + 1) for a, b in _changed_seconds(state.motion, result.motion)]
    excess = 0.0 if edit["do"] in TURNS else regeneration.speed_excess(state.motion, result.motion, places)
    if excess > _WARN_EXCESS:
        warnings += (f"Decision {number} moves up to {excess:.0%} more suddenly than the take does: give it more room.",)
    return _noted(state, replace(result, warnings=warnings), edit)


def _noted(before: State, after: State, edit: dict) -> State:
    """Return the state ``after`` an edit with the edit, and what it touched, in its provenance."""
    meta = {**after.motion.meta, "edits": [*before.motion.meta.get("edits", []), edit]}
    meta["touched"] = [*before.motion.meta.get("touched", []), _changed_seconds(before.motion, after.motion)]
    meta.setdefault(regeneration.PEAKS, regeneration.usual_peaks(before.motion))
    return replace(after, motion=replace(after.motion, meta=meta))


def _changed_seconds(before: Motion, after: Motion) -> list[list[float]]:
    """Return the intervals in which two motions differ by more than rounding, as [start, end] in seconds.

    Gaps of up to a second are bridged."""
    parts = [np.abs(before.directions - after.directions) > _ROUNDING]
    if before.hands is not None and after.hands is not None:
        pairs = zip(before.hands.arrays().values(), after.hands.arrays().values(), strict=True)
        parts += [np.abs(old - new) > _ROUNDING for old, new in pairs]
    rows = np.flatnonzero(np.any([part.reshape(len(part), -1).any(1) for part in parts], axis=0))
    ends = np.flatnonzero(np.diff(rows) > skeleton.FPS)
    groups = np.split(rows, ends + 1) if len(rows) else []
    return [[round(float(group[0] / before.fps), 4), round(float(group[-1] / before.fps), 4)] for group in groups]


def _gesture(state: State, at: float, apart: float, to: float | None = None) -> tuple[Gesture, list[Gesture]]:
    """Return the gesture at a time, and the others that stay: those at least ``apart`` seconds from its new time ``to``.

    Raises :class:`UsageError` if there is no gesture at that time."""
    detected = gestures.find_gestures(state.motion)
    gesture = gestures.nearest_of(detected, at)
    if gesture is None:
        nearest = gestures.nearest_of(detected, at, np.inf)
        remedy = f"The nearest is at {nearest.at:.2f} s." if nearest else "The take has none at all."
        raise UsageError(f"there is no gesture at {at:.2f} s.", remedy)
    to = gesture.at if to is None else to
    return gesture, [other for other in detected if other is not gesture and abs(other.at - to) >= apart]


def _move(filler: Regenerator, state: State, edit: dict, apart: float) -> tuple[State, float]:
    gesture, others = _gesture(state, edit["at"], apart, edit["to"])
    whole = gesture.kind != BEAT
    core = stroke_core.core_at(state.motion, gesture, edit["to"], whole)
    frames = len(state.motion.directions)
    first, last = int(gesture.stroke * skeleton.FPS), int(np.ceil(gesture.hold * skeleton.FPS))
    old = frame_ranges.range_around(others, first, last, frames, frame_ranges.LEAST)
    places = frame_ranges.merge_ranges([old, frame_ranges.range_around(others, core.first, core.last, frames)])
    aim = StrokeTarget(edit["to"], gesture.hand, gesture.size)
    nearer = stroke_placement.SECOND if apart else 0.0
    moved, miss = stroke_placement.place_stroke(filler, state, edit, places, core, aim, whole, nearer)
    if miss > 1 and apart and gesture.hand != "both" and len(places) == 1:  # the idle arm moves more here than at the old time
        ends = state.motion.directions[[max(places[0][0] - 1, 0), min(places[0][1], frames - 1)]]
        calm = stroke_core.swap_hand(core, gesture.hand, gesture.hand, ends, places[0])
        calmer, off = stroke_placement.place_stroke(filler, state, edit, places, calm, aim, whole, nearer)
        moved, miss = (calmer, off) if off < miss else (moved, miss)
    return replace(moved, motion=semantic_gestures.record_meant(moved.motion, places, [(gesture.kind, edit["to"])])), miss


def _change(filler: Regenerator, state: State, edit: dict, apart: float) -> tuple[State, float]:
    if edit.get("kind") == gestures.REST:
        return quieting.delete(filler, state, edit, apart)
    gesture, others = _gesture(state, edit["at"], apart)
    hand, size = edit.get("hand"), edit.get("size", 1.0)
    if edit.get("kind", gesture.kind) not in (gesture.kind, BEAT):
        return semantic_gestures.place_gesture(filler, state, edit, gesture.at, others, edit["kind"], hand, size, apart > 0)
    core = stroke_core.core_at(state.motion, gesture, gesture.at, gesture.kind != BEAT)
    own_hand, metres = gesture.hand, gesture.size
    if edit.get("kind", gesture.kind) != gesture.kind:
        core, own_hand, metres = _borrow_beat(filler, state, edit, gesture.at)
    nearer = stroke_placement.SECOND if apart else 0.0
    hands, sizes = (own_hand, hand or own_hand), (metres, size)
    return _place_core(filler, state, edit, others, gesture.at, core, hands, sizes, gesture.kind != BEAT, nearer)


def _add(filler: Regenerator, state: State, edit: dict, apart: float) -> tuple[State, float]:
    at = edit["at"] if "at" in edit else semantic_gestures.word_time(state.motion.words, edit["word"], edit.get("nth", 1))
    kind, hand, size = edit.get("kind", BEAT), edit.get("hand"), edit.get("size", 1.0)
    if kind == gestures.REST:
        low = max(at - _REST_AROUND, 0.0)
        return quieting.rest_range(filler, state, {**edit, "from": low, "to": low + 2 * _REST_AROUND}, apart)
    detected = gestures.find_gestures(state.motion)
    others = [one for one in detected if abs(one.at - at) >= max(apart, strokes.APART / 2)]
    if kind != BEAT:
        return semantic_gestures.place_gesture(filler, state, edit, at, others, kind, hand, size, apart > 0)
    core, own_hand, metres = _borrow_beat(filler, state, edit, at)
    nearer = stroke_placement.SECOND if apart else 0.0
    return _place_core(filler, state, edit, others, at, core, (own_hand, hand or own_hand), (metres, size), False, nearer)


def _place_core(
    filler: Regenerator, state: State, edit: dict, others: Sequence[Gesture], at: float, core: stroke_core.StrokeCore,
    hands: tuple[str, str], sizes: tuple[float, float], whole: bool, nearer: float
) -> tuple[State, float]:  # fmt: skip
    """Place a core at ``at`` seconds, mirrored to another hand and scaled if need be; return the state and its miss.

    ``hands`` are the hand that made it and the requested one, ``sizes`` its metres and the factor on them, ``others`` the
    gestures that stay; head and trunk move along if ``whole`` is set."""
    frames = len(state.motion.directions)
    span = frame_ranges.range_around(others, core.first, core.last, frames)
    ends = state.motion.directions[[max(span[0] - 1, 0), min(span[1], frames - 1)]]
    if hands[0] != hands[1]:
        core = stroke_core.swap_hand(core, *hands, ends, span)
    core = stroke_core.scale_core(core, sizes[1], hands[1])
    core = stroke_core.limit_core_speed(core, at, state.motion, regeneration.usual_peaks(state.motion), whole)
    span = frame_ranges.range_around(others, core.first, core.last, frames)
    aim = StrokeTarget(at, hands[1], sizes[0] * sizes[1])
    placed, miss = stroke_placement.place_stroke(filler, state, edit, [span], core, aim, whole, nearer)
    if miss > 1 and hands[0] == "both" and hands[1] != "both" and sizes[1] == 1:
        placed, miss = _rest_other_arm(state, span, aim, placed, miss)
    shows = [one for one in gestures.meant_gestures(state.motion) if whole and abs(one[1] - at) < LOOSE]
    return replace(placed, motion=semantic_gestures.record_meant(placed.motion, [span], shows)), miss


def _rest_other_arm(
    state: State, span: frame_ranges.FrameRange, aim: StrokeTarget, placed: State, miss: float
) -> tuple[State, float]:
    """Return the take with the other arm idle in the span and the aim's arm unchanged, if that misses less than ``placed``."""
    motion = regeneration.interpolate_arms(
        state.motion, span, state.held, stroke_core.arm_edges("left" if aim.hand == "right" else "right")
    )
    return (replace(state, motion=motion), aim.miss(motion)) if aim.miss(motion) < miss else (placed, miss)


def _borrow_beat(filler: Regenerator, state: State, edit: dict, at: float) -> tuple[stroke_core.StrokeCore, str, float]:
    """Return the core of another beat of the take, moved to ``at`` seconds, with its hand and its size in metres."""
    beats = [one for one in gestures.find_gestures(state.motion) if one.kind == BEAT and abs(one.at - at) > strokes.APART]
    sizes = np.array([one.size for one in beats])
    typical = [one for one in beats if abs(one.size / np.median(sizes) - 1) < 0.4] if len(beats) else []
    candidates = [one for one in typical if edit.get("hand") in (None, one.hand)] or typical
    if not candidates:
        raise UsageError("the take has no gesture like it.", "Give a kind that means something.")
    beat = candidates[filler.attempt_seed(edit, 0) % len(candidates)]
    return stroke_core.core_at(state.motion, beat, at), beat.hand, beat.size


def _reroll(filler: Regenerator, state: State, edit: dict, apart: float) -> tuple[State, float]:
    motion = state.motion
    start, stop = round(edit["from"] * motion.fps), min(round(edit["to"] * motion.fps) + 1, len(motion.directions))
    if stop - start < SHORTEST * motion.fps:
        raise UsageError("less than a phrase is chosen.", f"Choose {SHORTEST:g} s or more of the recording.")
    return replace(state, motion=_anew(filler, state, edit, (start, stop))), 0.0


def _anew(filler: Regenerator, state: State, edit: dict, span: frame_ranges.FrameRange) -> Motion:
    """Return the take with all of a span performed anew."""

    def make(attempt: int, seed: int) -> Motion:
        made, inside = filler.fill(state.motion, [span], None, seed, state.held, plain=False, whole=True)
        return semantic_gestures.record_meant(made, [span], inside)

    return best_attempt(filler, state, edit, [span], make, lambda motion: 0.0)[0]


def _turn(filler: Regenerator, state: State, edit: dict, apart: float) -> tuple[State, float]:
    """Perform in another style, or with another feeling, from a moment to the next such change."""
    motion, (styled_then, felt_then) = state.motion, turns([edit])
    after = replace(state, changes=state.changes + styled_then, feelings=state.feelings + felt_then)
    others = [at for at, _ in state.feelings] if felt_then else [*filler.style_times, *(at for at, _ in state.changes)]
    later = [at for at in others if at > edit["at"]]
    start, stop = round(edit["at"] * motion.fps), round(min([*later, motion.duration + 1]) * motion.fps)
    span = start, min(stop, len(motion.directions))
    if span[1] - start < SHORTEST * motion.fps:
        raise UsageError("less than a phrase is chosen.", f"Choose {SHORTEST:g} s or more of the recording.")
    styled = filler.turned(after.changes, after.feelings)
    made = _anew(styled, state, edit, span)
    if felt_then:
        made = styled.feeling_face(made, edit["at"], min([*later, motion.duration + 1]))
    return replace(after, motion=made), 0.0


def _pose(filler: Regenerator, state: State, edit: dict, apart: float) -> tuple[State, float]:
    at, frames = edit["at"] * state.motion.fps, len(state.motion.directions)
    first, last = int(np.floor(at + 1e-6)), int(np.ceil(at - 1e-6))
    if last >= frames:
        raise UsageError("the recording ends before that.", f"Give a time within 0 to {state.motion.duration:.1f} s.")
    pose = skeleton.normalize(np.array(edit["directions"], float)).astype(np.float32)
    return _fix(filler, state, edit, stroke_core.StrokeCore(first, np.repeat(pose[None], last - first + 1, 0)), True)


def _place(filler: Regenerator, state: State, edit: dict, apart: float) -> tuple[State, float]:
    fps, frames = state.motion.fps, len(state.motion.directions)
    first, last = int(np.floor(edit["from"] * fps)), int(np.ceil(edit["to"] * fps))
    if last >= frames:
        raise UsageError("the recording ends before that.", f"Give times within 0 to {state.motion.duration:.1f} s.")
    side = gestures.HANDS.index(edit["hand"])
    core = stroke_core.reach_core(state.motion, side, first, last, edit["place"])
    fixed, miss = _fix(filler, state, edit, core, False)
    wrist = skeleton.to_positions(core.directions)[:, skeleton.EDGES[skeleton.ARMS[side][1]][1]]
    short = np.linalg.norm(wrist - edit["place"], axis=-1).max()
    if short > _NEAR:
        far = f"The body moves, and the hand is up to {100 * short:.0f} cm from its place."
        fixed = replace(fixed, warnings=(*fixed.warnings, far))
    return fixed, miss


def _fix(filler: Regenerator, state: State, edit: dict, core: stroke_core.StrokeCore, whole: bool) -> tuple[State, float]:
    """Fix the frames of a core and lead the take through them, in longer transitions if they are far from it."""
    others, frames = gestures.find_gestures(state.motion), len(state.motion.directions)
    places = [frame_ranges.range_around(others, core.first, core.last, frames)]
    held_before, fixed = state.held.copy(), replace(state, held=state.held.copy())
    held_before[core.frames], fixed.held[core.frames] = False, True

    def make(attempt: int, seed: int) -> Motion:
        return filler.fill(state.motion, places, core, seed, held_before, whole=whole)[0]

    made, _ = best_attempt(filler, fixed, edit, places, make, lambda motion: 0.0, tries=2)
    strain, least = regeneration.join_strain(state.motion, made, places), float(regeneration.is_implausible(core.directions))
    wide = [frame_ranges.range_until(held_before, core.first, core.last, _LEAD_SECONDS[-1])]
    if strain > least:  # the hands of all transitions tried come from this one performance
        filler.fill(state.motion, wide, core, filler.attempt_seed(edit, 0), held_before, whole=whole)
    for seconds in _LEAD_SECONDS if strain > least else ():
        places = [frame_ranges.range_until(held_before, core.first, core.last, seconds)]
        led = filler.fill(state.motion, places, core, 0, held_before, whole=whole, again=True)[0]
        turns = core.frames if len(core.frames) < 3 else ()
        led = stroke_placement.without_gestures(
            led, places, core, held_before, regeneration.ALL if whole else stroke_core.ARMS, turns
        )
        eased = regeneration.join_strain(state.motion, led, places)
        made, strain = (led, eased) if eased < strain else (made, strain)
        if strain <= least:
            break
    return replace(fixed, motion=made), 0.0


_ACTIONS: dict[str, Callable[[Regenerator, State, dict, float], tuple[State, float]]] = {
    "move": _move,
    "delete": quieting.delete,
    "rest": quieting.rest_range,
    "change": _change,
    "add": _add,
    "reroll": _reroll,
    "style": _turn,
    "feel": _turn,
    "pose": _pose,
    "place": _place,
}
