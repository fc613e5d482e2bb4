"""Unity clips: the format on small files made here, the captured conversation where it is present."""

import numpy as np
import pytest
from s2ag.core.learning.corpus import smartbody, unity
from s2ag.core.motion import skeleton

HALF = 2**-0.5


def keys(values: list[tuple[float, str, str, str]]) -> str:
    """Keys as Unity writes them, from (time, value, slope before, slope after)."""
    return "".join(
        f"      - serializedVersion: 3\n        time: {time}\n        value: {value}\n        inSlope: {before}\n"
        f"        outSlope: {after}\n        tangentMode: 0\n        weightedMode: 0\n"
        for time, value, before, after in values
    )


def curve(path: str, values: list[tuple[float, str, str, str]]) -> str:
    return (
        f"  - curve:\n      serializedVersion: 2\n      m_Curve:\n{keys(values)}      m_PreInfinity: 2\n"
        f"      m_PostInfinity: 2\n      m_RotationOrder: 4\n    path: {path}\n"
    )


def still(value: str) -> list[tuple[float, str, str, str]]:
    zero = "{x: 0, y: 0, z: 0" + (", w: 0}" if "w" in value else "}")
    return [(0, value, zero, zero), (1, value, zero, zero)]


NO_TURN = "{x: 0, y: 0, z: 0, w: 1}"
FLAT = "{x: 0, y: 0, z: 0, w: 0}"
# the upper arm turns by 90 degrees about Unity's y: with the left hand's thumb up, from +x towards -z
TURNING = [(0, NO_TURN, FLAT, FLAT), (1, f"{{x: 0, y: {HALF},\n          z: 0, w: {HALF}}}", FLAT, FLAT)]
SMALL = (
    "%YAML 1.1\n%TAG !u! tag:unity3d.com,2011:\n--- !u!74 &7400000\nAnimationClip:\n  m_Name: small\n  m_RotationCurves:\n"
    + curve("Hip", still(NO_TURN))
    + curve("Hip/Upper Arm", TURNING)
    + curve("Hip/Upper\n      Arm/Hand", still(NO_TURN))
    + "  m_CompressedRotationCurves: []\n  m_EulerCurves: []\n  m_PositionCurves:\n"
    + curve("Hip", still("{x: 0, y: 1, z: 0}"))
    + curve("Hip/Upper Arm", still("{x: 0.25, y: 0.5, z: 0}"))
    + curve("Hip/Upper\n      Arm/Hand", still("{x: 0.5, y: 0, z: 0}"))
    + "  m_ScaleCurves: []\n  m_SampleRate: 4\n  m_WrapMode: 0\n"
)


@pytest.fixture
def small(tmp_path):
    path = tmp_path / "small.anim"
    path.write_text(SMALL)
    return path


@pytest.fixture(scope="module")
def conversation(shared):
    if not (shared / unity.CONVERSATION).is_file():
        pytest.skip("the conversation is absent")
    return unity.load(shared / unity.CONVERSATION)


def test_curves_are_read_by_path_even_where_lines_are_folded(small):
    animation = unity.load(small)
    assert set(animation.rotations) == set(animation.positions) == {"Hip", "Hip/Upper Arm", "Hip/Upper Arm/Hand"}
    assert animation.fps == 4 and animation.duration == 1
    np.testing.assert_allclose(animation.rotations["Hip/Upper Arm"].values[1], [0, HALF, 0, HALF])


def test_curves_follow_their_slopes_and_steps():
    def at(before, after):
        slopes = np.array([[0.0], [before]]), np.array([[after], [0.0]])
        return unity.Curve(np.array([1.0, 3.0]), np.array([[2.0], [6.0]]), *slopes).at(np.array([0, 1, 2, 2.5, 3, 9]))[:, 0]

    np.testing.assert_allclose(at(2, 2), [2, 2, 4, 5, 6, 6])
    np.testing.assert_allclose(at(0, 0), [2, 2, 4, 5.375, 6, 6])
    np.testing.assert_allclose(at(0, np.inf), [2, 2, 2, 2, 6, 6])


def test_the_left_handed_file_becomes_a_right_handed_body(small):
    joints, recording = unity.to_recording(unity.load(small))
    assert [joint.name for joint in joints] == ["Hip", "Upper Arm", "Hand"] and [joint.parent for joint in joints] == [-1, 0, 1]
    positions, _ = smartbody.forward_kinematics(joints, recording, {"Hand"})
    # x is mirrored, so an arm along Unity's +x (the right) lies at our -x, and swings back as it did there
    np.testing.assert_allclose(positions["Hand"][0], [-0.75, 1.5, 0], atol=1e-7)
    np.testing.assert_allclose(positions["Hand"][-1], [-0.25, 1.5, -0.5], atol=1e-7)


def test_a_turned_rest_pose_is_taken_out(tmp_path):
    path = tmp_path / "turned.anim"
    path.write_text(SMALL.replace(NO_TURN, f"{{x: 0, y: 0, z: {HALF}, w: {HALF}}}", 2))
    joints, recording = unity.to_recording(unity.load(path))
    still_positions, _ = smartbody.forward_kinematics(joints, None, {"Hand"})
    positions, rotations = smartbody.forward_kinematics(joints, recording, {"Hand"})
    np.testing.assert_allclose(still_positions["Hand"][0], positions["Hand"][0], atol=1e-7)
    # Unity's quarter turn about z takes (0.25, 0.5) to (-0.5, 0.25) and the hand's (0.5, 0) to (0, 0.5)
    np.testing.assert_allclose(positions["Hand"][0], [0.5, 1.75, 0], atol=1e-7)
    np.testing.assert_allclose(np.abs(rotations["Hand"][0]), [1, 0, 0, 0], atol=1e-7)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "solid cube\n",
        SMALL[: len(SMALL) // 2],
        SMALL.replace("time: 1\n", "time: soon\n", 1),
        SMALL.replace("    path: Hip/Upper Arm\n", "    path: Elsewhere/Upper Arm\n"),
    ],
)
def test_what_is_no_whole_clip_is_refused(tmp_path, text):
    path = tmp_path / "bad.anim"
    path.write_text(text)
    with pytest.raises(ValueError, match=r"bad\.anim"):
        unity.load(path)


def test_the_conversation_starts_in_a_t_pose(conversation):
    joints, recording = unity.to_recording(conversation)
    assert len(recording.times) == 999
    wanted = unity.BIPED.all() | {"Bip01 L Foot", "Bip01 R Foot", "Bip01 L Toe0", "Bip01 MNose"}
    positions, rotations = smartbody.forward_kinematics(joints, recording, wanted)
    at = {name.removeprefix("Bip01 "): position[0] for name, position in positions.items()}
    assert 1.6 < at["Head"][1] < 1.9 and at["Head"][1] > at["Neck"][1] > at["Spine2"][1] > at["Pelvis"][1] > at["L Foot"][1]
    np.testing.assert_allclose(at["L Hand"] - at["Neck"], (at["R Hand"] - at["Neck"]) * [-1, 1, 1], atol=1e-3)
    assert 0.7 < at["L Hand"][0] < 0.8 and abs(at["L Hand"][1] - at["L UpperArm"][1]) < 0.05
    assert at["MNose"][2] > at["Head"][2] + 0.05 and at["L Toe0"][2] > at["L Foot"][2] + 0.05
    np.testing.assert_allclose(np.abs(rotations["Bip01 Head"][0]), [1, 0, 0, 0], atol=1e-6)
    for start, end in (("L UpperArm", "L Forearm"), ("L Forearm", "L Hand"), ("R UpperArm", "R Forearm"), ("Neck", "Head")):
        length = np.linalg.norm(positions[f"Bip01 {end}"] - positions[f"Bip01 {start}"], axis=-1)
        np.testing.assert_allclose(length, length[0], rtol=1e-5)


def test_the_conversation_shows_a_person_who_talks_with_the_hands(conversation):
    directions = unity.to_directions(conversation, *unity.STRETCH)
    assert directions.shape == (706, 9, 3) and directions.dtype == np.float32
    np.testing.assert_allclose(np.linalg.norm(directions, axis=-1), 1, atol=1e-5)
    mean = skeleton.normalize(directions.mean(axis=0))
    assert np.degrees(np.arccos((mean * skeleton.MEAN_UNIT).sum(-1)))[[0, 1, 2, 3, 6]].max() < 4
    points = skeleton.canonical_to_y_up(skeleton.to_positions(directions))
    assert (points[:, 1, 1] > 0.2).all() and (points[:, 3, 1] > 0.38).all(), "the trunk is upright"
    assert (points[:, 4, 0] > 0.1).all() and (points[:, 7, 0] < -0.1).all(), "the left shoulder is on the left"
    wrists = points[:, [6, 9]]
    assert np.median(wrists[..., 2]) > 0.1 and (wrists[..., 2] > -0.1).mean() > 0.95, "the hands are before the body"
    assert np.median(wrists[:, 0, 0]) > 0.1 > -0.05 > np.median(wrists[:, 1, 0])
    speed = np.linalg.norm(np.diff(wrists, axis=0), axis=-1) * 30
    assert 0.1 < speed.mean() < 0.8 and speed.max() < 6


def test_slow_turns_of_the_body_are_taken_out_and_quick_ones_stay(conversation):
    directions = unity.to_directions(conversation, *unity.STRETCH).astype(float)
    shoulders = -(directions[:, 3] - directions[:, 6])
    yaw = np.degrees(np.unwrap(np.arctan2(shoulders[:, 2], shoulders[:, 0])))
    assert abs(yaw.mean()) < 1 and 3 < yaw.std() < 12
