import json
import os
import shutil
import signal
import tempfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")  # as core.threads does in the worker and on the command line

# Word times are kept in a folder of this run, so that tests neither see nor leave anything in the user's.
_CACHE = tempfile.TemporaryDirectory(prefix="s2ag-cache-")
os.environ["S2AG_CACHE"] = _CACHE.name

# numba's cache breaks where two processes write it at once (librosa's functions then crash), so each of a run's has its own.
_COMPILED = tempfile.TemporaryDirectory(prefix="s2ag-numba-")
os.environ["NUMBA_CACHE_DIR"] = _COMPILED.name

# Blender gets an empty home of its own before anything imports bpy: packages of an extension that is installed on this
# machine would shadow the environment's.
_BLENDER_HOME = tempfile.TemporaryDirectory(prefix="s2ag-blender-")
os.environ["BLENDER_USER_RESOURCES"] = _BLENDER_HOME.name
os.environ["BLENDER_USER_EXTENSIONS"] = os.path.join(_BLENDER_HOME.name, "extensions")


@pytest.fixture
def interruptible():
    """Ctrl-C as on a terminal: a shell's background jobs, such as a test run, are started with it ignored."""
    former = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, former)


@pytest.fixture(scope="session")
def examples():
    """The recordings that the repository ships."""
    return ROOT / "examples"


@pytest.fixture(scope="session")
def shared():
    """Public material beside the project; tests that use it skip where it is absent."""
    folder = ROOT.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip("the material folder beside the project is absent")
    return folder


@pytest.fixture(scope="session")
def random_checkpoint(tmp_path_factory):
    """A network with random weights and two speakers: what it makes is worthless, how it is made is not."""
    return save_random_network(tmp_path_factory.mktemp("checkpoint") / "random.safetensors")


@pytest.fixture(scope="session")
def deaf(tmp_path_factory):
    """The shipped weights, as if they did not say that their controls follow the voice."""
    from s2ag.core.model.checkpoint_metadata import DEFAULT_CHECKPOINT

    path = tmp_path_factory.mktemp("deaf") / "deaf.safetensors"
    shutil.copy(DEFAULT_CHECKPOINT, path)
    facts = json.loads(DEFAULT_CHECKPOINT.with_suffix(".json").read_text("utf-8"))
    assert facts.pop("affect") == "heard"
    path.with_suffix(".json").write_text(json.dumps(facts), "utf-8")
    return path


@pytest.fixture(scope="session")
def plain_checkpoint(tmp_path_factory):
    """The same without controls and prosody, as the first checkpoint was."""
    path = tmp_path_factory.mktemp("plain") / "plain.safetensors"
    return save_random_network(path, controls=0, prosody_features=0)


def save_random_network(path, **changes):
    """Save a network of random weights to ``path`` and return the path."""
    torch = pytest.importorskip("torch", reason="the engine is not installed")
    from s2ag.core.model import checkpoint
    from s2ag.core.model.config import ModelConfig
    from s2ag.core.model.generator import Generator

    torch.manual_seed(0)
    network = Generator(ModelConfig.default(speakers=2, **changes))
    checkpoint.save(path, network, None, _facts())
    return path


def _facts():
    """Two speakers and the windows of a training that never was."""
    speakers = [{"name": "calm one", "description": "small"}, {"name": "lively one", "description": "wide"}]
    return {"speakers": speakers, "training": {"settings": {"frames": 64, "seed_frames": 10}}}


@pytest.fixture(scope="session")
def flow_checkpoint(tmp_path_factory):
    """A small network that draws from noise, of random weights, which can be asked for four kinds of strokes."""
    torch = pytest.importorskip("torch", reason="the engine is not installed")
    from s2ag.core.model import checkpoint
    from s2ag.core.model.config import ModelConfig
    from s2ag.core.model.flow import FlowGenerator

    torch.manual_seed(0)
    network = FlowGenerator(ModelConfig.flow(speakers=2, meanings=4, flow_size=48, flow_condition=32))
    for parameter in network.denoiser.parameters():  # some begin at zero, and nothing would be drawn
        torch.nn.init.normal_(parameter, std=0.1)
    path = tmp_path_factory.mktemp("flow") / "flow.safetensors"
    meta = {**_facts(), "meanings": ["beat", "me", "there", "big"]}
    checkpoint.save(path, network, None, meta)
    return path
