"""What a performance is asked for by, and what comes of it."""

from dataclasses import dataclass, field
from os import PathLike

import numpy as np

from .. import styles
from ..errors import UsageError
from ..motion.motion import Motion
from . import course


@dataclass(frozen=True)
class Request:
    """What to make. ``audio`` is a path; give ``transcript`` (a path) or ``text``, or neither: audio alone still gestures.

    ``style`` is a style expression (:func:`styles.parse`), ``takes`` how many variations, ``intensity`` how far the
    performance departs from rest. ``affect`` (any of :data:`styles.AFFECTS`), ``rate`` and ``hand`` steer the style, -1..1
    each, 0 as the speaker would. ``meaning`` (0..1) is how readily phrases are shown by gestures of their own, 1 as the
    speaker would. ``hands`` (0..1) is how much wrists and fingers live; with 0 the motion has none, and the arms are the same.
    ``stance`` (0..1) is how far weight goes from foot to foot; with 0 the motion has no pelvis. ``face`` (0..2) is how far
    the mouth opens and brows rise, with 0 the motion has no face, and ``face_smoothness`` (0..1) how lazily lips move.
    ``mirror`` exchanges left and right of the finished performance. With ``recognise`` words that nobody wrote down are
    recognised, which needs the extra of that name.

    ``curves`` say how ``intensity`` or a control goes on in time, ``{name: [[seconds, value], ...]}``, straight from point to
    point and instead of the one number; ``changes`` are styles that begin on the way, ``((seconds, style), ...)``.

    Some frames of the finished motion can be given, in unit directions ``(9, 3)`` (canonical frame): ``pose`` is the first
    (at rest if None), ``end_pose`` the last, and ``kept`` any, as a pair of frame numbers ``(n,)`` and directions
    ``(n, 9, 3)``; they are kept exactly and the performance leads from one to the next.

    With ``listen`` the recording is somebody else's, and the performer listens to all of it; ``turn`` is whose lines of a
    transcript with names it speaks, listening to the others; ``hears`` is the recording of
    another speaker of the same scene, to whom it listens where it is silent itself; that begins ``later`` seconds later than
    this one, or earlier. The other one stands ``toward`` degrees to the performer's left, or to its right (-90..90), and who
    listens looks there, who speaks a little.

    ``take`` is the number of the first take. ``near`` are the steps ``(number, spread)`` that lead to a variation of it;
    with ``spread`` (0..1, a share of how far takes differ) all takes are one more step away from that, numbered from ``step``
    on (:func:`styles.identities`). ``latent`` ``(steps, size)``, as :class:`Result` gives it, is the point of the latent
    space for each step of the style, instead of drawing it. ``made_by`` is the hash of the checkpoint that made the take of
    which more is wanted; if another performs now, the result says so.
    """

    audio: str | PathLike
    transcript: str | PathLike | None = None
    text: str | None = None
    style: str | dict = ""
    seed: int = 0
    takes: int = 1
    intensity: float = 1.0
    affect: dict[str, float] = field(default_factory=dict)
    rate: float = 0.0
    hand: float = 0.0
    curves: dict = field(default_factory=dict)
    changes: tuple = ()
    meaning: float = 1.0
    hands: float = 0.0
    stance: float = 0.0
    face: float = 0.0
    face_smoothness: float = 0.5
    mirror: bool = False
    pose: np.ndarray | None = None
    end_pose: np.ndarray | None = None
    kept: tuple | None = None
    take: int = 0
    near: tuple = ()
    spread: float = 0.0
    step: int = 1
    recognise: bool = False
    listen: bool = False
    turn: str = ""
    hears: str | PathLike | None = None
    later: float = 0.0
    toward: float = 0.0
    latent: np.ndarray | None = None
    made_by: str = ""

    def __post_init__(self):
        if self.transcript is not None and self.text is not None:
            raise UsageError("Both a transcript file and a text were given.", "Give one of them.")
        if not 1 <= self.takes <= 64:
            raise UsageError(f"{self.takes} takes were asked for.", "Ask for 1 to 64.")
        if self.listen + bool(self.turn) + (self.hears is not None) > 1:
            raise UsageError("A performer cannot listen in several ways.", "Give one of listen, turn and hears.")
        if not -90 <= self.toward <= 90:
            raise UsageError(f"Nobody is seen at {self.toward:g} degrees.", "Give -90 (right) to 90 (left).")
        if not abs(self.later) <= 13 * 3600:
            raise UsageError(f"The other recording begins {self.later:g} s later.", "Give seconds within the scene.")
        if not 0 <= self.intensity <= 3:
            raise UsageError(f"Intensity {self.intensity:g} is out of range.", "Give a number from 0 to 3.")
        if not 0 <= self.meaning <= 1:
            raise UsageError(f"Meaning {self.meaning:g} is out of range.", "Give a number from 0 to 1.")
        if not 0 <= self.hands <= 1:
            raise UsageError(f"Hands of {self.hands:g} are out of range.", "Give a number from 0 to 1.")
        if not 0 <= self.stance <= 1:
            raise UsageError(f"Stance {self.stance:g} is out of range.", "Give a number from 0 to 1.")
        if not 0 <= self.face <= 2:
            raise UsageError(f"Face of {self.face:g} is out of range.", "Give a number from 0 to 2.")
        if not 0 <= self.face_smoothness <= 1:
            raise UsageError(f"A face's smoothness of {self.face_smoothness:g} is out of range.", "Give a number from 0 to 1.")
        if self.seed < 0:
            raise UsageError(f"Seed {self.seed} is negative.", "Give zero or a positive whole number.")
        for pose in (self.pose, self.end_pose):
            if pose is not None and not _are_poses(pose, (9, 3)):
                raise UsageError("The seed pose is not nine directions.", "Give nine times three numbers, no direction zero.")
        if self.kept is not None and not _is_kept(self.kept):
            raise UsageError("The frames to keep make no sense.", "Give numbers of frames and nine directions for each.")
        if self.take < 0 or self.step < 1:
            raise UsageError(f"Take {self.take} or step {self.step} is too low.", "Takes count from 0, steps from 1.")
        if not 0 <= self.spread <= 1 or not _are_steps(self.near):
            raise UsageError("The variation asked for makes no sense.", "Give a spread of 0 to 1, steps as (number, spread).")
        self._settle_course()
        styles.controls(self.affect, self.rate, self.hand)
        if self.latent is not None and self.takes != 1:
            raise UsageError("A point of the latent space is one performance.", "Ask for one take.")

    def _settle_course(self) -> None:
        """Check what goes on in time; a curve that never changes is the plain setting."""
        curves, changes = course.checked(self.curves), course.changed(self.changes)
        same = course.constants(curves)
        settled = {"curves": {name: points for name, points in curves.items() if name not in same}, "changes": changes}
        settled |= {name: value for name, value in same.items() if name not in styles.AFFECTS}
        settled["affect"] = {**self.affect, **{name: value for name, value in same.items() if name in styles.AFFECTS}}
        for name, value in settled.items():
            object.__setattr__(self, name, value)
        if changes and len(styles.steps(self.style)) > 1:
            raise UsageError("A style that walks cannot change at moments, too.", "Leave out the walk or the changes.")
        if self.latent is not None and course.steers(self):
            raise UsageError("A chosen cell has its own controls.", "Leave out their curves.")

    @property
    def identities(self) -> list[tuple]:
        """What tells the takes apart (:func:`styles.identities`)."""
        return styles.identities(self.take, self.takes, tuple(self.near), self.spread, self.step)

    @property
    def controls(self) -> np.ndarray:
        """Affect, rate and hand ``(5,)`` in the order of :data:`styles.CONTROLS`."""
        return styles.controls(self.affect, self.rate, self.hand)


@dataclass(frozen=True)
class Result:
    """Motions (one a take), words with times, warnings for the user, seconds spent by stage, and the styles that performed:
    ``latents`` ``(takes, steps, size)``, one step unless the style walks.
    """

    motions: list[Motion]
    words: tuple
    warnings: list[str] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)
    latents: np.ndarray | None = None


def _are_steps(near) -> bool:
    try:
        return all(int(number) > 0 and 0 < float(spread) <= 1 for number, spread in near)
    except (TypeError, ValueError):
        return False


def _are_poses(value, shape: tuple) -> bool:
    try:
        poses = np.asarray(value, float)
    except (TypeError, ValueError):
        return False
    return poses.shape == shape and bool(np.isfinite(poses).all()) and bool((np.linalg.norm(poses, axis=-1) > 0).all())


def _is_kept(value) -> bool:
    try:
        frames, poses = value
        numbers = np.asarray(frames)
        whole = np.issubdtype(numbers.dtype, np.integer) and numbers.ndim == 1 and numbers.min() >= 0
        return bool(whole) and len(set(numbers.tolist())) == len(numbers) and _are_poses(poses, (len(numbers), 9, 3))
    except (TypeError, ValueError):
        return False
