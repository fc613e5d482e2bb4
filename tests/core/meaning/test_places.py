"""Places within a talk: contrasts have two sides, and what was placed on one is shown there again."""

import json

import pytest
from s2ag.core.cli import meaning
from s2ag.core.meaning import document, gesture_selection, sentence, vocabulary

KNOWN = vocabulary.load_vocabulary()
BETWEEN = "We have lived with my aunt for a while and bought what we needed to furnish it."
SIDES = "On the one hand there is the city, on the other hand there is the country."
TALK = f"{SIDES} {BETWEEN} I think the city is loud. The country is green."


def spoken(text: str) -> list[tuple[str, float, float]]:
    return [(word, 0.4 * k, 0.4 * k + 0.3) for k, word in enumerate(text.split())]


def sides(text: str, language: str | None = None) -> list[tuple[str, str, float | None]]:
    words = spoken(text)
    found = gesture_selection.find_occasions(KNOWN, words, language)
    return [(words[at][0].strip(".,"), one.schema, one.side) for at, one in sorted(found.items())]


@pytest.mark.parametrize(
    ("said", "language"),
    [
        ("On the one hand it is cheap, on the other hand it is ugly.", None),
        ("This one is cheap, and the other one lasts.", None),
        ("This one is cheap, that one is not.", None),
        ("Some people love the winter, but others cannot wait for summer.", None),
        ("Rich people live on this side, poor people on that side.", None),
        ("Einerseits ist es billig, andererseits hält es nicht lange.", "de"),
        ("D'un côté c'est bon marché, de l'autre cela ne dure pas.", "fr"),
        ("Por un lado es barato, por otro lado no dura.", "es"),
    ],
)
def test_the_two_sides_of_a_contrast_are_two_sides(said, language):
    (_, one, first), (_, other, second) = sides(said, language)
    assert one == other == "contrast"
    assert first == -second and abs(first) == 1


def test_what_was_put_on_a_side_comes_again_there():
    (*_, city), (*_, country), *later = sides(TALK)
    assert city == -country
    assert later == [("city", "contrast", city), ("country", "contrast", country)]


def test_a_gesture_about_a_placed_thing_has_the_hand_of_its_side():
    said = "I never saw the school, and I never saw the church."
    found = sides(f"On the left is the church, on the right the school. {BETWEEN} {said}")
    assert [side for _, schema, side in found if schema == "negation"] == [1.0, -1.0]


@pytest.mark.parametrize(
    ("said", "contrasts"),
    [
        ("This one is nice.", 0),
        ("I know that one is nice.", 0),
        (f"On the one hand there is the city, on the other hand there is the city. {BETWEEN} I think the city is loud.", 2),
        ("The city is loud, and the country is green, and the city is older than that.", 0),
    ],
)
def test_what_has_no_other_side_or_both_has_no_place(said, contrasts):
    assert sum(schema == "contrast" for _, schema, _ in sides(said)) == contrasts


def test_places_are_printed_performed_and_read_back():
    words = spoken(TALK)
    found = gesture_selection.find_occasions(KNOWN, words)
    written = json.loads(meaning.write([word for word, *_ in words], found))
    assert [entry["hand"] for entry in written["gestures"]][:2] in (["left", "right"], ["right", "left"])
    assert document.find(document.check(written), [word for word, *_ in words], KNOWN.gestures) == (found, [])
    shown = gesture_selection.choose_gestures(KNOWN, words, {}, 1.0, (1,), found)
    assert len(shown) > 2 and [one.side for one in shown[:2]] == [found[3].side, found[11].side]


def test_every_language_says_which_side_its_words_name():
    for language in ("en", "de", "fr", "es"):
        grammar = sentence.load_grammar(language)
        assert grammar is not None and set(grammar.data["sides"]) == {"one", "other", "paired"}
