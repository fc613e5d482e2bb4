import numpy as np
import pytest
from s2ag.core.motion import limits, rest, skeleton
from s2ag.core.synthesis import style_sequence
from s2ag.core.synthesis.refine import Take, refine
from s2ag.core.synthesis.refine.arm_rest import arm_rest, readiness
from s2ag.core.synthesis.request import Request
from s2ag.core.synthesis.session import Session

FPS = skeleton.FPS
KEY = (3, (0, ()), {"shy student": 1.0})
FRONT = skeleton.normalize(np.array([[-0.2, 0.96, 0.1], [0.5, 0.3, 0.8]]))


def waiting(share: np.ndarray, sides=(0, 1)) -> np.ndarray:
    """Directions (frames, 9, 3) of standing whose hands are before the body by a share ``(frames,)``."""
    motion = np.tile(rest.REST.astype(float), (len(share), 1, 1))
    for side in sides:
        arm, mirror = list(skeleton.ARMS[side]), (1, 1, 1) if side == 0 else (-1, 1, 1)
        motion[:, arm] = rest.slerp(motion[:, arm], FRONT * mirror, share[:, None])
    return motion.astype(np.float32)


def plateau(begin: float, end: float, seconds: float = 12.0, way: float = 0.5) -> np.ndarray:
    """From 0 to 1 before ``begin``, and back after ``end``, all seconds."""
    time = np.arange(round(seconds * FPS)) / FPS
    share = np.clip(np.minimum(time - begin + way, end + way - time) / way, 0, 1)
    return share * share * (3 - 2 * share)


def above(motion: np.ndarray) -> np.ndarray:
    """Metres of both wrists above where they hang ``(frames, 2)``."""
    return skeleton.wrists(rest.REST)[:, 1] - skeleton.wrists(motion)[..., 1]


def sink(directions: np.ndarray, ready: np.ndarray, key: tuple, given=()) -> tuple[np.ndarray, np.ndarray]:
    """Directions after the rule, and how far each arm hangs ``(frames, 2)``."""
    return refine(directions, Take(given=given, ready=ready, key=key), [arm_rest])[:2]


def always(motion: np.ndarray) -> np.ndarray:
    return np.ones(len(motion))


def test_an_arm_that_waits_hangs_meanwhile_and_is_back_when_it_moves_on():
    drawn = waiting(plateau(2.0, 10.0), (1,))
    made, share = sink(drawn, always(drawn), KEY)
    assert above(drawn)[60:120, 1].min() > 0.12
    assert above(made)[60:120, 1].max() < 0.06 and share[60:120, 1].min() > 0.75
    np.testing.assert_array_equal(made[:12], drawn[:12])
    np.testing.assert_array_equal(made[-12:], drawn[-12:])
    others = [edge for edge in range(9) if edge not in skeleton.ARMS[1]]
    np.testing.assert_allclose(made[:, others[:4]], drawn[:, others[:4]], atol=1e-7)
    np.testing.assert_allclose(np.linalg.norm(made, axis=-1), 1, atol=1e-5)
    np.testing.assert_allclose(limits.enforce_limits(made), made, atol=1e-3)
    speed = np.linalg.norm(np.diff(skeleton.wrists(made), axis=0), axis=-1) * FPS
    assert speed.max() < 1.5


def test_arms_that_gesture_stay_to_the_bit():
    time = np.arange(180) / FPS
    drawn = waiting(0.5 + 0.5 * np.sin(2 * np.pi * 0.6 * time))
    made, share = sink(drawn, always(drawn), KEY)
    np.testing.assert_array_equal(made, drawn)
    assert not share.any()


@pytest.mark.parametrize("frames", [0, 1, 10])
def test_nobody_who_does_not_hang_and_nothing_short_is_changed(frames):
    for drawn in (waiting(plateau(2.0, 10.0)), waiting(plateau(0.2, 0.4))[:frames]):
        ready = always(drawn) * (len(drawn) <= frames)
        np.testing.assert_array_equal(sink(drawn, ready, KEY)[0], drawn)


def test_each_wait_has_a_chance_of_its_own_by_seed_and_readiness():
    share = np.concatenate([plateau(1.0, 4.0, 5.0) for _ in range(60)])
    drawn = waiting(share)

    def sinks(ready: float, seed: int = 3) -> np.ndarray:
        _, share = sink(drawn, np.full(len(drawn), ready), (seed, *KEY[1:]))
        return share.reshape(60, -1, 2).max(axis=1) > 0.5

    often, seldom = sinks(0.6), sinks(0.25)
    assert 0 < seldom.mean() < often.mean() < 1
    assert not (seldom & ~often).any()
    np.testing.assert_array_equal(often, sinks(0.6))
    assert (often != sinks(0.6, 4)).mean() > 0.15
    apart = (often[:, 0] != often[:, 1]).mean()
    assert 0 < apart < 0.3  # one arm alone at times, both together mostly


def test_a_wait_changes_no_other_one():
    drawn = waiting(np.concatenate([plateau(1.0, 4.0, 5.0) for _ in range(8)]))
    other = drawn.copy()
    other[:75] = waiting(np.zeros(75))
    ready = np.full(len(drawn), 0.5)
    np.testing.assert_array_equal(sink(drawn, ready, KEY)[0][90:], sink(other, ready, KEY)[0][90:])


def test_given_frames_stay_and_lead_into_what_sinks():
    drawn = waiting(plateau(2.0, 10.0))
    made, _ = sink(drawn, always(drawn), KEY, np.array([90]))
    np.testing.assert_array_equal(made[90], drawn[90])
    assert above(made)[60].max() < 0.5 * above(drawn)[60].min()
    assert np.abs(np.diff(skeleton.wrists(made), axis=0)).max() * FPS < 2


def test_what_sank_comes_up_where_nobody_is_ready():
    drawn = waiting(plateau(2.0, 10.0))
    ready = always(drawn)
    ready[105:] = 0
    made, _ = sink(drawn, ready, (1, *KEY[1:]))
    assert above(made)[70:95].max() < 0.06
    np.testing.assert_array_equal(made[105:], drawn[105:])


def test_in_silence_arms_go_where_they_rest():
    talking = np.repeat([1.0, 0.0, 1.0], 45)
    front = rest.REST.copy()
    front[list(skeleton.ARMS[0])] = FRONT
    hangs = np.full(len(talking), 0.5)
    by_side, before = (readiness(hangs, talking, pose) for pose in (rest.REST, front))
    assert by_side[67] > 0.99 and before[67] < 0.01
    np.testing.assert_allclose([by_side[5], before[5]], 0.5, atol=1e-6)
    assert not readiness(0 * hangs, talking, rest.REST).any()


def test_styles_hang_as_their_speakers_do():
    shipped = Session().checkpoint
    known = {one["name"]: one["hangs"] for one in shipped.speakers}
    assert known["diplomat"] > known["deadpan"] == 0

    def hanging(style: str) -> np.ndarray:
        return style_sequence.from_request(shipped, Request("none.wav", style=style)).hanging(11)

    np.testing.assert_allclose(hanging("diplomat"), known["diplomat"])
    walk = hanging("diplomat > deadpan")
    assert walk[0] == pytest.approx(known["diplomat"]) and walk[-1] == pytest.approx(0) and (np.diff(walk) <= 0).all()
