"""What is asked of a performance, checked, and what comes of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from typing import Any

import numpy as np

from .. import control_curves, styles
from ..errors import UsageError
from ..meaning import document
from ..motion import skeleton
from ..motion.motion import Motion
from ..settings import AFFECTS, CONTROLS, Settings, names_with, table
from . import curves as curves_module


@dataclass(frozen=True)
class Request(Settings):
    """One performance: ``audio``, the path of the recording, and the settings of :class:`settings.Settings`.

    Raises :class:`UsageError` for values out of range and for settings that exclude each other."""

    audio: str | PathLike

    def __post_init__(self) -> None:
        _check_alternatives(self)
        for name, one in table(Settings).items():
            one.check(getattr(self, name))
        for pose in (self.pose, self.end_pose):
            if pose is not None and not _are_poses(pose, (9, 3)):
                raise UsageError("The seed pose is not nine directions.", "Give nine times three numbers, no direction zero.")
        if self.kept is not None and not _are_kept_frames(self.kept):
            raise UsageError("The frames to keep make no sense.", "Give numbers of frames and nine directions for each.")
        if self.take < 0 or self.step < 1:
            raise UsageError(f"Take {self.take} or step {self.step} is too low.", "Takes count from 0, steps from 1.")
        if not 0 <= self.spread <= 1 or not _are_steps(self.near):
            raise UsageError("The variation asked for makes no sense.", "Give a spread of 0 to 1, steps as (number, spread).")
        self._settle_curves()
        document.check(self.meanings)
        styles.controls(self.affect, self.rate, self.hand)
        if self.latent is not None and self.takes != 1:
            raise UsageError("A point of the latent space is one performance.", "Ask for one take.")

    def _settle_curves(self) -> None:
        """Check curves and changes of style; replace a curve that never changes by the plain value."""
        curves, changes = control_curves.check_curves(self.curves), control_curves.check_changes(self.changes)
        constants = control_curves.constant_values(curves)
        affects = {name: value for name, value in constants.items() if name in AFFECTS}
        settled = {name: value for name, value in constants.items() if name not in AFFECTS}
        settled |= {"curves": {name: points for name, points in curves.items() if name not in constants}, "changes": changes}
        for name, value in (settled | {"affect": {**self.affect, **affects}}).items():
            object.__setattr__(self, name, value)
        if changes and self.sequence:
            raise UsageError("A style that walks cannot change at moments, too.", "Leave out the walk or the changes.")
        if self.latent is not None and curves_module.has_control_curves(self):
            raise UsageError("A chosen cell has its own controls.", "Leave out their curves.")

    def walk(self, speakers: list[dict], hinted: Sequence[tuple] = ()) -> tuple[list[str | dict], list[float]]:
        """Return the styles, one after the other, and the seconds at which the later ones begin, none for a sequence.

        ``speakers`` are those of the checkpoint, one of whom is the default; styles that words ask for, ``hinted``
        ``(seconds, style)``, are left out of a sequence."""
        usual = self.style or styles.default_speaker(speakers)
        steps = styles.split_sequence(usual)
        turns = sorted([*(hinted if len(steps) == 1 else ()), *self.changes], key=lambda one: one[0])
        return [usual, *(style or usual for _, style in turns)] if turns else steps, [at for at, _ in turns]

    @property
    def sequence(self) -> str | dict:
        """The style if it is a sequence of several, else an empty text."""
        return self.style if len(styles.split_sequence(self.style)) > 1 else ""

    def in_styles(self, every: Sequence[str | dict]) -> "list[Request]":
        """Return the same request in each of these styles."""
        return [replace(self, style=style) for style in every]

    def turned(self, changes: Sequence[tuple[float, str]], curves: Mapping[str, list] = {}) -> "Request":  # noqa: B006
        """Return the request with further style changes, as (seconds, style), and with other curves by name."""
        return replace(self, changes=(*self.changes, *changes), curves={**self.curves, **curves})

    @property
    def identities(self) -> list[tuple]:
        """What tells the takes apart (:func:`styles.take_identities`)."""
        return styles.take_identities(self.take, self.takes, tuple(self.near), self.spread, self.step)

    @property
    def keyed_seed(self) -> int:
        """The seed of a performance's random numbers: ``seed``, with the recording's ``chance`` above its 32 bits."""
        return self.seed + ((self.chance or 0) << 32)

    @property
    def words_from(self) -> tuple[str | PathLike | None, str | None]:
        """The file of the transcript and the text, of which at most one is given."""
        return self.transcript, self.text

    @property
    def starts_at_rest(self) -> bool:
        """Whether no first frame is given."""
        return self.pose is None

    def first_pose(self, rest: np.ndarray) -> np.ndarray:
        """Return the first frame ``(9, 3)`` before the motion is mirrored: the one that is given, or else ``rest``."""
        return rest if self.pose is None else self.as_performed(np.asarray(self.pose, float))

    @property
    def controls(self) -> np.ndarray:
        """Affect, rate and hand ``(5,)`` in the order of :data:`settings.CONTROLS`."""
        return styles.controls(self.affect, self.rate, self.hand)

    @property
    def steered(self) -> set[str]:
        """Names of the controls that are not left at 0, and of the curves."""
        return {name for name, value in zip(CONTROLS, self.controls, strict=True) if value} | set(self.curves)

    def as_performed(self, poses: np.ndarray) -> np.ndarray:
        """Directions ``(..., 9, 3)`` of the finished motion as they are before it is mirrored."""
        return skeleton.mirror(poses) if self.mirror else poses

    def of_arms(self) -> "Request":
        """The same request without the parts of the motion that do not depend on arms, trunk and hands."""
        return replace(self, **{name: table(Settings)[name].default for name in names_with(beside_arms=True)})

    def at_usual_rate(self) -> "Request":
        """The same request with as many gestures as the performer makes."""
        return replace(self, rate=0.0, curves={name: points for name, points in self.curves.items() if name != "rate"})


@dataclass(frozen=True)
class Result:
    """Motions (one a take), words with times, warnings for the user, seconds spent by stage, and the styles that performed:
    ``latents`` ``(takes, steps, size)``, one step unless the style walks."""

    motions: list[Motion]
    words: tuple
    warnings: list[str] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)
    latents: np.ndarray | None = None


def _check_alternatives(request: Request) -> None:
    """Raise :class:`UsageError` where two settings are given that exclude each other."""
    given: set[str] = set()
    for name, one in table(Settings).items():
        if one.alternatives and getattr(request, name) != one.default:
            if one.alternatives in given:
                raise UsageError(*one.conflict)
            given.add(one.alternatives)


def _are_steps(near: Any) -> bool:
    try:
        return all(int(number) > 0 and 0 < float(spread) <= 1 for number, spread in near)
    except (TypeError, ValueError):
        return False


def _are_poses(value: Any, shape: tuple) -> bool:
    try:
        poses = np.asarray(value, float)
    except (TypeError, ValueError):
        return False
    return poses.shape == shape and bool(np.isfinite(poses).all()) and bool((np.linalg.norm(poses, axis=-1) > 0).all())


def _are_kept_frames(value: Any) -> bool:
    try:
        frames, poses = value
        numbers = np.asarray(frames)
        whole = np.issubdtype(numbers.dtype, np.integer) and numbers.ndim == 1 and numbers.min() >= 0
        return bool(whole) and len(set(numbers.tolist())) == len(numbers) and _are_poses(poses, (len(numbers), 9, 3))
    except (TypeError, ValueError):
        return False
