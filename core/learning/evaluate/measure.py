"""All figures of a set of performances, and those of the same motions shifted in time against their speech."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...motion import skeleton
from ...motion.hands import Hands
from . import figures, kinematics, strokes
from .talks import Talk

SHIFTS = 20
"""Number of random shifts of every motion against its speech."""
LEAST_SHIFT = 2.0
"""Smallest shift in seconds."""


@dataclass(frozen=True)
class Case:
    """A performance to measure: the talk, directions ``(frames, 9, 3)``, resting pose ``(9, 3)``, first frames of windows
    after the first, and hands if they are known."""

    talk: Talk
    directions: np.ndarray
    rest: np.ndarray
    joins: tuple[int, ...] = ()
    hands: Hands | None = None

    @property
    def duration(self) -> float:
        """Length in seconds."""
        return len(self.directions) / skeleton.FPS

    @cached_property
    def strokes(self) -> np.ndarray:
        """Seconds at which strokes land."""
        return strokes.detect(self.directions, self.rest)

    @cached_property
    def beats(self) -> np.ndarray:
        """Seconds of the kinematic beats."""
        return figures.kinematic_beats(self.directions)

    @cached_property
    def arm_speed(self) -> np.ndarray:
        """Arm speed ``(frames,)`` in degrees a second; the first frame repeats the second's."""
        speed = kinematics.arm_speed(self.directions)
        return np.concatenate([speed[:1], speed])

    @cached_property
    def at_rest(self) -> np.ndarray:
        """Share of the two hands ``(frames,)`` that are at rest."""
        return (kinematics.wrist_distance_from_rest(self.directions, self.rest) < strokes.NEAR_REST).mean(axis=1)

    @cached_property
    def silence(self) -> tuple[np.ndarray, np.ndarray]:
        """Masks ``(frames,)`` of expected rest and of speech."""
        return figures.pause_frames(self.talk.spoken, len(self.directions))


def measure(cases: Sequence[Case], width: int = 10, seed: int = 0) -> dict:
    """Return every figure of a set of performances; ``shuffled`` holds the figures of timing of time-shifted motion.

    ``width``: frames of a join between windows.
    """
    motions = [case.directions for case in cases]
    result = {
        **timing(cases, [0.0] * len(cases)),
        "strokes_a_minute": 60 * sum(len(case.strokes) for case in cases) / sum(case.duration for case in cases),
        **figures.speeds(motions),
        **figures.gesture_motion(motions),
        **figures.body(motions),
        **figures.seams(motions, [case.joins for case in cases], width),
    }
    shuffled = _shifted_timing(cases, seed)
    trials = SHIFTS * max(sum(len(case.strokes) for case in cases), 1)
    # counting at least half a hit keeps the ratio finite where no shifted stroke is on an accent
    result["main_accent_gain"] = result["main_accent"] / max(shuffled["main_accent"], 0.5 / trials)
    return {**result, "shuffled": shuffled}


def timing(cases: Sequence[Case], shifts: Sequence[float]) -> dict[str, float]:
    """Return the figures of timing, with every motion shifted cyclically by its shift (s) against its speech."""
    stroke_times = [_shift(case.strokes, shift, case) for case, shift in zip(cases, shifts, strict=True)]
    beats = [_shift(case.beats, shift, case) for case, shift in zip(cases, shifts, strict=True)]
    away = np.concatenate(
        [strokes.distance_to_nearest(times, case.talk.main) for times, case in zip(stroke_times, cases, strict=True)]
    )
    alignment = np.sum(
        [figures.accent_alignment(times, case.talk.accents) for times, case in zip(stroke_times, cases, strict=True)], axis=0
    )
    aligned = [figures.beat_align(times, case.talk.accents) for times, case in zip(beats, cases, strict=True)]
    return {
        "main_accent": float((away <= figures.ON_ACCENT).mean()) if len(away) else 0.0,
        "main_accent_distance": float(np.median(away)) if len(away) else float("nan"),
        "accent_alignment": float(alignment[0] / max(alignment[1], 1e-9)),
        "beat_align": float(np.mean(aligned)),
        **_rest_figures(cases, shifts),
    }


def _rest_figures(cases: Sequence[Case], shifts: Sequence[float]) -> dict[str, float]:
    """Return arm speed and share of hands at rest, in pauses and in speech."""
    speeds, resting = {True: [], False: []}, {True: [], False: []}
    for case, shift in zip(cases, shifts, strict=True):
        quiet, speech = case.silence
        frames = round(shift * skeleton.FPS)
        for mask, silent in ((quiet, True), (speech, False)):
            speeds[silent].append(np.roll(case.arm_speed, frames)[mask])
            resting[silent].append(np.roll(case.at_rest, frames)[mask])

    def mean(parts: list[np.ndarray]) -> float:
        values = np.concatenate(parts)
        return float(values.mean()) if len(values) else float("nan")

    return {
        "pause_speed": mean(speeds[True]),
        "speech_speed": mean(speeds[False]),
        "pause_at_rest": mean(resting[True]),
        "speech_at_rest": mean(resting[False]),
    }


def _shifted_timing(cases: Sequence[Case], seed: int) -> dict[str, float]:
    """Return the figures of timing, mean over :data:`SHIFTS` random shifts."""
    random = np.random.default_rng(seed)
    rounds = []
    for _ in range(SHIFTS):
        room = [max(case.duration - 2 * LEAST_SHIFT, 0.0) for case in cases]
        rounds.append(timing(cases, [LEAST_SHIFT + random.random() * here for here in room]))
    with np.errstate(all="ignore"):
        return {name: float(np.mean([one[name] for one in rounds])) for name in rounds[0]}


def _shift(times: np.ndarray, shift: float, case: Case) -> np.ndarray:
    return (times + shift) % case.duration
