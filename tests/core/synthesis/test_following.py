"""What is heard in the voice moves the controls of networks that were trained so, beside sliders and below curves."""

import numpy as np
import pytest
from s2ag.core.settings import AFFECTS, CONTROLS
from s2ag.core.sound import audio
from s2ag.core.synthesis import curves, style_sequence
from s2ag.core.synthesis.session import Request, Session
from s2ag.core.synthesis.stages import Stages
from sounds import write_wav

TRACK = np.stack([np.linspace(-1, 1, 60), np.full(60, 0.5), np.zeros(60)], axis=1).astype(np.float32)


def asked(heard=TRACK, **settings):
    """Controls ``(60, 5)`` that move the style of a request, where ``heard`` is."""

    class Network:
        speakers = np.zeros((1, 5), np.float32), np.zeros((1, 5), np.float32)

        def steer(self, points, wishes):
            return points + wishes

    class Config:
        controls, style_size = 5, 5

    class Checkpoint:
        config, network, speakers, window = Config(), Network(), [{"name": "one"}], (34, 4)
        hash = ""

    performers = style_sequence.from_request(Checkpoint(), Request("none.wav", **settings), (), heard)
    return np.broadcast_to(performers.on_the_way(60)[0], (60, 5))


def test_sliders_are_offsets_to_what_is_heard():
    plain, offset = asked(), asked(affect={"arousal": 0.8, "dominance": -0.4}, rate=0.5)
    np.testing.assert_allclose(plain[:, :3], np.minimum(TRACK * curves.FOLLOWED, curves.MOST), atol=1e-6)
    np.testing.assert_allclose(offset[:, 0], np.clip(TRACK[:, 0] + 0.8, -curves.REACH, curves.REACH), atol=1e-6)
    np.testing.assert_allclose(offset[:, 1:], np.broadcast_to([curves.MOST[1], -0.4, 0.5, 0], (60, 4)), atol=1e-6)


def test_curves_win_over_what_is_heard_and_leave_the_other_affects():
    drawn = asked(curves={"arousal": [[0, 0.2], [3, 0.4]]}, affect={"valence": 0.1})
    assert drawn[:, 0].min() >= 0.2 and drawn[:, 0].max() <= 0.41
    np.testing.assert_allclose(drawn[:, 1], 0.1 + curves.MOST[1], atol=1e-6)


def test_following_less_or_not_at_all():
    np.testing.assert_allclose(asked(follow=0.5)[:, 0], 0.5 * TRACK[:, 0], atol=1e-6)
    assert not asked(follow=0.0).any() and not asked(heard=None).any()
    assert np.abs(asked(follow=2.0)[:, 0]).max() == curves.REACH


def test_later_takes_vary_around_what_is_heard():
    performers = asked(takes=1, take=3)
    np.testing.assert_allclose(np.diff(performers[20:40, 0]), np.diff(TRACK[20:40, 0]), atol=1e-5)


@pytest.fixture(scope="module")
def angry(tmp_path_factory, shared):
    path = tmp_path_factory.mktemp("voice") / "angry.wav"
    write_wav(path, np.tile(audio.load(shared / "thorsten_emotional" / "angry.wav"), 2))
    return path


def test_weights_that_do_not_say_so_hear_no_affect(deaf, examples):
    session = Session(deaf, cache="off")
    request = Request(examples / "hello.flac", text=(examples / "hello.txt").read_text("utf-8"))
    heard, performers = session.hear(request, Stages(lambda *_: None, lambda: False))
    assert heard.affect is None and performers.steer is None
    assert "heard" not in session.synthesize(request).motions[0].meta


def test_a_take_follows_the_voice_and_tells_what_was_heard(deaf, angry):
    session = Session(cache="off")
    follows, alone = (session.synthesize(Request(angry, face=1.0, **more)).motions[0] for more in ({}, {"follow": 0.0}))
    told = follows.meta["heard"]
    assert list(told) == list(AFFECTS) and {len(values) for values in told.values()} == {len(follows.directions) // 8 + 1}
    assert np.mean(told["arousal"]) > 0.3 and told == alone.meta["heard"]
    assert "follow" not in follows.meta and alone.meta["follow"] == 0.0
    assert np.abs(follows.directions - alone.directions).max() > 0.05
    assert not np.array_equal(follows.face.weights, alone.face.weights)
    plain = Session(deaf, cache="off").synthesize(Request(angry)).motions[0]
    np.testing.assert_array_equal(alone.directions, plain.directions)


def test_curves_of_what_was_heard_perform_nearly_the_same(angry):
    session = Session(cache="off")
    first = session.synthesize(Request(angry)).motions[0]
    points = {name: [[0.5 * at, value] for at, value in enumerate(track)] for name, track in first.meta["heard"].items()}
    again = session.synthesize(Request(angry, curves=points)).motions[0]
    without = session.synthesize(Request(angry, follow=0.0)).motions[0]
    near, far = (np.abs(first.directions - other.directions).mean() for other in (again, without))
    assert near < 0.3 * far
    assert set(again.meta["curves"]) <= set(CONTROLS)
