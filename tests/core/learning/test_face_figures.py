"""Figures of speaking faces, as ``s2ag evaluate --faces`` tells them."""

import json

import numpy as np
import pytest
from s2ag.core.cli.main import main
from s2ag.core.learning.evaluate import faces
from s2ag.core.motion.face import CHANNELS, Face


def test_the_example_s_face_beside_people(examples, tmp_path, capsys):
    assert main(["evaluate", "--faces", "--human", str(examples / "hello.flac"), "--report", str(tmp_path / "new")]) == 0
    (told,) = json.loads((tmp_path / "new" / "faces.json").read_text()).values()
    assert told["closures_24"] == told["closures_60"] == 1 and told["closures_by_ear_24"] >= 0.6
    assert told["jaw_with_loudness"] > 0.4 and told["shortest_viseme_ms"] >= 25 and 12 <= told["blinks_a_minute"] <= 45
    table = capsys.readouterr().out
    assert "hello.flac" in table and "Bentivoglio" in table and "100% at 24 fps" in table


def test_without_faces_a_corpus_is_needed(capsys):
    assert main(["evaluate"]) == 2 and "--data is required" in capsys.readouterr().err


@pytest.mark.parametrize(("late", "seen"), [(0.0, 1.0), (0.02, 1.0), (0.2, 0.0)])
def test_a_closure_is_hit_within_a_frame(late, seen):
    weights = np.zeros((200, len(CHANNELS)), np.float32)
    face = Face(weights, np.array([[1.0 + late, 1.08 + late]]))
    assert faces.closures_hit(face, [(0.98, 1.03)], 24) == seen
    assert faces.false_closures(face, [(0.98, 1.03)]) == 1 - seen
