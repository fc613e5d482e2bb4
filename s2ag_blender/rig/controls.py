"""Solves the rotations of a control rig's bones by measuring what constraints, drivers and switches do to them.

D of a bone is its evaluated rotation relative to the rig's own rest, without animation. The D that a bone gets from other
bones is first predicted, from a trial turn of each bone that shows which others follow it, then measured on a private copy
and corrected from the root down: ``M^-1 S M`` for the remaining rotation S of a bone whose orientation is M. Where the
prediction holds, as on most rigs, one evaluation per frame confirms it; else each pass is exact one level further."""

from collections.abc import Callable, Collection, Generator
from dataclasses import dataclass, replace

import bpy
import numpy as np

from ...core.motion import quaternion, skeleton
from ...core.motion.hands import Hands
from ...core.motion.pelvis import Pelvis
from ...rigs import twist
from ...rigs.goals import Goals
from ...rigs.skeleton import Bones, Mapping, part_phrase
from ...rigs.walk import Walk
from ..datablocks import ArmatureObject
from . import locks
from . import rotations as rotations_module
from .control_bones import MIN_GAIN, Control, carriers, list_controls, round_gain
from .private_copy import PausableCopy, RigCopy, rotations_without_scale

TOLERANCE = np.radians(0.03)
"""Radians by which a bone may miss its goal and count as solved."""
MAX_PASSES, MAX_TRIES = 20, 3
"""Most evaluations of a frame, and most steps of a bone without improvement."""
TRIAL_TURN = quaternion.about(np.array([1.0, 2.0, 3.0]) / np.sqrt(14), np.radians(20.0))
"""A small rotation about an axis that no rig is aligned with."""
MIN_ANGLE = np.radians(2.0)
"""Radians below which a rotation says nothing about its axis."""
MAX_MISS_DEGREES = 1.0
"""Degrees by which an arm may miss its direction without a warning."""
_Rotations = np.ndarray | list[np.ndarray]


@dataclass(frozen=True)
class Take:
    """A motion for a rig: canonical edge ``directions`` (frames, 9, 3) at ``fps``, and their scene ``frames`` (frames,)."""

    directions: np.ndarray
    fps: float
    frames: np.ndarray
    hands: Hands | None = None
    pelvis: Pelvis | None = None


def solve_in_slices(
    armature: ArmatureObject, bones: Bones, mapping: Mapping, motion: Take, keys: Take, *, scene: bpy.types.Scene,
    ask: Callable[..., Goals], values: dict[str, float] | None = None, hands: Collection[str] = (),
    tell: Callable[[str], None] = print
) -> Generator[None, None, dict[str, np.ndarray]]:  # fmt: skip
    """Solve rotations ``{bone: (keys, 4)}``: measured at the frames of ``motion``, transferred to those of ``keys``; in slices.

    ``ask(bones, take, clear=False)`` returns the goals of a take; ``values`` are property values that the rig will have;
    ``hands`` may be rotated with their forearms where they do not follow by themselves. Sentences about bones that miss
    their goals go to ``tell``; bones that do not respond get no keys. Nothing in the file changes. Raises
    :class:`RigUnusable` for an unusable mapping."""
    mapped = [name for chain in mapping.chains.values() for name in chain]
    with PausableCopy(armature, scene, mapped, values, float(motion.frames[0])) as place:
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
        targets = solver.predict(walk)
    yield
    for sentence in solver.shortfalls():
        tell(sentence)
    result = twist.rotations(walk.goals, walk)
    for index, control in enumerate(solver.controls):
        if control.gain < MIN_GAIN:
            continue
        # The correction by measuring comes before the bone's own rotation: it is due to what the bone follows.
        change = quaternion.multiply(solved[index], quaternion.conjugate(predicted[index]))
        change = rotations_module.interpolate(quaternion.continuous(change), motion.frames, keys.frames)
        result[control.name] = quaternion.continuous(quaternion.multiply(change, targets[index]))
    return result


def _cleared(goals: Goals, place: PausableCopy) -> Generator[None, None, Goals]:
    """Return the goals with the arms moved out of the trunk, working in slices."""
    for _ in goals.clearing():
        yield from place.pause()
    yield from place.pause(always=True)
    return goals


class Solver:
    """Solves one motion on a private copy of a rig. The first axis of arrays is controls, the second frames."""

    def __init__(self, place: PausableCopy, goals: Goals, hands: Collection[str] = ()) -> None:
        self.place, self.goals, self.frames = place, goals, len(goals.directions)
        self.rest = goals.bones.rest
        self.controls = self._learn(list_controls(goals, hands))
        self.carriers = carriers(self.controls)
        self.missed: dict[str, float] = {}

    @property
    def rig(self) -> RigCopy:
        """The current copy of the rig."""
        return self.place.rig

    def predict(self, walk: Walk) -> np.ndarray:
        """Return rotations (controls, frames, 4) predicted from the trial turns."""
        still = np.tile(walk.goals.still(), (len(self.controls), 1, 1))
        return self._step(walk, still, still, [None] * len(self.controls), still, np.ones(still.shape[:2]))[0]

    def running(self, frames: np.ndarray) -> Generator[None, None, np.ndarray]:
        """Solve rotations (controls, frames, 4) at scene ``frames`` by measuring, as near as the rig allows; in slices."""
        basis = self.predict(Walk(self.goals))
        turned, along = np.zeros_like(basis), np.zeros((*basis.shape[:2], 3))
        nearest, best = np.full(basis.shape[:2], np.inf), basis.copy()
        failed, active = np.zeros(basis.shape[:2], int), np.arange(self.frames)
        tilt, step, former = np.tile(quaternion.IDENTITY, (*basis.shape[:2], 1)), np.zeros_like(basis), turned
        quiet = np.zeros(basis.shape[:2], bool)
        for last in [False] * MAX_PASSES + [True]:
            for frame in active:
                turned[:, frame], along[:, frame] = self._measure(basis[:, frame], frames[frame])
                yield from self.place.pause()
            if last:
                break
            yield from self.place.pause(always=True)
            tilt = np.where(quiet[..., None], self._update_tilt(tilt, step, former, turned), tilt)
            yield from self.place.pause(always=True)
            # A bone that does not respond as expected takes smaller steps, and finally stays at its best rotation.
            ease = np.where(failed < MAX_TRIES, 0.5**failed, 0.0)
            segments = quaternion.rotate(quaternion.conjugate(turned), along)
            target, left = self._step(Walk(self.goals), basis, turned, segments, tilt, ease)
            # A response is the bone's own only where nothing that it may follow moved at the same time.
            nearest = np.where(quiet, nearest, np.inf)
            failed += quiet & (left > TOLERANCE) & (left > 0.8 * nearest) & (failed < MAX_TRIES)
            best = np.where((left < nearest)[..., None], basis, best)
            nearest = np.minimum(nearest, left)
            following = np.where((left > TOLERANCE)[..., None], target, basis)
            following = np.where((failed >= MAX_TRIES)[..., None], best, following)
            moving = (np.abs(following - basis) > 1e-7).any(-1)
            quiet, active = self.carriers @ moving == 0, np.flatnonzero(moving.any(0))
            step, former, basis = quaternion.multiply(quaternion.conjugate(basis), following), turned.copy(), following
            if not len(active):
                break
            yield from self.place.pause(always=True)
        self._note(along)
        return basis

    def _update_tilt(self, tilt: np.ndarray, step: np.ndarray, former: np.ndarray, turned: np.ndarray) -> np.ndarray:
        """Return the rotations (controls, frames, 4) from the axis of each bone's own turn to the axis of its response.

        ``step`` is the last change of the bones' rotations, which took them from D ``former`` to ``turned``. A constraint
        after a bone's own rotation turns the axis about which the bone responds."""
        result = tilt.copy()
        for index, control in enumerate(self.controls):
            rest = self.rest[control.row]
            carried = self._carry(control, former, turned, former[index])
            response = quaternion.multiply(quaternion.conjugate(carried), turned[index])
            response = rotations_module.to_armature(quaternion.conjugate(rest), response)
            expected = rotations_module.with_axis_turned(tilt[index], step[index])
            clear = (rotations_module.angle(step[index]) > MIN_ANGLE) & (rotations_module.angle(response) > MIN_ANGLE)
            change = quaternion.swing(rotations_module.axis(expected), rotations_module.axis(response))
            differs = clear & (rotations_module.angle(change) > MIN_ANGLE)
            result[index] = np.where(differs[:, None], quaternion.multiply(change, tilt[index]), tilt[index])
        return result

    def _carry(self, control: Control, before: _Rotations, after: _Rotations, turned: np.ndarray) -> np.ndarray:
        """Return the D of a bone from ``turned`` (frames, 4) when the others' D go from ``before`` to ``after``."""
        if control.rides < 0:
            return turned
        start, end = (quaternion.power(all_turned[control.rides], control.share) for all_turned in (before, after))
        return quaternion.multiply(quaternion.multiply(end, quaternion.conjugate(start)), turned)

    def shortfalls(self) -> list[str]:
        """Return a sentence for each bone that misses its goal, as found by :meth:`operator_base`."""
        sentences = []
        for control in self.controls:
            if control.gain < MIN_GAIN:
                sentences.append(f'Bone "{control.name}" stays as it is: a constraint or a driver holds it.')
            elif control.name in self.missed:
                sentences.append(
                    f'Bone "{control.name}" is up to {self.missed[control.name]:.0f} degrees off the direction of '
                    f"{part_phrase(control.part)}: a constraint, a driver or a lock holds it back."
                )
        return sentences

    def _step(
        self, walk: Walk, basis: np.ndarray, turned: np.ndarray, segments: _Rotations | list[None], tilt: np.ndarray,
        ease: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """Return rotations (controls, frames, 4) that should reach the goals, given that ``basis`` led to D ``turned``.

        Also return the angles (controls, frames) from ``basis`` to the goals. ``segments`` are directions from heads to the
        ends of parts (controls, frames, 3) relative to D; ``ease`` (controls, frames) is the share of each step to take."""
        expected, result, left = [], [], []
        for index, control in enumerate(self.controls):
            rest = self.rest[control.row]
            carried = self._carry(control, turned, expected, turned[index])
            start = quaternion.multiply(carried, quaternion.conjugate(rotations_module.to_armature(rest, basis[index])))
            if control.gain != 1.0:  # its own rotation cannot be separated from what it follows
                start = walk.goals.still()
                if control.rides >= 0:
                    start = quaternion.power(expected[control.rides], control.share)
            if control.copies >= 0:
                side = control.part.split("_")[0]
                goal = walk.hands[side] if side in walk.hands else expected[control.copies]
            else:
                base = expected[control.base] if control.base >= 0 else None
                goal = walk.turn(control.row, start, base, segments[index])
            turn = rotations_module.to_armature(
                quaternion.conjugate(rest), quaternion.multiply(quaternion.conjugate(carried), goal)
            )
            turn = quaternion.power(turn, 1.0 / control.gain if control.gain >= MIN_GAIN else 0.0)
            turn = rotations_module.with_axis_turned(quaternion.conjugate(tilt[index]), turn)
            turn = self._apply_locks(control, basis[index], turn)
            left.append(rotations_module.angle(turn))
            turn = quaternion.power(turn, ease[index])
            response = quaternion.power(rotations_module.with_axis_turned(tilt[index], turn), control.gain)
            expected.append(quaternion.multiply(carried, rotations_module.to_armature(rest, response)))
            result.append(quaternion.multiply(basis[index], turn))
        return np.array(result), np.array(left)

    def _apply_locks(self, control: Control, basis: np.ndarray, turn: np.ndarray) -> np.ndarray:
        """Return the part of a ``turn`` (frames, 4) from ``basis`` that a bone's locked channels allow."""
        bone = self.rig.item.pose.bones[control.name]
        if not any(bone.lock_rotation):
            return turn
        return quaternion.multiply(quaternion.conjugate(basis), locks.apply_locks(bone, quaternion.multiply(basis, turn)))

    def _measure(self, rotations: np.ndarray, frame: float | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Return D (controls, 4) and directions (controls, 3) of the parts, measured with ``rotations`` (controls, 4)."""
        names = [control.name for control in self.controls]
        self.rig.pose(dict(zip(names, rotations, strict=True)), frame)
        matrices = self.rig.matrices(names)
        turned = quaternion.multiply(
            quaternion.from_matrix(rotations_without_scale(matrices[:, :3, :3])),
            quaternion.conjugate(self.rest[[control.row for control in self.controls]]),
        )
        return turned, skeleton.normalize(self._ends() - matrices[:, :3, 3])

    def _ends(self) -> np.ndarray:
        """Return where the parts of the controls end (controls, 3), in armature space."""
        heads = self.rig.matrices([control.tip or control.name for control in self.controls])[:, :3, 3]
        last = [self.goals.mapping.chains[control.part][-1] for control in self.controls]
        own = np.array([not control.tip for control in self.controls])
        return np.where(own[:, None], self.rig.tails(last), heads)

    def _learn(self, controls: list[Control]) -> list[Control]:
        """Find by a trial turn of each bone which others follow it, and what share of it takes effect on the bone itself.

        Returns the controls with these values, without hands that follow their forearms by themselves."""
        self.controls = controls
        shares = np.zeros((len(controls), len(controls)))
        gains = []
        for index, control in enumerate(controls):
            rotations = np.tile(quaternion.IDENTITY, (len(controls), 1))
            rotations[index] = rotations_module.to_armature(quaternion.conjugate(self.rest[control.row]), TRIAL_TURN)
            turned, _ = self._measure(rotations)
            own = turned[index]
            gains.append(round_gain(float(rotations_module.angle(own) / rotations_module.angle(TRIAL_TURN))))
            if gains[-1] > 0.2:
                share = np.round(rotations_module.angle(turned) / rotations_module.angle(own), 2)
                difference = rotations_module.angle(
                    quaternion.multiply(quaternion.conjugate(quaternion.power(own, share)), turned)
                )
                shares[index] = np.where(difference < MIN_ANGLE, share, 0.0)
        self._measure(np.tile(quaternion.IDENTITY, (len(controls), 1)))
        measured = []
        for index, control in enumerate(controls):
            above = np.flatnonzero(shares[:index, index] > 0.05)
            rides = int(above[-1]) if len(above) else -1
            measured.append(replace(control, rides=rides, share=shares[rides, index], gain=gains[index]))
        # A hand that follows its forearm needs no keys for that; hands come last, so indices into the list stay valid.
        follows = [(one.rides, one.share) == (one.copies, 1.0) and self.goals.hands is None for one in measured]
        return [control for control, alone in zip(measured, follows, strict=True) if control.copies < 0 or not alone]

    def _note(self, along: np.ndarray) -> None:
        """Note the parts whose directions ``along`` (controls, frames, 3) miss their targets by too much."""
        for index, control in enumerate(self.controls):
            if control.part in self.goals.options.aimed and self.goals.mapping.chains[control.part][0] == control.name:
                target = self.goals.target(control.part)
                cross = np.linalg.norm(np.cross(along[index], target), axis=-1)
                off = np.degrees(np.arctan2(cross, np.sum(along[index] * target, -1))).max()
                if off > MAX_MISS_DEGREES:
                    self.missed[control.name] = off
