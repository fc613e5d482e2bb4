"""Sentences that call for a gesture and twins that do not, in two halves (docs/meaning.md)."""

import csv
import json
from pathlib import Path

import pytest
from s2ag.core.meaning import gesture_selection, sentence, vocabulary


def read(name: str) -> list[dict]:
    with (Path(__file__).parent / name).open(encoding="utf-8") as file:
        return list(csv.DictReader(file, delimiter="\t"))


PAIRS = read("sentences.tsv")
SPOKEN = read("sentences_spoken.tsv")
TALK = read("sentences_talk.tsv")
SETS = {"first half": PAIRS[::2], "second half": PAIRS[1::2], "later": read("sentences_later.tsv"), "spoken": SPOKEN[::2]}
SETS |= {"other senses": read("sentences_senses.tsv"), "talk": TALK[::2]}
SETS |= {language: read(f"sentences_{language}.tsv") for language in ("de", "fr", "es")}


def shown(said: str, language: str | None = None) -> set[str]:
    words = [(word, 0.33 * k, 0.33 * k + 0.3) for k, word in enumerate(said.split())]
    return {name for name, *_ in gesture_selection.find_occasions(vocabulary.load_vocabulary(), words, language).values()}


@pytest.mark.parametrize("part", SETS)
def test_what_is_said_is_shown_and_twins_are_silent(part):
    pairs, language = SETS[part], part if len(part) == len("de") else None
    seen = sum(not shown(pair["sentence"], language).isdisjoint(pair["schemas"].split(",")) for pair in pairs)
    silent = sum(not shown(pair["twin"], language) for pair in pairs)
    print(f"{part}: of {len(pairs)} sentences {seen} are shown, of their twins {silent} show nothing")
    assert len(PAIRS) >= 120
    assert seen >= 0.8 * len(pairs)
    assert silent >= 0.95 * len(pairs)


@pytest.mark.parametrize(("pairs", "least"), [(SPOKEN, 0.79), (TALK, 0.8)], ids=["spoken", "talk"])
def test_the_half_that_no_rule_was_written_from_stays_as_well_understood(pairs, least):
    unread = pairs[1::2]
    seen = sum(not shown(pair["sentence"]).isdisjoint(pair["schemas"].split(",")) for pair in unread)
    silent = sum(not shown(pair["twin"]) for pair in unread)
    print(f"of {len(unread)} unread sentences {seen} are shown, of their twins {silent} show nothing")
    assert len(SPOKEN) >= 120
    assert seen >= least * len(unread)
    assert silent >= 0.95 * len(unread)


@pytest.mark.parametrize("language", ["en", "de", "fr", "es"])
def test_frames_name_gestures_and_every_gesture_has_words(language):
    data = json.loads((sentence.FOLDER / f"{language}.json").read_text("utf-8"))
    known = set(vocabulary.load_vocabulary().gestures)
    named = set(data["frames"]) - {sentence.SILENT, "count"} | set(data["counts"].values())
    assert named == known or (language != "en" and named <= known)


@pytest.mark.parametrize(
    ("said", "schema"),
    [
        ("I never did that.", "negation"),
        ("Never mind.", None),
        ("The price did not rise.", None),
        ("He has four sisters.", "four"),
        ("He has lived here four years.", None),
        ("I am not sure what he means.", "shrug"),
        ("What happened.", None),
        ("What happened to you?", "question"),
    ],
)
def test_the_sentence_decides(said, schema):
    assert shown(said) == ({schema} if schema else set())
