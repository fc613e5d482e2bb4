import numpy as np
import pytest

torch = pytest.importorskip("torch")

from rounding import bound_of  # noqa: E402
from s2ag.core.errors import Cancelled  # noqa: E402
from s2ag.core.model import windows  # noqa: E402
from s2ag.core.model.config import ModelConfig  # noqa: E402
from s2ag.core.model.generator import Generator  # noqa: E402
from s2ag.core.model.mfcc_timing import mfcc_slice  # noqa: E402
from s2ag.core.motion import rest, skeleton  # noqa: E402
from s2ag.core.sound.prosody import FEATURES  # noqa: E402

SEEDS, WINDOW = 10, 96


@pytest.fixture(scope="module")
def generator():
    torch.manual_seed(0)
    return Generator(ModelConfig.default(speakers=2)).eval()


def inputs(start, stop):
    rng = np.random.default_rng(5)
    mfcc, words, prosody = (rng.standard_normal(shape) for shape in ((2000, 40), (960, 300), (960, FEATURES)))
    return mfcc[mfcc_slice(start, stop)], words[start:stop], prosody[start:stop]


def run(generator, frames, takes=1, **options):
    poses = np.broadcast_to(rest.REST, (takes, SEEDS, 9, 3)).astype(np.float32)
    styles = np.random.default_rng(1).standard_normal((takes, 16)).astype(np.float32)
    return windows.generate(generator, inputs, styles, poses, frames, WINDOW, **options)


@pytest.mark.parametrize("frames", [2, 50, 96, 97, 150, 171, 333, 900])
def test_windows_cover_every_frame_with_room_for_seeds_and_look_ahead(frames):
    starts = windows.window_starts(frames, WINDOW, SEEDS)
    assert starts[0] == 0 and starts[-1] + WINDOW >= frames
    if len(starts) > 1:
        assert starts[-1] + WINDOW == frames
        assert np.diff(starts).max() <= WINDOW - SEEDS - windows.LOOKAHEAD + 1


@pytest.mark.parametrize("frames", [2, 7, 40, 97, 300])
def test_any_length_gives_unit_directions(generator, frames):
    made = run(generator, frames)
    assert made.shape == (1, frames, 9, 3) and made.dtype == np.float32
    np.testing.assert_allclose(np.linalg.norm(made, axis=-1), 1, atol=1e-5)


def test_same_inputs_give_the_same_bytes_and_takes_do_not_disturb_each_other(generator):
    assert np.array_equal(run(generator, 200), run(generator, 200))
    several = run(generator, 200, takes=3)
    np.testing.assert_allclose(several[0], run(generator, 200)[0], atol=bound_of(generator, WINDOW))
    assert not np.allclose(several[0], several[1], atol=1e-3)


def test_progress_reaches_one_and_cancelling_stops(generator):
    heard = []
    run(generator, 300, progress=heard.append)
    assert heard == sorted(heard) and heard[-1] == 1
    with pytest.raises(Cancelled):
        run(generator, 300, cancelled=lambda: True)


def test_the_cross_fade_takes_position_and_speed_from_the_old_window_to_the_new():
    frames = np.arange(SEEDS)[None, :, None, None] * np.ones((1, SEEDS, 9, 3))
    old = skeleton.normalize(frames * [0.01, 0, 0] + [0, 1, 0])
    new = skeleton.normalize(frames * [0.012, 0, 0] + [0.02, 1, 0])
    faded = windows._cross_fade(old, new)
    assert np.abs(faded[:, 0] - old[:, 0]).max() < 0.001 and np.abs(faded[:, -1] - new[:, -1]).max() < 0.001
    assert np.abs(np.diff(faded, 2, axis=1)).max() < 0.003
