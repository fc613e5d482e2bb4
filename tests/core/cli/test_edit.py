"""``s2ag edit`` and ``--edits``: gestures are listed, edits are done, and what is wrong is said in a sentence."""

import json

import numpy as np
import pytest
from documents import save_edits
from refusals import files
from s2ag.core.cli.main import main
from s2ag.core.editing import edits
from s2ag.core.editing.director import Director
from s2ag.core.motion.motion import Motion
from s2ag.core.sound import audio
from s2ag.core.synthesis.session import Request, Session
from sounds import write_wav


@pytest.fixture(scope="module")
def take(examples, tmp_path_factory):
    path = tmp_path_factory.mktemp("take") / "take.npz"
    words = ["--transcript", str(examples / "hello.txt")]
    assert main(["synth", str(examples / "hello.flac"), *words, "--seed", "2", "-o", str(path)]) == 0
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
    save_edits([{"do": "delete", "at": at}], document)
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


def test_all_that_a_director_decides_is_done_from_a_file_and_by_a_script(take, examples, out, tmp_path, capsys):
    """The command line and a script make the same of ten decisions, keep all in the file, and tell what is not possible."""
    one, two, three, four = (row["at"] for row in listed(capsys, take)["gestures"][4:8])
    pose = Motion.load(take).directions[30].tolist()
    decided = [
        {"do": "rest", "from": 0.5, "to": 2.0, "how": "fewer"},
        {"do": "add", "word": "hands", "kind": "point"},
        {"do": "delete", "at": [one, two, three]},
        {"do": "reroll", "from": 9.0, "to": 10.5, "seed": 2},
        {"do": "pose", "at": 6.0, "directions": pose},
        {"do": "place", "from": 7.0, "to": 8.0, "hand": "left", "place": [-0.25, 0.1, 0.3]},
        {"do": "change", "at": four, "size": 1.3, "off": True},
        {"do": "delete", "at": 900.0},
        {"do": "feel", "at": 8.5, "arousal": 0.8},
        {"do": "style", "at": 11.0, "style": "calm lecturer"},
    ]
    save_edits(decided, tmp_path / "edits.json")
    sound, words = examples / "hello.flac", examples / "hello.txt"
    asked = ["--audio", str(sound), "--transcript", str(words), "--edits", str(tmp_path / "edits.json")]
    assert main(["edit", str(take), *asked, "-o", str(out / "a.npz")]) == 0
    told = capsys.readouterr().err
    assert "s2ag: note: Decision 8 was left out: there is no gesture at 900.00 s." in told
    made = Motion.load(out / "a.npz")
    script = Director(Session(cache="off")).direct(Request(sound, transcript=words, seed=2), decided).motions[0]
    assert np.array_equal(made.directions, script.directions)
    assert made.meta["edits"] == script.meta["edits"] == edits.check(decided) and made.meta["unmet"] == [7]
    assert np.abs(made.directions[90] - pose).max() < 1e-5
    assert main(["edit", str(out / "a.npz")]) == 0


@pytest.mark.parametrize("content", ["[]", "no", '{"format": 1, "edits": [{"do": "fly"}]}'])
def test_bad_edits(refuse, voice, out, tmp_path, random_checkpoint, content):
    path = tmp_path / "edits.json"
    path.write_text(content)
    refuse("synth", voice, "--checkpoint", random_checkpoint, "--edits", path, "-o", out / "a.npz")
    assert not files(out)


def test_what_belongs_together(refuse, take, voice, out, tmp_path, random_checkpoint):
    path = tmp_path / "edits.json"
    save_edits([], path)
    assert "belong together" in refuse("edit", take, "--edits", path)
    more = ["--edits", path, "--audio", voice, "-o", out / "a.npz"]
    assert "other weights" in refuse("edit", take, *more, "--checkpoint", random_checkpoint)
    assert main(["edit", str(tmp_path / "none.npz")]) == 2
    assert not files(out)


def test_a_take_is_carried_to_another_recording(take, examples, out, tmp_path, capsys):
    later = tmp_path / "later.wav"
    write_wav(later, np.concatenate([np.zeros(audio.SAMPLE_RATE // 2), audio.load(examples / "hello.flac")]))
    words = ["--transcript", str(examples / "hello.txt")]
    assert main(["edit", str(take), "--recording", str(later), *words, "-o", str(out / "b.npz")]) == 0
    capsys.readouterr()
    made, before = Motion.load(out / "b.npz"), Motion.load(take)
    assert made.meta["retimed"] == [before.meta["audio"]] != [made.meta["audio"]]
    assert made.duration == pytest.approx(before.duration + 0.5, abs=0.1)
    document = tmp_path / "edits.json"
    at = listed(capsys, out / "b.npz")["gestures"][4]["at"]
    save_edits([{"do": "delete", "at": at}], document)
    more = ["--audio", str(later), *words, "--edits", str(document)]
    assert main(["edit", str(out / "b.npz"), *more, "-o", str(out / "c.npz")]) == 0
    same = (Motion.load(out / "c.npz").directions == made.directions).all((1, 2))
    assert 5 < np.count_nonzero(~same) < 60


def test_a_recording_of_other_words_is_refused(refuse, take, examples, out, tmp_path):
    said = ["--recording", examples / "hello.flac", "--text", "quite another text than that"]
    assert "words in common" in refuse("edit", take, *said, "-o", out / "b.npz")
    assert "carried" in refuse("edit", take, "--recording", examples / "hello.flac")
    assert not files(out)
