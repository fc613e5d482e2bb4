"""What an author writes between the lines, and what becomes of it in the motion."""

import numpy as np
import pytest
from s2ag.core import audio, hints, markup, rest, transcript
from s2ag.core.markup import Mark


def marks(text):
    return [(mark.kind, mark.first, mark.last, mark.value) for mark in markup.read(text).marks]


def said(text):
    return " ".join(part for _, parts in transcript.tokenise(text) for part in parts)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("this is *really* good", [("stress", 2, 3, "")]),
        ("this is **really good**.", [("stress", 2, 3, ""), ("stress", 3, 4, "")]),
        ("one [pause] two", [("pause", 1, 1, "")]),
        ("one (long pause) two [Pause 0.5] three", [("pause", 1, 1, ""), ("pause", 2, 2, "")]),
        ("so {me} I think, and more", [("hint", 1, 3, "me")]),
        ("{none} we sat still, {big} then it grew.", [("hint", 0, 3, "none"), ("hint", 3, 6, "big")]),
        ("look {point left} there", [("hint", 1, 2, "point left")]),
        ("2 * 3 * 4", []),
        ("{big}", []),
        ("a [laughs] b {} c", []),
    ],
)
def test_marks(text, expected):
    assert marks(text) == expected


@pytest.mark.parametrize(
    ("text", "spoken"),
    [
        ("JOHN: Hello.\nMARY ANN: Hi.", "hello hi"),
        ("Bob: Hello.\nEve: Hi.\nBob: So?\nEve: So.", "hello hi so so"),
        ("Speaker 1: Hello.", "hello"),
        ("[SPEAKER_00]: Hello. <v Mary>Hi</v>", "hello hi"),
        (">> Hello.\n>> ANNA: Hi.", "hello hi"),
        ("Remember: be kind.", "remember be kind"),
        ("(laughs) well (DOOR SLAMS) (really) no ♪", "well really no"),
        ("It cost $20 million, or €3.5bn.", "it cost twenty million dollars or three point five billion euros"),
        ("3.5 % of the 1990s", "three point five percent of the nineteen nineties"),
        ("the U.S. and a B2B-well-known API", "the u s and a b two b well known API"),
        ("ALL OF IT IN CAPITALS, NASA TOO", "all of it in capitals nasa too"),
        ("I *can't* do 42 rock'n'roll songs", "i can't do forty two rock'n'roll songs"),
        ("Dr. Smith vs. Mr. Jones etc.", "doctor smith versus mister jones et cetera"),
        ("at 10:30, 5km north, 7pm, #1, ½", "at ten thirty five kilometers north seven pm number one one half"),
        ("24/7 and 5–10 people", "twenty four seven and five to ten people"),
        ("The 1,250th at 20°C", "the one thousand two hundred fiftieth at twenty degrees celsius"),
    ],
)
def test_what_is_said(text, spoken):
    assert said(text) == spoken


def test_unknown_hints_are_named_and_nothing_else():
    words = [("so", 0.0, 0.2), ("it", 0.2, 0.4)]
    wishes = hints.understand([Mark("hint", 0, 2, "somersault"), Mark("hint", 0, 2, "left hook")], words)
    assert wishes == hints.Wishes(unknown=("somersault", "left hook"))
    motion = np.random.default_rng(0).normal(size=(30, 9, 3)).astype(np.float32)
    assert hints.perform(motion, wishes, rest.REST) is motion


def test_envelope_is_smooth_and_local():
    time = np.arange(150) / 15
    share = hints.envelope(time, 4.0, 6.0)
    assert share[time < 3.5].max() == share[time > 6.5].max() == 0
    assert (share[(time >= 4) & (time <= 6)] == 1).all() and np.abs(np.diff(share)).max() < 0.25


# --- in the motion of the shipped network

TEXT = "Hello! I am the one who moves. So give me your voice, and watch me move: every word, every pause, all of it."


@pytest.fixture(scope="module")
def performer(examples):
    """Directions for a marked text of the shipped recording, by the shipped network."""
    pytest.importorskip("torch")
    from s2ag.core.synthesis import Request, Session

    session, plain = Session(), (examples / "hello.txt").read_text()
    heard = transcript.hear(audio.load(examples / "hello.flac"), text=plain)

    def perform(changed):
        result = session.synthesize(Request(examples / "hello.flac", text=changed(plain), seed=1))
        assert [word for word, *_ in result.words] == [word for word, *_ in heard.words]
        return result.motions[0].directions, result

    return perform, heard.words


def before(word, mark, number=0):
    """A change that puts a mark before a word of the text."""

    def change(text):
        parts = text.split(" ")
        places = [place for place, part in enumerate(parts) if transcript.tokenise(part)[0][0] == word]
        return " ".join([*parts[: places[number]], mark, *parts[places[number] :]])

    return change


def extent(directions):
    """Radians ``(frames,)`` of both arms away from rest."""
    return np.arccos(np.clip((directions * rest.REST).sum(-1), -1, 1))[:, [4, 5, 7, 8]].mean(1)


def frames(start, end):
    return slice(int(start * 15), int(end * 15) + 1)
