"""Training: runs that learn, stop, continue and share their work."""

import json
import math
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from s2ag.core.errors import CheckpointUnreadable, UsageError  # noqa: E402
from s2ag.core.learning.train.__main__ import main  # noqa: E402
from s2ag.core.learning.train.config import TrainConfig  # noqa: E402
from s2ag.core.learning.train.logbook import LOG, TABLE  # noqa: E402
from s2ag.core.learning.train.loop import CHECKPOINT, STATE, train  # noqa: E402
from s2ag.core.model import checkpoint  # noqa: E402
from s2ag.core.motion import hand_channels  # noqa: E402
from toy_corpus import PROSODY, write_toy_corpus  # noqa: E402

SMALL = {
    "gru_size": 32, "gru_layers": 1, "head_size": 32, "mfcc_channels": [16, 16, 16], "text_channels": 16,
    "prosody_features": PROSODY, "prosody_size": 8,
}  # fmt: skip
FLOW = {
    "model": "flow", "model_settings": {**SMALL, "flow_size": 48, "flow_condition": 32}, "velocity": 0.5, "divergence": 1e-3,
    "kept": {"start": 0.3, "end": 0.1, "both": 0.1, "gap": 0.2, "frames": 0.1}, "stroke_tell": 0.5, "style_drop": 0.2,
    "text_drop": 0.2, "clip": 1.0, "warm_up": 5, "weight_decay": 1e-3,
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


@pytest.mark.slow
def test_training_learns_to_follow_the_voice(settings, tmp_path, one_thread):
    figures = train(TrainConfig.from_dict({**settings, "steps": 60, "log_steps": 10, "validate_steps": 60}))
    lines = [json.loads(line) for line in (tmp_path / "run" / LOG).read_text().splitlines()]
    huber = [line["huber"] for line in lines if "huber" in line]
    assert huber[-1] < 0.5 * huber[0]
    assert figures["rhythm"] > figures["rhythm_shuffled"] + 0.3
    assert 0.5 < figures["speed_ratio"] < 1.5
    logged = {"windows_per_second", "frames_per_second", "outside", "generator_gradient", "discriminator_gradient"}
    assert (logged | {"judged_real", "judged_made", "right_real", "right_made"}) <= lines[0].keys()
    assert 0 <= lines[0]["outside"] < 1 and lines[0]["frames_per_second"] > 0
    loaded = checkpoint.load(settings["out"] + "/" + CHECKPOINT)
    assert [speaker["name"] for speaker in loaded.speakers] == ["small", "large"]
    assert loaded.meta["training"]["steps"] == 60 and loaded.meta["training"]["validation"] == figures
    assert loaded.meta["features"] == {"mfcc": "toy", "fps": 15, "prosody": "", "controls": ""}


@pytest.mark.parametrize("model", ["default", "paper", "flow"])
def test_a_continued_run_equals_an_uninterrupted_one(settings, tmp_path, one_thread, model):
    if model == "paper":
        settings |= {"model_settings": {"text_channels": 16, "gru_size": 16, "discriminator_size": 16}}
    if model == "flow":
        settings |= FLOW
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


@pytest.mark.slow
def test_a_flow_learns_to_follow_the_voice_and_who_performs(settings, tmp_path, one_thread):
    settings = {**settings, **FLOW, "steps": 120, "log_steps": 20, "validate_steps": 120, "arm_weight": 2.0}
    figures = train(TrainConfig.from_dict(settings))
    lines = [json.loads(line) for line in (tmp_path / "run" / LOG).read_text().splitlines()]
    errors = [line["flow"] for line in lines if "flow" in line]
    assert errors[-1] < 0.7 * errors[0]
    assert figures["rhythm"] > figures["rhythm_shuffled"] + 0.1
    loaded = checkpoint.load(settings["out"] + "/" + CHECKPOINT)
    assert loaded.config.decoder == "flow" and loaded.meta["meanings"] == ["a", "b"]
    assert loaded.config.meanings == 2 and float(loaded.generator.scale.min()) >= 0.049
    assert loaded.discriminator is None


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
    ("change", "says"),
    [
        ({"model": "published"}, "flow, default or paper"),
        ({"kept": {"middle": 0.5}}, "kept names"),
        ({"kept": {"start": 0.7, "gap": 0.5}}, "no sense"),
        ({"model": "flow", "model_settings": {**SMALL, "words": 5}}, "any length"),
        ({"seed_frames": 48}, "seed_frames"),
        ({"batch": 0}, "batch"),
        ({"device": "tpu"}, "cpu, cuda, mps"),
        ({"precision": "int4"}, "bf16-mixed"),
        ({"model_settings": {"words": 9}}, "word vectors"),
        ({"model_settings": {"prosody_features": PROSODY + 1}}, f'"prosody_features": {PROSODY}'),
        ({"model_settings": {**SMALL, "controls": 2}}, '"controls": 5'),
    ],
)
def test_bad_settings_are_refused(settings, tmp_path, change, says):
    with pytest.raises(UsageError, match=says):
        train(TrainConfig.from_dict({**settings, **change}))
    assert not (tmp_path / "run" / STATE).exists()


@pytest.mark.skipif(torch.cuda.is_available(), reason="there is a GPU")
def test_an_absent_device_is_named(settings):
    with pytest.raises(UsageError, match="no cuda device"):
        train(TrainConfig.from_dict({**settings, "device": "cuda"}))


def test_a_missing_fabric_is_named(settings, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "lightning_fabric", None)
    assert main(["--data", settings["data"], "--out", settings["out"]]) == 2
    assert "s2ag[train]" in capsys.readouterr().err


def test_all_switches_train_at_low_precision(settings, one_thread):
    switches = {"precision": "bf16-mixed", "wrist": 100.0, "arm_weight": 2.0, "mirror": 0.5, "discriminator_frames": 0}
    figures = train(TrainConfig.from_dict({**settings, **switches}))
    tensors = torch_tensors(f"{settings['out']}/{STATE}")
    assert all(value.isfinite().all() for value in tensors.values()) and math.isfinite(figures["huber"])
    assert {value.dtype for name, value in tensors.items() if name.startswith("generator")} == {torch.float32}
    assert tensors["generator/controls.weight"].shape == (16, 5)


def test_a_flow_trains_at_low_precision(settings, one_thread):
    figures = train(TrainConfig.from_dict({**settings, **FLOW, "precision": "bf16-mixed"}))
    tensors = torch_tensors(f"{settings['out']}/{STATE}")
    assert all(value.isfinite().all() for value in tensors.values()) and math.isfinite(figures["huber"])
    assert {value.dtype for name, value in tensors.items() if name.startswith("generator")} == {torch.float32}


def test_a_told_end_finishes_the_step_and_saves(settings):
    command = [sys.executable, "-m", "s2ag.core.learning.train", "--config", settings["out"] + ".json"]
    Path(command[-1]).write_text(json.dumps({**settings, "steps": 10**6, "log": "csv"}))
    run = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert run.stdout.readline().startswith("step 1")
    run.send_signal(signal.SIGTERM)
    said, _ = run.communicate(timeout=60)
    assert run.returncode == 0 and "everything is saved" in said
    facts = json.loads((Path(settings["out"]) / CHECKPOINT).with_suffix(".json").read_text())
    lines = [json.loads(line) for line in (Path(settings["out"]) / LOG).read_text().splitlines()]
    assert 0 < facts["training"]["steps"] == max(line["step"] for line in lines if "huber" in line) < 10**6
    assert "huber" in (Path(settings["out"]) / TABLE).read_text()


@pytest.mark.slow
def test_two_processes_share_their_work(settings, tmp_path):
    """Each learns from windows of its own, and both hold the same weights bit for bit."""
    script = Path(__file__).parents[2] / "helpers" / "every_rank.py"
    command = [sys.executable, "-m", "torch.distributed.run", "--standalone", "--nproc-per-node", "2", str(script)]
    run = subprocess.run([*command, json.dumps({**settings, "batch": 4})], capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    one, two = (torch_tensors(f"{settings['out']}/{rank}.safetensors") for rank in (0, 1))
    assert not torch.equal(one.pop("windows"), two.pop("windows"))
    assert one.keys() == two.keys() and all(torch.equal(one[name], two[name]) for name in one)
    lines = [json.loads(line) for line in (tmp_path / "run" / LOG).read_text().splitlines()]
    assert [line["step"] for line in lines if "huber" in line] == [1, 2, 3]
    assert all(np.isfinite(value).all() for line in lines for value in line.values())
    facts = checkpoint.load(settings["out"] + "/" + CHECKPOINT).meta["training"]
    assert (facts["steps"], facts["processes"]) == (3, 2)


@pytest.mark.parametrize("kind", [{}, FLOW], ids=["regressor", "flow"])
def test_poses_are_learned_of_a_corpus_with_hands(settings, kind, one_thread):
    with_hands(settings)
    train(TrainConfig.from_dict({**settings, **kind}))
    assert checkpoint.load(Path(settings["out"]) / CHECKPOINT).config.extras == 0


def test_hands_are_learned_on_arms_that_stay_as_they_are(settings, one_thread):
    with_hands(settings)
    train(TrainConfig.from_dict({**settings, **FLOW}))
    arms = Path(settings["out"]) / CHECKPOINT
    again = {**settings, **FLOW, "out": settings["out"] + "2", "start": str(arms), "learns": "extras"}
    train(TrainConfig.from_dict(again))
    before, after = (checkpoint.load(path).generator.state_dict() for path in (arms, Path(again["out"]) / CHECKPOINT))
    assert len(after["centre"]) == 27 + hand_channels.SIZE
    assert all(torch.equal(after[name][: len(value)] if value.dim() else after[name], value) for name, value in before.items())
    assert after["extras_denoiser.out.weight"].abs().max() > 0  # it began with zeros


def test_hands_need_arms_and_a_corpus_that_has_hands(settings, one_thread):
    with pytest.raises(UsageError, match="--start"):
        TrainConfig.from_dict({**settings, **FLOW, "learns": "extras"})
    train(TrainConfig.from_dict({**settings, **FLOW}))
    arms = str(Path(settings["out"]) / CHECKPOINT)
    with pytest.raises(UsageError, match="no hands"):
        train(TrainConfig.from_dict({**settings, **FLOW, "out": settings["out"] + "2", "start": arms, "learns": "extras"}))


def with_hands(settings):
    data = Path(settings["data"])
    frames = len(np.load(data / "directions.npy"))
    np.save(data / "extras.npy", np.random.default_rng(0).normal(size=(frames, hand_channels.SIZE)).astype(np.float16))


def test_a_training_may_start_from_a_checkpoint(settings, one_thread):
    train(TrainConfig.from_dict(settings))
    first = Path(settings["out"]) / CHECKPOINT
    again = {**settings, "out": settings["out"] + "2", "start": str(first), "steps": 1, "generator_rate": 0.0}
    train(TrainConfig.from_dict(again))
    mine, theirs = (checkpoint.load(path).generator.state_dict() for path in (first, Path(again["out"]) / CHECKPOINT))
    for name, value in mine.items():
        torch.testing.assert_close(theirs[name], value, rtol=2**-10, atol=1e-6)
