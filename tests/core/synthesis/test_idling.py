"""Idles: always something moves, no fidget comes soon again, loops go on without a jump, and the table is what was captured."""

from pathlib import Path

import numpy as np
import pytest
from s2ag.core.errors import UsageError
from s2ag.core.motion import skeleton
from s2ag.core.synthesis import idling

MATERIAL = Path(__file__).parents[4] / "shared" / "data" / "rocketbox_clips"


@pytest.mark.parametrize("stillness", [0.0, 0.5, 1.0])
def test_something_moves_in_every_frame(stillness):
    motion = idling.idle(60, seed=3, stillness=stillness, fps=24)
    steps = np.degrees(np.linalg.norm(np.diff(motion.directions.astype(float), axis=0), axis=-1)).max(axis=1)
    assert steps.min() > 0.005 and len(motion.directions) == 60 * 24 and len(motion.face.weights) == 6000


def test_a_loop_ends_in_its_first_pose_and_moves_on():
    for seed in range(4):
        motion = idling.idle(20, seed=seed, loop=True, fps=24)
        parts = [motion.directions, motion.hands.knuckles, motion.hands.palms, motion.pelvis.place, motion.pelvis.turn]
        for part in parts:
            part = part.astype(float).reshape(len(part), -1)
            assert len(part) == 481 and np.abs(part[-1] - part[0]).max() < 1e-6
            speeds = np.diff(part, axis=0)
            jumps = np.linalg.norm(np.diff(np.concatenate([speeds, speeds[:1]]), axis=0), axis=1)
            assert jumps[-1] <= np.percentile(jumps, 99)  # the seam is a moment like others
        assert (motion.face.weights[0] == motion.face.weights[-1]).all()


def test_no_fidget_comes_twice_within_twenty_seconds():
    shown = [idling.idle(120, seed=seed, stillness=0.0).meta["shows"] for seed in range(6)]
    assert min(map(len, shown)) > 8
    for one in shown:
        for kind in {kind for kind, _ in one}:
            times = [at for name, at in one if name == kind]
            assert min(np.diff(times), default=np.inf) > idling.APART


def test_stillness_seed_and_style_make_it_another():
    def speed(**about):
        return np.median(np.linalg.norm(np.diff(idling.idle(120, **about).directions, axis=0), axis=-1))

    assert speed(seed=1, stillness=0.0) > 1.3 * speed(seed=1, stillness=1.0)
    assert idling.idle(60, seed=1, stillness=1.0).meta["shows"] == []
    one, same, other, styled = (idling.idle(10, **about).directions for about in ({}, {}, {"seed": 1}, {"style": "stern"}))
    assert (one == same).all() and not (one == other).all() and not (one == styled).all()


def test_fidgets_are_whole():
    """None is cut by an end or by the seam of a loop."""
    lengths = {one.kind: len(one.numbers) / skeleton.FPS for one in idling._table()}
    for seed in range(6):
        for at, end in [(at, at + 0.5 * lengths[kind]) for kind, at in idling.idle(30, "", seed, 0.0, True).meta["shows"]]:
            assert 0 < at < end < 30


def test_what_cannot_be_is_refused():
    for about in ({"seconds": 0.2}, {"seconds": 9e9}, {"seconds": 5, "stillness": 2}, {"seconds": 5, "seed": -1}):
        with pytest.raises(UsageError):
            idling.idle(**about)


def test_the_table_is_what_was_captured():
    if not MATERIAL.is_dir():
        pytest.skip("the captured clips are not here")
    pytest.importorskip("scipy")
    from s2ag.core import npz
    from s2ag.core.learning.corpus import idle_table

    for name in ("idle", "listener"):
        with npz.open_arrays(Path(idling.__file__).parents[1] / "assets" / f"{name}.npz") as stored:
            made = idle_table.pack(MATERIAL, name == "listener")
            assert all((stored[part] == made[part]).all() for part in ("names", "ends"))
            assert np.abs(stored["steps"].astype(int) - made["steps"]).max() <= 1
