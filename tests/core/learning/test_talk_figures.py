"""Figures and faults of talk, on motions whose making is known."""

import numpy as np
import pytest
import talking
from s2ag.core.learning.evaluate import talk_faults, talk_figures
from s2ag.core.motion import rest, skeleton


def nodding(hertz: float, degrees: float, seconds: float = 20.0) -> np.ndarray:
    """The left forearm goes up and down about the horizontal, the right arm hangs."""
    time = np.arange(round(seconds * skeleton.FPS)) / skeleton.FPS
    angle = np.radians(degrees / 2) * np.sin(2 * np.pi * hertz * time)
    motion = np.tile(rest.REST, (len(time), 1, 1))
    motion[:, 5] = np.stack([np.zeros_like(angle), -np.sin(angle), np.cos(angle)], -1)
    return motion


def standing(frames: int = 60) -> np.ndarray:
    return np.tile(rest.REST, (frames, 1, 1))


def posed(edges: dict[int, list[float]], hold: int = 15) -> np.ndarray:
    """The resting pose, with other directions of some edges in the middle of it."""
    motion = standing(hold + 40)
    for edge, direction in edges.items():
        motion[20 : 20 + hold, edge] = skeleton.normalize(np.array(direction))
    return motion


def test_small_quick_movements_are_beats_in_their_band():
    found = talk_figures.figures([nodding(0.9, 40)])  # 0.33 m times 0.7 radians: 23 cm
    assert found["beats 0.6 to 1.2 Hz"] > 0.8
    assert found["bells a second"] == pytest.approx(1.8, abs=0.25)
    assert found["length of a bell, s"] == pytest.approx(0.56, abs=0.1)
    assert found["way of a bell, m"] == pytest.approx(0.2, abs=0.04)
    assert found["beats among strokes"] > 0.95 and found["moves over 45 cm a minute"] == 0
    assert found["leading hand's share"] > 0.99 and found["both elbows bent"] == 0


def test_arms_that_are_both_held_out_are_wide():
    arms = zip(skeleton.ARMS, (-1, 1), strict=True)
    left, right = ({upper: [side, 0.3, 0.5], fore: [side, -0.3, 0.5]} for (upper, fore), side in arms)
    assert talk_figures.both_wide(posed(left | right))[20:35].all()
    for one in (left, right, {}):
        assert not talk_figures.both_wide(posed(one)).any()


def test_large_slow_sweeps_are_no_beats():
    found = talk_figures.figures([nodding(0.3, 120)])
    assert found["beats 0.6 to 1.2 Hz"] < 0.2 and found["beats among strokes"] < 0.1  # edges cut one
    assert found["moves over 45 cm a minute"] == pytest.approx(36, abs=4)
    assert found["strokes under 20 cm"] < 0.1


def test_figures_at_equal_speed_are_of_windows_like_peoples():
    ours = [talking.talk(seed, 30, size=size) for seed, size in enumerate((0.12, 0.35))]
    people = [talking.talk(9, 30, size=0.12)]
    alone, alike = talk_figures.figures(ours), talk_figures.figures(ours, people)
    wanted = talk_figures.figures(people)["wrist speed, m/s"]
    assert alike["wrist speed, m/s"] == pytest.approx(wanted, rel=0.15) != alone["wrist speed, m/s"]
    assert alike["strokes a minute"] == alone["strokes a minute"]


def test_elbows_and_the_right_hand():
    assert talk_figures.elbows_bent(talking.talk(1, 10, size=0.05)).mean() > 0.95
    assert talk_figures.leading_share(nodding(1, 30)) < 0.01
    assert talk_figures.leading_share(skeleton.mirror(nodding(1, 30))) > 0.99


FAULTS = {
    "hands before the face": {4: [0.1, 0.35, 0.9], 5: [0.35, -0.9, 0.1]},
    "wing elbows": {4: [-0.95, 0.1, 0.2], 5: [0.3, 0.9, 0.3]},
    "across or wide": {4: [-0.9, 0.2, 0.3], 5: [-0.9, 0.1, 0.2]},
}


@pytest.mark.parametrize("name", FAULTS)
def test_each_fault_is_counted_once_on_either_side(name):
    for turn in (lambda motion: motion, skeleton.mirror):
        motion = turn(posed(FAULTS[name]))
        found = dict(zip(talk_faults.NAMES, talk_faults.found(skeleton.to_positions(motion)), strict=True))
        assert found[name][20:35].all() and not found[name][:20].any() and not found[name][35:].any()
        assert talk_faults.faults([motion])[name] == pytest.approx(60 * 15 / len(motion))


def test_an_arm_across_the_chest_is_far():
    motion = posed({4: [0.35, 0.7, 0.6], 5: [0.95, 0.0, 0.3]})
    assert talk_faults.faults([motion])["across or wide"] > 0


def test_fast_wrists_and_nothing_at_rest_or_on_a_perch():
    motion = standing()
    motion[30:, 5] = skeleton.normalize(np.array([0.0, 0, 1.0]))  # 0.4 m in one frame
    assert talk_faults.faults([motion])["wrists over 2.7 m/s"] == pytest.approx(60 * 15 / len(motion))
    assert not any(talk_faults.faults([standing(), talking.talk(1, 20, size=0.1)]).values())


def test_close_stretches_are_one_and_wings_must_last():
    motion = np.concatenate([posed(FAULTS["wing elbows"], hold=1)])
    assert talk_faults.faults([motion])["wing elbows"] == 0
    wrong = np.zeros(100, bool)
    wrong[[10, 13, 40]] = True
    assert talk_faults._stretches(wrong, 15) == 2
