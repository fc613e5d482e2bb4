"""The trial of talk as the command line runs it: people, voices, a small table; and its refusals."""

import json

import numpy as np
import pytest
import talking
import toy_corpus
from refusals import one_sentence
from s2ag.core.cli.main import main
from s2ag.core.errors import UsageError
from s2ag.core.learning.evaluate import talk_characters, talk_faults, talk_people, talk_split, talk_trial, talk_voices
from s2ag.core.learning.evaluate.talks import load_human_recording
from s2ag.core.learning.train.storage import save_arrays
from s2ag.core.motion import skeleton
from s2ag.core.motion.motion import Motion
from s2ag.core.synthesis.session import Request, Session
from sounds import write_wav


def test_what_is_kept_for_reports_is_not_read_while_choosing(shared, tmp_path):
    chosen, reported = talk_people.load(shared, reported=False), talk_people.load(shared)
    frames = [sum(len(motion) for motions in people.motions.values() for motion in motions) for people in (chosen, reported)]
    assert 60 < frames[0] / 15 < 70 and 75 < frames[1] / 15 < 85
    assert set(chosen.asked) == set(chosen.kinds) and "one hand busy" not in chosen.kinds
    assert reported.asked == ["a woman presents", "one hand busy"] and len(reported.kinds) == 4
    for name in talk_split.CAPTURED_CHOSEN_ON:  # a folder without the others is enough
        (tmp_path / "rocketbox_clips").mkdir(exist_ok=True)
        (tmp_path / "rocketbox_clips" / f"{name}.npz").write_bytes((shared / "rocketbox_clips" / f"{name}.npz").read_bytes())
    assert talk_people.load(tmp_path, reported=False).asked == chosen.asked


def test_voices_are_read_sentences_by_the_split(shared, tmp_path):
    pytest.importorskip("av", reason="the engine is not installed")
    (tmp_path / "kathleen").mkdir()
    rows = ["file,text,seconds"]
    for name in ("arctic_a0001.opus", "arctic_b0510.opus", "arctic_b0511.opus"):
        rows.append(f"{name},a few words are read here,3")
        (tmp_path / "kathleen" / name).write_bytes((shared / "kathleen" / name).read_bytes())
    (tmp_path / "kathleen" / "sentences.csv").write_text("\n".join(rows), "utf-8")
    (talk,) = talk_voices.load(tmp_path)
    alone = [load_human_recording(tmp_path / "kathleen" / f"arctic_b051{row}.opus", "a few words") for row in (0, 1)]
    assert talk.name == "read sentences 1" and talk.words
    assert len(talk.audio) == sum(len(one.audio) for one in alone) + 0.6 * 16000


@pytest.fixture(scope="module")
def result(shared, tmp_path_factory, random_checkpoint):
    folder = tmp_path_factory.mktemp("talk")
    time = np.arange(12 * 16000) / 16000
    write_wav(folder / "voice.wav", 0.3 * np.sin(2 * np.pi * 180 * time) * (np.sin(2 * np.pi * 0.8 * time) > -0.3))
    setting = talk_trial.Setting(
        shared, random_checkpoint, voices=[folder / "voice.wav"], performers=1, reported=False, draws=1, beats=True
    )
    return talk_trial.try_talk(setting)


def test_the_trial_has_people_and_ours_side_by_side(result):
    assert list(result["columns"]) == ["network", "ships", "beats alone"] and len(result["people"]) == 3
    assert 0.4 < result["people"]["a man's conversation"]["told apart"] < 1
    ships = (f"ships, {size:g}" for size in talk_trial.INTENSITIES)
    assert set(result["faults"]) == {"people", "network", "beats alone", *ships}
    json.dumps(talk_trial.finite(result), allow_nan=False)


def test_the_page_has_a_line_for_each_figure_and_fault(result):
    page = talk_trial.page(result)
    assert "Settings may be chosen on these." in page and "m_conversation" in page and "f_trolley_talk" not in page
    figures = [line.split("|")[1].strip() for line in page.splitlines() if line.startswith("| ")]
    assert figures[1:3] == ["told apart", "told apart, second judge"] and "beats among strokes" in figures
    assert len({line.count("|") for line in page.split("\n\n")[2].splitlines()}) == 1
    low = min(column["bells a second"] for column in result["people"].values())
    assert f"least {low:.2f}" in next(line for line in page.splitlines() if line.startswith("| bells a second"))


def test_pieces_are_spread_over_all_takes():
    takes = [Motion(np.full((450, 9, 3), number, np.float32)) for number in range(4)]
    pieces = talk_characters.pieces(takes, 4)
    assert [len(piece.directions) for piece in pieces] == [150] * 4
    assert [piece.directions[0, 0, 0] for piece in pieces] == [0, 1, 2, 3]
    assert len(talk_characters.pieces(takes[:1], 9)) == 3


def test_the_mannequin_is_keyed_and_its_joints_are_in_their_places():
    pytest.importorskip("bpy", reason="Blender is not installed")
    from s2ag.core.cli import blender

    motions = [Motion(talking.talk(seed, 4, size=0.1)) for seed in range(2)]
    one, other = talk_characters.joints("mannequin", motions, blender.run)
    assert one.shape == other.shape == (60 - 8, 10, 3)
    wanted = talking.talk(0, 4, size=0.1)[8:]
    fore = skeleton.normalize(one[:, [6, 9]] - one[:, [5, 8]])
    assert np.degrees(np.arccos(np.clip((fore * wanted[-len(fore) :, [5, 8]]).sum(-1), -1, 1))).mean() < 6
    assert (one[:, 2, 1] < one[:, 1, 1] - 0.1).all()  # the nose is over the neck, y down,
    assert (one[:, 2, 2] > one[:, 1, 2] + 0.03).all()  # and before it
    assert (one[:, 4, 0] < -0.1).all() and (one[:, 7, 0] > 0.1).all()


@pytest.mark.slow
def test_large_takes_on_a_character_hardly_have_a_fault(examples):
    """Of all styles at intensity 1.4: one stretch in nearly six minutes may be, as a threshold is passed by millimetres."""
    pytest.importorskip("bpy", reason="Blender is not installed")
    from s2ag.core.cli import blender

    session, files = Session(cache="off"), {"audio": examples / "hello.flac", "transcript": examples / "hello.txt"}
    styles = [style["name"] for style in session.styles()]
    wishes = [Request(**files, style=name, seed=row, hands=1.0, intensity=1.4) for row, name in enumerate(styles, 100)]
    takes = [result.motions[0] for result in session.synthesize_all(wishes)]
    places = talk_characters.joints("human:mixamo", takes, blender.run)
    minutes = sum(map(len, places)) / skeleton.FPS / 60
    assert minutes > 5 and sum(talk_faults.by_minute(places).values()) * minutes < 1.5


def test_refusals(tmp_path, capsys):
    assert main(["evaluate", "--talk"]) == 2
    assert "--material is required" in one_sentence(capsys.readouterr().err)
    assert main(["evaluate", "--talk", "--material", str(tmp_path)]) == 2
    assert "holds no captured talk" in one_sentence(capsys.readouterr().err)


def test_a_data_set_is_one_more_kind_of_people(shared, tmp_path):
    arrays = toy_corpus.toy_arrays()
    save_arrays(tmp_path / "mine", arrays, toy_corpus.META)
    people = talk_people.load(shared, reported=False, data=[tmp_path / "mine"])
    assert people.asked[-1] == "mine" and len(people.kinds["mine"]) == 6  # it has no test split
    arrays["split"] = np.array([0, 0, 0, 1, 2, 2])
    save_arrays(tmp_path / "split", arrays, toy_corpus.META)
    tested = talk_people.performances(tmp_path / "split")
    assert len(tested) == 2 and np.allclose(tested[0], skeleton.normalize(arrays["directions"][800:1000].astype(float)))
    save_arrays(tmp_path / "fast", arrays, {**toy_corpus.META, "fps": 30})
    with pytest.raises(UsageError, match="30 frames a second"):
        talk_people.performances(tmp_path / "fast")
