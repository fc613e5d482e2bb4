"""The network in numpy against the network in torch, its reader of weights, and who computes what."""

import json
import subprocess
import sys

import numpy as np
import pytest
from s2ag.core.errors import CheckpointUnreadable, UsageError
from s2ag.core.model import checkpoint_metadata, loading
from s2ag.core.model.config import ModelConfig
from s2ag.core.model.mfcc_timing import mfcc_slice
from s2ag.core.model.numpy_inference import weights
from s2ag.core.motion import rest, skeleton

CLOSE = 1e-3
"""Degrees."""


def angles(a, b):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(-1)))


def drawn(network, frames, walks=False, asked=False, kept=(0,)):
    """Directions and extras drawn from the same random inputs, as large as those of a recording."""
    config, rng = network.config, np.random.default_rng(frames)
    normal = lambda *shape: rng.standard_normal(shape).astype(np.float32)  # noqa: E731
    words = 0.06 * normal(frames, config.word_size) * (normal(frames, 1) > 0)
    seeds = np.zeros((frames, network.noise_size + 1), np.float32)
    seeds[list(kept), :27] = (rest.REST - skeleton.MEAN).ravel()
    seeds[list(kept), -1] = 1
    prosody = normal(frames, config.prosody_features) if config.prosody_features else None
    heard = network.hear(normal(mfcc_slice(0, frames).stop, config.mfcc_features), words, seeds, prosody)
    if asked:
        wishes = np.abs(normal(frames, 7))
        wishes[:, 0], wishes[:, 6] = frames // 2 < np.arange(frames), np.arange(frames) % (config.meanings + 1)
        heard = network.told(heard, wishes)
    style = normal(frames, config.style_size) if walks else normal(config.style_size)
    return network.draw(heard, style, seeds, normal(frames, network.noise_size))


def both(path):
    return [loading.load(path, backend).network for backend in loading.BACKENDS]


def saved(path, **changes):
    """A checkpoint of random weights, where torch is installed."""
    torch = pytest.importorskip("torch", reason="the engine is not installed")
    from s2ag.core.model import checkpoint
    from s2ag.core.model.config import ModelConfig
    from s2ag.core.model.flow import FlowGenerator

    torch.manual_seed(1)
    network = FlowGenerator(ModelConfig.flow(speakers=3, **{"flow_size": 32, "flow_condition": 24, **changes}))
    for name, parameter in network.named_parameters():
        if "denoiser" in name:
            torch.nn.init.normal_(parameter, std=0.1)
    facts = {"speakers": [{"name": name} for name in "abc"], "training": {"settings": {"frames": 64, "seed_frames": 10}}}
    checkpoint.save(path, network, None, facts)
    return path


@pytest.mark.parametrize(
    "way",
    [
        {"frames": 150},
        {"frames": 33, "kept": ()},
        {"frames": 97, "walks": True, "kept": (0, 40, 96)},
        {"frames": 130, "asked": True, "kept": range(20, 30)},
    ],
)
def test_the_shipped_network_in_numpy_is_that_in_torch(way):
    pytest.importorskip("torch", reason="the engine is not installed")
    (light, extras), (heavy, others) = (drawn(network, **way) for network in both(None))
    assert extras.dtype == np.float32 and np.abs(extras - others).max() < np.radians(CLOSE)
    assert light.dtype == np.float32 and light.shape == heavy.shape == (way["frames"], 9, 3)
    assert np.abs(np.linalg.norm(light, axis=-1) - 1).max() < 1e-5
    assert angles(light, heavy).max() < CLOSE


@pytest.mark.parametrize(
    "changes",
    [
        {"meanings": 4, "flow_noise": 0.8, "flow_style": 1.3, "flow_voice": 1.2},
        {
            "extras": 5,
            "flow_extras_noise": 0.7,
            "flow_extras_size": 40,
            "flow_patch": 3,
            "flow_kernel": 3,
            "flow_dilations": [1, 3],
        },
        {"prosody_features": 0, "controls": 0, "flow_voice": 1.5},
        {"text_causal": True, "text_channels": 300, "text_levels": 1, "time_kernel": 3, "graph": "chain"},
    ],
)
def test_every_setting_of_a_flow_is_followed(tmp_path, changes):
    path = saved(tmp_path / "flow.safetensors", **changes)
    networks = both(path)
    (light, extras), (heavy, others) = (drawn(network, 70, asked="meanings" in changes) for network in networks)
    assert extras.shape == others.shape == (70, changes.get("extras", 0))
    assert np.abs(extras - others).max(initial=0) < np.radians(CLOSE)
    assert angles(light, heavy).max() < CLOSE
    light, heavy = networks
    assert (light.velocity_reach, light.hears, light.noise_size) == (heavy.velocity_reach, heavy.hears, heavy.noise_size)
    for mine, theirs in zip((*light.speakers, light.ways), (*heavy.speakers, heavy.ways), strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=1e-5, atol=1e-6)


def test_a_performance_in_numpy_is_that_in_torch(flow_checkpoint, examples):
    pytest.importorskip("torch", reason="the engine is not installed")
    from s2ag.core.synthesis.session import Request, Session

    request = Request(examples / "hello.flac", takes=2, style="calm one > lively one", affect={"arousal": 0.5})
    one, other = (Session(flow_checkpoint, backend=backend).synthesize(request).motions for backend in loading.BACKENDS)
    for mine, theirs in zip(one, other, strict=True):
        np.testing.assert_allclose(mine.directions, theirs.directions, rtol=0, atol=2e-4)
        assert mine.meta == theirs.meta


def test_the_shipped_network_performs_without_torch(examples, tmp_path):
    code = "import sys; sys.modules.update(dict.fromkeys(('torch', 'safetensors', 'scipy', 'librosa')));"
    code += "from s2ag.core.cli.main import main; sys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-c", code, "synth", examples / "hello.flac", "--no-transcript", "-o", tmp_path / "a.npz"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with np.load(tmp_path / "a.npz") as motion:
        assert np.abs(np.linalg.norm(motion["directions"], axis=-1) - 1).max() < 1e-4


def test_weights_are_those_that_safetensors_reads():
    theirs = pytest.importorskip("safetensors.numpy").load_file(checkpoint_metadata.DEFAULT_CHECKPOINT)
    _, mine = weights.read(checkpoint_metadata.DEFAULT_CHECKPOINT)
    assert set(mine) == set(theirs)
    for name, array in theirs.items():
        assert mine[name].dtype == np.float32
        np.testing.assert_array_equal(mine[name], array.astype(np.float32))


def packed(header, body=b"\0" * 8):
    text = header if isinstance(header, bytes) else json.dumps(header).encode()
    return len(text).to_bytes(8, "little") + text + body


ENTRY = {"dtype": "F32", "shape": [2], "data_offsets": [0, 8]}


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\x05",
        packed({"a": ENTRY})[:20],
        (2**40).to_bytes(8, "little") + b"{}",
        packed(b"{" * 100_000),
        packed(b"\xff\xfe"),
        packed([1]),
        packed({"a": 1}),
        packed({"a": {**ENTRY, "dtype": "O"}}),
        packed({"a": {**ENTRY, "more": 1}}),
        packed({"a": {**ENTRY, "shape": [3]}}),
        packed({"a": {**ENTRY, "shape": [-1, -2]}}),
        packed({"a": {**ENTRY, "shape": [2.0]}}),
        packed({"a": {**ENTRY, "shape": "2"}}),
        packed({"a": {**ENTRY, "data_offsets": [8, 16]}}),
        packed({"a": {**ENTRY, "data_offsets": [0]}}),
        packed({"a": {**ENTRY, "data_offsets": None}}),
        packed({"a": ENTRY, "b": ENTRY}, bytes(16)),
        packed({"a": ENTRY, "b": {**ENTRY, "data_offsets": [4, 12]}}, bytes(16)),
    ],
)
def test_damaged_weights_are_refused(tmp_path, data):
    path = tmp_path / "a.safetensors"
    path.write_bytes(data)
    with pytest.raises(ValueError):
        weights.read(path)


def test_what_weights_hold_is_read(tmp_path):
    path = tmp_path / "a.safetensors"
    path.write_bytes(packed({"__metadata__": {"by": "us"}, "a": ENTRY}, np.float32([1, 2]).tobytes()))
    data, arrays = weights.read(path)
    assert data == path.read_bytes() and list(arrays) == ["a"] and arrays["a"].tolist() == [1, 2]


def test_who_computes_what(flow_checkpoint, random_checkpoint):
    from s2ag.core.model.numpy_inference.network import NumpyNetwork
    from s2ag.core.model.torch_inference import TorchNetwork

    assert isinstance(loading.load(flow_checkpoint).network, NumpyNetwork)
    assert isinstance(loading.load(flow_checkpoint, "torch").network, TorchNetwork)
    assert isinstance(loading.load(random_checkpoint).network, TorchNetwork)
    for asked, says in (
        ((random_checkpoint, "numpy"), "numpy cannot compute"),
        ((flow_checkpoint, "abacus"), "no backend"),
        ((flow_checkpoint, "numpy", "cuda"), "numpy does not compute on"),
        ((flow_checkpoint, None, "nowhere"), "torch cannot compute on"),
    ):
        with pytest.raises(UsageError, match=says):
            loading.load(*asked)


def change(path, **facts):
    beside = path.with_suffix(".json")
    beside.write_text(json.dumps({**json.loads(beside.read_text()), **facts}))


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (lambda path: path.unlink(), "no checkpoint"),
        (lambda path: path.write_bytes(path.read_bytes()[:1000]), "cannot be read"),
        (lambda path: path.write_bytes(path.read_bytes()[:-2] + b"ab"), "other weights"),
        (lambda path: change(path, config={"decoder": "flow", "magic": 1}), "magic"),
        (lambda path: change(path, config={"decoder": "flow", "seed_view": 0}), "does not fit"),
        (lambda path: change(path, config=[1]), "does not fit|no such"),
        (lambda path: change(path, speakers=[1]), "does not fit"),
    ],
)
@pytest.mark.parametrize("backend", loading.BACKENDS)
def test_damaged_checkpoints_are_told(tmp_path, damage, says, backend):
    path = saved(tmp_path / "flow.safetensors")
    damage(path)
    with pytest.raises(CheckpointUnreadable, match=says) as caught:
        loading.load(path, backend)
    assert caught.value.remedy


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1e30, 1e306])
def test_factors_that_mean_nothing_are_refused(value):
    with pytest.raises(UsageError, match="flow_voice"):
        ModelConfig.from_dict({"decoder": "flow", "flow_voice": value})
