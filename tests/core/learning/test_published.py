"""The paper's system by its name: made by one command, continued, found by its name, refused in a sentence before that."""

import json

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("librosa")

from s2ag.core import user_folders  # noqa: E402
from s2ag.core.cli.main import main  # noqa: E402
from s2ag.core.errors import CheckpointUnreadable, UsageError  # noqa: E402
from s2ag.core.learning.bench import published  # noqa: E402
from s2ag.core.model import checkpoint, checkpoint_metadata, loading  # noqa: E402
from s2ag.core.model.amplitude import gain_of  # noqa: E402
from s2ag.core.synthesis.session import Request, Session  # noqa: E402
from sounds import write_wav  # noqa: E402
from toy_bench import write_bench_corpus  # noqa: E402

TINY = published.SETTING.replace(
    share=0.05, steps=3, batch=8, filtered=False, validate_every=2, validation_windows=8, diversity_share=0.25
)


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    torch.set_num_threads(1)
    return write_bench_corpus(tmp_path_factory.mktemp("data") / "corpus")


@pytest.fixture
def home(tmp_path, monkeypatch):
    """The user's folder of data."""
    monkeypatch.setenv(user_folders.ENVIRONMENT_VARIABLE, str(tmp_path / "home"))
    return tmp_path / "home"


def test_sizes_are_the_published_ones(corpus, tmp_path):
    data = published.Data(corpus, tmp_path, filtered=False)
    system = published._build(data, "s2ag", published.SETTING)
    words, speakers = system.config.words, system.config.speakers
    count = sum(parameter.numel() for parameter in system.generator.parameters())
    assert count == 7_197_497 + 300 * words + 16 * speakers  # reference section A.7
    assert sum(parameter.numel() for parameter in system.judge.parameters()) == 313_068  # A.8


def test_a_name_performs_what_was_made_under_it(corpus, home, tmp_path, capsys):
    sound = tmp_path / "x.wav"
    write_wav(sound, np.random.default_rng(0).normal(0, 0.1, 16000 * 5))
    command = ["synth", str(sound), "--text", "one beautiful day", "--checkpoint", "published", "-o", str(tmp_path / "x.npz")]
    assert main(command) == 2
    assert "s2ag checkpoint train --data" in capsys.readouterr().err
    with pytest.raises(CheckpointUnreadable, match="have not been made") as refusal:
        checkpoint_metadata.describe("published")
    assert "s2ag checkpoint train --data" in refusal.value.remedy

    path = published.default_path("s2ag")
    facts = published.make(corpus, path, setting=TINY, say=lambda text: None)
    assert path == home / "published.safetensors" and facts["steps"] == 3 and facts["kind"] == "s2ag"
    loaded = loading.load("published")
    assert loaded.config.name == "published" and loaded.window == (34, 4)
    assert all(1 <= gain <= 1.4 for gain in gain_of(loaded.meta))
    stored = json.loads(path.with_suffix(".json").read_text())
    assert stored["training"]["validation"]["maje_code"] > 0
    assert stored["vocabulary"][4:] == ["one", "beautiful", "day", "of", "gestures"]

    assert main(command) == 0 and (tmp_path / "x.npz").is_file()
    names = [one["name"] for one in checkpoint_metadata.describe("published")["speakers"]]
    motions = [
        Session("published", cache="off").synthesize(Request(sound, text="one beautiful day", style=name)).motions[0]
        for name in names[:2]
    ]
    assert len(motions[0].directions) == 75 and np.isfinite(motions[0].directions).all()
    assert motions[0].meta["checkpoint"] == loaded.hash
    assert not np.allclose(motions[0].directions, motions[1].directions)


def test_a_stopped_training_goes_on(corpus, home):
    path = published.default_path("s2ag")
    steps = iter(range(2))
    facts = published.make(corpus, path, setting=TINY, stopping=lambda: next(steps, None) is None, say=lambda text: None)
    assert facts["steps"] == 2 and path.is_file()
    said = []
    assert published.make(corpus, path, setting=TINY, say=said.append)["steps"] == 3
    assert "1 of 3 steps to go" in said[0]
    assert published.make(corpus, path, setting=TINY.replace(steps=4), say=said.append)["steps"] == 4
    with pytest.raises(UsageError, match="other settings or data"):
        published.make(corpus, path, setting=TINY.replace(batch=4), say=said.append)


def test_weights_are_stored_in_half_of_the_bytes(corpus, home):
    path = published.default_path("s2ag-no-affect")
    published.make(corpus, path, "s2ag-no-affect", TINY.replace(steps=1), say=lambda text: None)
    stored = checkpoint.load("published-no-affect")
    count = sum(value.numel() for value in stored.generator.state_dict().values())
    assert path.stat().st_size < 2.2 * count + 20_000


def test_the_command_makes_them(corpus, home, monkeypatch, capsys):
    monkeypatch.setattr(published, "SETTING", TINY)
    assert main(["checkpoint", "train", "--data", str(corpus), "--steps", "1", "--batch", "8"]) == 0
    assert "--checkpoint published" in capsys.readouterr().out
    assert main(["checkpoint", "train", "--data", str(corpus), "--system", "gtc"]) == 2
    assert "s2ag-no-mfcc" in capsys.readouterr().err
    assert main(["styles", "--checkpoint", "published"]) == 0
    assert main(["styles", "--checkpoint", "default"]) == 0


def test_names_and_files(home, tmp_path, monkeypatch):
    shipped = checkpoint_metadata.DEFAULT_CHECKPOINT
    assert checkpoint_metadata.locate() == checkpoint_metadata.locate("") == checkpoint_metadata.locate("default") == shipped
    assert checkpoint_metadata.locate(tmp_path / "default") == shipped, "engines and manifests make names into paths"
    assert checkpoint_metadata.locate("default.safetensors").name == "default.safetensors"
    (tmp_path / "default").write_bytes(b"")
    assert checkpoint_metadata.locate(tmp_path / "default") == tmp_path / "default", "a file beside comes first"
    with pytest.raises(CheckpointUnreadable, match="There is no checkpoint"):
        checkpoint_metadata.describe("nobody")
