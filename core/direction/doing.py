"""What each kind of edit does to a take."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..errors import UsageError
from ..motion import skeleton
from ..motion.motion import Motion
from . import cores, filling, gestures, joins, kinds, spans, strokes
from .aims import LOOSE, Aim, State, best, seed_of
from .filling import Filler
from .gestures import BEAT, Gesture

GIVE_WAY = 0.8
"""Seconds around a stroke in which others give way to it where it cannot be had beside them."""
SHORTEST = 0.6
"""Seconds of a range that is made anew, at least."""
_BESIDE = 0.25
"""What another gesture that does not stay counts in choosing how one is deleted, in shares of what may be left of it."""
_TOLD = 0.005
"""Share by which joins may be more sudden than the take without a word of it."""
_LED = (0.8, 1.2, 1.6, 2.0, 2.5, 3.0)
"""Seconds on either side in which arms are led to a pose that is far from the take, until they come as gently as it moves."""


def do(filler: Filler, state: State, edit: dict, number: int) -> State:
    """A take after one more edit, which is the ``number``-th; raises :class:`UsageError` for what cannot be done."""
    filler = filler if edit["do"] == "style" else filler.turned(state.changes)
    try:
        made, miss = _DOING[edit["do"]](filler, state, edit, 0.0)
        if miss > 1:
            freer, off = _DOING[edit["do"]](filler, state, edit, GIVE_WAY)
            made, miss = (freer, off) if off < miss else (made, miss)
    except UsageError as error:
        raise UsageError(f"Edit {number} cannot be done: {error.message}", error.remedy) from error
    warnings = state.warnings
    if miss > 1:
        warnings += (f"Edit {number} ({edit['do']}) came only near to what was asked for: its neighbours leave no room.",)
    told, touched = state.motion.meta, _touched(state.motion, made.motion)
    places = [(round(start * skeleton.FPS), round(stop * skeleton.FPS) + 1) for start, stop in touched]
    excess = 0.0 if edit["do"] == "style" else filling.excess(state.motion, made.motion, places)
    if excess > _TOLD:
        warnings += (
            f"Edit {number} ({edit['do']}) moves up to {excess:.0%} more suddenly than the take does: give it more room.",
        )
    meta = {**made.motion.meta, "edits": [*told.get("edits", []), edit]}
    meta["touched"] = [*told.get("touched", []), touched]
    return replace(made, motion=replace(made.motion, meta=meta), warnings=warnings)


def _touched(before: Motion, after: Motion) -> list[list[float]]:
    """Seconds between which motions differ."""
    parts = [before.directions != after.directions]
    if before.hands is not None:
        pairs = zip(before.hands.arrays().values(), after.hands.arrays().values(), strict=True)
        parts += [old != new for old, new in pairs]
    rows = np.flatnonzero(np.any([part.reshape(len(part), -1).any(1) for part in parts], axis=0))
    ends = np.flatnonzero(np.diff(rows) > skeleton.FPS)
    groups = np.split(rows, ends + 1) if len(rows) else []
    return [[round(float(one[0] / before.fps), 4), round(float(one[-1] / before.fps), 4)] for one in groups]


def _gesture(state: State, at: float, apart: float, to: float | None = None) -> tuple[Gesture, list[Gesture]]:
    """The gesture at a time, and the others that are to stay: those so far ``apart`` from where it will be, ``to``."""
    found = gestures.find(state.motion)
    one = gestures.near(found, at)
    if one is None:
        best = gestures.near(found, at, np.inf)
        remedy = f"The nearest is at {best.at:.2f} s." if best else "The take has none at all."
        raise UsageError(f"there is no gesture at {at:.2f} s.", remedy)
    to = one.at if to is None else to
    return one, [other for other in found if other is not one and abs(other.at - to) >= apart]


def _frames(one: Gesture) -> tuple[int, int]:
    return int(one.stroke * skeleton.FPS), int(np.ceil(one.hold * skeleton.FPS))


def _move(filler: Filler, state: State, edit: dict, apart: float) -> tuple[State, float]:
    one, others = _gesture(state, edit["at"], apart, edit["to"])
    whole = one.kind != BEAT
    core = cores.carried(state.motion, one, edit["to"], whole)
    frames = len(state.motion.directions)
    old = spans.around(others, *_frames(one), frames, spans.LEAST)
    places = spans.joined([old, spans.around(others, core.first, core.last, frames)])
    aim = Aim(edit["to"], one.hand, one.size)
    nearer = strokes.SECOND if apart else 0.0
    made, miss = strokes.through(filler, state, edit, places, core, aim, whole, nearer)
    if miss > 1 and apart and one.hand != "both" and len(places) == 1:  # the other arm moves more here than it did there
        ends = state.motion.directions[[max(places[0][0] - 1, 0), min(places[0][1], frames - 1)]]
        calm = cores.by_hand(core, one.hand, one.hand, ends, places[0])
        calmer, off = strokes.through(filler, state, edit, places, calm, aim, whole, nearer)
        made, miss = (calmer, off) if off < miss else (made, miss)
    return replace(made, motion=kinds.told(made.motion, places, [(one.kind, edit["to"])])), miss


def _delete(filler: Filler, state: State, edit: dict, apart: float) -> tuple[State, float]:
    one, others = _gesture(state, edit["at"], apart)
    frames, wanted = len(state.motion.directions), spans.WANTED if not apart else 2 * spans.WANTED
    places = [spans.around(others, *_frames(one), frames, wanted)]
    if apart and places == [spans.around(_gesture(state, edit["at"], 0.0)[1], *_frames(one), frames)]:
        return state, np.inf  # no more room than before
    alone = spans.around(others, *_frames(one), frames, wanted, 0.0)
    made = state.motion

    def make(attempt: int, seed: int) -> Motion:
        nonlocal made
        if attempt == 0:
            made = filler.fill(state.motion, places, None, seed, state.held, whole=one.kind != BEAT)[0]
            return made
        place, former = (alone, state.motion) if attempt < 3 else (places[0], made)
        straight = filling.quiet(former, place, state.held)
        return straight if attempt % 2 else joins.slow(state.motion, straight, [place], state.held)

    def miss(motion: Motion) -> float:
        off = 2 * gestures.left(motion, one, others) / one.size
        return off if off > 1 else min(off + _BESIDE * gestures.disturbed(motion, one, others), 1.0)

    gone, off = best(filler, state, edit, places, make, miss, tries=5)
    return replace(state, motion=kinds.told(gone, places, [])), off


def _change(filler: Filler, state: State, edit: dict, apart: float) -> tuple[State, float]:
    one, others = _gesture(state, edit["at"], apart)
    hand, size = edit.get("hand"), edit.get("size", 1.0)
    if edit.get("kind", one.kind) not in (one.kind, BEAT):
        return kinds.shown(filler, state, edit, one.at, others, edit["kind"], hand, size, apart > 0)
    core, made_by, way = cores.carried(state.motion, one, one.at, one.kind != BEAT), one.hand, one.size
    if edit.get("kind", one.kind) != one.kind:
        core, made_by, way = _borrowed(filler, state, edit, one.at)
    nearer = strokes.SECOND if apart else 0.0
    return _formed(filler, state, edit, others, one.at, core, (made_by, hand or made_by), (way, size), one.kind != BEAT, nearer)


def _add(filler: Filler, state: State, edit: dict, apart: float) -> tuple[State, float]:
    at = edit["at"] if "at" in edit else kinds.time_of(state.motion.words, edit["word"], edit.get("nth", 1))
    kind, hand, size = edit.get("kind", BEAT), edit.get("hand"), edit.get("size", 1.0)
    found = gestures.find(state.motion)
    others = [one for one in found if abs(one.at - at) >= max(apart, gestures.APART / 2)]
    if kind != BEAT:
        return kinds.shown(filler, state, edit, at, others, kind, hand, size, apart > 0)
    core, made_by, way = _borrowed(filler, state, edit, at)
    nearer = strokes.SECOND if apart else 0.0
    return _formed(filler, state, edit, others, at, core, (made_by, hand or made_by), (way, size), False, nearer)


def _formed(filler, state, edit, others, at, core, by, sizes, whole, nearer) -> tuple[State, float]:
    """A core made by another hand, and of another size, put in its place; ``by`` is who did it and who is to."""
    frames = len(state.motion.directions)
    span = spans.around(others, core.first, core.last, frames)
    ends = state.motion.directions[[max(span[0] - 1, 0), min(span[1], frames - 1)]]
    if by[0] != by[1]:
        core = cores.by_hand(core, *by, ends, span)
    core = cores.sized(core, sizes[1], by[1])
    core = cores.unhurried(core, at, state.motion, filling.fastest(state.motion.directions), whole)
    span = spans.around(others, core.first, core.last, frames)
    aim = Aim(at, by[1], sizes[0] * sizes[1])
    made, miss = strokes.through(filler, state, edit, [span], core, aim, whole, nearer)
    if miss > 1 and by[0] == "both" and by[1] != "both" and sizes[1] == 1:
        made, miss = _alone(state, span, aim, made, miss)
    kept = [one for one in gestures.shows(state.motion) if whole and abs(one[1] - at) < LOOSE]
    return replace(made, motion=kinds.told(made.motion, [span], kept)), miss


def _alone(state: State, span: spans.Span, aim: Aim, made: State, miss: float) -> tuple[State, float]:
    """What both hands did with one of them resting and the other as it was, if that misses less than what was ``made``."""
    one = filling.quiet(state.motion, span, state.held, cores.arm("left" if aim.hand == "right" else "right"))
    return (replace(state, motion=one), aim.miss(one)) if aim.miss(one) < miss else (made, miss)


def _borrowed(filler: Filler, state: State, edit: dict, at: float) -> tuple[cores.Core, str, float]:
    """The core of a beat from elsewhere in the take at ``at``, the hand that made it, and how far."""
    beats = [one for one in gestures.find(state.motion) if one.kind == BEAT and abs(one.at - at) > gestures.APART]
    sizes = np.array([one.size for one in beats])
    usual = [one for one in beats if abs(one.size / np.median(sizes) - 1) < 0.4] if len(beats) else []
    wanted = [one for one in usual if edit.get("hand") in (None, one.hand)] or usual
    if not wanted:
        raise UsageError("the take has no gesture like it.", "Give a kind that means something.")
    one = wanted[seed_of(filler, edit, 0) % len(wanted)]
    return cores.carried(state.motion, one, at), one.hand, one.size


def _reroll(filler: Filler, state: State, edit: dict, apart: float) -> tuple[State, float]:
    motion = state.motion
    start, stop = round(edit["from"] * motion.fps), min(round(edit["to"] * motion.fps) + 1, len(motion.directions))
    if stop - start < SHORTEST * motion.fps:
        raise UsageError("less than a phrase is chosen.", f"Choose {SHORTEST:g} s or more of the recording.")
    places = [(start, stop)]

    def make(attempt: int, seed: int) -> Motion:
        made, inside = filler.fill(motion, places, None, seed, state.held, plain=False, whole=True)
        return kinds.told(made, places, inside)

    made, _ = best(filler, state, edit, places, make, lambda motion: 0.0)
    return replace(state, motion=made), 0.0


def _style(filler: Filler, state: State, edit: dict, apart: float) -> tuple[State, float]:
    motion, changes = state.motion, (*state.changes, (edit["at"], edit["style"]))
    later = [at for at, _ in (*filler.request.changes, *state.changes) if at > edit["at"]]
    start, stop = round(edit["at"] * motion.fps), round(min([*later, motion.duration + 1]) * motion.fps)
    places = [(start, min(stop, len(motion.directions)))]
    if places[0][1] - start < SHORTEST * motion.fps:
        raise UsageError("less than a phrase is chosen.", f"Choose {SHORTEST:g} s or more of the recording.")
    begun = filler.turned(changes)

    def make(attempt: int, seed: int) -> Motion:
        made, inside = begun.fill(motion, places, None, seed, state.held, plain=False, whole=True)
        return kinds.told(made, places, inside)

    made, _ = best(begun, state, edit, places, make, lambda motion: 0.0)
    return replace(state, motion=made, changes=changes), 0.0


def _pose(filler: Filler, state: State, edit: dict, apart: float) -> tuple[State, float]:
    at, frames = edit["at"] * state.motion.fps, len(state.motion.directions)
    first, last = int(np.floor(at + 1e-6)), int(np.ceil(at - 1e-6))
    if last >= frames:
        raise UsageError("the recording ends before that.", f"Give a time within 0 to {state.motion.duration:.1f} s.")
    pose = skeleton.normalize(np.array(edit["directions"], float)).astype(np.float32)
    return _held(filler, state, edit, cores.Core(first, np.repeat(pose[None], last - first + 1, 0)), True)


def _place(filler: Filler, state: State, edit: dict, apart: float) -> tuple[State, float]:
    fps, frames = state.motion.fps, len(state.motion.directions)
    first, last = int(np.floor(edit["from"] * fps)), int(np.ceil(edit["to"] * fps))
    if last >= frames:
        raise UsageError("the recording ends before that.", f"Give times within 0 to {state.motion.duration:.1f} s.")
    side = gestures.HANDS.index(edit["hand"])
    return _held(filler, state, edit, cores.reaching(state.motion, side, first, last, edit["place"]), False)


def _held(filler: Filler, state: State, edit: dict, core: cores.Core, whole: bool) -> tuple[State, float]:
    """The take led through frames that stay as they are from now on; from far away it is led there for longer."""
    found, frames = gestures.find(state.motion), len(state.motion.directions)
    places = [spans.around(found, core.first, core.last, frames)]
    free, kept = state.held.copy(), replace(state, held=state.held.copy())
    free[core.frames], kept.held[core.frames] = False, True

    def make(attempt: int, seed: int) -> Motion:
        return filler.fill(state.motion, places, core, seed, free, whole=whole)[0]

    made, _ = best(filler, kept, edit, places, make, lambda motion: 0.0, tries=2)
    far, least = filling.strain(state.motion, made, places), float(filling.strange(core.directions))
    wide = [spans.until(free, core.first, core.last, _LED[-1])]
    if far > least:  # hands of all ways there are those of one performance
        filler.fill(state.motion, wide, core, seed_of(filler, edit, 0), free, whole=whole)
    for wanted in _LED if far > least else ():
        places = [spans.until(free, core.first, core.last, wanted)]
        led = filler.fill(state.motion, places, core, 0, free, whole=whole, again=True)[0]
        turns = core.frames if len(core.frames) < 3 else ()
        led = strokes.bare(led, places, core, free, filling.ALL if whole else cores.ARMS, turns)
        strain = filling.strain(state.motion, led, places)
        made, far = (led, strain) if strain < far else (made, far)
        if far <= least:
            break
    return replace(kept, motion=made), 0.0


_DOING: dict[str, Callable[[Filler, State, dict, float], tuple[State, float]]] = {
    "move": _move,
    "delete": _delete,
    "change": _change,
    "add": _add,
    "reroll": _reroll,
    "style": _style,
    "pose": _pose,
    "place": _place,
}
