"""Weight that goes from foot to foot during a performance."""

import zlib

import numpy as np
import pytest
from s2ag.core.motion import skeleton
from s2ag.core.synthesis import stance

FPS = 15
MINUTES = 4
FRAMES = MINUTES * 60 * FPS


def speech(frames=FRAMES):
    """Activity of somebody who pauses for half a second every five."""
    return (np.arange(frames) % (5 * FPS) > 0.5 * FPS).astype(float)


def gestures(speed, frames=FRAMES):
    """Forearms that swing as fast as asked (degrees a second)."""
    time = np.arange(frames) / FPS
    pose = np.repeat(skeleton.REST[None], frames, 0).astype(float)
    pose[:, [5, 8], 0] += (np.radians(speed) * np.sin(2.0 * time))[:, None]
    return skeleton.normalize(pose)


def changes(pelvis):
    """Frames in the middle of changes of weight, from one side of the feet or the middle to another."""
    slow = np.convolve(pelvis.place[:, 0], np.ones(2 * FPS) / (2 * FPS), "same")
    speed = np.abs(np.gradient(slow)) * FPS
    peaks = 1 + np.flatnonzero((speed[1:-1] > speed[:-2]) & (speed[1:-1] >= speed[2:]) & (speed[1:-1] > 0.012))
    kept = []
    for peak in peaks:
        if not kept or peak - kept[-1] > 2 * FPS:
            kept.append(peak)
    return np.array(kept)


@pytest.mark.parametrize("seed", range(4))
def test_weight_shifts_as_far_as_captured_people_do(seed):
    pelvis = stance.synthesize_pelvis(gestures(40), speech(), style="a", seed=seed)
    assert np.ptp(pelvis.place[:, 0]) > 0.06  # from one foot to the other
    assert np.abs(pelvis.place[:, 0]).max() < 0.16
    assert pelvis.place[:, 1].min() > -0.005 and 0.001 < pelvis.place[:, 1].mean() < 0.02  # a knee is never stiff; y is down
    assert np.degrees(np.abs(pelvis.turn)).max() < 12


def test_it_is_smooth_and_never_still():
    pelvis = stance.synthesize_pelvis(gestures(40), speech(), style="a")
    steps = np.linalg.norm(np.diff(pelvis.place, axis=0), axis=-1) * FPS
    assert steps.max() < 0.25 and np.abs(np.diff(pelvis.place, n=2, axis=0)).max() < 0.004
    moved = [np.ptp(pelvis.place[start : start + 5 * FPS], axis=0).max() for start in range(0, FRAMES, 5 * FPS)]
    assert min(moved) > 0.0005


def test_calm_performers_shift_seldom():
    counts = []
    for speed in (5, 120):
        made = [stance.synthesize_pelvis(gestures(speed), speech(), style=name) for name in "abcdef"]
        counts.append(np.mean([len(changes(one)) for one in made]) / MINUTES)
    assert counts[0] < 0.6 * counts[1]
    assert 0.5 < counts[0] < counts[1] < 7  # a minute


def test_changes_come_where_speech_pauses():
    """The way lasts two seconds; it begins with a pause."""
    near = []
    for name in "abcdef":
        pelvis = stance.synthesize_pelvis(gestures(60), speech(), style=name)
        begins = (changes(pelvis) / FPS - 1.2) % 5
        near += list(np.minimum(begins, 5 - begins))
    assert np.median(near) < 0.7


def test_the_same_seed_gives_the_same_and_another_another():
    first, again, other = (stance.synthesize_pelvis(gestures(40), speech(), style="a", seed=seed) for seed in (1, 1, 2))
    assert zlib.crc32(first.place.tobytes()) == zlib.crc32(again.place.tobytes())
    assert np.abs(first.place - other.place).max() > 0.02


@pytest.mark.parametrize("frames", [1, 2, 20])
def test_short_performances(frames):
    assert len(stance.synthesize_pelvis(gestures(40, frames), speech(frames), (("a", 0.0, 0.1), ("b", 0.8, 1.0)))) == frames
