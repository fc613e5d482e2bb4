"""All figures of a set of performances, beside what they become when the motion is shifted in time."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...motion import skeleton
from ...motion.hands import Hands
from . import figures, kinematics, strokes
from .talks import Talk

SHIFTS = 20
"""Random shifts of every motion against its speech."""
LEAST_SHIFT = 2.0
"""Seconds."""


@dataclass(frozen=True)
class Case:
    """A talk, somebody's performance ``(frames, 9, 3)`` of it, the pose it rests in, where its windows join, and its hands if
    they are known."""

    talk: Talk
    directions: np.ndarray
    rest: np.ndarray
    joins: tuple[int, ...] = ()
    hands: Hands | None = None

    @property
    def duration(self) -> float:
        """Seconds."""
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
        """Degrees a second ``(frames,)``; the first frame takes the second's."""
        speed = kinematics.arm_speed(self.directions)
        return np.concatenate([speed[:1], speed])

    @cached_property
    def at_rest(self) -> np.ndarray:
        """Share of the hands ``(frames,)`` that are where they rest."""
        return (kinematics.away(self.directions, self.rest) < strokes.NEAR_REST).mean(axis=1)

    @cached_property
    def silence(self) -> tuple[np.ndarray, np.ndarray]:
        """Frames in which rest may be expected, and frames of speech."""
        return figures.pause_frames(self.talk.spoken, len(self.directions))


def measure(cases: Sequence[Case], width: int = 10, seed: int = 0) -> dict:
    """Every figure that a set of performances gives by itself; ``shuffled`` holds those of time when shifted in time.

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
    shuffled = _shuffled(cases, seed)
    tried = SHIFTS * max(sum(len(case.strokes) for case in cases), 1)
    # Where no shifted stroke ever hits, half a hit keeps the ratio finite and modest.
    result["main_accent_gain"] = result["main_accent"] / max(shuffled["main_accent"], 0.5 / tried)
    return {**result, "shuffled": shuffled}


def timing(cases: Sequence[Case], shifts: Sequence[float]) -> dict[str, float]:
    """The figures of when things happen, with every motion turned round by its shift (s) against its speech."""
    landed = [_turn(case.strokes, shift, case) for case, shift in zip(cases, shifts, strict=True)]
    beats = [_turn(case.beats, shift, case) for case, shift in zip(cases, shifts, strict=True)]
    away = np.concatenate([strokes.nearest(times, case.talk.main) for times, case in zip(landed, cases, strict=True)])
    answered = np.sum(
        [figures.accent_alignment(times, case.talk.accents) for times, case in zip(landed, cases, strict=True)], axis=0
    )
    aligned = [figures.beat_align(times, case.talk.accents) for times, case in zip(beats, cases, strict=True)]
    return {
        "main_accent": float((away <= figures.ON_ACCENT).mean()) if len(away) else 0.0,
        "main_accent_distance": float(np.median(away)) if len(away) else float("nan"),
        "accent_alignment": float(answered[0] / max(answered[1], 1e-9)),
        "beat_align": float(np.mean(aligned)),
        **_rest(cases, shifts),
    }


def _rest(cases: Sequence[Case], shifts: Sequence[float]) -> dict[str, float]:
    speeds, resting = {True: [], False: []}, {True: [], False: []}
    for case, shift in zip(cases, shifts, strict=True):
        quiet, speech = case.silence
        turn = round(shift * skeleton.FPS)
        for mask, silent in ((quiet, True), (speech, False)):
            speeds[silent].append(np.roll(case.arm_speed, turn)[mask])
            resting[silent].append(np.roll(case.at_rest, turn)[mask])

    def mean(parts: list[np.ndarray]) -> float:
        every = np.concatenate(parts)
        return float(every.mean()) if len(every) else float("nan")

    return {
        "pause_speed": mean(speeds[True]),
        "speech_speed": mean(speeds[False]),
        "pause_at_rest": mean(resting[True]),
        "speech_at_rest": mean(resting[False]),
    }


def _shuffled(cases: Sequence[Case], seed: int) -> dict[str, float]:
    random = np.random.default_rng(seed)
    rounds = []
    for _ in range(SHIFTS):
        room = [max(case.duration - 2 * LEAST_SHIFT, 0.0) for case in cases]
        rounds.append(timing(cases, [LEAST_SHIFT + random.random() * here for here in room]))
    with np.errstate(all="ignore"):
        return {name: float(np.mean([one[name] for one in rounds])) for name in rounds[0]}


def _turn(times: np.ndarray, shift: float, case: Case) -> np.ndarray:
    return (times + shift) % case.duration
