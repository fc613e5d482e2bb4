"""Training: losses against hand-computed values, windows against the corpus, and runs that learn, stop and continue."""

import json
import math

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from s2ag.core import checkpoint, skeleton  # noqa: E402
from s2ag.core.errors import CheckpointUnreadable, CorpusUnreadable, UsageError  # noqa: E402
from s2ag.core.model.timing import nearest_mfcc  # noqa: E402
from s2ag.core.train import losses  # noqa: E402
from s2ag.core.train.__main__ import main  # noqa: E402
from s2ag.core.train.config import TrainConfig  # noqa: E402
from s2ag.core.train.dataset import TRAIN, VALIDATION, Corpus, augment  # noqa: E402
from s2ag.core.train.loop import CHECKPOINT, LOG, STATE, train  # noqa: E402
from s2ag.core.train.validation import arm_speed, correlation  # noqa: E402
from toy_corpus import toy_arrays, write_toy_corpus  # noqa: E402

SMALL = {"gru_size": 32, "gru_layers": 1, "head_size": 32, "mfcc_channels": [16, 16, 16], "text_channels": 16}


@pytest.fixture
def one_thread():
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


@pytest.fixture
def settings(tmp_path):
    data = write_toy_corpus(tmp_path / "corpus.npz")
    return dict(
        data=str(data), out=str(tmp_path / "run"), model_settings=SMALL, batch=8, frames=48, steps=3, threads=1,
        discriminator_frames=32, generator_rate=3e-3, diversity_share=0.25, log_steps=1, validate_steps=2,
    )  # fmt: skip


def test_huber_is_quadratic_below_a_tenth():
    d = torch.tensor([0.05, -0.05, 0.3, -1.0])
    assert losses.huber(d, torch.zeros(4)).item() == pytest.approx((2 * 0.5 * 0.05**2 / 0.1 + 0.25 + 0.95) / 4)


def test_motion_compares_differences():
    moving = torch.tensor([0.0, 0.05, 0.15]).view(1, 3, 1)
    still = torch.full((1, 3, 1), 7.0)
    assert losses.motion(moving, still, 1).item() == pytest.approx((0.0125 + 0.05) / 2, rel=1e-4)
    assert losses.motion(moving, still, 2).item() == pytest.approx(0.0125, rel=1e-4)


def test_adversarial_losses():
    real, made = torch.tensor([[0.9], [0.8]]), torch.tensor([[0.2], [0.4]])
    assert losses.adversarial(made).item() == pytest.approx(-(math.log(0.2) + math.log(0.4)) / 2)
    expected = -(math.log(0.9) + math.log(0.8) + math.log(0.8) + math.log(0.6)) / 2
    assert losses.discriminator(real, made).item() == pytest.approx(expected)
    soft = -(0.9 * math.log(0.9) + 0.1 * math.log(0.1) + math.log(0.8))
    assert losses.discriminator(real[:1], made[:1], 0.9).item() == pytest.approx(soft, rel=1e-5)
    assert math.isfinite(losses.adversarial(torch.zeros(1, 1))) and math.isfinite(
        losses.discriminator(torch.zeros(1), torch.ones(1))
    )


def test_divergence_from_a_standard_normal():
    assert losses.divergence(torch.zeros(2, 16), torch.zeros(2, 16)).item() == 0
    mu, logvar = torch.tensor([[1.0, 0.0]]), torch.tensor([[0.0, math.log(2.0)]])
    assert losses.divergence(mu, logvar).item() == pytest.approx((0.5 + 0.5 * (2 - 1 - math.log(2))) / 2)


def test_diversity_rewards_distance_per_style():
    made = torch.zeros(1, 2, 1, requires_grad=True)
    other = torch.tensor([[[0.02], [1.0]]], requires_grad=True)
    style, other_style = torch.zeros(1, 4), torch.full((1, 4), 0.5)
    value = losses.diversity(made, other, style, other_style)
    assert value.item() == pytest.approx(-(0.5 * 0.02**2 / 0.05 + 0.975) / 0.50001)
    value.backward()
    assert made.grad.abs().sum() > 0 and other.grad is None
    assert losses.diversity(made, other, style, style).item() == -1000


def test_windows_are_cuts_of_their_talk():
    arrays = toy_arrays(talks=3, frames=60)
    corpus = Corpus(arrays)
    batch = corpus.batch(np.array([0, 1]), np.array([7, 20]), 40, 10)
    for row, (talk, first) in enumerate([(0, 7), (1, 20)]):
        real = arrays["directions"][talk * 60 + first : talk * 60 + first + 40].astype(np.float32)
        np.testing.assert_allclose(batch.directions[row].numpy(), real, atol=2e-3)
        heard = arrays["mfcc_starts"][talk] + nearest_mfcc(first)
        np.testing.assert_array_equal(batch.mfcc[row].numpy(), arrays["mfcc"][heard : heard + 83].astype(np.float32))
        spoken = arrays["word_index"][talk * 60 + first : talk * 60 + first + 40]
        wanted = np.where(spoken[:, None] >= 0, arrays["vectors"][spoken], 0).astype(np.float32)
        np.testing.assert_array_equal(batch.words[row].numpy(), wanted)
        assert int(batch.speaker[row]) == talk % 2
    np.testing.assert_allclose(batch.directions.norm(dim=-1).numpy(), 1, atol=1e-6)
    seeds = batch.seeds.numpy()
    assert (seeds[:, :10, 27] == 1).all() and not seeds[:, 10:].any()
    np.testing.assert_allclose(
        seeds[:, :10, :27].reshape(2, 10, 9, 3) + skeleton.MEAN, batch.directions[:, :10].numpy(), atol=1e-6
    )


def test_windows_stay_inside_talks_of_their_split():
    corpus = Corpus(toy_arrays(talks=4, frames=60))
    talks, first = corpus.random_windows(np.random.default_rng(0), 500, 48)
    assert set(talks) == {0, 1, 2} and set(first) == set(range(13))
    held, first = corpus.spread_windows(VALIDATION, 5, 48)
    assert set(held) == {3} and first.tolist() == [0, 3, 6, 9, 12]
    with pytest.raises(CorpusUnreadable, match="61 frames"):
        corpus.window_starts(TRAIN, 61)


def test_integer_directions_and_mirrored_windows():
    arrays = toy_arrays(talks=2, frames=60)
    real = arrays["directions"].astype(np.float32)
    arrays["directions"] = np.round(real * 127).astype(np.int8)
    corpus = Corpus(arrays)
    talks, first = np.array([0, 0]), np.array([0, 0])
    batch = corpus.batch(talks, first, 48, 10, flip=np.array([False, True]))
    np.testing.assert_allclose(batch.directions[0].numpy(), real[:48], atol=0.01)
    np.testing.assert_allclose(batch.directions[1].numpy(), skeleton.mirror(batch.directions[0].numpy()), atol=1e-6)


def test_augmentation_drops_whole_windows():
    corpus = Corpus(toy_arrays(talks=4, frames=60))
    talks, first = corpus.random_windows(np.random.default_rng(0), 400, 48)
    batch = corpus.batch(talks, first, 48, 10)
    torch.manual_seed(0)
    changed = augment(batch, TrainConfig(word_drop=0.25, seed_drop=0.5))
    silent = float((changed.words.abs().sum((1, 2)) == 0).float().mean())
    unseeded = float((changed.seeds[..., 27].sum(1) == 0).float().mean())
    assert silent == pytest.approx(0.25, abs=0.07) and unseeded == pytest.approx(0.5, abs=0.08)
    assert not changed.seeds[:, 10:].any() and not torch.equal(changed.mfcc, batch.mfcc)
    torch.testing.assert_close(changed.directions, batch.directions)


@pytest.mark.parametrize("name", ["starts", "word_index", "speaker"])
def test_arrays_that_do_not_fit_are_refused(tmp_path, name):
    arrays = toy_arrays(talks=2, frames=60)
    arrays[name] = arrays[name] + 100
    np.savez(tmp_path / "corpus.npz", **arrays)
    with pytest.raises(CorpusUnreadable, match="do not fit"):
        Corpus.load(tmp_path / "corpus.npz")


def test_other_files_are_no_corpus(tmp_path):
    (tmp_path / "text.npz").write_text("hello")
    for path in (tmp_path / "text.npz", tmp_path / "absent.npz"):
        with pytest.raises(CorpusUnreadable):
            Corpus.load(path)


def test_arm_speed_is_in_degrees_a_second():
    angle = torch.deg2rad(6.0 * torch.arange(5))
    directions = torch.zeros(1, 5, 9, 3)
    directions[..., 2] = 1
    directions[0, :, (4, 5, 7, 8)] = torch.stack([angle.cos(), angle.sin(), 0 * angle], -1)[:, None]
    torch.testing.assert_close(arm_speed(directions), torch.full((1, 4), 90.0), rtol=1e-4, atol=1e-3)


def test_correlation():
    a = torch.tensor([[1.0, 2.0, 3.0], [1.0, 2.0, 3.0]])
    assert correlation(a, 2 * a + 5) == pytest.approx(1)
    assert correlation(a, torch.tensor([[3.0, 2.0, 1.0], [4.0, 4.0, 4.0]])) == pytest.approx(-0.5)


def test_training_learns_to_follow_the_voice(settings, tmp_path, one_thread):
    figures = train(TrainConfig.from_dict({**settings, "steps": 60, "log_steps": 10, "validate_steps": 60}))
    lines = [json.loads(line) for line in (tmp_path / "run" / LOG).read_text().splitlines()]
    huber = [line["huber"] for line in lines if "huber" in line]
    assert huber[-1] < 0.5 * huber[0]
    assert figures["rhythm"] > figures["rhythm_shuffled"] + 0.3
    assert 0.5 < figures["speed_ratio"] < 1.5
    loaded = checkpoint.load(settings["out"] + "/" + CHECKPOINT)
    assert [speaker["name"] for speaker in loaded.speakers] == ["small", "large"]
    assert loaded.meta["training"]["steps"] == 60 and loaded.meta["training"]["validation"] == figures
    assert loaded.meta["features"] == {"mfcc": "toy", "fps": 15}


@pytest.mark.parametrize("model", ["default", "paper"])
def test_a_continued_run_equals_an_uninterrupted_one(settings, tmp_path, one_thread, model):
    if model == "paper":
        settings |= {"model_settings": {"mfcc_features": 40, "text_channels": 16, "gru_size": 16, "discriminator_size": 16}}
    settings["model"] = model
    train(TrainConfig.from_dict(settings))
    parted = {**settings, "out": str(tmp_path / "parted")}
    # The rate's course depends on all steps, so the first part stops early by its time and not by its steps.
    train(TrainConfig.from_dict({**parted, "minutes": 1e-6}))
    first = json.loads((tmp_path / "parted" / CHECKPOINT).with_suffix(".json").read_text())
    assert first["training"]["steps"] == 1
    train(TrainConfig.from_dict({**parted, "resume": True}))
    for name in (CHECKPOINT, STATE):
        whole, joined = (torch_tensors(f"{out}/{name}") for out in (settings["out"], parted["out"]))
        assert whole.keys() == joined.keys()
        assert all(torch.equal(whole[key], joined[key]) for key in whole)


def torch_tensors(path):
    from safetensors.torch import load_file

    return load_file(path)


def test_a_run_is_neither_overwritten_nor_conjured_up(settings):
    with pytest.raises(UsageError, match="nothing to resume"):
        train(TrainConfig.from_dict({**settings, "resume": True}))
    train(TrainConfig.from_dict({**settings, "steps": 1}))
    with pytest.raises(UsageError, match="already holds"):
        train(TrainConfig.from_dict(settings))
    with pytest.raises(CheckpointUnreadable, match="cannot be continued"):
        train(TrainConfig.from_dict({**settings, "resume": True, "model_settings": {**SMALL, "gru_size": 40}}))


def test_command_line(settings, tmp_path, capsys):
    (tmp_path / "train.json").write_text(json.dumps({**settings, "steps": 500}))
    assert main(["--config", str(tmp_path / "train.json"), "--steps", "1"]) == 0
    assert "validation_rhythm" in capsys.readouterr().out
    (tmp_path / "train.json").write_text('{"batchsize": 3}')
    for arguments, says in (
        (["--config", str(tmp_path / "train.json")], "batchsize"),
        (["--config", str(tmp_path / "none.json")], "none.json"),
        (["--data", str(tmp_path / "none.npz"), "--out", str(tmp_path / "b")], "not a packed corpus"),
        ([], "--data"),
    ):
        assert main(arguments) == 2
        output = capsys.readouterr().err
        assert says in output and "Traceback" not in output
    assert not (tmp_path / "b").exists()


@pytest.mark.parametrize(
    "change", [{"model": "published"}, {"seed_frames": 48}, {"batch": 0}, {"model_settings": {"words": 9}}]
)
def test_bad_settings_are_refused(settings, change):
    with pytest.raises(UsageError):
        train(TrainConfig.from_dict({**settings, **change}))
