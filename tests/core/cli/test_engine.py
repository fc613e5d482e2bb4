"""``s2ag engine check``: what it says of a Python that works and of what is none."""

import sys

import pytest
from s2ag.core.cli.main import main


def test_a_python_that_works(capsys):
    pytest.importorskip("torch", reason="a full engine has PyTorch")
    assert main(["engine", "check", sys.executable]) == 0
    said = capsys.readouterr().err
    assert "the engine works" in said and "torch" in said and said.count("\n") == 1


@pytest.mark.parametrize(("python", "sentence"), [(".", "There is no Python in"), ("nowhere", "nowhere cannot be run")])
def test_what_is_no_python_is_one_sentence(capsys, tmp_path, monkeypatch, python, sentence):
    monkeypatch.chdir(tmp_path)
    assert main(["engine", "check", python]) == 2
    said = capsys.readouterr().err
    assert sentence in said and said.count("\n") == 1
