"""Faces through the front door: asked for, they are there and the body is the same; not asked for, they are not."""

import json

import numpy as np
import pytest
from s2ag.core.errors import UsageError
from s2ag.core.motion import json_export
from s2ag.core.motion.face import CHANNELS, VISEMES
from s2ag.core.motion.motion import Motion
from s2ag.core.synthesis.session import Request, Session


@pytest.fixture(scope="module")
def takes(examples):
    session = Session(remember=True)
    asked = {"audio": examples / "hello.flac", "transcript": examples / "hello.txt", "takes": 2}
    return [session.synthesize(Request(**asked, face=face)).motions for face in (0.0, 1.0)]


def test_a_face_comes_where_it_is_asked_for_and_leaves_the_body_as_it_is(takes, tmp_path):
    plain, faced = takes
    assert all(motion.face is None for motion in plain) and all(motion.face is not None for motion in faced)
    for one, other in zip(plain, faced, strict=True):
        assert (one.directions == other.directions).all() and "face" not in one.meta and other.meta["face"] == 1.0
    first, second = (motion.face.weights for motion in faced)
    lips = slice(0, len(VISEMES))
    assert (first[:, lips] == second[:, lips]).all() and (first != second).any()
    faced[0].save(tmp_path / "a.npz")
    assert np.abs(Motion.load(tmp_path / "a.npz").face.weights - first).max() < 1e-6


def test_json_tells_phonemes_and_visemes(takes, tmp_path):
    json_export.save(takes[1][0], tmp_path / "a.json")
    face = json.loads((tmp_path / "a.json").read_text())["face"]
    assert face["channels"] == list(CHANNELS) and len(face["weights"][0]) == len(CHANNELS)
    assert face["phonemes"][0][0] == "HH" and {name for name, *_ in face["visemes"]} <= {*VISEMES, "sil"}
    assert face["visemes"][0][1] == 0 and face["visemes"][-1][2] == pytest.approx(len(face["weights"]) / face["rate"])


@pytest.mark.parametrize("wrong", [{"face": 2.1}, {"face": -1.0}, {"face_smoothness": 1.2}])
def test_what_is_out_of_range_is_said_in_a_sentence(wrong):
    with pytest.raises(UsageError, match="out of range"):
        Request("voice.wav", **wrong)
