"""The hands' own clock: loud speech hurries them, strokes land where they were planned."""

from types import SimpleNamespace

import numpy as np
from s2ag.core.learning.corpus import loudness_warp
from s2ag.core.motion import skeleton
from s2ag.core.smoothing import gaussian
from s2ag.core.sound.prosody import RATE

SECONDS = 30
TIME = np.arange(SECONDS * skeleton.FPS) / skeleton.FPS


def voice() -> np.ndarray:
    """A level at 100 Hz that swings by ten decibels every two seconds and a bit."""
    return -12 + 10 * np.sin(2 * np.pi * np.arange(SECONDS * RATE) / RATE / 2.3)


def scene(level: np.ndarray) -> SimpleNamespace:
    """What the clock asks of a scene: its level, smoothed, at given times."""
    at = (np.arange(len(level)) + 0.5) / RATE
    track = lambda values, seconds, time: np.interp(time, at, gaussian(values, seconds * RATE))  # noqa: E731
    return SimpleNamespace(prosody=SimpleNamespace(level=level), track=track)


def strokes(*times: float) -> list:
    return [SimpleNamespace(emphasis=time) for time in times]


def test_strokes_land_where_they_were_planned():
    planned = [3.2, 7.7, 12.1, 12.9, 24.0]
    clock = loudness_warp.warp_times(strokes(*planned), scene(voice()), TIME)
    np.testing.assert_allclose(np.interp(planned, TIME, clock), planned, atol=0.5 / skeleton.FPS)
    assert clock[0] == TIME[0]
    assert clock[-1] == TIME[-1]


def test_it_never_runs_backwards_and_is_faster_where_the_voice_is_loud():
    level = voice()
    clock = loudness_warp.warp_times(strokes(10.0, 20.0), scene(level), TIME)
    rate = np.diff(clock) * skeleton.FPS
    assert (rate > 0).all()
    heard = np.interp(TIME[1:], np.arange(len(level)) / RATE, level)
    assert np.corrcoef(rate, heard)[0, 1] > 0.8


def test_a_voice_of_one_loudness_leaves_the_hands_alone():
    clock = loudness_warp.warp_times(strokes(4.0, 9.0), scene(np.full(SECONDS * RATE, -15.0)), TIME)
    np.testing.assert_allclose(clock, TIME, atol=1e-6)


def test_silence_is_no_softer_than_silence():
    level = voice()
    level[: 5 * RATE] = -60.0
    much_softer = level.copy()
    much_softer[: 5 * RATE] = -90.0
    np.testing.assert_array_equal(*(loudness_warp.warp_times([], scene(each), TIME) for each in (level, much_softer)))


def test_hands_by_their_own_clock_pass_through_the_same_poses():
    angle = 0.6 * np.sin(TIME)
    arms = np.stack([np.sin(angle), np.cos(angle), 0 * angle], axis=-1)[:, None]
    clock = loudness_warp.warp_times(strokes(10.0), scene(voice()), TIME)
    played = loudness_warp.resample(arms, clock)
    there = 0.6 * np.sin(clock)
    np.testing.assert_allclose(played[:, 0, 0], np.sin(there), atol=2e-3)
