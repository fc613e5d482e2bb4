"""What goes on in time is performed in time, and what never changes is the plain setting to the bit."""

import json

import numpy as np
import pytest
from documents import save_curves
from s2ag.core import control_curves, settings
from s2ag.core.cli import main
from s2ag.core.editing import provenance
from s2ag.core.errors import UsageError
from s2ag.core.motion import skeleton
from s2ag.core.motion.face import channel
from s2ag.core.motion.motion import Motion
from s2ag.core.sound import audio
from s2ag.core.synthesis.session import Request, Session
from sounds import write_wav

SECONDS = 20
LIVE = {"hands": 1.0, "stance": 1.0}


@pytest.fixture(scope="module")
def session():
    return Session(cache="off", remember=True)


@pytest.fixture(scope="module")
def talk(examples, tmp_path_factory):
    """A recording whose second half is its first again."""
    path = tmp_path_factory.mktemp("talk") / "twice.wav"
    half = audio.load(examples / "hello.flac")[: SECONDS // 2 * audio.SAMPLE_RATE]
    write_wav(path, np.tile(half, 2))
    return path


@pytest.fixture(scope="module")
def perform(session, talk):
    return lambda **asked: session.synthesize(Request(talk, seed=2, **{**LIVE, **asked})).motions[0]


def plain(name, value):
    return {"affect": {name: value}} if name in ("arousal", "valence", "dominance") else {name: value}


def step(low, high):
    return [[0, low], [SECONDS / 2 - 0.5, low], [SECONDS / 2 + 0.5, high], [SECONDS, high]]


def speeds(motion):
    """Mean speed of each wrist (halves, 2) in the first and the second half, without a second around the middle."""
    way = np.linalg.norm(np.diff(skeleton.wrists(motion.directions), axis=0), axis=-1)
    middle, room = len(way) // 2, int(skeleton.FPS)
    return np.array([way[: middle - room].mean(0), way[middle + room :].mean(0)])


@pytest.mark.parametrize("name", settings.CURVES)
def test_a_constant_curve_is_the_plain_setting_to_the_bit(perform, name):
    value = 0.7
    curved, set_ = perform(curves={name: [[0, value], [7, value]]}), perform(**plain(name, value))
    assert np.array_equal(curved.directions, set_.directions)
    assert np.array_equal(curved.hands.shape, set_.hands.shape) and np.array_equal(curved.pelvis.place, set_.pelvis.place)
    assert curved.meta == set_.meta


@pytest.mark.slow
@pytest.mark.parametrize(
    # The corpus talks alike at every rate, so that rate moves what is asked for alone.
    ("name", "low", "high", "by"),
    [("intensity", 0.4, 1.4, 1.1), ("arousal", -1, 1, 1.1), ("rate", -1, 1, 1.1)],
)
def test_each_half_is_as_lively_as_its_own_value_makes_it(session, talk, name, low, high, by):
    def perform(**asked) -> np.ndarray:
        # What is heard is no part of it: a curve wins over that, to which a slider is added.
        made = session.synthesize(Request(talk, seed=2, takes=9, follow=0.0, **{**LIVE, **asked})).motions
        return np.mean([speeds(motion).max(1) for motion in made], axis=0)  # of ten seconds one take alone says little

    low_first, high_first = (perform(curves={name: step(*pair)}) for pair in ((low, high), (high, low)))
    assert by * low_first[0] < high_first[0]
    assert low_first[1] > by * high_first[1]
    assert low_first[0] == pytest.approx(perform(**plain(name, low))[0], rel=0.15, abs=0.01)


def test_the_hand_that_leads_can_change(perform):
    left_first, right_first = (speeds(perform(curves={"hand": step(*pair)})) for pair in ((-1, 1), (1, -1)))
    share = [one[:, 1] / one.sum(1) for one in (left_first, right_first)]
    assert share[0][0] < share[1][0] and share[0][1] > share[1][1]


def test_a_curve_leaves_no_jump(perform):
    def most(motion):
        return np.linalg.norm(np.diff(skeleton.wrists(motion.directions), n=2, axis=0), axis=-1).max()

    jump = [[0, 0.3], [10, 0.3], [10, 1.3], [20, 1.3]]
    whole = perform(intensity=1.3)
    # Unsmoothed, arms would go all their way to four times the size in one frame.
    assert most(perform(curves={"intensity": jump})) <= 1.25 * most(whole)


def test_a_style_begins_at_its_moment(perform):
    calm, lively = perform(style="calm lecturer"), perform(style="eager storyteller")
    both = perform(style="calm lecturer", changes=((SECONDS / 2, "eager storyteller"),))
    own = [speeds(one).max(1) for one in (calm, lively, both)]
    assert own[2][0] == pytest.approx(own[0][0], rel=0.1)
    assert own[2][1] > 1.1 * own[0][1]
    assert both.meta["style"] == calm.meta["style"] and both.meta["changes"] == [[SECONDS / 2, "eager storyteller"]]


def test_a_style_begins_at_its_words(session, examples):
    text = (examples / "hello.txt").read_text()
    words = text.split()
    middle = len(words) // 2

    def made(**asked):
        return session.synthesize(Request(examples / "hello.flac", seed=2, **asked))

    marked = made(text=" ".join([*words[:middle], "{as eager storyteller}", *words[middle:]]), style="calm lecturer")
    calm = made(text=text, style="calm lecturer")
    at = marked.words[middle][1]
    again = made(text=text, style="calm lecturer", changes=((at - 0.2, "eager storyteller"),))
    assert not marked.warnings and marked.words == calm.words
    assert not np.allclose(marked.motions[0].directions, calm.motions[0].directions)
    assert np.array_equal(marked.motions[0].directions, again.motions[0].directions)


def test_a_style_that_nobody_knows_is_left_out_with_a_word(session, examples):
    text = "{as nobody} " + (examples / "hello.txt").read_text()
    result = session.synthesize(Request(examples / "hello.flac", text=text))
    assert len(result.warnings) == 1 and "nobody" in result.warnings[0]


def test_a_walk_says_which_styles_of_the_words_it_passes_by(session, examples):
    text = (examples / "hello.txt").read_text()
    walk = {"style": "calm lecturer>eager storyteller", "seed": 2}
    plain, marked = (
        session.synthesize(Request(examples / "hello.flac", text=said, **walk)) for said in (text, "{as calm lecturer} " + text)
    )
    assert not plain.warnings and len(marked.warnings) == 1 and "{as calm lecturer}" in marked.warnings[0]
    assert np.array_equal(plain.motions[0].directions, marked.motions[0].directions)


def test_provenance_makes_it_again(perform, talk, session):
    first = perform(curves={"arousal": step(-1, 1)}, changes=((12.0, "eager storyteller"),), face=1.0)
    again = session.synthesize(provenance.request_from_meta(json.loads(json.dumps(first.meta)), talk)).motions[0]
    assert np.array_equal(first.directions, again.directions)


def test_a_face_feels_with_the_body(perform):
    face = perform(face=1.0, curves={"valence": step(-1, 1)}).face
    smile = face.weights[:, channel("SMILE")]
    middle = len(smile) // 2
    assert smile[: middle - 100].mean() < 0.05 < 0.2 < smile[middle + 100 :].mean()


@pytest.mark.parametrize(
    "asked",
    [
        {"curves": {"joy": [[0, 1]]}},
        {"curves": {"arousal": [[0, 2]]}},
        {"curves": {"arousal": [[3, 0], [1, 0.5]]}},
        {"curves": {"arousal": []}},
        {"curves": {"arousal": [[0, float("nan")]]}},
        {"curves": [1]},
        {"changes": [["soon", "eager storyteller"]]},
        {"changes": [[1.0, "eager storyteller > street preacher"]]},
        {"style": "eager storyteller > calm lecturer", "changes": [[1.0, "eager storyteller"]]},
    ],
)
def test_what_makes_no_sense_is_refused(talk, asked):
    with pytest.raises(UsageError):
        Request(talk, **asked)


def test_a_document_is_what_it_was(tmp_path):
    asked = {"curves": {"arousal": [[0.0, -0.5], [9.0, 1.0]]}, "changes": ((4.0, "eager storyteller"),)}
    save_curves(tmp_path / "rise.json", asked["curves"], asked["changes"])
    assert control_curves.load(tmp_path / "rise.json") == asked
    (tmp_path / "other.json").write_text('{"format": 2, "curves": {}}')
    for name in ("other.json", "none.json"):
        with pytest.raises(UsageError):
            control_curves.load(tmp_path / name)


def test_the_command_line_performs_a_document(talk, tmp_path, perform):
    save_curves(tmp_path / "rise.json", {"arousal": step(-1, 1)})
    told = [str(talk), "--no-transcript", "--seed", "2", "--cache", "off", "--curves", str(tmp_path / "rise.json")]
    assert main.main(["synth", *told, "-o", str(tmp_path / "rise.npz")]) == 0
    made = Motion.load(tmp_path / "rise.npz")
    assert np.array_equal(made.directions, perform(curves={"arousal": step(-1, 1)}).directions)
