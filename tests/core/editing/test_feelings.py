"""A feeling from a moment on: the body and the face change from there, nothing before it, and it is an edit like all others."""

import numpy as np
import pytest
from s2ag.core.editing import edits
from s2ag.core.errors import UsageError
from s2ag.core.motion import skeleton
from s2ag.core.motion.face import RATE
from s2ag.core.synthesis.session import Request

AT = 6.0
EXCITED = {"do": "feel", "at": AT, "arousal": 1.0, "valence": 0.8}


@pytest.fixture(scope="module")
def request_(examples):
    return Request(examples / "hello.flac", transcript=examples / "hello.txt", seed=2, hands=1.0, face=1.0)


@pytest.fixture(scope="module")
def excited(director, request_):
    return director.direct(request_, [EXCITED]).motions[0]


def lively(motion, start, stop):
    wrists = skeleton.wrists(motion.directions[round(start * skeleton.FPS) : round(stop * skeleton.FPS)])
    return np.linalg.norm(np.diff(wrists, axis=0), axis=-1).mean()


def test_nothing_before_it_changes_and_all_that_follows_feels(base, excited):
    frame = round(AT * skeleton.FPS)
    assert np.array_equal(base.directions[:frame], excited.directions[:frame])
    assert not np.array_equal(base.directions[frame + 8 :], excited.directions[frame + 8 :])


def test_an_excited_rest_of_a_take_is_livelier_than_a_bored_one(director, request_, excited):
    bored = director.direct(request_, [{"do": "feel", "at": AT, "arousal": -1.0}]).motions[0]
    assert lively(excited, AT + 1, 14) > 1.2 * lively(bored, AT + 1, 14)


def test_the_face_feels_with_the_body(base, excited):
    before, after = slice(0, int((AT - 0.5) * RATE)), slice(int((AT + 1) * RATE), None)
    assert np.array_equal(base.face.weights[before], excited.face.weights[before])
    assert np.abs(base.face.weights[after] - excited.face.weights[after]).max() > 0.05


def test_later_edits_feel_so_and_the_next_feeling_ends_it(director, request_, excited):
    calm = {"do": "feel", "at": 10.0, "arousal": -1.0}
    both = director.direct(request_, [EXCITED, calm]).motions[0]
    frame = round(10.0 * skeleton.FPS)
    assert np.array_equal(excited.directions[:frame], both.directions[:frame])
    assert not np.array_equal(excited.directions[frame + 5 :], both.directions[frame + 5 :])
    earlier = director.direct(request_, [calm, EXCITED]).motions[0]
    alone = director.direct(request_, [calm]).motions[0]
    assert np.array_equal(earlier.directions[frame:], alone.directions[frame:])


def test_it_is_checked_as_all_edits_are():
    assert edits.check([EXCITED]) == [EXCITED]
    for wrong in ({"do": "feel", "at": 1.0}, {"do": "feel", "at": 1.0, "arousal": 2.0}, {"do": "feel", "arousal": 1.0}):
        with pytest.raises(UsageError, match="Edit 1 is not usable"):
            edits.check([wrong])
