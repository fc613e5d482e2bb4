"""Training: losses against hand-computed values, windows against the corpus, and runs that learn, stop and continue."""

import json
import math
import shutil

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from s2ag.core import checkpoint, skeleton  # noqa: E402
from s2ag.core.errors import CheckpointUnreadable, CorpusUnreadable, OutputUnwritable, UsageError  # noqa: E402
from s2ag.core.model.seeds import seed_input  # noqa: E402
from s2ag.core.model.timing import nearest_mfcc  # noqa: E402
from s2ag.core.train import losses  # noqa: E402
from s2ag.core.train.__main__ import main  # noqa: E402
from s2ag.core.train.config import TrainConfig  # noqa: E402
from s2ag.core.train.dataset import TRAIN, VALIDATION, Corpus, Windows, disturb, draw  # noqa: E402
from s2ag.core.train.loop import CHECKPOINT, LOG, STATE, train  # noqa: E402
from s2ag.core.train.storage import save_arrays  # noqa: E402
from s2ag.core.train.validation import arm_speed, correlation  # noqa: E402
from toy_corpus import META, PROSODY, toy_arrays, write_toy_corpus  # noqa: E402

SMALL = {
    "gru_size": 32, "gru_layers": 1, "head_size": 32, "mfcc_channels": [16, 16, 16], "text_channels": 16,
    "prosody_features": PROSODY, "prosody_size": 8,
}  # fmt: skip


@pytest.fixture
def one_thread():
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


@pytest.fixture
def settings(tmp_path):
    data = write_toy_corpus(tmp_path / "corpus")
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
        np.testing.assert_array_equal(batch.controls[row].numpy(), arrays["controls"][talk])
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


def test_a_mirrored_window_is_gestured_with_the_other_hand():
    arrays = toy_arrays(talks=2, frames=60)
    arrays["controls"][0] = (0.1, 0.2, 0.3, 0.4, 0.5)
    corpus = Corpus(arrays, META)
    windows = Windows(np.array([0, 0]), np.array([5, 5]), flip=np.array([False, True]))
    batch = corpus.batch(windows, 48, 10)
    np.testing.assert_allclose(batch.directions[1].numpy(), skeleton.mirror(batch.directions[0].numpy()), atol=1e-6)
    np.testing.assert_allclose(batch.seeds[1, :10, :27], seed_input(batch.directions[1:], 48)[0, :10, :27])
    torch.testing.assert_close(batch.controls[0], torch.tensor([0.1, 0.2, 0.3, 0.4, 0.5]))
    torch.testing.assert_close(batch.controls[1], torch.tensor([0.1, 0.2, 0.3, 0.4, -0.5]))
    assert arrays["controls"][0, 4] == np.float32(0.5)


def test_windows_without_words_have_the_prosody_of_sound_alone():
    arrays, corpus = toy(talks=2, frames=60)
    windows = Windows(np.array([0, 1]), np.array([3, 3]), wordless=np.array([False, True]), seedless=np.array([True, False]))
    batch = corpus.batch(windows, 40, 10)
    assert batch.words[0].any() and not batch.words[1].any()
    np.testing.assert_array_equal(batch.prosody[0].numpy(), arrays["prosody"][3:43].astype(np.float32))
    np.testing.assert_array_equal(batch.prosody[1].numpy(), arrays["prosody_plain"][3:43].astype(np.float32))
    assert not batch.seeds[0].any() and batch.seeds[1].any()


def test_chances_decide_over_whole_windows():
    _, corpus = toy(talks=4, frames=60)
    config = TrainConfig(batch=2000, frames=48, word_drop=0.25, seed_drop=0.5)
    windows = draw(corpus, config, np.random.default_rng(0))
    assert windows.wordless.mean() == pytest.approx(0.25, abs=0.05) and windows.seedless.mean() == pytest.approx(0.5, abs=0.05)
    assert not windows.flip.any()
    assert draw(corpus, TrainConfig(batch=50, frames=48, mirror=1.0), np.random.default_rng(0)).flip.all()


def test_noise_leaves_performances_and_empty_seeds_alone():
    _, corpus = toy(talks=4, frames=60)
    batch = corpus.batch(Windows(np.array([0, 1]), np.array([0, 4])), 48, 10)
    torch.manual_seed(0)
    changed = disturb(batch, TrainConfig())
    assert not torch.equal(changed.mfcc, batch.mfcc) and not torch.equal(changed.seeds, batch.seeds)
    assert torch.equal(changed.seeds[..., 27], batch.seeds[..., 27]) and not changed.seeds[:, 10:].any()
    assert torch.equal(changed.directions, batch.directions) and torch.equal(changed.words, batch.words)


@pytest.mark.parametrize("name", ["starts", "word_index", "speaker", "recording", "frame_starts"])
def test_arrays_that_do_not_fit_are_refused(tmp_path, name):
    arrays = toy_arrays(talks=2, frames=60)
    arrays[name] = arrays[name] + 100
    save_arrays(tmp_path / "corpus", arrays, META)
    with pytest.raises(CorpusUnreadable, match="do not fit"):
        Corpus.load(tmp_path / "corpus")


def cut_short(folder):
    path = folder / "directions.npy"
    path.write_bytes(path.read_bytes()[:-500])


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (lambda folder: shutil.rmtree(folder), "No such file"),
        (lambda folder: (folder / "prosody.npy").unlink(), "prosody.npy is missing"),
        (lambda folder: (folder / "mfcc.npy").write_text("hello"), "not a packed corpus"),
        (lambda folder: (folder / "speaker.npy").write_bytes(b""), "not a packed corpus"),
        (lambda folder: (folder / "meta.json").write_text("{"), "not a packed corpus"),
        (lambda folder: (folder / "meta.json").write_text(json.dumps({**META, "format": 1})), "format 2"),
        (lambda folder: (folder / "meta.json").write_text(json.dumps({**META, "fps": 30})), "30 fps"),
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
    assert "s2ag.core.corpus" in caught.value.remedy


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
    assert loaded.meta["features"] == {"mfcc": "toy", "fps": 15, "prosody": "", "controls": ""}


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
