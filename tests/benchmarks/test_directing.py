"""One edit of a minute's take, against performing the whole take again."""

import itertools

import numpy as np
import pytest
from s2ag.core.direction import gestures
from s2ag.core.direction.directing import Director
from s2ag.core.performance.synthesis import Request, Session
from s2ag.core.sound import audio
from sounds import write_wav

SECONDS = 60


@pytest.fixture(scope="module")
def minute(examples, tmp_path_factory):
    """A director who knows the take, its request, and its gestures but for those at the ends."""
    sound = audio.load(examples / "hello.flac")
    path = tmp_path_factory.mktemp("minute") / "minute.wav"
    write_wav(path, np.tile(sound, 5)[: SECONDS * audio.SAMPLE_RATE])
    director, request = Director(Session(cache="off")), Request(path, seed=2, hands=1.0, stance=1.0)
    return director, request, gestures.find(director.direct(request, []).motions[0])[2:-2]


@pytest.mark.benchmark(group="an edit of a minute's take")
def test_one_edit(benchmark, minute):
    director, request, found = minute
    wishes = itertools.cycle([{"hand": "left"}, {"size": 0.7}, {"hand": "right"}, {"size": 1.2}])
    edits = ({"do": "change", "at": one.at, **next(wishes)} for one in itertools.cycle(found))
    benchmark.pedantic(lambda edit: director.direct(request, [edit]), setup=lambda: ((next(edits),), {}), rounds=40)


@pytest.mark.benchmark(group="an edit of a minute's take")
def test_the_whole_take_again(benchmark, minute):
    director, request, _ = minute
    benchmark.pedantic(lambda: Session(cache="off").synthesize(request), rounds=3, warmup_rounds=1)
    assert director.direct(request, []).motions[0].duration == pytest.approx(SECONDS, abs=0.1)
