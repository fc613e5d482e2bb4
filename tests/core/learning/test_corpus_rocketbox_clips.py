"""Captured clips of the Rocketbox library: a small body whose pose is known, and the clips where they are present."""

import numpy as np
import pytest
from s2ag.core.learning.corpus import rocketbox_clips, unity
from s2ag.core.learning.evaluate import talk_split
from s2ag.core.motion import skeleton


def angles(one, other):
    return np.degrees(np.arccos(np.clip((one * other).sum(-1), -1, 1)))


@pytest.fixture
def folder(shared):
    return shared / rocketbox_clips.FOLDER


def changed(path, tmp_path, **arrays):
    with np.load(path) as data:
        content = {key: data[key] for key in data.files} | arrays
    np.savez(tmp_path / "changed.npz", **content)
    return rocketbox_clips.load(tmp_path / "changed.npz")


def test_the_bind_pose_is_upright_and_a_turned_body_faces_forward(folder, tmp_path):
    path = folder / "m_gestic_shrug_01.npz"
    with np.load(path) as data:
        bind, frames = data["bind_q"].astype(float), len(data["q"])
    w, x, y, z = bind[0]
    bind_turned = bind.copy()
    bind_turned[0] = [-z, -y, x, w]  # a half turn about z times the root's rotation
    for pose in (bind, bind_turned):
        pose = np.round(pose / np.linalg.norm(pose, axis=-1, keepdims=True) * 32767).astype(np.int16)
        capture = changed(path, tmp_path, q=np.tile(pose, (frames, 1, 1)))
        trunk = [0, 1, 2, 3, 6]
        assert angles(capture.directions[:, trunk], skeleton.MEAN_UNIT[trunk]).max() < 0.5
        left, right = capture.directions[0, 4], capture.directions[0, 7]
        assert left[0] < -0.4 and right[0] > 0.4 and left[1] > 0.4 and right[1] > 0.4  # out and down


def test_the_conversation_is_that_of_the_unity_file(shared, folder):
    capture = rocketbox_clips.load(folder / "m_conversation.npz")
    animation = unity.load(shared / unity.CONVERSATION)
    other = skeleton.normalize(unity.to_directions(animation, 2, animation.duration))[::2][: len(capture.directions)]
    away = angles(capture.directions[: len(other)], other).mean(0)
    # the other reader has the trunk relative to the clip's mean pose; arms differ by the heading's smoothing at the ends
    assert away[list(skeleton.ARM_EDGES)].max() < 12
    assert capture.fps == 15 and capture.hands is not None and len(capture.hands) == len(capture.directions)
    assert not capture.fingers


def test_all_clips_are_read_and_standing_ones_start_with_hanging_arms(folder):
    captures = [rocketbox_clips.load(path) for path in sorted(folder.glob("*_gestic_*.npz"))]
    assert len(captures) > 30
    for capture in captures:
        assert np.allclose(np.linalg.norm(capture.directions, axis=-1), 1, atol=1e-5)
        if "_sit_" not in capture.name and "shrug" not in capture.name:
            assert (capture.directions[0, list(skeleton.ARM_EDGES), 1] > 0.8).all(), capture.name
    assert any(capture.fingers for capture in captures)


def test_left_hand_of_a_left_presentation_moves_more_and_the_mirror_swaps_it(folder):
    capture = rocketbox_clips.load(folder / "m_gestic_presentation_left_01.npz")
    for each, more in ((capture, 0), (capture.mirrored(), 1)):
        path = np.linalg.norm(np.diff(skeleton.wrists(each.directions), axis=0), axis=-1).sum(0)
        assert path[more] > 1.2 * path[1 - more]


def test_no_clip(tmp_path):
    (tmp_path / "a.npz").write_bytes(b"no")
    with pytest.raises(ValueError, match="no packed"):
        rocketbox_clips.load(tmp_path / "a.npz")


def test_the_split_has_two_parts_that_exist(folder):
    chosen, reported = set(talk_split.CAPTURED_CHOSEN_ON), set(talk_split.CAPTURED_REPORTED)
    assert not chosen & reported
    assert all((folder / f"{name}.npz").is_file() for name in chosen | reported)
    assert all(map(talk_split.may_choose_on, chosen)) and not any(map(talk_split.may_choose_on, reported))
    assert talk_split.may_choose_on("arctic_b0410.opus") and not talk_split.may_choose_on("arctic_b0510.opus")
    assert not talk_split.may_choose_on("thorsten_emotional/angry.wav")
