"""Checkpoints: what is saved comes back, and damage is reported in words."""

import hashlib
import json

import pytest

torch = pytest.importorskip("torch")

from s2ag.core.errors import CheckpointUnreadable, OutputUnwritable  # noqa: E402
from s2ag.core.model import checkpoint  # noqa: E402
from s2ag.core.model.config import ModelConfig  # noqa: E402
from s2ag.core.model.discriminator import Discriminator  # noqa: E402
from s2ag.core.model.generator import Generator  # noqa: E402

SPEAKERS = [{"name": "calm", "description": "slow and low"}, {"name": "eager", "description": "fast and high"}]


@pytest.fixture
def saved(tmp_path):
    config = ModelConfig.default(2, gru_size=24, head_size=16)
    generator, discriminator = Generator(config), Discriminator(config)
    path = tmp_path / "weights.safetensors"
    checkpoint.save(path, generator, discriminator, {"speakers": SPEAKERS, "note": "toy"}, half=False)
    return path, generator, discriminator


def test_round_trip_is_exact(saved):
    path, generator, discriminator = saved
    loaded = checkpoint.load(path)
    assert loaded.config == generator.config and loaded.speakers == SPEAKERS and loaded.meta["note"] == "toy"
    assert loaded.hash == hashlib.sha256(path.read_bytes()).hexdigest()
    assert not loaded.generator.training
    for ours, theirs in ((generator, loaded.generator), (discriminator, loaded.discriminator)):
        for name, value in ours.state_dict().items():
            assert torch.equal(value, theirs.state_dict()[name]), name


def test_half_precision_is_small_and_close(tmp_path):
    generator = Generator(ModelConfig.default())
    path = tmp_path / "half.safetensors"
    checkpoint.save(path, generator, None, {})
    assert path.stat().st_size < 5_000_000
    loaded = checkpoint.load(path)
    assert loaded.discriminator is None and loaded.speakers == []
    for name, value in generator.state_dict().items():
        stored = loaded.generator.state_dict()[name]
        assert stored.dtype == torch.float32
        # to eleven bits, and then to eight; below 2^-14 float16 has ever fewer
        torch.testing.assert_close(stored, value, rtol=2**-8 + 2**-11, atol=2**-22 + 2**-25)


def test_same_weights_have_the_same_hash(saved, tmp_path):
    path, generator, discriminator = saved
    again = checkpoint.save(tmp_path / "again.safetensors", generator, discriminator, {}, half=False)
    assert again == checkpoint.load(path).hash


def _rewrite(path, change):
    facts = json.loads(path.read_text())
    change(facts)
    path.write_text(json.dumps(facts))


def break_weights(path):
    path.write_bytes(path.read_bytes()[:1000])


def break_facts(path):
    path.with_suffix(".json").write_text("{")


def make_text(path):
    path.write_text("not a checkpoint")
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    _rewrite(path.with_suffix(".json"), lambda facts: facts.update(weights_sha256=digest))


def settings(**changes):
    return lambda path: _rewrite(path.with_suffix(".json"), lambda facts: facts["config"].update(changes))


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (lambda path: path.unlink(), "no checkpoint"),
        (lambda path: path.with_suffix(".json").unlink(), "missing or no JSON"),
        (break_facts, "missing or no JSON"),
        (break_weights, "cannot be read"),
        (make_text, "cannot be read"),
        (lambda path: _rewrite(path.with_suffix(".json"), lambda facts: facts.update(weights_sha256="0")), "other weights"),
        (lambda path: _rewrite(path.with_suffix(".json"), lambda facts: facts.update(format=99)), "format"),
        (lambda path: _rewrite(path.with_suffix(".json"), lambda facts: facts["config"].update(gru_size=25)), "does not fit"),
        (lambda path: _rewrite(path.with_suffix(".json"), lambda facts: facts["config"].update(magic=1)), "magic"),
        (settings(gru_size=10**6), "shapes"),
        (settings(gru_size=10**9), "out of range"),
        (settings(gru_layers=10**6), "0 to 64"),
    ],
)
def test_damage_is_reported(saved, damage, says):
    path = saved[0]
    damage(path)
    with pytest.raises(CheckpointUnreadable, match=says) as caught:
        checkpoint.load(path)
    assert caught.value.remedy


def test_unwritable_folder_leaves_nothing(saved, tmp_path):
    with pytest.raises(OutputUnwritable):
        checkpoint.save(tmp_path / "absent" / "weights.safetensors", saved[1], None, {})
    assert sorted(p.name for p in tmp_path.iterdir()) == ["weights.json", "weights.safetensors"]
