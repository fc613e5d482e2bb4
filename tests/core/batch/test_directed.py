"""A row of a manifest with an animator's edits is performed as they say."""

import numpy as np
import pytest
from documents import save_edits
from s2ag.core.batch import checks, manifest
from s2ag.core.batch.clip import Clip
from s2ag.core.batch.folder import Folder
from s2ag.core.batch.stages import Batch
from s2ag.core.batch.tasks import Synthesis
from s2ag.core.editing import edits, gestures
from s2ag.core.motion.motion import Motion


@pytest.fixture
def clip(tmp_path, examples):
    save_edits([{"do": "delete", "at": 4.3}], tmp_path / "mine.json")
    (tmp_path / "plan.csv").write_text(f"audio,seed,edits\n{examples / 'hello.flac'},2,mine.json\n")
    clips, problems = manifest.read(tmp_path / "plan.csv")
    assert not problems and not checks.check(clips)
    return clips[0]


def test_edits_are_performed_and_changed_edits_are_performed_anew(clip, tmp_path):
    folder = Folder(tmp_path / "out")

    def perform(asked: list[dict]) -> Motion:
        save_edits(asked, clip.edits)
        batch = Batch(folder, (clip,), "off")
        (step,) = batch.steps("synth", batch.units)
        assert step.state == "ready", asked
        Synthesis()(step.task.params, lambda *_: None)
        return Motion.load(folder.result("npz", clip.name, ".npz"))

    found = gestures.find_gestures(perform([]))
    for one in (found[2], found[-3]):
        asked = [{"do": "delete", "at": round(one.at, 2)}]
        motion = perform(asked)
        assert motion.meta["edits"] == edits.check(asked) and np.isfinite(motion.directions).all()


def test_wrong_edits_are_told_before_anything_is_made(clip, tmp_path):
    (tmp_path / "mine.json").write_text("[]")
    assert any("edits" in problem.sentence for problem in checks.check([clip]))
    save_edits([], tmp_path / "mine.json")
    several = Clip(1, "a", clip.audio, takes=2, edits=clip.edits)
    assert any("one take" in problem.sentence for problem in checks.check([several]))


def test_mouth_cues_of_a_row_move_its_mouth(tmp_path, examples):
    (tmp_path / "mouth.tsv").write_text("0.00\tX\n1.00\tA\n1.50\tD\n3.00\tX\n")
    (tmp_path / "plan.csv").write_text(f"audio,face,rhubarb\n{examples / 'hello.flac'},1,mouth.tsv\n")
    (clip,), problems = manifest.read(tmp_path / "plan.csv")
    assert not problems and not checks.check([clip])
    folder = Folder(tmp_path / "out")
    batch = Batch(folder, (clip,), "off")
    (step,) = batch.steps("synth", batch.units)
    Synthesis()(step.task.params, lambda *_: None)
    face = Motion.load(folder.result("npz", clip.name, ".npz")).face
    assert face.meta["cues"] == "rhubarb"
    np.testing.assert_allclose(face.closures, [[1.0, 1.5]], atol=1e-6)
    (tmp_path / "mouth.tsv").write_text("0.00\tX\n1.00\tD\n3.00\tX\n")
    assert Batch(folder, (clip,), "off").steps("synth", batch.units)[0].state == "ready"
    (still,) = checks.check([Clip(1, "a", clip.audio, rhubarb=clip.rhubarb)])
    assert "column face" in still.sentence
