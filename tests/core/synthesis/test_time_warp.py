"""The pace of performances: what the voice does to it, and that strokes, given frames and tiles stay where they belong."""

import numpy as np
import pytest
from s2ag.core.model.mfcc_timing import mfcc_slice
from s2ag.core.motion import skeleton
from s2ag.core.sound import prosody
from s2ag.core.synthesis import strokes, time_warp

FRAMES = 600
TIME = np.arange(FRAMES) / skeleton.FPS
VOICED = (TIME < 24) | (TIME > 30)


def rhythm(level: np.ndarray, accents: tuple = ()) -> prosody.Prosody:
    features = np.zeros((len(level), prosody.FEATURES), np.float32)
    features[:, prosody.FEATURE_NAMES.index("level")] = level
    return prosody.Prosody(accents, np.zeros((0, 2)), features, np.zeros(0), np.zeros(0))


@pytest.fixture(scope="module")
def level() -> np.ndarray:
    return np.where(VOICED, 0.3 * np.sin(2 * np.pi * TIME / 4), -2.5)


@pytest.fixture(scope="module")
def clock(level) -> time_warp.TimeWarp:
    return time_warp.warp_for(rhythm(level), VOICED.astype(float))


def turning(frames: int) -> np.ndarray:
    """Arms that go slowly to and fro."""
    angle = np.sin(np.arange(frames) / 15)[:, None] * np.linspace(0.5, 1, 9)
    return np.stack([np.sin(angle), np.cos(angle), np.zeros_like(angle)], -1).astype(np.float32)


def test_loud_stretches_are_hurried_through_and_soft_ones_not(clock, level):
    pace = np.gradient(clock.places)
    here = VOICED & (TIME > 4) & (TIME < 20)
    loud, soft = (pace[here & chosen].mean() for chosen in (level > 0.2, level < -0.2))
    assert loud > 1.2 and soft < 0.8
    assert pace.min() >= 0.4 - 1e-9 and pace.max() <= 1.6 + 1e-9


def test_pauses_are_gone_through_as_usual(clock):
    inside = (TIME > 25) & (TIME < 29)
    assert np.gradient(clock.places)[inside] == pytest.approx(1, abs=0.02)


def test_places_and_moments_are_of_each_other(clock):
    assert clock.places[0] == clock.moments[0] == 0 and (np.diff(clock.places) > 0).all() and (np.diff(clock.moments) > 0).all()
    assert len(clock.moments) == clock.frames and clock.frames - 1 >= clock.places[-1]
    there = np.interp(clock.places, np.arange(clock.frames), clock.moments)
    # Between two frames of the performance the way back is straight where the way there bends by 0.6 at most.
    assert np.abs(there - np.arange(FRAMES)).max() < 0.6


def test_nothing_known_and_nothing_said_leave_the_usual_tempo(level):
    assert time_warp.warp_for(None, np.ones(FRAMES)) is None
    assert time_warp.warp_for(rhythm(np.zeros(FRAMES)), np.zeros(FRAMES)) is None
    assert time_warp.warp_for(rhythm(level[:1]), np.ones(1)) is None


def test_what_goes_there_and_back_is_what_it_was(clock):
    poses = turning(FRAMES)
    known, there = clock.given(np.ones(FRAMES, bool), poses)
    assert known[:-2].all()
    back = skeleton.normalize(clock.back(there))
    step = np.linalg.norm(np.diff(poses, axis=0), axis=-1).max()
    assert np.linalg.norm(back - poses, axis=-1).max() < 0.3 * step


def test_given_frames_are_given_wherever_they_are(clock):
    poses = turning(FRAMES)
    for frame in (0, 1, 77, 78, 300, FRAMES - 1):
        mask = np.zeros(FRAMES, bool)
        mask[frame] = True
        known, there = clock.given(mask, poses)
        assert known.sum() == 1 and abs(np.flatnonzero(known)[0] - clock.places[frame]) < 1
        assert there[known][0] == pytest.approx(poses[frame], abs=1e-6)
    mask = (np.arange(FRAMES) >= 100) & (np.arange(FRAMES) < 200)
    known, there = clock.given(mask, poses)
    moments = clock.moments[known]
    assert 100 <= moments.min() < 102.5 and 196.5 < moments.max() <= 199
    assert not clock.given(np.zeros(FRAMES, bool), poses)[0].any()


def test_a_performance_hears_the_recording_along_its_clock(clock):
    asked = []

    def listen(start: int, stop: int):
        asked.append((start, stop))
        span = mfcc_slice(start, stop)
        frames = np.arange(start, stop, dtype=float)[:, None]
        return np.arange(span.start, span.stop, dtype=float)[:, None], frames, frames[: max(FRAMES - start, 0)]

    hear = clock.heard(listen)
    whole = hear(0, clock.frames)
    assert whole[1][:, 0] == pytest.approx(clock.moments, abs=0.5)
    assert len(whole[0]) == mfcc_slice(0, clock.frames).stop
    places = np.arange(len(whole[0])) * 12 / 25
    heard = np.interp(places, np.arange(clock.frames), clock.moments) * 25 / 12
    assert np.abs(whole[0][:, 0] - heard)[places < clock.frames - 1].max() <= 1.01  # halves of both frames
    # What is cut at frames that both rates share is what the whole has there: tiles do not show.
    part = hear(240, 360)
    rows = mfcc_slice(240, 360)
    assert (part[0] == whole[0][rows]).all() and (part[1] == whole[1][240:360]).all() and (part[2] == whole[2][240:360]).all()
    beyond = hear(clock.frames - 12, clock.frames + 24)
    assert len(beyond[1]) == 36 and np.isfinite(beyond[0]).all()
    assert all(start >= 0 for start, _ in asked)


STROKES = np.arange(4, 24, 2.5)
"""Seconds at which :func:`reaching` begins to move."""


def reaching(clock: time_warp.TimeWarp) -> np.ndarray:
    """A performance whose arms go from one place to the other in a second, and wait."""
    begun = np.clip(TIME[:, None] - STROKES, 0, 1)
    angle = (0.9 * (begun - np.sin(2 * np.pi * begun) / (2 * np.pi)) * (-1) ** np.arange(len(STROKES))).sum(1)[:, None, None]
    there = np.concatenate([np.sin(angle), np.cos(angle), np.zeros_like(angle)], -1) * np.ones((1, 9, 1))
    return clock.along(there.astype(np.float32))


def ends(motion: np.ndarray) -> np.ndarray:
    speeds = strokes.wrist_speeds(motion).max(1)
    places = strokes.stroke_places(speeds, skeleton.FPS)
    return np.array([strokes.stroke_span(speeds.tolist(), place)[1] for place in places]) / skeleton.FPS


def accented(level: np.ndarray, late: float, main: bool = True) -> time_warp.TimeWarp:
    """Return the clock of a recording with an accent so many seconds after each stroke's end as it would be without accents."""
    usual = time_warp.warp_for(rhythm(level), VOICED.astype(float))
    accents = tuple(prosody.Accent(at + late, 0.8, main, 0, -1) for at in ends(usual.back(reaching(usual))))
    return time_warp.warp_for(rhythm(level, accents), VOICED.astype(float))


@pytest.mark.parametrize("late", [-0.25, 0.2])
def test_strokes_near_main_accents_end_on_them(level, late):
    clock = accented(level, late)
    accents, made = clock.accents / skeleton.FPS, reaching(clock)
    led = clock.on_accents(made, np.zeros(FRAMES, bool))
    before, after = (np.abs(ends(one.back(made)) - accents) for one in (clock, led))
    # An accent pulls with a weight of 1 against one of 0.5 for staying, and ends are found to a frame.
    assert len(after) == len(STROKES) and np.median(after) <= before.max() / 3 + 1 / skeleton.FPS
    assert (np.diff(led.places) >= 0).all()


def test_strokes_far_from_main_accents_and_beside_weak_ones_keep_their_time(level):
    for clock in (accented(level, 0.9), accented(level, 0.2, main=False)):
        assert clock.on_accents(reaching(clock), np.zeros(FRAMES, bool)) is clock


def test_no_given_frame_is_led_to_an_accent(level):
    clock = accented(level, 0.3)
    given = (TIME > 8) & (TIME < 12)
    led = clock.on_accents(reaching(clock), given)
    np.testing.assert_array_equal(led.places[given], clock.places[given])
    assert np.abs(led.places - clock.places).max() > 1
