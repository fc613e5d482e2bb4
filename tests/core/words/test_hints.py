"""What an author writes between the lines, and what becomes of it in the motion."""

import numpy as np
import pytest
from s2ag.core.motion import rest
from s2ag.core.sound import audio
from s2ag.core.words import hints, markup, transcript
from s2ag.core.words.markup import Mark
from transcripts import words_and_warnings


def marks(text):
    return [(mark.kind, mark.first, mark.last, mark.value) for mark in markup.parse(text).marks]


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
    wishes = hints.parse_hints([Mark("hint", 0, 2, "somersault"), Mark("hint", 0, 2, "left hook")], words)
    assert wishes == hints.HintEffects(unknown=("somersault", "left hook"))
    motion = np.random.default_rng(0).normal(size=(30, 9, 3)).astype(np.float32)
    assert hints.apply_hints(motion, wishes, rest.REST) is motion


def test_rest_may_change_on_the_way():
    words = [("so", 0.5, 0.8), ("this", 0.9, 1.2), ("one", 1.3, 1.8)]
    wishes = hints.parse_hints([Mark("gesture", 1, 2, "point left"), Mark("gesture", 2, 3, "none")], words)
    directions = rest.RestBlend.of(np.ones(40)).live(np.broadcast_to(rest.REST[::-1], (40, 9, 3)))
    same = hints.apply_hints(directions, wishes, np.broadcast_to(rest.REST, directions.shape))
    np.testing.assert_array_equal(same, hints.apply_hints(directions, wishes, rest.REST))
    assert not np.array_equal(same, directions)


def test_envelope_is_smooth_and_local():
    time = np.arange(150) / 15
    share = hints.envelope(time, 4.0, 6.0)
    assert share[time < 3.5].max() == share[time > 6.5].max() == 0
    assert (share[(time >= 4) & (time <= 6)] == 1).all() and np.abs(np.diff(share)).max() < 0.25


# --- in the motion of the shipped network


@pytest.fixture(scope="module")
def performer(examples):
    """Directions for a marked text of the shipped recording, by the shipped network."""
    pytest.importorskip("torch")
    from s2ag.core.synthesis.session import Request, Session

    session, plain = Session(), (examples / "hello.txt").read_text()
    heard = transcript.timed_transcript(audio.load(examples / "hello.flac"), text=plain)

    def perform(change):
        result = session.synthesize(Request(examples / "hello.flac", text=change(plain), seed=1))
        assert [word for word, *_ in result.words] == [word for word, *_ in heard.words]
        return result.motions[0].directions, result

    return perform, heard.words


def extent(directions, arms=(4, 5, 7, 8)):
    """Radians ``(frames,)`` of the arms away from rest."""
    return np.arccos(np.clip((directions * rest.REST).sum(-1), -1, 1))[:, list(arms)].mean(1)


def turned(one, other):
    """Degrees ``(frames,)`` between two motions, at most over the edges."""
    return np.degrees(np.arccos(np.clip((one * other).sum(-1), -1, 1))).max(1)


@pytest.fixture(scope="module")
def plain(performer):
    return performer[0](lambda text: text)[0]


def compare(performer, plain, old, new, first, last):
    """Frames from the first to the last word (each ``(text, which)``), and the motion of the changed text."""
    perform, words = performer
    directions, _ = perform(lambda text: text.replace(old, new, 1))
    assert directions.shape == plain.shape and not np.array_equal(directions, plain)
    start, end = ([(s, e) for text, s, e in words if text == word][which] for word, which in (first, last))
    here = slice(int(start[0] * 15), int(end[1] * 15) + 1)
    # A mark may take the place of a gesture a second or two after it.
    far = np.r_[0 : max(here.start - 60, 0), here.stop + 90 : len(plain)]
    assert turned(plain, directions)[far].max() < 6, "what is far away stays"
    return here, directions


def test_stress_makes_a_larger_gesture(performer, plain):
    here, directions = compare(performer, plain, "hands", "*hands*", ("hands", 0), ("hands", 0))
    assert extent(directions)[here].mean() > 1.08 * extent(plain)[here].mean()


def test_none_rests_over_its_phrase(performer, plain):
    here, directions = compare(performer, plain, "When we", "{none} When we", ("we", 0), ("talk", 0))
    assert extent(plain)[here].mean() > 0.5 and extent(directions)[here].max() < 0.1 * extent(plain)[here].mean()


def test_big_and_small(performer, plain):
    here, big = compare(performer, plain, "a small", "{big} a small", ("small", 0), ("here", 0))
    assert extent(big)[here].mean() > 1.3 * extent(plain)[here].mean()
    here, small = compare(performer, plain, "a small", "{small} a small", ("small", 0), ("here", 0))
    assert extent(small)[here].mean() < 0.75 * extent(plain)[here].mean()


def test_pause_brings_the_hands_down(performer, plain):
    here, directions = compare(performer, plain, "still. When", "still. [pause] When", ("still", 0), ("When", 0))
    middle = slice(here.start + 7, here.stop - 2)
    assert extent(directions)[middle].min() < 0.4 * extent(plain)[middle].min()


def test_a_gesture_of_another_word(performer, plain):
    here, directions = compare(performer, plain, "idea", "{me} idea", ("idea", 0), ("idea", 0))
    assert turned(plain, directions)[here].max() > 5


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_side_asked_for_leads(performer, plain, side):
    here, directions = compare(performer, plain, "small idea", f"small {{{side}}} idea", ("idea", 0), ("idea", 0))
    left, right = extent(directions, (4, 5))[here].mean(), extent(directions, (7, 8))[here].mean()
    assert (left > 2 * right) if side == "left" else (right > 2 * left)


def test_unknown_hints_change_nothing_and_are_named(performer, plain):
    perform, _ = performer
    directions, result = perform(lambda text: text.replace("hands", "{somersault} hands [cheers]"))
    assert np.array_equal(directions, plain)
    assert len(result.warnings) == 1 and "{somersault}" in result.warnings[0]


def test_what_the_network_hears_has_the_main_accent_on_the_stressed_word(examples):
    from s2ag.core.sound import prosody

    sound = audio.load(examples / "hello.flac")
    words, _ = words_and_warnings(sound, examples / "hello.txt")
    usual = prosody.analyse(sound, words)
    number = min((accent for accent in usual.accents if not accent.main), key=lambda accent: accent.strength).word
    stressed = prosody.analyse(sound, words, stressed={number})
    of = {accent.word: accent for accent in stressed.accents}
    before = {accent.word: accent for accent in usual.accents}
    assert of[number].main and not before[number].main and of[number].strength > before[number].strength + 0.2
    phrase = [accent for accent in stressed.accents if accent.phrase == of[number].phrase]
    assert sum(accent.main for accent in phrase) == 1
    frame = round(of[number].time * 15)
    for column in ("accent", "main accent"):
        k = prosody.FEATURE_NAMES.index(column)
        assert stressed.features[frame, k] > usual.features[frame, k] + 0.1
