"""Rotations of a control rig's bones, found by measuring: how far constraints, drivers and switches let them go.

D of a bone is its rotation away from the rig's own rest, evaluated without animation. Where a bone comes to lie without
its own rotation is first predicted, from a trial turn of each bone that shows which others ride on it, then measured on
a private copy and corrected top down: ``M^-1 S M`` for the remaining turn S of a bone whose orientation is M. Where the
prediction holds, as on most rigs, one evaluation a frame confirms it; else the next pass is exact one level further.
"""

from collections.abc import Callable, Collection, Generator
from dataclasses import dataclass, replace

import bpy
import numpy as np

from ...core.motion import quaternion, skeleton
from ...core.motion.hands import Hands
from ...core.motion.pelvis import Pelvis
from ...rigs import twist
from ...rigs.family import LINES, SIDES
from ...rigs.goals import Goals
from ...rigs.plain import Bones, Mapping, spoken
from ...rigs.walk import Walk
from . import locks
from .standin import Returning, StandIn, upright

SETTLED = np.radians(0.03)
PASSES, TRIES = 20, 3
"""Evaluations of a frame, at most; and steps of a bone that lead nowhere."""
TRIAL = quaternion.about(np.array([1.0, 2.0, 3.0]) / np.sqrt(14), np.radians(20.0))
"""A small turn about no axis that any rig is built on."""
SIMILAR, DEAD = np.radians(2.0), 0.02
WORTH_TELLING = 1.0
"""Degrees by which an arm may miss its direction before it is told."""


@dataclass(frozen=True)
class Take:
    """A motion to lay onto a rig: ``directions`` (frames, 9, 3), canonical, at ``fps``, and the scene ``frames`` (frames,)."""

    directions: np.ndarray
    fps: float
    frames: np.ndarray
    hands: Hands | None = None
    pelvis: Pelvis | None = None


@dataclass(frozen=True)
class Control:
    """A bone that is turned. ``tip`` is the bone at whose head (or own tail) its part ends; the rest are places in the list.

    ``rides`` is the bone that carries it, by ``share`` of that one's turn, ``base`` the one a relative turn is counted
    from, ``copies`` the forearm whose turn a hand takes over unless the motion has hands; -1 for none. ``gain`` is how much
    of its own rotation it carries out.
    """

    name: str
    row: int
    part: str
    tip: str = ""
    rides: int = -1
    share: float = 1.0
    base: int = -1
    copies: int = -1
    gain: float = 1.0


def solving(
    armature: bpy.types.Object,
    bones: Bones,
    mapping: Mapping,
    motion: Take,
    keys: Take,
    *,
    scene: bpy.types.Scene,
    ask: Callable[..., Goals],
    values: dict[str, float] | None = None,
    hands: Collection[str] = (),
    tell: Callable[[str], None] = print,
) -> Generator[None, None, dict[str, np.ndarray]]:
    """Rotations ``{bone: (keys, 4)}``: measured at the frames of ``motion`` and carried over to those of ``keys``, in slices.

    ``ask(bones, take, clear=False)`` says what a take asks of bones; ``values`` are the settings that the rig will have;
    ``hands`` may be made to follow their forearms where they do not by themselves. Bones that do not get where they should
    are told, and those that do not answer at all get no keys. Nothing in the file changes. Raises :class:`RigUnusable` for
    an unusable mapping.
    """
    watched = [name for chain in mapping.chains.values() for name in chain]
    with Returning(armature, scene, watched, values, float(motion.frames[0])) as place:
        rest = place.rig.as_bones(bones)
        yield from place.pause(always=True)
        goals = yield from _cleared(ask(rest, motion, clear=False), place)
        solver = Solver(place, goals, hands)
        yield from place.pause(always=True)
        predicted = solver.predict(Walk(goals))
        yield from place.pause(always=True)
        solved = yield from solver.running(motion.frames)
        goals = yield from _cleared(ask(rest, keys, clear=False), place)
        walk = Walk(goals)
        wanted = solver.predict(walk)
    yield
    for sentence in solver.shortfalls():
        tell(sentence)
    result = twist.rotations(walk.goals, walk)
    for index, control in enumerate(solver.controls):
        if control.gain < DEAD:
            continue
        # What measuring added to the prediction lies before the bone's own turn: it is what the bone hangs on.
        change = quaternion.multiply(solved[index], quaternion.conjugate(predicted[index]))
        change = between(quaternion.continuous(change), motion.frames, keys.frames)
        result[control.name] = quaternion.continuous(quaternion.multiply(change, wanted[index]))
    return result


def _cleared(goals: Goals, place: Returning) -> Generator[None, None, Goals]:
    """The goals, once their arms are out of the trunk, in slices."""
    for _ in goals.clearing():
        yield from place.pause()
    yield from place.pause(always=True)
    return goals


def between(rotations: np.ndarray, frames: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Rotations ``(frames, 4)`` given at ascending ``frames``, at others ``(n,)``; beyond the ends, those at the ends."""
    place = np.interp(at, frames, np.arange(len(frames)))
    index = np.minimum(place.astype(int), max(len(frames) - 2, 0))
    after = np.minimum(index + 1, len(frames) - 1)
    return quaternion.slerp(rotations[index], rotations[after], (place - index))


class Solver:
    """One motion on one private copy of a rig. Arrays of bones come first, then frames."""

    def __init__(self, place: Returning, goals: Goals, hands: Collection[str] = ()):
        self.place, self.goals, self.frames = place, goals, len(goals.directions)
        self.rest = goals.bones.rest
        self.controls = self._learn(_controls(goals, hands))
        self.carriers = _carriers(self.controls)
        self.missed = {}

    @property
    def rig(self) -> StandIn:
        """The copy that is there just now."""
        return self.place.rig

    def predict(self, walk: Walk) -> np.ndarray:
        """Rotations (bones, frames, 4) by what the trial turns showed."""
        still = np.tile(walk.goals.still(), (len(self.controls), 1, 1))
        return self._step(walk, still, still, [None] * len(self.controls), still, np.ones(still.shape[:2]))[0]

    def running(self, frames: np.ndarray) -> Generator[None, None, np.ndarray]:
        """Rotations (bones, frames, 4) measured to be right at scene ``frames``, or as near as the rig allows; in slices."""
        basis = self.predict(Walk(self.goals))
        turned, along = np.zeros_like(basis), np.zeros((*basis.shape[:2], 3))
        nearest, best = np.full(basis.shape[:2], np.inf), basis.copy()
        failed, active = np.zeros(basis.shape[:2], int), np.arange(self.frames)
        tilt, made, former = np.tile(quaternion.IDENTITY, (*basis.shape[:2], 1)), np.zeros_like(basis), turned
        quiet = np.zeros(basis.shape[:2], bool)
        for last in [False] * PASSES + [True]:
            for frame in active:
                turned[:, frame], along[:, frame] = self._measure(basis[:, frame], frames[frame])
                yield from self.place.pause()
            if last:
                break
            yield from self.place.pause(always=True)
            tilt = np.where(quiet[..., None], self._retilted(tilt, made, former, turned), tilt)
            yield from self.place.pause(always=True)
            # A bone that does not answer as expected takes smaller steps, and in the end stays where it came nearest.
            ease = np.where(failed < TRIES, 0.5**failed, 0.0)
            segments = quaternion.rotate(quaternion.conjugate(turned), along)
            wanted, left = self._step(Walk(self.goals), basis, turned, segments, tilt, ease)
            # What a bone does is its own only where nothing that may carry it moved at the same time.
            nearest = np.where(quiet, nearest, np.inf)
            failed += quiet & (left > SETTLED) & (left > 0.8 * nearest) & (failed < TRIES)
            best = np.where((left < nearest)[..., None], basis, best)
            nearest = np.minimum(nearest, left)
            following = np.where((left > SETTLED)[..., None], wanted, basis)
            following = np.where((failed >= TRIES)[..., None], best, following)
            moving = (np.abs(following - basis) > 1e-7).any(-1)
            quiet, active = self.carriers @ moving == 0, np.flatnonzero(moving.any(0))
            made, former, basis = quaternion.multiply(quaternion.conjugate(basis), following), turned.copy(), following
            if not len(active):
                break
            yield from self.place.pause(always=True)
        self._note(along)
        return basis

    def _retilted(self, tilt, made, former, turned) -> np.ndarray:
        """How each bone's answers lie to its own turns (bones, frames, 4), by one turn ``made`` and what came of it.

        A constraint after a bone's own rotation turns the axis about which it answers.
        """
        result = tilt.copy()
        for index, control in enumerate(self.controls):
            rest = self.rest[control.row]
            arrived = self._carried(control, former, turned, former[index])
            answer = quaternion.multiply(quaternion.conjugate(arrived), turned[index])
            answer = _seen(quaternion.conjugate(rest), answer)
            thought = _tilted(tilt[index], made[index])
            clear = (angle(made[index]) > SIMILAR) & (angle(answer) > SIMILAR)
            change = quaternion.swing(_axis(thought), _axis(answer))
            known = clear & (angle(change) > SIMILAR)
            result[index] = np.where(known[:, None], quaternion.multiply(change, tilt[index]), tilt[index])
        return result

    def _carried(self, control: Control, before, after, turned: np.ndarray) -> np.ndarray:
        """Where a bone comes to be from ``turned`` (frames, 4) when the others go from ``before`` to ``after``."""
        if control.rides < 0:
            return turned
        before, after = (quaternion.power(turns[control.rides], control.share) for turns in (before, after))
        return quaternion.multiply(quaternion.multiply(after, quaternion.conjugate(before)), turned)

    def shortfalls(self) -> list[str]:
        """A sentence for each bone that stays off, which :meth:`running` found out."""
        sentences = []
        for control in self.controls:
            if control.gain < DEAD:
                sentences.append(f'Bone "{control.name}" stays as it is: a constraint or a driver holds it.')
            elif control.name in self.missed:
                sentences.append(
                    f'Bone "{control.name}" is up to {self.missed[control.name]:.0f} degrees off the direction of '
                    f"{spoken(control.part)}: a constraint, a driver or a lock holds it back."
                )
        return sentences

    def _step(self, walk, basis, turned, segments, tilt, ease) -> tuple[np.ndarray, np.ndarray]:
        """Rotations (bones, frames, 4) that ought to reach the goals, given that ``basis`` led to ``turned``.

        And the angles (bones, frames) that they lie from there; of each step ``ease`` (bones, frames) is carried out.
        """
        expected, result, left = [], [], []
        for index, control in enumerate(self.controls):
            rest = self.rest[control.row]
            arrived = self._carried(control, turned, expected, turned[index])
            start = quaternion.multiply(arrived, quaternion.conjugate(_seen(rest, basis[index])))
            if control.gain != 1.0:  # its own turn cannot be told from what it rides on
                start = walk.goals.still()
                if control.rides >= 0:
                    start = quaternion.power(expected[control.rides], control.share)
            if control.copies >= 0:
                goal = walk.hands.get(control.part.split("_")[0], expected[control.copies])
            else:
                base = expected[control.base] if control.base >= 0 else None
                goal = walk.turn(control.row, start, base, segments[index])
            turn = _seen(quaternion.conjugate(rest), quaternion.multiply(quaternion.conjugate(arrived), goal))
            turn = quaternion.power(turn, 1.0 / control.gain if control.gain >= DEAD else 0.0)
            turn = _tilted(quaternion.conjugate(tilt[index]), turn)
            turn = self._allowed(control, basis[index], turn)
            left.append(angle(turn))
            turn = quaternion.power(turn, ease[index])
            answer = quaternion.power(_tilted(tilt[index], turn), control.gain)
            expected.append(quaternion.multiply(arrived, _seen(rest, answer)))
            result.append(quaternion.multiply(basis[index], turn))
        return np.array(result), np.array(left)

    def _allowed(self, control: Control, basis: np.ndarray, turn: np.ndarray) -> np.ndarray:
        """As much of a ``turn`` (frames, 4) of a bone as its locked channels let through."""
        bone = self.rig.item.pose.bones[control.name]
        if not any(bone.lock_rotation):
            return turn
        return quaternion.multiply(quaternion.conjugate(basis), locks.held(bone, quaternion.multiply(basis, turn)))

    def _measure(self, rotations: np.ndarray, frame: float | None = None) -> tuple[np.ndarray, np.ndarray]:
        """D (bones, 4) and the directions (bones, 3) from heads to the ends of parts, with ``rotations`` (bones, 4)."""
        names = [control.name for control in self.controls]
        self.rig.pose(dict(zip(names, rotations, strict=True)), frame)
        matrices = self.rig.matrices(names)
        turned = quaternion.multiply(
            quaternion.from_matrix(upright(matrices[:, :3, :3])),
            quaternion.conjugate(self.rest[[control.row for control in self.controls]]),
        )
        return turned, skeleton.normalize(self._ends() - matrices[:, :3, 3])

    def _ends(self) -> np.ndarray:
        heads = self.rig.matrices([control.tip or control.name for control in self.controls])[:, :3, 3]
        last = [self.goals.mapping.chains[control.part][-1] for control in self.controls]
        own = np.array([not control.tip for control in self.controls])
        return np.where(own[:, None], self.rig.tails(last), heads)

    def _learn(self, controls: list[Control]) -> list[Control]:
        """Find by a trial turn of each bone which others it carries, and how much of it the bone itself makes."""
        self.controls = controls
        shares = np.zeros((len(controls), len(controls)))
        gains = []
        for index, control in enumerate(controls):
            rotations = np.tile(quaternion.IDENTITY, (len(controls), 1))
            rotations[index] = _seen(quaternion.conjugate(self.rest[control.row]), TRIAL)
            turned, _ = self._measure(rotations)
            own = turned[index]
            gains.append(_gain(float(angle(own) / angle(TRIAL))))
            if gains[-1] > 0.2:
                share = np.round(angle(turned) / angle(own), 2)
                difference = angle(quaternion.multiply(quaternion.conjugate(quaternion.power(own, share)), turned))
                shares[index] = np.where(difference < SIMILAR, share, 0.0)
        self._measure(np.tile(quaternion.IDENTITY, (len(controls), 1)))
        learnt = []
        for index, control in enumerate(controls):
            above = np.flatnonzero(shares[:index, index] > 0.05)
            rides = int(above[-1]) if len(above) else -1
            learnt.append(replace(control, rides=rides, share=shares[rides, index], gain=gains[index]))
        # A hand that rides on its forearm needs no keys of its own to follow; hands come last, so no place in the list changes.
        follows = [(one.rides, one.share) == (one.copies, 1.0) and self.goals.hands is None for one in learnt]
        return [control for control, alone in zip(learnt, follows, strict=True) if control.copies < 0 or not alone]

    def _note(self, along: np.ndarray) -> None:
        for index, control in enumerate(self.controls):
            if control.part in self.goals.options.aimed and self.goals.mapping.chains[control.part][0] == control.name:
                target = self.goals.target(control.part)
                cross = np.linalg.norm(np.cross(along[index], target), axis=-1)
                off = np.degrees(np.arctan2(cross, np.sum(along[index] * target, -1))).max()
                if off > WORTH_TELLING:
                    self.missed[control.name] = off


def angle(q: np.ndarray) -> np.ndarray:
    """How far rotations (..., 4) turn, in radians."""
    return 2.0 * np.arctan2(np.linalg.norm(q[..., 1:], axis=-1), np.abs(q[..., 0]))


def _tilted(tilt: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Turns (frames, 4) about axes that are themselves turned."""
    return np.concatenate([turn[..., :1], quaternion.rotate(tilt, turn[..., 1:])], -1)


def _axis(turn: np.ndarray) -> np.ndarray:
    """Unit axes (frames, 3) of rotations, each the short way round."""
    vector = np.where(turn[..., :1] < 0, -turn[..., 1:], turn[..., 1:])
    length = np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.where(length > 1e-9, vector / np.maximum(length, 1e-9), [0.0, 1.0, 0.0])


def _gain(measured: float) -> float:
    """How much of its own rotation a bone carries out, by a trial; too little to divide by is nothing or a fifth."""
    if abs(measured - 1.0) < 0.05:
        return 1.0
    return 0.0 if measured < DEAD else max(measured, 0.2)


def _seen(rest: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """A rotation in a bone's rest frame, seen from the armature."""
    return quaternion.multiply(rest, quaternion.multiply(rotation, quaternion.conjugate(rest)))


def _controls(goals: Goals, hands: Collection[str]) -> list[Control]:
    """The bones to turn, each after those that may carry it; hands turn as their forearms do."""
    bones, chains, controls, places = goals.bones, goals.mapping.chains, [], {}
    for part in (part for line in LINES for part in line):
        for name in chains.get(part, ()):
            row = bones.row(name)
            if row in goals.roles:
                places[name] = len(controls)
                base = _base(goals, part, places)
                controls.append(Control(name, row, part, goals.mapping.tip(part), base=base))
    for side in SIDES:
        for name in chains.get(f"{side}_hand", ())[:1]:
            forearm = places.get(chains[f"{side}_forearm"][-1], -1)
            if bones.row(name) not in goals.roles and name in hands and forearm >= 0:
                controls.append(Control(name, bones.row(name), f"{side}_hand", copies=forearm))
    return controls


def _carriers(controls: list[Control]) -> np.ndarray:
    """Which controls (n, n) may carry each: those before it of the trunk and of its own side."""
    sides = [control.part.split("_")[0] for control in controls]
    return np.array(
        [[j < i and (other == side or other not in SIDES) for j, other in enumerate(sides)] for i, side in enumerate(sides)],
        int,
    )


def _base(goals: Goals, part: str, places: dict[str, int]) -> int:
    """What a relative part is counted from: the torso's bone that it hangs on, by its parents or as the last one."""
    torso = [name for name in goals.mapping.chains.get("torso", ()) if name in places]
    if part == "torso" or part not in goals.relative or not torso:
        return -1
    bones = goals.bones
    above = {bones.names[row] for row in bones.ancestors(bones.row(goals.mapping.chains[part][0]))}
    return places[([name for name in torso if name in above] or torso)[-1]]
