"""``s2ag edit`` and ``--edits``: gestures are listed, edits are done, and what is wrong is said in a sentence."""

import json

import numpy as np
import pytest
from refusals import files
from s2ag.core.cli.main import main
from s2ag.core.direction import edits
from s2ag.core.motion.motion import Motion


@pytest.fixture
def take(examples, tmp_path, capsys):
    path = tmp_path / "take.npz"
    words = ["--transcript", str(examples / "hello.txt")]
    assert main(["synth", str(examples / "hello.flac"), *words, "--seed", "2", "-o", str(path)]) == 0
    capsys.readouterr()
    return path


def listed(capsys, path):
    assert main(["edit", str(path), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_gestures_are_listed(take, capsys):
    found = listed(capsys, take)
    assert len(found["gestures"]) > 5 and found["edits"] == []
    assert main(["edit", str(take)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 1 + len(found["gestures"])


def test_edits_are_done_and_told_in_both_ways(take, examples, out, tmp_path, capsys):
    at = listed(capsys, take)["gestures"][4]["at"]
    document = tmp_path / "edits.json"
    edits.save([{"do": "delete", "at": at}], document)
    words = ["--transcript", str(examples / "hello.txt"), "--edits", str(document)]
    sound = str(examples / "hello.flac")
    assert main(["edit", str(take), "--audio", sound, *words, "-o", str(out / "a.npz")]) == 0
    assert main(["synth", sound, *words, "--seed", "2", "-o", str(out / "b.npz")]) == 0
    capsys.readouterr()
    one, two, before = (Motion.load(path) for path in (out / "a.npz", out / "b.npz", take))
    assert (one.directions == two.directions).all()
    same = (one.directions == before.directions).all((1, 2))
    assert 5 < np.count_nonzero(~same) < 60
    assert listed(capsys, out / "a.npz")["edits"] == [{"do": "delete", "at": at}]


@pytest.mark.parametrize("content", ["[]", "no", '{"format": 1, "edits": [{"do": "fly"}]}'])
def test_bad_edits(refuse, voice, out, tmp_path, random_checkpoint, content):
    path = tmp_path / "edits.json"
    path.write_text(content)
    refuse("synth", voice, "--checkpoint", random_checkpoint, "--edits", path, "-o", out / "a.npz")
    assert not files(out)


def test_what_belongs_together(refuse, take, voice, out, tmp_path, random_checkpoint):
    path = tmp_path / "edits.json"
    edits.save([], path)
    assert "belong together" in refuse("edit", take, "--edits", path)
    more = ["--edits", path, "--audio", voice, "-o", out / "a.npz"]
    assert "other weights" in refuse("edit", take, *more, "--checkpoint", random_checkpoint)
    assert main(["edit", str(tmp_path / "none.npz")]) == 2
    assert not files(out)
