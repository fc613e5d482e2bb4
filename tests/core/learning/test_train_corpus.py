"""Corpus folders: windows against the arrays they are cut from, mirroring, dropped words, and damage."""

import json
import shutil
import threading

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from s2ag.core.errors import CorpusUnreadable, OutputUnwritable  # noqa: E402
from s2ag.core.learning.train.config import TrainConfig  # noqa: E402
from s2ag.core.learning.train.dataset import TRAIN, VALIDATION, Corpus, Windows, augment, draw_windows  # noqa: E402
from s2ag.core.learning.train.given_frames import draw_masks  # noqa: E402
from s2ag.core.learning.train.prefetch import Prefetch  # noqa: E402
from s2ag.core.learning.train.storage import save_arrays  # noqa: E402
from s2ag.core.model.mfcc_timing import nearest_mfcc  # noqa: E402
from s2ag.core.model.seeds import seed_input  # noqa: E402
from s2ag.core.motion import hand_channels, skeleton  # noqa: E402
from toy_corpus import META, toy_arrays, write_toy_corpus  # noqa: E402


def toy(talks, frames):
    arrays = toy_arrays(talks=talks, frames=frames)
    return arrays, Corpus(arrays, META)


def test_windows_are_cuts_of_their_talk():
    arrays, corpus = toy(talks=3, frames=60)
    assert arrays["recording"].tolist() == [0, 0, 1]
    batch = corpus.batch(Windows(np.array([1, 2]), np.array([7, 20])), 40, 10)
    for row, (talk, first) in enumerate([(1, 7), (2, 20)]):
        recording = talk // 2
        real = arrays["directions"][talk * 60 + first : talk * 60 + first + 40].astype(np.float32)
        np.testing.assert_allclose(batch.directions[row].numpy(), real, atol=2e-3)
        heard = arrays["mfcc_starts"][recording] + nearest_mfcc(first)
        np.testing.assert_array_equal(batch.mfcc[row].numpy(), arrays["mfcc"][heard : heard + 83].astype(np.float32))
        here = slice(recording * 60 + first, recording * 60 + first + 40)
        spoken = arrays["word_index"][here]
        wanted = np.where(spoken[:, None] >= 0, arrays["vectors"][spoken], 0).astype(np.float32)
        np.testing.assert_array_equal(batch.words[row].numpy(), wanted)
        np.testing.assert_array_equal(batch.prosody[row].numpy(), arrays["prosody"][here].astype(np.float32))
        np.testing.assert_array_equal(batch.controls[row].numpy(), np.tile(arrays["controls"][talk], (40, 1)))
        assert int(batch.speaker[row]) == talk % 2
    np.testing.assert_allclose(batch.directions.norm(dim=-1).numpy(), 1, atol=1e-6)
    seeds = batch.seeds.numpy()
    assert (seeds[:, :10, 27] == 1).all() and not seeds[:, 10:].any()
    np.testing.assert_allclose(
        seeds[:, :10, :27].reshape(2, 10, 9, 3) + skeleton.MEAN, batch.directions[:, :10].numpy(), atol=1e-6
    )


def test_windows_stay_inside_talks_of_their_split():
    _, corpus = toy(talks=5, frames=60)
    talks, first = corpus.random_windows(np.random.default_rng(0), 500, 48)
    assert set(talks) == {0, 1, 2, 3} and set(first) == set(range(13))
    held, first = corpus.spread_windows(VALIDATION, 5, 48)
    assert set(held) == {4} and first.tolist() == [0, 3, 6, 9, 12]
    with pytest.raises(CorpusUnreadable, match="61 frames"):
        corpus.window_starts(TRAIN, 61)


def test_hands_are_mirrored_with_their_arms_and_given_with_them():
    arrays = toy_arrays(talks=2, frames=60)
    numbers = np.random.default_rng(0).normal(size=(len(arrays["directions"]), hand_channels.SIZE)).astype(np.float16)
    corpus = Corpus({**arrays, "extras": numbers}, META)
    batch = corpus.batch(Windows(np.array([0, 0]), np.array([5, 5]), flip=np.array([False, True])), 48, 10)
    np.testing.assert_array_equal(batch.extras[0], numbers[5:53].astype(np.float32))
    np.testing.assert_array_equal(
        batch.extras[1], hand_channels.mirror_channels(numbers[5:53]).astype(np.float16).astype(np.float32)
    )
    np.testing.assert_array_equal(batch.seeds[:, :10, 27:-1], batch.extras[:, :10])
    with pytest.raises(ValueError):
        Corpus({**arrays, "extras": numbers[:, :7]}, META)


def test_a_mirrored_window_is_gestured_with_the_other_hand():
    arrays = toy_arrays(talks=2, frames=60)
    arrays["controls"][0] = (0.1, 0.2, 0.3, 0.4, 0.5)
    corpus = Corpus(arrays, META)
    windows = Windows(np.array([0, 0]), np.array([5, 5]), flip=np.array([False, True]))
    batch = corpus.batch(windows, 48, 10)
    np.testing.assert_allclose(batch.directions[1].numpy(), skeleton.mirror(batch.directions[0].numpy()), atol=1e-6)
    np.testing.assert_allclose(batch.seeds[1, :10, :27], seed_input(batch.directions[1:], 48)[0, :10, :27])
    torch.testing.assert_close(batch.controls[0], torch.tensor([0.1, 0.2, 0.3, 0.4, 0.5]).expand(48, 5))
    torch.testing.assert_close(batch.controls[1], torch.tensor([0.1, 0.2, 0.3, 0.4, -0.5]).expand(48, 5))
    assert arrays["controls"][0, 4] == np.float32(0.5)


def test_windows_without_words_have_the_prosody_of_sound_alone():
    arrays, corpus = toy(talks=2, frames=60)
    windows = Windows(np.array([0, 1]), np.array([3, 3]), wordless=np.array([False, True]), kept=np.arange(40) < [[0], [10]])
    batch = corpus.batch(windows, 40, 10)
    assert batch.words[0].any() and not batch.words[1].any()
    np.testing.assert_array_equal(batch.prosody[0].numpy(), arrays["prosody"][3:43].astype(np.float32))
    np.testing.assert_array_equal(batch.prosody[1].numpy(), arrays["prosody_plain"][3:43].astype(np.float32))
    assert not batch.seeds[0].any() and batch.seeds[1].any()


def test_what_is_heard_is_added_to_the_controls_and_hidden_by_chance():
    arrays = toy_arrays(talks=2, frames=60)
    arrays["controls"][:, 0] = 0.9
    heard = np.random.default_rng(2).uniform(-1, 1, (len(arrays["prosody"]), 3)).astype(np.float16)
    corpus = Corpus({**arrays, "heard": heard}, META)
    here, none = heard[3:43].astype(np.float32), np.zeros(4, bool)
    voiceless, toneless, unmoved = (np.arange(4) == k for k in (1, 2, 3))
    windows = Windows(np.zeros(4, int), np.full(4, 3), none, voiceless=voiceless, toneless=toneless, unmoved=unmoved)
    batch = corpus.batch(windows, 40, 10)
    for row in (0, 2):
        np.testing.assert_allclose(batch.controls[row, :, 0], np.minimum(here[:, 0] + 0.9, 1.5), atol=1e-6)
        np.testing.assert_allclose(batch.controls[row, :, 1:3], here[:, 1:], atol=1e-6)
    for row in (1, 3):
        torch.testing.assert_close(batch.controls[row, :, :3], torch.tensor([0.9, 0, 0]).expand(40, 3))
    assert [bool(part.any()) for part in batch.mfcc] == [True, False, True, True]
    assert [bool(part.any()) for part in batch.prosody] == [True, False, False, True]
    with pytest.raises(ValueError):
        Corpus({**arrays, "heard": heard[:-1]}, META)


def test_chances_decide_over_whole_windows():
    _, corpus = toy(talks=4, frames=60)
    config = TrainConfig(batch=2000, frames=48, word_drop=0.25, seed_drop=0.5)
    windows = draw_windows(corpus, config, np.random.default_rng(0))
    assert windows.wordless.mean() == pytest.approx(0.25, abs=0.05)
    assert windows.kept[:, :10].all(1).mean() == pytest.approx(0.5, abs=0.05) and not windows.kept[:, 10:].any()
    assert not windows.flip.any() and windows.voiceless is None
    drops = TrainConfig(batch=2000, frames=48, voice_drop=0.1, prosody_drop=0.3, affect_drop=0.2)
    windows = draw_windows(corpus, drops, np.random.default_rng(0))
    shares = [hidden.mean() for hidden in (windows.voiceless, windows.toneless, windows.unmoved)]
    assert shares == pytest.approx([0.1, 0.3, 0.2], abs=0.04)
    assert draw_windows(corpus, TrainConfig(batch=50, frames=48, mirror=1.0), np.random.default_rng(0)).flip.all()


def test_noise_leaves_performances_and_empty_seeds_alone():
    _, corpus = toy(talks=4, frames=60)
    batch = corpus.batch(Windows(np.array([0, 1]), np.array([0, 4])), 48, 10)
    torch.manual_seed(0)
    changed = augment(batch, TrainConfig())
    assert not torch.equal(changed.mfcc, batch.mfcc) and not torch.equal(changed.seeds, batch.seeds)
    assert torch.equal(changed.seeds[..., 27], batch.seeds[..., 27]) and not changed.seeds[:, 10:].any()
    assert torch.equal(changed.directions, batch.directions) and torch.equal(changed.words, batch.words)


@pytest.mark.parametrize("name", ["starts", "word_index", "speaker", "recording", "frame_starts"])
def test_arrays_that_do_not_fit_are_refused(tmp_path, name):
    arrays = toy_arrays(talks=2, frames=60)
    arrays[name] = arrays[name] + 100
    save_arrays(tmp_path / "corpus", arrays, META)
    with pytest.raises(CorpusUnreadable, match="do not fit|does not rise from 0"):
        Corpus.load(tmp_path / "corpus")


def cut_short(folder):
    path = folder / "directions.npy"
    path.write_bytes(path.read_bytes()[:-500])


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (lambda folder: shutil.rmtree(folder), "no such folder"),
        (lambda folder: (folder / "prosody.npy").unlink(), "prosody.npy is missing"),
        (lambda folder: (folder / "mfcc.npy").write_text("hello"), "not a packed corpus"),
        (lambda folder: (folder / "speaker.npy").write_bytes(b""), "not a packed corpus"),
        (lambda folder: (folder / "meta.json").write_text("{"), "not a packed corpus"),
        (lambda folder: (folder / "meta.json").write_text(json.dumps({**META, "format": 1})), "format 2"),
        (lambda folder: (folder / "meta.json").write_text(json.dumps({**META, "fps": 500})), "rate is out of range"),
        (lambda folder: (folder / "meta.json").write_text(json.dumps({**META, "fps": "15"})), "rate is out of range"),
        (lambda folder: (folder / "meta.json").write_text('{"format": 2}'), "speakers"),
        (cut_short, "not a packed corpus"),
    ],
)
def test_damaged_folders_are_no_corpus(tmp_path, damage, says):
    folder = write_toy_corpus(tmp_path / "corpus", talks=2, frames=60)
    Corpus.load(folder)
    damage(folder)
    with pytest.raises(CorpusUnreadable, match=says) as caught:
        Corpus.load(folder)
    assert "s2ag.core.learning.corpus" in caught.value.remedy


def test_a_corpus_is_written_whole_or_not_at_all(tmp_path):
    folder = write_toy_corpus(tmp_path / "corpus", talks=2, frames=60)
    with pytest.raises(ValueError):
        save_arrays(folder, {"directions": np.array([object()])}, META)
    assert Corpus.load(folder).starts[-1] == 120
    write_toy_corpus(folder, talks=2, frames=80)
    assert Corpus.load(folder).starts[-1] == 160
    assert [path.name for path in tmp_path.iterdir()] == ["corpus"]


def test_a_corpus_replaces_nothing_else(tmp_path):
    (tmp_path / "thesis.txt").write_text("precious")
    with pytest.raises(OutputUnwritable, match="something else"):
        write_toy_corpus(tmp_path)
    with pytest.raises(OutputUnwritable):
        write_toy_corpus(tmp_path / "absent" / "corpus")
    assert (tmp_path / "thesis.txt").read_text() == "precious"


def test_the_next_batch_is_begun_while_one_is_used():
    begun, go_on = [], threading.Event()

    def prepare(step):
        begun.append(step)
        if step == 8:
            go_on.set()
        return step * 10

    batches = Prefetch(prepare)
    assert batches.take(7) == 70
    assert go_on.wait(10) and begun == [7, 8]
    assert batches.take(8) == 80
    assert batches.take(3) == 30  # after a resume
    batches.close()


def test_a_failure_to_gather_reaches_the_step():
    batches = Prefetch(lambda step: 1 // step)
    with pytest.raises(ZeroDivisionError):
        batches.take(0)
    batches.close()


def test_given_frames_may_lie_anywhere():
    shares = {"start": 0.3, "end": 0.2, "both": 0.1, "gap": 0.1, "frames": 0.1}
    masks = draw_masks(np.random.default_rng(0), 4000, 48, 10, shares)
    start, end, count = masks[:, :10].all(1), masks[:, -1], masks.sum(1)
    assert (count == 0).mean() == pytest.approx(0.22, abs=0.04)
    assert (masks[:, 0] & ~end & (count <= 10)).mean() == pytest.approx(0.3, abs=0.04)
    assert (start & ~end).mean() == pytest.approx(0.165, abs=0.03)
    assert (end & ~masks[:, 0] & (count <= 10)).mean() == pytest.approx(0.2, abs=0.03)
    assert (start & end & (count > 20)).mean() > 0.03
    _, corpus = toy(talks=2, frames=60)
    windows = Windows(np.array([0, 1]), np.array([3, 3]), kept=masks[:2])
    seeds = corpus.batch(windows, 48, 10).seeds
    np.testing.assert_array_equal(seeds[..., 27].numpy() > 0, masks[:2])
    assert not seeds[..., :27].numpy()[~masks[:2]].any() and seeds[..., :27].numpy()[masks[:2]].any(-1).all()


def test_strokes_are_told_in_some_windows_and_mirrored_with_them():
    _, corpus = toy(talks=2, frames=60)
    draws = np.ones((3, 48))
    draws[:2] = 0
    windows = Windows(np.array([0, 0, 0]), np.array([3, 3, 3]), np.array([False, True, False]), draws=draws)
    asked = corpus.batch(windows, 48, 10).asked.numpy()
    assert asked[:2, :, 0].all() and not asked[2].any()
    assert np.flatnonzero(asked[0, :, 1]).tolist() == list(range(12, 43)) and asked[0, :, 2].argmax() == 27
    assert asked[0, 27].tolist() == [1, 1, 1, 0, 1, 0.5, 1] and asked[1, 27].tolist() == [1, 1, 1, 1, 0, 0.5, 1]
    arrays = toy_arrays(talks=2, frames=60)
    del arrays["strokes"]
    silent = Corpus(arrays, META)
    assert silent.meanings == [] and not silent.batch(windows, 48, 10).asked.any()
    assert TrainConfig(model="flow", stroke_tell=0.3).model_config(2, len(silent.meanings)).meanings == 0
