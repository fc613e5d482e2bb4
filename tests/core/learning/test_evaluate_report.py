"""``s2ag evaluate`` from a corpus folder to the report's files."""

import json
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("torch", reason="the engine is not installed")
pytest.importorskip("matplotlib", reason="pictures need matplotlib")
pytest.importorskip("parselmouth", reason="prosody needs parselmouth")

from s2ag.core.cli.main import main  # noqa: E402
from s2ag.core.errors import CorpusUnreadable  # noqa: E402
from s2ag.core.learning.corpus.speech import Speech, Word  # noqa: E402
from s2ag.core.learning.evaluate import comparisons, figures  # noqa: E402
from s2ag.core.learning.evaluate.generation import Generator, PerformanceOptions  # noqa: E402
from s2ag.core.learning.evaluate.report import reference  # noqa: E402
from s2ag.core.learning.evaluate.report_files import file_name  # noqa: E402
from s2ag.core.learning.evaluate.talks import Corpus, load_human_recording  # noqa: E402
from s2ag.core.learning.train.storage import ARRAYS, save_arrays  # noqa: E402
from s2ag.core.motion import rest, skeleton  # noqa: E402
from s2ag.core.sound import audio  # noqa: E402

SECONDS, RECORDINGS = 8, 4
FRAMES = int(SECONDS * skeleton.FPS)
SPLITS = np.array([0, 2, 2, 2])
WORDS = [["this", 0.5, 0.8], ["matters", 1.0, 1.6], ["greatly", 2.0, 2.6], ["today", 6.0, 6.5]]
NAMES = ("calm one", "unknown one")


def talk_arrays():
    """Two speakers perform four recordings; only what evaluation reads has sense in it."""
    performances = 2 * RECORDINGS
    time = np.arange(FRAMES) / skeleton.FPS
    raised = rest.REST.copy()
    raised[8] = skeleton.normalize(np.array([0.1, -0.2, 0.9]))
    motions = []
    for number in range(performances):
        share = (0.5 + 0.1 * (number // 2)) * np.sin(np.pi * np.clip((time - 1) / 2, 0, 1)) ** 2
        motions.append(rest.slerp(np.broadcast_to(rest.REST, (FRAMES, 9, 3)), raised, np.tile(share[:, None], (1, 9))))
    accents = np.array([[1.3, 0.4, 0], [2.3, 0.9, 1], [6.2, 0.7, 1]], np.float32)
    return {
        **{name: np.zeros(1, int) for name in ARRAYS if name.endswith("starts") or name == "word_index"},
        **{name: np.zeros((1, 1), np.float32) for name in ("mfcc", "vectors", "prosody", "prosody_plain")},
        "affect": np.array([[0.5, (row + 1) / 5, 0.5] for row in range(RECORDINGS)], np.float32),
        "accents": np.tile(accents, (RECORDINGS, 1)),
        "accent_starts": np.arange(RECORDINGS + 1) * 3,
        "directions": np.concatenate(motions).astype(np.float16),
        "starts": np.arange(performances + 1) * FRAMES,
        "recording": np.arange(performances) // 2,
        "speaker": np.arange(performances) % 2,
        "split": SPLITS[np.arange(performances) // 2],
        "controls": np.zeros((performances, 5), np.float32),
        "strokes": np.tile(np.float32([2.0, 6.0]), performances),
        "stroke_starts": np.arange(performances + 1) * 2,
    }


@pytest.fixture(scope="module")
def corpus_folders(examples, tmp_path_factory):
    """A corpus and its speech: pieces of the shipped recording."""
    folder = tmp_path_factory.mktemp("evaluate")
    sound = audio.load(examples / "hello.flac")
    speech = folder / "speech"
    speech.mkdir()
    words = tuple(Word(text, start, end, (start, end), 2, 0, "") for text, start, end in WORDS)
    for row in range(RECORDINGS):
        piece = sound[row * 16000 :][: SECONDS * 16000]
        Speech(row, int(SPLITS[row]), piece, piece, words, np.full((1, 3), 0.5), {"kind": "piper"}).save(speech / f"{row}.npz")
    meta = {
        "format": 2,
        "fps": 15,
        "speakers": [{"name": name, "description": "", "rest": rest.REST.tolist()} for name in NAMES],
        "recordings": [
            {"speech": f"{row}.npz", "kind": "human:prompts" if row == 3 else "piper", "words": WORDS}
            for row in range(RECORDINGS)
        ],
    }
    return save_arrays(folder / "corpus", talk_arrays(), meta), speech


def test_talks_of_the_test_split_in_turn(corpus_folders):
    corpus = Corpus(*corpus_folders)
    assert corpus.chosen(3) == [2, 5, 6]  # every recording once, speakers in turn
    assert sorted(corpus.chosen(99)) == [2, 3, 4, 5, 6, 7]
    talk = corpus.talk(5)
    assert (talk.name, talk.recording, talk.style) == ("2 unknown one", "2", "unknown one")
    assert talk.words[0] == ("this", 0.5, 0.8) and talk.main.tolist() == pytest.approx([2.3, 6.2])
    assert talk.directed.shape == (FRAMES, 9, 3) and talk.strokes.tolist() == [2, 6] and talk.affect[1] == np.float32(0.6)
    assert corpus.talk(6).affect is None  # a person's own recording has no acted affect
    short = talk.cut(2.2)
    assert len(short.audio) == 35200 and short.directed.shape[0] == 33 and len(short.words) == 2
    assert short.accents[:, 0].max() < 2.2 and short.strokes.tolist() == [2] and short.name != talk.name


def test_directed_figures(corpus_folders):
    corpus = Corpus(*corpus_folders)
    assert comparisons.directed_speakers(corpus)["speakers_apart"] < 0.01  # both perform alike
    found = comparisons.directed_arousal(corpus)
    assert set(found) == {"arousal_spearman", "arousal_pearson"}  # three acted recordings: energy grows with arousal
    assert found["arousal_spearman"] == pytest.approx(1, abs=0.2)


def test_what_is_missing_is_named(corpus_folders, tmp_path):
    folder, speech = corpus_folders
    with pytest.raises(CorpusUnreadable, match="no folder of speech"):
        Corpus(folder, tmp_path / "nowhere")
    with pytest.raises(CorpusUnreadable, match=r"speech .*0\.npz is missing"):
        Corpus(folder, tmp_path).talk(0)
    for path in speech.glob("*.npz"):
        talk = Speech.load(path)
        replace(talk, clean=talk.clean[:-16000]).save(tmp_path / path.name)
    with pytest.raises(CorpusUnreadable, match="another length"):
        Corpus(folder, tmp_path).talk(0)
    arrays = talk_arrays()
    meta = json.loads((folder / "meta.json").read_text())
    with pytest.raises(CorpusUnreadable, match="strokes.npy"):
        Corpus(save_arrays(tmp_path / "a", {n: v for n, v in arrays.items() if n != "strokes"}, meta), speech)
    with pytest.raises(CorpusUnreadable, match="test split"):
        Corpus(save_arrays(tmp_path / "b", {**arrays, "split": arrays["split"] * 0}, meta), speech)


def test_the_studio_performs_as_a_user_would(corpus_folders, random_checkpoint, tmp_path):
    studio, talk = Generator(random_checkpoint, tmp_path), Corpus(*corpus_folders).talk(2)
    assert studio.steerable and studio.known("calm one") == "calm one" and studio.known("nobody") in studio.names
    one, two = studio.perform(
        talk,
        [PerformanceOptions("calm one"), PerformanceOptions("lively one", takes=2, controls={"arousal": 0.5, "rate": 0.2})],
    )
    assert one.shape == (1, FRAMES, 9, 3) and two.shape == (2, FRAMES, 9, 3)
    assert figures.mean_arm_angle(np.stack([one[0], two[0]])) > 0.1
    assert all(0 < join < FRAMES for join in studio.joins(FRAMES)) and studio.seed_frames == 10


def test_people_are_aligned_and_their_accents_found(examples):
    talk = load_human_recording(examples / "hello.flac")
    assert talk.words[0][0] == "Hello" and 3 <= len(talk.main) < len(talk.accents)
    assert talk.directed is None and talk.affect is None and talk.spoken == talk.words
    unknown = replace(talk, words=())
    covered = sum(end - start for _, start, end in unknown.spoken)
    assert 0.5 < covered / (len(talk.audio) / audio.SAMPLE_RATE) < 1 and unknown.spoken[0][1] == pytest.approx(
        talk.words[0][1], abs=0.3
    )


@pytest.mark.slow
def test_a_report_is_written(corpus_folders, random_checkpoint, examples, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("S2AG_DEBUG", "1")
    folder, speech = corpus_folders
    place = tmp_path / "new" / "report"
    options = [
        "--data",
        folder,
        "--speech",
        speech,
        "--talks",
        3,
        "--checkpoint",
        random_checkpoint,
        "--report",
        place,
        "--performers",
        2,
    ]
    assert main([str(part) for part in ["evaluate", *options, "--compare", random_checkpoint]]) == 0
    said = capsys.readouterr()
    assert not said.out and "goals are missed" in said.err
    report = json.loads((place / "report.json").read_text())  # strict JSON: no NaN
    columns = report["columns"]
    assert set(columns) == {"this", "compare", "directed", "resting", "one gesture", "shuffled"}
    assert columns["this"]["forearm_p90"] == columns["compare"]["forearm_p90"] > columns["resting"]["forearm_p90"]
    assert set(report["verdicts"]["backward_elbows"]["dull"]) == {"resting", "one gesture"}
    variety = report["variety"]
    assert set(variety) == {"people", "talks"} and set(variety["people"]) == {"this", "compare", "resting", "one gesture"}
    assert variety["people"]["this"]["seeds_apart"] == variety["people"]["compare"]["seeds_apart"] > 0
    assert set(variety["people"]["this"]["performers"]) == {"calm one", "lively one"}
    assert report["variety_verdicts"]["people"]["follows_voice"]["reached"]  # exactly as the weights beside it
    assert {"slider_low", "takes_apart", "speakers_apart", "told_apart", "through_body"} <= set(columns["this"])
    assert report["checkpoints"]["this"]["hash"] == report["checkpoints"]["compare"]["hash"]
    assert report["verdicts"]["forearm_p90"]["not_worse"] and set(report["human"]) == {"hello"}
    page = (place / "report.md").read_text()
    assert report["checkpoints"]["this"]["hash"] in page and "| strokes within 0.15 s of a main accent |" in page
    assert "## Variety at recordings of people" in page and "| narrators | lively talker | reached |" in page
    pictures = {str(path.relative_to(place)) for path in place.rglob("*.png")}
    films = {"sheets/wrist-paths.png", "sheets/film-calm-one.png", "sheets/film-lively-one.png"}
    assert films | {"curves/speeds.png", "sheets/hello.png", f"sheets/{file_name('1 calm one')}.png"} <= pictures
    assert all(f"![{name}]({name})" in page for name in pictures)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"--data": "nowhere"}, "not a packed corpus"),
        ({"--speech": "nowhere"}, "no folder of speech"),
        ({"--talks": "0"}, "0 talks were asked for"),
        ({"--performers": "0"}, "0 performers were asked for"),
        ({"--human": "nowhere.wav"}, "does not exist"),
        ({"--checkpoint": "nowhere.safetensors"}, "no checkpoint"),
        ({"--material": "nowhere"}, "no smartbody gestures"),
        ({"--report": "file.txt/report"}, "cannot be written"),
        ({"--report": None}, "required"),
    ],
)
def test_bad_input_gets_one_sentence(corpus_folders, tmp_path, monkeypatch, capsys, changes, sentence):
    monkeypatch.setenv("S2AG_DEBUG", "1")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file.txt").write_text("no folder")
    options = {"--data": corpus_folders[0], "--speech": corpus_folders[1], "--report": "report", "--talks": "1", **changes}
    arguments = [str(part) for name, value in options.items() if value is not None for part in (name, value)]
    assert main(["evaluate", *arguments]) == 2
    told = capsys.readouterr()
    (line,) = told.err.splitlines()
    assert line.startswith("s2ag: ") and sentence in line and not told.out


@pytest.mark.slow
def test_real_clips_move_as_they_were_measured(shared):
    real = reference(shared)
    assert 40 < real["energy"][8] < 100 and real["energy"][5] == real["energy"][8]
    assert 15 < real["jerk"] < 40 and 50 < real["jerk_per_speed"] < 110
