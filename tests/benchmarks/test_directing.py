"""One edit of a minute's take, against performing the whole take again."""

import itertools
import random

import numpy as np
import pytest
from s2ag.core.direction import aims, filling, gestures
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


@pytest.mark.parametrize("kind", ["hand", "size", "move", "delete"])
@pytest.mark.benchmark(group="a hundred edits of a kind")
def test_a_hundred_edits(benchmark, minute, kind):
    """How many of a hundred random edits are not had, and by how much joins are harder than the take itself."""
    director, request, found = minute
    base, rng, missed, strains = director.direct(request, []).motions[0], random.Random(5), [], []

    def one_edit():
        one = rng.choice(found)
        edit, aim = _edit(kind, one, rng)
        made = director.direct(request, [edit]).motions[0]
        rows = np.flatnonzero((made.directions != base.directions).reshape(len(base.directions), -1).any(1))
        strains.append(filling.strain(base, made, [(rows[0], rows[-1] + 1)]))
        others = [other for other in gestures.find(base) if other != one]
        off = aim.miss(made) if aim else 2 * gestures.left(made, one, others) / one.size
        missed.extend([edit] if off > 1 else [])

    benchmark.pedantic(one_edit, rounds=100)
    print(
        f"\n{kind}: {len(missed)} of 100 missed, strain at most {max(strains):.0%}, above 10 % {sum(x > 0.1 for x in strains)}"
    )
    assert len(missed) <= (20 if kind == "delete" else 5)


def _edit(kind: str, one: gestures.Gesture, rng) -> tuple[dict, aims.Aim | None]:
    """A random edit of a gesture and what it aims at, None for one that is to be gone."""
    if kind == "hand":
        hand = rng.choice([hand for hand in gestures.HANDS if hand != one.hand])
        return {"do": "change", "at": one.at, "hand": hand}, aims.Aim(one.at, hand, one.size)
    if kind == "size":
        size = rng.choice([0.6, 0.8, 1.25, 1.4])
        return {"do": "change", "at": one.at, "size": size}, aims.Aim(one.at, one.hand, one.size * size)
    if kind == "move":
        to = one.at + rng.choice([-1, 1]) * rng.uniform(0.2, 0.8)
        return {"do": "move", "at": one.at, "to": to}, aims.Aim(to, one.hand, one.size)
    return {"do": "delete", "at": one.at}, None
