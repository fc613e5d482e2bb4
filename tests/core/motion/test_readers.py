"""Readers of motion files, on small files in the true layouts, axes and handedness; one sentence for each malformed one."""

import moving
import numpy as np
import pytest
from s2ag.core.errors import CorpusUnreadable
from s2ag.core.learning.datasets.body_model import model_offsets
from s2ag.core.learning.datasets.resampling import resample
from s2ag.core.motion import skeleton
from s2ag.core.motion.motion import Motion
from s2ag.core.motion.readers import bvh, smplx, ten_joints
from s2ag.rigs.bvh import save as save_bvh


@pytest.mark.parametrize("yaw", [0.0, 140.0])
@pytest.mark.parametrize("z_up", [False, True])
def test_bvh_in_the_canonical_frame(tmp_path, yaw, z_up):
    moving.bvh(tmp_path / "a.bvh", hips_yaw=0.0 if z_up else yaw, z_up=z_up)
    if z_up:  # forearm's rotation is about the file's own z, which is up there
        posed, fps = bvh.read(tmp_path / "a.bvh")
        made = ten_joints.directions(posed)
        assert fps == pytest.approx(60, abs=0.01)
        assert (made[:, 0, 1] < -0.9).all() and (made[:, 3, 0] < -0.5).all()
        return
    posed, fps = bvh.read(tmp_path / "a.bvh")
    moving.check(resample(ten_joints.directions(posed), fps))
    assert len(resample(ten_joints.directions(posed), fps)) == 75


def test_our_own_bvh_comes_back(tmp_path):
    rng = np.random.default_rng(0)
    time = np.arange(60)[:, None, None] / 15
    directions = skeleton.normalize(skeleton.MEAN_UNIT + 0.25 * np.sin(2 * time + rng.uniform(0, 6, (1, 9, 3))))
    directions[:, :4], directions[:, 6] = skeleton.MEAN_UNIT[:4], skeleton.MEAN_UNIT[6]
    save_bvh(Motion(directions.astype(np.float32)), tmp_path / "own.bvh")
    posed, fps = bvh.read(tmp_path / "own.bvh")
    found = ten_joints.directions(posed)
    assert fps == pytest.approx(15)
    arms = [4, 5, 7, 8]
    np.testing.assert_allclose(found[:, arms], directions[:, arms], atol=0.02)


def test_the_papers_joints_put_the_right_arm_first(tmp_path):
    moving.bvh(tmp_path / "a.bvh")
    directions = ten_joints.directions(bvh.read(tmp_path / "a.bvh")[0], paper=True)
    np.testing.assert_allclose(directions[-1, moving.RIGHT_FOREARM], moving.FORWARD, atol=0.08)
    np.testing.assert_allclose(directions[-1, moving.LEFT_FOREARM], moving.DOWN, atol=0.08)
    assert directions[0, 3, 0] > 0.5


def test_smplx_in_the_canonical_frame(tmp_path):
    moving.smplx(tmp_path / "a.npz")
    posed, fps = smplx.read(tmp_path / "a.npz")
    assert fps == 30
    moving.check(resample(ten_joints.directions(posed), fps))


def test_a_users_body_replaces_the_average_one(tmp_path):
    joints = np.zeros((22, 3))
    for row, parent in enumerate(smplx.PARENTS):
        joints[row] = smplx.OFFSETS[row] * 2 + (joints[parent] if parent >= 0 else 0)
    np.savez(tmp_path / "model.npz", v_template=joints, J_regressor=np.eye(22))
    np.testing.assert_allclose(model_offsets(tmp_path / "model.npz"), 2 * smplx.OFFSETS, atol=1e-12)
    with pytest.raises(CorpusUnreadable, match="no SMPL-X model"):
        model_offsets(tmp_path / "absent.npz")


def test_turns_are_proper_rotations(tmp_path):
    moving.bvh(tmp_path / "a.bvh", hips_yaw=73)
    turn = ten_joints.frontal(bvh.read(tmp_path / "a.bvh")[0])
    np.testing.assert_allclose(np.linalg.det(turn), 1)


def test_malformed_files_are_one_sentence(tmp_path):
    moving.bvh(tmp_path / "good.bvh", frames=3)
    text = (tmp_path / "good.bvh").read_text()
    broken = {
        "empty": "",
        "cut": text[: len(text) // 3], "short": text.rsplit("\n", 3)[0], "letters": text[:-20] + " x y z\n",
        "channel": text.replace("Xrotation", "Xturn"), "frames": text.replace("Frames: 3", "Frames: 0"),
        "foreign": "MOTION HIERARCHY {",
        "still": "HIERARCHY\nROOT Hips { OFFSET 0 0 0 CHANNELS 0 }\nMOTION\nFrames: 9999999 Frame Time: 0.004\n",
    }  # fmt: skip
    for name, content in broken.items():
        (tmp_path / f"{name}.bvh").write_text(content)
        with pytest.raises(CorpusUnreadable, match="is no BVH file"):
            bvh.read(tmp_path / f"{name}.bvh")
    with pytest.raises(CorpusUnreadable, match="cannot be read"):
        bvh.read(tmp_path / "absent.bvh")
    (tmp_path / "odd.bvh").write_text(text.replace("LeftForeArm", "Tentacle"))
    with pytest.raises(CorpusUnreadable, match="no joint for left elbow"):
        ten_joints.directions(bvh.read(tmp_path / "odd.bvh")[0])
    np.savez(tmp_path / "few.npz", poses=np.zeros((5, 9)))
    (tmp_path / "noise.npz").write_bytes(b"zip")
    for name, sentence in (("few", "shape"), ("noise", "no SMPL-X motion")):
        with pytest.raises(CorpusUnreadable, match=sentence):
            smplx.read(tmp_path / f"{name}.npz")


def test_bvh_names_with_spaces(tmp_path):
    moving.bvh(tmp_path / "a.bvh")
    text = (tmp_path / "a.bvh").read_text("utf-8")
    name = next(line.split()[1] for line in text.splitlines() if "JOINT" in line)
    (tmp_path / "b.bvh").write_text(text.replace(f"JOINT {name}\n", f"JOINT Bip01 {name} A\n"), "utf-8")
    plain, spaced = bvh.read(tmp_path / "a.bvh")[0], bvh.read(tmp_path / "b.bvh")[0]
    assert f"Bip01 {name} A" in spaced.names and name in plain.names
    assert np.array_equal(plain.positions, spaced.positions)
