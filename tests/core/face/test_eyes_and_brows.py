"""Blinks at phrase ends, with shifts of gaze and in clusters; brows on main accents and in questions; moods by valence."""

import numpy as np
import pytest
from s2ag.core.face import brows, eyes
from s2ag.core.motion.face import RATE

PHRASES = np.array([[3.0 * k, 3.0 * k + 2.4] for k in range(200)])
COUNT = 600 * RATE


def random(seed=0):
    return np.random.default_rng(seed)


def near(moments, places, before, after):
    return np.mean([((moments >= place - before) & (moments <= place + after)).any() for place in places])


def test_blinks_come_as_phrases_end_and_in_clusters():
    moments = eyes.blink_times(PHRASES, [], COUNT, random())
    at_ends, inside = (near(moments, PHRASES[:, 1] + shift, 0.05, 0.2) for shift in (0.0, -1.2))
    assert at_ends > 0.4 > 2 * inside
    assert moments.size == pytest.approx(260, rel=0.2)  # 26 a minute
    gaps = np.diff(moments)
    assert gaps.min() >= 0.35 and np.mean(gaps < 0.9) > np.mean((gaps > 0.9) & (gaps < 1.45))


def test_blinks_come_with_large_shifts_of_gaze_alone():
    moments = np.arange(0.0, 600.0, 3.0) + 1.1
    for degrees, share in ((20.0, 0.3), (5.0, 0.0)):
        found = eyes.blink_times(np.zeros((0, 2)), [(moment, degrees) for moment in moments], COUNT, random())
        assert np.mean(np.isin(moments, found)) >= share and (share or not np.isin(moments, found).any())


def test_gaze_is_aside_while_a_phrase_is_planned():
    gaze, shifts = eyes.gaze(PHRASES, np.tile([0.0, -1.0, 0.0], (9000, 9, 1)), COUNT, random())
    away = np.abs(gaze[:, 0]) > 10
    starts, ends = (
        (PHRASES[:, side, None] * RATE + np.arange(*rows)).astype(int) for side, rows in ((0, (0, 30)), (1, (-30, 0)))
    )
    assert away[starts].mean() > 0.6 and away[ends].mean() < 0.1
    assert max(degrees for _, degrees in shifts) >= 14


def test_brows_rise_on_main_accents_more_than_on_others_and_just_before_them():
    times = np.arange(2.0, 590.0, 3.0)
    main, other = (brows.brow_raises([(t, 1.0, kind) for t in times], [], COUNT, random()) for kind in (True, False))
    rows = (times * RATE).astype(int)
    assert 0.4 < (main[rows] > 0.3).mean() < 0.7 and 0.05 < (other[rows] > 0.3).mean() < 0.25
    begins = np.flatnonzero(np.diff(main > 0) & (main[1:] > 0)) / RATE
    ahead = times[np.searchsorted(times, begins)] - begins
    assert ahead.min() > 0.1 and ahead.max() < 0.3


def test_brows_stay_up_through_a_question():
    raised = brows.brow_raises([], [(2.0, 2.8)], 500, random())
    assert (raised[200:265] > 0.69).all() and not raised[:180].any() and not raised[330:].any()


@pytest.mark.parametrize(("valence", "shown", "hidden"), [(0.8, "SMILE", "FROWN"), (-0.8, "FROWN", "SMILE")])
def test_valence_smiles_and_frowns(valence, shown, hidden):
    tracks = brows.mood_channels({"valence": valence}, np.zeros(1000), random())
    plain = brows.mood_channels({}, np.zeros(1000), random())
    assert tracks[shown].mean() > 0.3 > plain[shown].mean() and tracks[hidden].max() <= plain[hidden].max()
    quieter = brows.mood_channels({"valence": valence}, np.ones(1000), random())
    assert valence < 0 or quieter["SMILE"].mean() < 0.7 * tracks["SMILE"].mean()  # lips are busy
