"""What the command line says where something ends it, or where others' files hold what no terminal should show."""

import os
import subprocess
import sys
import warnings

import pytest
from refusals import one_sentence
from s2ag.core import errors
from s2ag.core.cli import animate
from s2ag.core.cli.main import FAILED, INTERRUPTED, main

INTERRUPTED_AT = """
import importlib.abc, os, signal, sys

class Interrupt(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name == at:
            sys.meta_path.remove(self)
            signal.raise_signal(signal.SIGINT)

at = sys.argv.pop(1)
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.modules.pop(at, None)
sys.meta_path.insert(0, Interrupt())
from s2ag.core.cli.main import main
status = main()
assert at in sys.modules or status == 130, "never imported"
sys.exit(status)
"""


@pytest.mark.parametrize(
    "module", ["argparse", *(f"s2ag.core.{name}" for name in ("errors", "cli.batch", "synthesis.session", "sound.audio"))]
)
def test_ctrl_c_during_imports_is_one_line(module, examples, tmp_path):
    command = ["synth", str(examples / "hello.flac"), "-o", str(tmp_path / "a.npz")]
    done = subprocess.run([sys.executable, "-c", INTERRUPTED_AT, module, *command], capture_output=True, text=True)
    told = [line for line in done.stderr.splitlines() if not line.startswith("s2ag: note: ")]
    assert (done.returncode, told) == (INTERRUPTED, ["s2ag: interrupted."])
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["k" * 2_000_000, "k " * 1_000_000, "\x1b[2J\x1b]0;title\x07", "one\ntwo", "\u202egnp"])
def test_what_a_message_quotes_is_short_and_shows_as_it_is(name):
    error = errors.UsageError(f"There is no key {name}.", f"Leave out {name}.")
    for text in (error.message, error.remedy, str(error)):
        assert len(text) < 3000 and text.isprintable()
    assert error.message.startswith("There is no key") and error.message.endswith(".")


def test_a_manifest_with_a_key_of_two_megabytes(tmp_path, capsys):
    (tmp_path / "talks.jsonl").write_text(f'{{"audio": "a.wav", "{"k" * 2_000_000}": 1}}\n', "utf-8")
    assert main(["batch", "plan", str(tmp_path / "talks.jsonl"), "-o", str(tmp_path / "out")]) == FAILED
    assert len(capsys.readouterr().err) < 5000


def test_warnings_of_packages_do_not_reach_the_terminal(tmp_path):
    code = "import warnings, sys\nfrom s2ag.core.cli import main, styles\n"
    code += "styles.run = lambda options: print(warnings.warn('overflow encountered', RuntimeWarning))\nsys.exit(main.main())"
    run = [sys.executable, "-c", code, "styles"]
    quiet = {name: value for name, value in os.environ.items() if name != "S2AG_DEBUG"}
    assert subprocess.run(run, capture_output=True, text=True, env=quiet).stderr == ""
    told = subprocess.run(run, capture_output=True, text=True, env={**quiet, "S2AG_DEBUG": "1"}).stderr
    assert "overflow encountered" in told


def test_a_mistake_of_ours_is_one_sentence_with_a_log(tmp_path, monkeypatch, capsys):
    monkeypatch.delenv("S2AG_DEBUG", raising=False)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr(animate, "run", lambda options: {}["k" * 5000])
    assert main(["animate", "a.wav", "-o", "b.mp4"]) == FAILED
    sentence = one_sentence(capsys.readouterr().err)
    (log,) = tmp_path.iterdir()
    assert "this is a mistake in s2ag (KeyError" in sentence and sentence.endswith(f"with the log {log}.")
    held = log.read_text("utf-8")
    assert "Traceback" in held and "in <lambda>" in held and "numpy" in held


def test_without_room_for_a_log_the_sentence_stays(tmp_path, monkeypatch, capsys):
    monkeypatch.delenv("S2AG_DEBUG", raising=False)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "none"))
    monkeypatch.setattr(animate, "run", lambda options: {}["k"])
    assert main(["animate", "a.wav", "-o", "b.mp4"]) == FAILED
    assert "its log could not be written" in one_sentence(capsys.readouterr().err)


def test_no_memory_is_one_sentence(monkeypatch, capsys):
    def run(options):
        raise MemoryError

    monkeypatch.setattr(animate, "run", run)
    assert main(["animate", "a.wav", "-o", "b.mp4"]) == FAILED
    assert "memory" in one_sentence(capsys.readouterr().err)


def test_warnings_stay_as_they_were_for_programs_that_call_main():
    before = list(warnings.filters)
    assert main(["styles", "--help"]) == 0
    assert warnings.filters == before
