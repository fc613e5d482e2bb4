"""Figures of ``s2ag evaluate`` on motions whose figures are known."""

import numpy as np
import pytest

pytest.importorskip("scipy", reason="the engine is not installed")

from s2ag.core.learning.evaluate import comparisons, figures, goals, kinematics, speaker_identification, strokes  # noqa: E402
from s2ag.core.learning.evaluate.measure import Case, measure, timing  # noqa: E402
from s2ag.core.learning.evaluate.talks import Talk  # noqa: E402
from s2ag.core.motion import rest, skeleton  # noqa: E402

FPS = skeleton.FPS
RAISED = rest.REST.copy()
RAISED[[7, 8]] = skeleton.normalize(np.array([[0.3, 0.6, 0.7], [-0.1, -0.5, 0.9]]))


def ramp(time, begin, end):
    x = np.clip((time - begin) / (end - begin), 0, 1)
    return x**3 * (10 - 15 * x + 6 * x * x)


def gestures(landings, seconds=20.0, pose=RAISED, way=0.5):
    """The right hand comes up from rest within ``way`` seconds, lands, stays up for 0.6 s and goes back within 0.8 s."""
    time = np.arange(int(seconds * FPS)) / FPS
    weight = sum(ramp(time, at - way, at) * (1 - ramp(time, at + 0.6, at + 1.4)) for at in landings)
    return rest.slerp(np.broadcast_to(rest.REST, (len(time), 9, 3)), pose, np.broadcast_to(weight[:, None], (len(time), 9)))


def turning(degrees_a_second, seconds=4.0, edges=(5, 8)):
    """Edges that turn steadily about the vertical, all others still."""
    angle = np.radians(degrees_a_second) * np.arange(int(seconds * FPS)) / FPS
    motion = np.tile(skeleton.MEAN_UNIT.astype(float), (len(angle), 1, 1))
    motion[:, list(edges)] = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=-1)[:, None]
    return motion


def talk(accents, seconds=20.0, words=(), affect=None):
    accents = np.array(accents, float).reshape(-1, 3)
    return Talk("talk", "talk", np.zeros(int(seconds * 16000), np.float32), tuple(words), accents, affect=affect)


def test_strokes_are_found_where_the_hand_lands_and_not_where_it_returns():
    landings = np.array([2.0, 5.3, 9.1, 12.47, 16.0])
    found = strokes.detect(gestures(landings), rest.REST)
    assert len(found) == len(landings)  # one each: none of the five returns counts
    assert np.abs(found - landings).max() < 0.15
    mirrored = strokes.detect(skeleton.mirror(gestures(landings)), skeleton.mirror(rest.REST))
    np.testing.assert_allclose(mirrored, found, atol=0.01)


def test_a_stroke_replaces_the_preparation_just_before_it():
    time = np.arange(int(6 * FPS)) / FPS
    half, way = ramp(time, 1.0, 1.4), ramp(time, 1.5, 1.85)
    weight = 0.5 * half + 0.5 * way
    motion = rest.slerp(np.broadcast_to(rest.REST, (len(time), 9, 3)), RAISED, np.broadcast_to(weight[:, None], (len(time), 9)))
    (found,) = strokes.detect(motion, rest.REST)
    assert abs(found - 1.85) < 0.15


def test_who_does_not_move_or_only_sways_makes_no_strokes():
    still = np.tile(RAISED, (150, 1, 1))
    assert len(strokes.detect(still, rest.REST)) == 0
    assert len(strokes.detect(skeleton.normalize(still + rest.idle_offsets(150, seed=1)), rest.REST)) == 0
    assert len(strokes.detect(still[:2], rest.REST)) == 0


def test_agreement_counts_every_stroke_once():
    found, truth = [np.array([1.0, 1.2, 4.0])], [np.array([1.05, 3.9, 8.0])]
    result = strokes.detection_accuracy(found, truth)
    assert result["precision"] == pytest.approx(2 / 3) and result["recall"] == pytest.approx(2 / 3)
    assert result["f1"] == pytest.approx(2 / 3)
    assert result["bias"] == pytest.approx(0.025)
    assert strokes.detection_accuracy([np.zeros(0)], truth)["f1"] == 0


def test_nearness_to_accents():
    assert figures.share_near(np.array([1.0, 2.1, 3.2]), np.array([1.1, 3.0])) == pytest.approx(1 / 3)
    assert figures.share_near(np.zeros(0), np.array([1.0])) == 0
    assert np.isinf(strokes.distance_to_nearest(np.array([1.0]), np.zeros(0))).all()
    accents = np.array([[1.0, 0.8, 1], [2.0, 0.2, 0]])
    met, all_of_it = figures.accent_alignment(np.array([1.1]), accents)
    assert met / all_of_it == pytest.approx(0.8 * np.exp(-0.5), abs=1e-6)  # one sigma from the strong, far from the weak one
    assert figures.accent_alignment(np.zeros(0), accents)[0] == 0


def test_beats_are_the_minima_of_speed():
    time = np.arange(int(6 * FPS)) / FPS
    motion = np.tile(skeleton.MEAN_UNIT.astype(float), (len(time), 1, 1))
    angle = 0.8 * np.sin(2 * np.pi * 0.5 * time)  # turns round at 0.5, 1.5, 2.5 ... seconds
    motion[:, 8] = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=-1)
    beats = figures.kinematic_beats(motion)
    np.testing.assert_allclose(beats, np.arange(0.5, 6, 1.0), atol=0.05)
    accents = np.stack([np.arange(0.5, 6, 1.0), np.ones(6), np.ones(6)], axis=1)
    assert figures.beat_align(beats, accents) > 0.9
    assert figures.beat_align(beats, accents + [0.5, 0, 0]) < 0.01
    assert len(figures.kinematic_beats(np.tile(skeleton.MEAN_UNIT, (90, 1, 1)))) == 0


def test_angular_speeds_of_a_steady_turn():
    result = figures.speeds([turning(40.0), turning(2.0)])
    assert result["forearm_median"] == pytest.approx(21, abs=19.1) and result["forearm_p90"] == pytest.approx(40, abs=1e-6)
    assert result["forearm_under_5"] == pytest.approx(0.5) and result["upper_arm_under_5"] == 1
    assert kinematics.arm_speed(turning(40.0)) == pytest.approx(20)  # two of the four parts turn
    assert kinematics.angular_speed(turning(30.0), fps=30)[:, 5] == pytest.approx(60)


def test_jerk_grows_with_the_cube_of_the_tempo_and_with_size():
    time = np.arange(int(8 * FPS)) / FPS

    def wave(rate, size):
        motion = np.tile(skeleton.MEAN_UNIT.astype(float), (len(time), 1, 1))
        angle = size * np.sin(2 * np.pi * rate * time)
        motion[:, 8] = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=-1)
        return figures.gesture_motion([motion])

    slow, large, fast = wave(0.4, 0.5), wave(0.4, 0.55), wave(0.8, 0.5)
    assert 1.08 < large["jerk"] / slow["jerk"] < 1.2
    assert 6.5 < fast["jerk"] / slow["jerk"] < 8.5
    assert 3.2 < fast["jerk_per_speed"] / slow["jerk_per_speed"] < 4.3
    assert fast["energy"][8] == fast["energy"][5] == pytest.approx(2 * slow["energy"][8], rel=0.05)  # both sides together
    assert fast["energy"][4] == 0
    still = figures.gesture_motion([np.tile(RAISED, (60, 1, 1))])
    assert still["jerk"] == 0 and still["energy"] == [0.0] * 9


def test_rest_is_expected_inside_long_pauses_only():
    words = [("one", 0.5, 1.0), ("two", 1.8, 2.0), ("three", 6.0, 7.0)]
    quiet, speech = figures.pause_frames(words, int(9.5 * FPS))
    time = np.arange(len(quiet)) / FPS
    assert (quiet == (((time >= 3.0) & (time < 5.7)) | ((time >= 8.0) & (time < 9.2)))).mean() > 0.99
    assert not speech[(time > 2.1) & (time < 5.9)].any() and speech[time < 2.0].all()
    everything, nothing = figures.pause_frames([], 150)
    assert everything[20:140].all() and not nothing.any()


def test_impossible_bodies_are_counted():
    through = skeleton.MEAN_UNIT.astype(float).copy()
    through[[4, 5]] = skeleton.normalize(np.array([[0.0, 1.0, 0.0], [1.0, 0.0, -0.1]]))
    backward = rest.REST.astype(float).copy()
    backward[8] = skeleton.normalize(np.array([0.2, 0.3, -0.9]))
    motion = np.stack([rest.REST] * 2 + [through] + [backward])
    result = figures.body([motion])
    assert result["through_body"] == pytest.approx(0.25) and result["backward_elbows"] >= 0.25 and result["hands_touch"] == 0
    praying = rest.REST.astype(float).copy()
    shoulder = abs(skeleton.to_positions(praying)[4, 0])
    praying[[4, 7]] = [0, 1, 0]
    inward = shoulder / skeleton.LENGTHS[5]
    praying[[5, 8]] = [[inward, 0, np.sqrt(1 - inward**2)], [-inward, 0, np.sqrt(1 - inward**2)]]
    assert figures.body([np.stack([praying, rest.REST])])["hands_touch"] == 0.5


def test_a_jump_at_the_joins_shows():
    smooth = turning(20.0, 40.0)
    joins = list(range(20, 580, 25))
    assert figures.seams([smooth], [joins], 4) == pytest.approx({"seam_speed": 1, "seam_acceleration": 1}, abs=1e-6)
    broken = smooth.copy()
    for start in joins:
        broken[start:, 8] = broken[start:, 8] * [-1, 1, 1]
    shown = figures.seams([broken], [joins], 4)
    assert shown["seam_speed"] > 2 and shown["seam_acceleration"] > 2
    assert figures.seams([smooth], [joins[:3]], 4) == {}  # too few to say anything


def test_angles_between_performances():
    a, b = (np.tile(skeleton.MEAN_UNIT.astype(float), (10, 1, 1)) for _ in range(2))
    a[:, skeleton.ARM_EDGES] = [0, 1, 0]
    b[:, skeleton.ARM_EDGES] = [0, np.cos(np.radians(30)), np.sin(np.radians(30))]
    assert figures.mean_arm_angle(np.stack([a, b])) == pytest.approx(30)
    assert figures.mean_arm_angle(np.stack([a, b, b])) == pytest.approx(20)
    assert comparisons.takes([np.stack([a, a]), np.stack([a, b])]) == {"takes_apart": pytest.approx(15, abs=1e-3)}


def test_correlations():
    assert figures.correlations([1, 2, 3, 4], [1, 4, 9, 100]) == (pytest.approx(1), pytest.approx(0.79, abs=0.03))
    assert figures.correlations([1, 2, 3], [5, 5, 5]) == (0, 0)
    energy = {"calm": [1, 2, 3, 4], "lively": [4, 3, 2, 1]}
    found = comparisons.arousal([0.1, 0.4, 0.5, 0.9], energy)
    assert found["arousal_spearman"] == pytest.approx(-1) and found["arousal_by_style"]["calm"][0] == pytest.approx(1)


def test_speakers_with_manners_are_told_apart_and_the_same_one_is_not():
    random = np.random.default_rng(3)

    def perform(speaker, talk_number):
        pose = rest.slerp(rest.REST, RAISED, np.full(9, 0.3 + 0.15 * speaker))
        landings = np.sort(random.uniform(1, 18, 6))
        return skeleton.normalize(gestures(landings, pose=pose) + rest.idle_offsets(300, seed=talk_number))

    different = [np.stack([perform(speaker, number) for speaker in range(4)]) for number in range(6)]
    alike = [np.stack([perform(0, 9 * number + speaker) for speaker in range(4)]) for number in range(6)]
    told = comparisons.speakers(different)
    assert told["told_apart"] == pytest.approx(4) and told["told_apart_share"] == 1
    assert comparisons.speakers(alike)["told_apart"] < 2.5
    assert told["speakers_apart"] > comparisons.speakers(alike)["speakers_apart"]
    assert set(comparisons.speakers(different[:1])) == {"speakers_apart"}
    assert speaker_identification.features(different[0][0]).shape == (82,)


def test_the_slider_compares_with_its_middle():
    low, middle, high = ([turning(speed)] for speed in (10.0, 20.0, 50.0))
    assert comparisons.slider(low, middle, high) == {"slider_low": pytest.approx(0.5), "slider_high": pytest.approx(2.5)}


def test_strokes_on_the_accents_count_and_the_same_shifted_in_time_do_not():
    landings = np.array([2.0, 5.3, 9.1, 12.47, 16.0])
    accents = [(at + 0.04, 0.8, 1) for at in landings] + [(at + 1.3, 0.4, 0) for at in landings]
    motion = gestures(landings)
    case = Case(talk(accents, words=[("word", at - 0.2, at + 0.2) for at in landings]), motion, rest.REST)
    result = measure([case])
    assert result["main_accent"] == 1 and result["main_accent_gain"] > 4 and result["main_accent_distance"] < 0.15
    assert result["strokes_a_minute"] == pytest.approx(15, abs=0.1)
    assert result["shuffled"]["main_accent"] < 0.25
    assert timing([case], [10.0])["main_accent"] == np.mean(
        strokes.distance_to_nearest((case.strokes + 10) % 20, case.talk.main) <= 0.15
    )
    assert result["pause_at_rest"] > 0.6 > result["speech_at_rest"]
    frozen = measure([Case(case.talk, np.tile(rest.REST, (300, 1, 1)), rest.REST)])
    assert frozen["main_accent"] == 0 and frozen["strokes_a_minute"] == 0 and np.isnan(frozen["main_accent_distance"])


def test_goals_are_reached_and_compared():
    ratio, share = goals.Goal(2.5), goals.Goal(0.8, of="directed")
    assert ratio.reached(2.5) and not ratio.reached(2.4) and ratio.missing(2.4) == pytest.approx(0.1)
    assert share.reached(0.4, 0.5) and not share.reached(0.39, 0.5) and share.reached(0.4) is None
    between = goals.Goal(0.7, 1.3)
    assert between.beats(1.2, 0.8) and between.beats(1.35, 1.5) and not between.beats(0.5, 1.4)
    assert goals.Goal(better="lower").beats(0.2, 0.3) and not goals.Goal(better="higher").beats(0.2, 0.3)
    assert goals.Goal().beats(1, 2) is None and ratio.beats(np.nan, 1) is None and goals.Goal().missing(3) is None


COLUMNS = {
    "this": {"main_accent_gain": 2.6, "backward_elbows": 0.001, "told_apart": None},
    "compare": {"main_accent_gain": 2.8, "backward_elbows": 0.002},
    "directed": {"main_accent_gain": 3.0, "backward_elbows": 0.01},
    "resting": {"main_accent_gain": 0.0, "backward_elbows": 0.0},
    "one gesture": {"main_accent_gain": 9.0, "backward_elbows": 0.0},
}


def test_the_table_says_what_is_reached_and_leaves_out_what_is_unknown():
    lines = goals.table(COLUMNS)
    assert len(lines) == 4 and lines[0].startswith(
        "| figure | wanted | these weights | compared weights | directed | resting |"
    )
    assert lines[2].endswith("| at least 2.40 | 2.60 | 2.80 | 3.00 | 0.00 | 9.00 | yes | yes | one gesture |")
    assert "| at most 0.00 % | 0.10 % | 0.20 % | 1.00 % (misses) | 0.00 % | 0.00 % | **no**, by 0.10 % | yes |" in lines[3]
    assert lines[3].endswith("| resting, one gesture |")
    verdicts = goals.verdicts(COLUMNS)
    assert verdicts["backward_elbows"] == {
        "reached": False,
        "missing": pytest.approx(0.001),
        "not_worse": True,
        "dull": ["resting", "one gesture"],
    }
    assert verdicts["told_apart"] == {"reached": None, "missing": None, "not_worse": None, "dull": []}


def test_a_short_table_has_a_line_a_recording():
    recordings = {"a": COLUMNS, "b": {"this": {"main_accent_gain": 1.0}}}
    lines = goals.short_table(recordings, [("this", "main_accent_gain"), ("compare", "main_accent_gain")], goals.ROWS)
    name = "strokes on main accents, times the shifted ones"
    assert lines[0] == f"| recording | {name} | {name}, compared weights |"
    assert lines[2:] == ["| a | 2.60 | 2.80 |", "| b | 1.00 |  |"]


def test_names_of_goals_stand_alone():
    for rows in (goals.ROWS, goals.VARIETY):
        assert len({row.key for row in rows}) == len(rows)
        assert not [row.name for row in rows if row.goal.bounds(1.0) and row.name.startswith("...")]
