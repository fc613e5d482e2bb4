"""Documents of meanings: what is understood is written, read, changed, and performed as it says (docs/meaning.md)."""

import csv
import json
from pathlib import Path

import pytest
from s2ag.core.batch import checks, manifest
from s2ag.core.batch.folder import Folder
from s2ag.core.batch.stages import Batch
from s2ag.core.cli import meaning
from s2ag.core.cli.main import main
from s2ag.core.errors import UsageError
from s2ag.core.meaning import document, gesture_selection, sentence, vocabulary
from s2ag.core.synthesis.request import Request
from s2ag.core.synthesis.session import Session

KNOWN = vocabulary.load_vocabulary()
TALK = "We climbed higher and higher. I don't know why, we never went down again; some people rest, but others climb on."


def listed(*entries: dict) -> dict:
    return {"format": 1, "gestures": list(entries)}


def spoken(text: str) -> list[tuple[str, float, float]]:
    return [(word, 0.4 * k, 0.4 * k + 0.3) for k, word in enumerate(text.split())]


def sentences() -> str:
    with Path(__file__).with_name("sentences.tsv").open(encoding="utf-8") as file:
        return " ".join(f"{row['sentence']} {row['twin']}" for row in csv.DictReader(file, delimiter="\t"))


@pytest.mark.parametrize("text", [TALK, sentences()], ids=["short", "long"])
def test_what_is_understood_is_read_back_from_its_document(text):
    words = spoken(text)
    found = gesture_selection.find_occasions(KNOWN, words)
    written = json.loads(meaning.write([word for word, *_ in words], found))
    assert document.find(document.check(written), [word for word, *_ in words], KNOWN.gestures) == (found, [])
    assert len(found) > 3


def test_words_are_found_in_the_order_of_the_talk_or_by_their_number():
    texts = ["So", "big,", "so", "big,", "and", "then", "So", "Big", "again"]
    found, missed = document.find(
        listed(
            {"words": "so big", "schema": "big"},
            {"words": "So big,", "schema": "small", "on": "so", "hand": "left", "size": 0.5, "form": 2},
            {"words": "so big", "schema": "rise", "nth": 3, "sure": 0.7},
            {"words": "so little", "schema": "fall"},
        ),
        texts,
        KNOWN.gestures,
    )
    assert sorted(found) == [1, 2, 7]
    assert found[2] == document.Wanted("small", 2, None, -1.0, 0.5, 2, 0) and found[7].sure == 0.7
    assert missed == ["The words “so little” of gesture 4 of the meanings are not said there."]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ([], "no document"),
        ({"format": 2, "gestures": []}, "no document"),
        ({"format": 1}, "list of gestures"),
        ({"format": 1, "gestures": [], "more": 1}, "list of gestures"),
        (listed("rise"), "another form"),
        (listed({"words": "so", "schema": "rise", "why": "because"}), "another form"),
        (listed({"words": "so"}), "usable schema"),
        (listed({"schema": "rise", "words": "..."}), "usable words"),
        (listed({"schema": "rise", "words": "so", "size": 9}), "usable size"),
        (listed({"schema": "rise", "words": "so", "form": True}), "usable form"),
        (listed({"schema": "rise", "words": "so", "sure": "very"}), "usable sure"),
        (listed({"schema": "rise", "words": "so", "hand": "third"}), "usable hand"),
        (listed({"schema": "rise", "words": "so", "on": "there"}), "usable on"),
    ],
)
def test_a_wrong_document_is_told_in_a_sentence(content, said):
    with pytest.raises(UsageError, match=said):
        document.check(content)


def test_a_file_that_is_none_is_told(tmp_path):
    (tmp_path / "no.json").write_text('{"format": 1,')
    with pytest.raises(UsageError, match="no JSON"):
        document.load(tmp_path / "no.json")
    (tmp_path / "empty.json").write_text("{}")
    with pytest.raises(UsageError, match="no document"):
        document.load(tmp_path / "empty.json")
    with pytest.raises(UsageError, match="cannot be read"):
        document.load(tmp_path / "none.json")
    with pytest.raises(UsageError, match="ris"):
        document.find(listed({"words": "so", "schema": "ris"}), ["so"], KNOWN.gestures)


def test_the_command_prints_what_is_understood_and_checks_a_document(tmp_path, capsys):
    (tmp_path / "talk.txt").write_text(TALK)
    assert main(["meaning", str(tmp_path / "talk.txt"), "-o", str(tmp_path / "talk.json")]) == 0
    content = document.load(tmp_path / "talk.json")
    schemas = [entry["schema"] for entry in content["gestures"]]
    assert schemas == ["rise", "rise", "shrug", "negation", "contrast", "contrast"]
    content["gestures"].append({"words": "nobody said that", "schema": "circle"})
    (tmp_path / "talk.json").write_text(json.dumps(content))
    capsys.readouterr()
    assert main(["meaning", str(tmp_path / "talk.txt"), "--meanings", str(tmp_path / "talk.json")]) == 1
    told = capsys.readouterr()
    assert "nobody said that" in told.err and json.loads(told.out)["gestures"] == content["gestures"][:-1]


def test_a_document_is_performed(examples):
    session, hello = Session(remember=True), {"audio": examples / "hello.flac", "transcript": examples / "hello.txt", "seed": 1}
    plain = session.synthesize(Request(**hello)).motions[0]
    understood = [(word, 0.0, 0.0) for word in (examples / "hello.txt").read_text().split()]
    same = json.loads(meaning.write([w for w, *_ in understood], gesture_selection.find_occasions(KNOWN, understood)))
    again = session.synthesize(Request(**hello, meanings=same)).motions[0]
    assert (again.directions == plain.directions).all() and again.meta["meanings"] == same
    asked = listed({"words": plain.words[8][0], "schema": "circle"}, {"words": "not in it", "schema": "rise"})
    result = session.synthesize(Request(**hello, meanings=asked, meaning=0.0))
    assert [name for name, _ in result.motions[0].meta["shows"]] == ["circle"]
    assert any("not in it" in warning for warning in result.warnings)
    with pytest.raises(UsageError, match="schema 'cirkle'"):
        session.synthesize(Request(**hello, meanings=listed({"words": "so", "schema": "cirkle"})))


def test_a_batch_makes_a_clip_anew_when_its_document_or_the_language_changes(tmp_path, examples, monkeypatch):
    (tmp_path / "mine.json").write_text(json.dumps(listed()))
    (tmp_path / "plan.csv").write_text(f"audio,text,meanings\n{examples / 'hello.flac'},so it is,mine.json\n")
    clips, problems = manifest.read(tmp_path / "plan.csv")
    assert not problems and not checks.check(clips)

    def key() -> str:
        batch = Batch(Folder(tmp_path / "out"), tuple(clips), "off")
        (step,) = batch.steps("synth", batch.units)
        return step.key

    first = key()
    (tmp_path / "mine.json").write_text(json.dumps(listed({"words": "so", "schema": "circle"})))
    assert (second := key()) != first == first
    other = tmp_path / "en.json"
    other.write_text("{}")
    monkeypatch.setattr(sentence, "files", lambda language=None: [other])
    assert key() not in (first, second)
    (tmp_path / "mine.json").write_text("[]")
    assert any("meanings" in problem.sentence for problem in checks.check(clips))
