"""What is heard in acted speech, of people and of voices that act as people do."""

import shutil

import numpy as np
import pytest
from s2ag.core.cli.main import main
from s2ag.core.learning.evaluate.listens import heard_affect, recordings
from s2ag.core.learning.evaluate.listens.heard_affect import Heard, speaker_of, told


@pytest.mark.parametrize(
    ("name", "speaker"),
    [
        ("slt-0-anger-3", "slt-0"),
        ("03a01Fa", "03"),
        ("wav-03a01Fa", "03"),
        ("03-01-06-01-02-01-12", "12"),
        ("Actor_12-03-01-06-01-02-01-12", "12"),
        ("angry", ""),
        ("anna-sad_1", "anna"),
        ("nobody", ""),
    ],
)
def test_names_tell_the_speaker(name, speaker):
    assert speaker_of(name) == speaker


def test_what_is_told_of_all_and_of_the_worst_speaker():
    def heard(speaker, emotion, *values):
        return Heard(speaker, emotion, np.array(values, float))

    rows = [heard("a", "anger", 0.9, -0.5, 0.4), heard("a", "joy", 0.8, 0.2, 0.1), heard("a", "sadness", -0.5, 0, -0.2)]
    rows += [heard("b", "anger", 0.0, 0.5, 0.0), heard("b", "joy", 0.3, 0.4, 0.0), heard("b", "sadness", 0.1, 0, 0.1)]
    found = told(rows)
    assert found["high from low arousal"] == {"all": pytest.approx(7 / 8), "worst": 0.5}
    assert found["joy from anger"] == {"all": 0.5, "worst": 0.0}
    assert found["anger from fear and sadness"]["worst"] == 0.0
    assert np.isnan(found["neutral from low arousal"]["all"]) and np.isnan(found["neutral from low arousal"]["worst"])
    page = heard_affect.page(rows)
    assert "| high from low arousal | 0.88 | 0.50 |" in page and "neutral from low" not in page
    assert "| anger | 2 | +0.45 | +0.00 | +0.20 |" in page


def test_the_command_tells_what_is_heard(shared, tmp_path, capsys):
    for path in sorted((shared / "thorsten_emotional").glob("*.wav")):
        shutil.copy(path, tmp_path / f"thorsten-{path.name}")
    reading = str(shared / "speech" / "p002.mp3")
    assert main(["evaluate", "--affect", str(tmp_path), "--reading", reading]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "5 recordings, 1 speakers." in lines
    (row,) = (line for line in lines if line.startswith("| high from low arousal"))
    assert min(float(cell) for cell in row.split("|")[2:6]) == 1.0


def test_after_a_reading_the_line_alone_is_heard(shared):
    acted = recordings.load_acted(shared / "thorsten_emotional")
    (angry,) = (one for one in acted if one.emotion == "anger")
    reading = recordings.load(shared / "speech" / "p001.mp3").audio
    (alone,), (after,) = heard_affect.hear_all([angry]), heard_affect.hear_all([angry], reading)
    assert alone.speaker == "" and min(alone.affect[0], after.affect[0]) > 0.5
    assert abs(alone.affect[0] - after.affect[0]) < 0.4


def test_a_folder_that_is_not_there_is_refused(capsys):
    assert main(["evaluate", "--affect", "nowhere"]) == 2
    assert "nowhere does not exist" in capsys.readouterr().err
