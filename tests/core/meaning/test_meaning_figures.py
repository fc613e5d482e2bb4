"""What schemas show is seen in the performance: the figures of docs/meaning.md, for some of them in one style."""

import pytest
from s2ag.core.learning import meaning_figures
from s2ag.core.synthesis.session import Session

SOME = ("rise", "fall", "split", "merge", "circle", "future", "past", "left", "right", "four", "seven", "negation", "across")


@pytest.fixture(scope="module")
def shown(examples):
    files = (examples / "hello.flac", examples / "hello.txt")
    return list(meaning_figures.perform(Session(remember=True), SOME, ["stern"], "too", *files))


def test_every_form_is_seen_as_it_is_meant(shown):
    assert {one.schema for one in shown} == set(SOME) and {one.form for one in shown} >= {1, 2}
    wrong = [(one.schema, one.form, name, meaning_figures.figures(one)[name]) for one in shown
             for name, fits in [meaning_figures.meant(one.schema, meaning_figures.figures(one))] if not fits]  # fmt: skip
    assert not wrong


def test_opposites_are_told_apart(shown):
    for schema, other in (("rise", "fall"), ("split", "merge"), ("future", "past"), ("left", "right")):
        for one in shown:
            if one.schema == schema:
                assert not meaning_figures.meant(other, meaning_figures.figures(one))[1], one.schema
