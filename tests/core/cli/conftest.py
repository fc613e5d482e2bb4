import shutil
from pathlib import Path

import pytest
from refusals import one_sentence
from s2ag.core.cli.main import main


@pytest.fixture(autouse=True)
def show_mistakes(monkeypatch):
    """Mistakes of ours fail the test with their traceback instead of looking like a refused input."""
    monkeypatch.setenv("S2AG_DEBUG", "1")


@pytest.fixture
def voice(examples, tmp_path):
    """A copy of the shipped recording without a transcript beside it."""
    return Path(shutil.copy(examples / "hello.flac", tmp_path / "voice.flac"))


@pytest.fixture
def out(tmp_path):
    """An empty folder for outputs."""
    folder = tmp_path / "out"
    folder.mkdir()
    return folder


@pytest.fixture
def refuse(capsys):
    """Runs a command line that must fail as the rules say; returns its sentence."""

    def run(*arguments):
        assert main([str(argument) for argument in arguments]) == 2
        told = capsys.readouterr()
        return one_sentence(told.err, told.out)

    return run
