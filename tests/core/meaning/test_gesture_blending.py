"""Twenty phrases and their neutral twins: what is said is seen, and nothing else is touched."""

import json
from dataclasses import replace

import numpy as np
import pytest
from s2ag.core.meaning import gesture_blending, gesture_selection, vocabulary
from s2ag.core.motion import handshape, limits, rest, skeleton
from s2ag.core.motion.hands import Hands
from s2ag.core.motion.motion import Motion

ARMS = list(skeleton.ARM_EDGES)
FRAMES = 150
PAUSE = 3.0
"""Seconds before the phrase."""


@pytest.fixture(scope="module")
def known():
    return first_form(vocabulary.load_vocabulary())


def spoken(said: str, start: float = PAUSE) -> list[tuple[str, float, float]]:
    """Words a third of a second each."""
    return [(word, start + 0.33 * k, start + 0.33 * k + 0.3) for k, word in enumerate(said.split())]


def performance() -> np.ndarray:
    """Somebody who talks with a right hand that goes up and down, and little else."""
    time = np.arange(FRAMES) / skeleton.FPS
    body = np.tile(rest.REST.astype(float), (FRAMES, 1, 1))
    body[:, 8] = rest.slerp(body[:, 8], np.array([0.1, 0.1, 0.99]), 0.4 + 0.3 * np.sin(3 * time))
    return skeleton.normalize(body).astype(np.float32)


def shown(known, said: str, seed: int = 1):
    return gesture_selection.choose_gestures(known, spoken(said), {}, 1.0, (seed,))


def first_form(known):
    """The vocabulary with the first form of every gesture alone."""
    return replace(known, forms={name: forms[:1] for name, forms in known.forms.items()})


def both(known, said: str) -> tuple[np.ndarray, np.ndarray, gesture_selection.ScheduledGesture]:
    """The performance without and with what is said, and the gesture; the first seed that shows it."""
    plain = performance()
    for seed in range(20):
        strokes = shown(known, said, seed)
        if strokes:
            return (
                plain,
                limits.enforce_limits(
                    gesture_blending.blend_gestures(plain, strokes, gesture_blending.arms_of_gestures(plain, strokes))
                ),
                strokes[0],
            )
    raise AssertionError(f"nobody shows {said!r}")


def at(motion: np.ndarray, stroke: gesture_selection.ScheduledGesture) -> np.ndarray:
    """Joint positions ``(10, 3)`` where the stroke has landed."""
    return skeleton.to_positions(motion)[round((stroke.lands + 0.1) * skeleton.FPS)]


def head_yaw(motion: np.ndarray, stroke: gesture_selection.ScheduledGesture) -> float:
    """Degrees from the leftmost to the rightmost heading of the face around a stroke."""
    here = slice(round((stroke.lands - 0.5) * skeleton.FPS), round((stroke.lands + 1.2) * skeleton.FPS))
    return float(np.ptp(np.degrees(np.arctan2(motion[here, 2, 0], motion[here, 2, 2]))))


def test_negations_shake_the_head(known):
    for said in ("no", "never", "not at all", "of course not"):
        plain, motion, stroke = both(known, said)
        assert head_yaw(motion, stroke) > head_yaw(plain, stroke) + 10, said


def test_not_knowing_raises_shoulders_and_opens_both_arms(known):
    for said in ("i don't know", "no idea", "who knows", "maybe"):
        plain, motion, stroke = both(known, said)
        before, after = at(plain, stroke), at(motion, stroke)
        for shoulder, wrist, way in ((4, 6, -1), (7, 9, 1)):
            assert before[shoulder, 1] - after[shoulder, 1] > 0.03, said
            assert way * (after[wrist, 0] - after[shoulder, 0]) > 0.15, said
            assert after[wrist, 1] - after[shoulder, 1] < 0.45, said


def test_sizes_are_the_distance_of_the_hands(known):
    big, small = [], []
    for said, sizes in (("this big", big), ("huge", big), ("so much", big), ("tiny", small), ("this small", small)):
        _, motion, stroke = both(known, said)
        points = at(motion, stroke)
        sizes.append(float(np.linalg.norm(points[6] - points[9])))
        assert abs(points[6, 1] - points[9, 1]) < 0.08, said
    assert min(big) > 0.75 and max(small) < 0.35


def test_refusals_push_both_hands_away(known):
    for said in ("no way", "stop it"):
        _, motion, stroke = both(known, said)
        points = at(motion, stroke)
        assert (points[[6, 9], 2] - points[[4, 7], 2]).min() > 0.4, said


def test_pointing_reaches_to_where_it_points(known):
    _, motion, stroke = both(known, "over there")
    points, (left, right) = at(motion, stroke), gesture_blending.arms_of_gestures(performance(), [stroke])[0]
    assert left != right
    wrist, shoulder, way = (6, 4, -1) if left else (9, 7, 1)
    assert way * (points[wrist] - points[shoulder])[0] > 0.35
    _, motion, stroke = both(known, "as for me")
    points, (left, _) = at(motion, stroke), gesture_blending.arms_of_gestures(performance(), [stroke])[0]
    assert abs(points[6 if left else 9, 0]) < 0.12
    _, motion, stroke = both(known, "as for you")
    points, (left, _) = at(motion, stroke), gesture_blending.arms_of_gestures(performance(), [stroke])[0]
    wrist, shoulder = (6, 4) if left else (9, 7)
    assert (points[wrist] - points[shoulder])[2] > 0.45


def test_numbers_hold_one_hand_up_with_as_many_fingers(known):
    for said, fingers in (("first of all", 1), ("secondly,", 2), ("number three", 3)):
        plain, motion, stroke = both(known, said)
        points, (left, right) = at(motion, stroke), gesture_blending.arms_of_gestures(plain, [stroke])[0]
        assert left != right
        assert points[6 if left else 9, 1] < points[5 if left else 8, 1] - 0.15, said
        fingers_bent = stroke.gesture.shape[-1]
        bends = fingers_bent[:8:2] + fingers_bent[1:8:2]
        assert (bends < 20).sum() == fingers and (bends > 150).sum() == 4 - fingers


def test_a_contrast_goes_from_one_side_to_the_other(known):
    words = [*spoken("some like it,", 2.0), *spoken("but others do not.", 6.0), *spoken("However, it sells.", 10.0)]
    strokes = gesture_selection.choose_gestures(known, words, {}, 1.0, (2,))
    assert [one.gesture.name for one in strokes] == ["contrast", "contrast", "contrast"]
    assert strokes[0].side == -strokes[1].side == strokes[2].side != 0


def test_steps_of_a_list_go_on_to_the_side(known):
    words = [*spoken("Next we eat.", 2.0), *spoken("And then we sleep.", 4.5), *spoken("Finally we go.", 7.0)]
    strokes = gesture_selection.choose_gestures(known, words, {}, 1.0, (0,))
    across = [one.across for one in strokes]
    assert len(across) == 3 and across == sorted(across) and across[0] < 0 < across[-1]


def test_neutral_twins_are_left_alone_to_the_bit(known):
    plain = performance()
    for said in ("the table is green", "we walked home", "it rained on sunday", "she reads a book"):
        strokes = shown(known, said)
        np.testing.assert_array_equal(
            gesture_blending.blend_gestures(plain, strokes, gesture_blending.arms_of_gestures(plain, strokes)), plain
        )


def test_outside_of_its_time_a_gesture_changes_nothing(known):
    plain, _, stroke = both(known, "this big")
    motion = gesture_blending.blend_gestures(plain, [stroke], gesture_blending.arms_of_gestures(plain, [stroke]))
    time = np.arange(FRAMES) / skeleton.FPS
    away = (time < stroke.begin) | (time > max(stroke.end, stroke.lands + 1.2))
    np.testing.assert_array_equal(motion[away], plain[away])
    assert np.abs(motion[~away] - plain[~away]).max() > 0.1
    speed = np.degrees(np.linalg.norm(np.diff(motion, axis=0), axis=-1)).max() * skeleton.FPS
    assert speed < 450


def test_less_readiness_shows_less_and_marks_are_always_shown(known):
    words = [(text, 6.0 * k, 6.0 * k + 0.3) for k, text in enumerate(["No.", "Huge!", "Stop!", "There!", "Never!"] * 5)]
    counts = [len(gesture_selection.choose_gestures(known, words, {}, readiness, (3,))) for readiness in (0.0, 0.4, 1.0)]
    assert counts[0] == 0 < counts[1] < counts[2]
    asked = {1: ("point", -1.0), 2: ("three", 0.0), 3: ("nonsense", 0.0)}
    strokes = gesture_selection.choose_gestures(known, spoken("a b c d"), asked, 0.0, (3,))
    assert [(one.gesture.name, one.side) for one in strokes] == [("there", -1.0), ("three", 0.0)]


def test_gestures_that_nobody_asked_for_are_not_crowded(known):
    words = [(text, 0.5 * k, 0.5 * k + 0.3) for k, text in enumerate(["No.", "Huge!", "Maybe.", "Stop!"] * 6)]
    lands = [one.lands for one in gesture_selection.choose_gestures(known, words, {}, 1.0, (5,))]
    assert np.diff(lands).min() >= 1.4
    assert max(sum(abs(one - other) < 15 for other in lands) for one in lands) <= 7


def test_the_same_seed_shows_the_same_and_another_another(known):
    words = [(text, 6.0 * k, 6.0 * k + 0.3) for k, text in enumerate(["No.", "Huge!", "Maybe.", "Stop!", "There!"] * 4)]
    one, again, other = (gesture_selection.choose_gestures(known, words, {}, 0.5, (seed,)) for seed in (7, 7, 8))
    times = [[stroke.lands for stroke in each] for each in (one, again, other)]
    assert times[0] == times[1] != times[2]


def test_hands_show_what_arms_mean(known):
    down, relaxed = np.tile([0, 1.0, 0], (FRAMES, 2, 1)), np.tile(handshape.RELAXED, (FRAMES, 2, 1))
    for said, palm in (("i don't know", [0, -1, 0]), ("no way", [0, 0, 1])):
        plain, motion, stroke = both(known, said)
        hands = gesture_blending.blend_hands(
            Hands.of(motion[:, [5, 8]], down, relaxed), [stroke], gesture_blending.arms_of_gestures(plain, [stroke])
        )
        landed = round((stroke.lands + 0.1) * skeleton.FPS)
        assert (hands.palms[landed] @ np.array(palm)).min() > 0.7, said
    plain, motion, stroke = both(known, "number two")
    ease = Hands.of(motion[:, [5, 8]], down, relaxed)
    which = gesture_blending.arms_of_gestures(plain, [stroke])
    hands, (left, _) = gesture_blending.blend_hands(ease, [stroke], which), which[0]
    landed, showing_hand = round((stroke.lands + 0.1) * skeleton.FPS), 0 if left else 1
    bends = hands.shape[landed, showing_hand, :8:2] + hands.shape[landed, showing_hand, 1:8:2]
    assert (bends < 40).sum() == 2 and (bends > 150).sum() == 2
    np.testing.assert_allclose(hands.shape[0], ease.shape[0], atol=1e-4)
    np.testing.assert_allclose(hands.shape[:, 1 - showing_hand], ease.shape[:, 1 - showing_hand], atol=1e-4)


def acted(folder, **more):
    """A vocabulary whose "abracadabra" is a clip of two seconds in which the right arm goes up until 1.2 s."""
    time = np.arange(30) / skeleton.FPS
    body = np.tile(rest.REST.astype(float), (30, 1, 1))
    body[:, 7:9] = rest.slerp(body[:, 7:9], np.array([0.3, -0.8, 0.5]), np.exp(-(((time - 1.2) / 0.4) ** 2))[:, None])
    body[:, 2] = rest.slerp(body[:, 2], np.array([0.7, 0, 0.7]), time / 4)
    body = skeleton.normalize(body).astype(np.float32)
    hands = Hands.of(body[:, [5, 8]], np.tile([[1.0, 0, 0], [-1, 0, 0]], (30, 1, 1)), np.full((30, 2, 12), 12.0))
    Motion(body, hands=hands).save(folder / "magic.npz")
    given = {"says": ["abracadabra"], "clip": "magic.npz", "often": 1, **more}
    (folder / "own.json").write_text(json.dumps({"gestures": {"magic": given}}))
    return first_form(vocabulary.load_vocabulary(folder / "own.json")), body


def test_a_clip_is_played_so_that_its_stroke_lands_on_the_word(tmp_path):
    known, clip = acted(tmp_path)
    plain, motion, stroke = both(known, "abracadabra")
    assert stroke.gesture.acted.lands == pytest.approx(1.2) and stroke.gesture.acted.leading_arm == 1
    frame = round(stroke.lands * skeleton.FPS)
    apart = np.degrees(np.arccos(np.clip((motion[frame - 6 : frame + 7, ARMS] * clip[12:25, ARMS]).sum(-1), -1, 1)))
    assert apart.max() < 8  # of frames that lie up to half a frame apart, at 200 degrees a second
    assert motion[frame, 2, 0] > plain[frame, 2, 0] + 0.1
    performed = Hands.of(plain[:, [5, 8]], np.tile([0.0, 0, 1], (FRAMES, 2, 1)), np.full((FRAMES, 2, 12), 30.0))
    hands = gesture_blending.blend_hands(performed, [stroke], [(True, True)])
    np.testing.assert_allclose(hands.shape[frame], 12.0, atol=0.1)
    outside = np.arange(FRAMES) / skeleton.FPS > stroke.end + 0.1
    np.testing.assert_array_equal(motion[outside], limits.enforce_limits(plain)[outside])


def test_one_arm_plays_the_leading_arm_of_a_clip(tmp_path):
    known, clip = acted(tmp_path, arms="one", lands=1.0)
    plain, strokes = performance(), shown(known, "abracadabra")
    for which, edges, body in (((True, False), [4, 5], skeleton.mirror(clip)), ((False, True), [7, 8], clip)):
        motion, frame = gesture_blending.blend_gestures(plain, strokes, [which]), round(strokes[0].lands * skeleton.FPS)
        assert (motion[frame, edges] * body[15, edges]).sum(-1).min() > 0.99
        others = [edge for edge in range(9) if edge not in edges]
        np.testing.assert_array_equal(motion[:, others], plain[:, others])
