"""Where Blender's Python has no ``aud``, another Blender's mixer hears the recording."""

import sys
import time
from pathlib import Path

import bpy
import numpy as np
import pytest
from s2ag.core.errors import AudioUnreadable, Cancelled, WorkerFailed
from s2ag.core.sound import audio
from s2ag.s2ag_blender.engine import decoding, mixing

pytestmark = pytest.mark.skipif(not bpy.app.build_options.audaspace, reason="this Blender has no sound system at all")

START = Path(mixing.__file__).parents[2] / "core" / "start.py"
BLENDER = [sys.executable, "-P", str(START), "--", "s2ag_blender.engine.mixing"]
"""The module bpy, which has no program to be run as Blender."""


@pytest.fixture
def deaf(monkeypatch):
    """A Blender whose Python lacks ``aud``, as Debian built 4.3."""
    monkeypatch.setitem(sys.modules, "aud", None)
    monkeypatch.setattr(mixing, "command", lambda: BLENDER)


def test_it_hears_what_aud_hears(monkeypatch, request):
    path = str(Path(decoding.__file__).parents[2] / "core" / "assets" / "hello.mp3")
    said = audio.load(decoding.Decoding(path).outcome())
    decoding._kept.clear()
    request.getfixturevalue("deaf")
    assert decoding.needed(path)
    found = audio.load(decoding.Decoding(path).outcome())
    assert 0 <= len(found) - len(said) < 0.1 * audio.SAMPLE_RATE  # the mixer ends with a frame of the scene
    likeness = [np.corrcoef(found[shift : shift + len(said) - 4], said[: len(said) - 4])[0, 1] for shift in range(4)]
    assert max(likeness) > 0.98  # a sample of the recording's rate late, which is no whole one here


def test_what_is_no_recording_says_why(deaf, tmp_path):
    (tmp_path / "text.mp3").write_text("no sound")
    with pytest.raises(AudioUnreadable, match="text.mp3 is not a readable recording"):
        decoding.Decoding(str(tmp_path / "text.mp3")).outcome()
    assert not list(Path(bpy.app.tempdir).glob("s2ag-*/mixed.wav"))


def test_it_is_left_at_once_and_its_end_is_told(tmp_path):
    asleep = [sys.executable, "-c", "import time; time.sleep(60)"]
    begun = time.monotonic()
    with pytest.raises(Cancelled):
        mixing.mixed(asleep, tmp_path / "a.mp3", tmp_path / "a.wav", lambda: True)
    assert time.monotonic() - begun < 30
    with pytest.raises(WorkerFailed, match="ended with status 3"):
        mixing.mixed([sys.executable, "-c", "exit(3)"], tmp_path / "a.mp3", tmp_path / "a.wav", lambda: False)
    with pytest.raises(WorkerFailed, match="cannot be started"):
        mixing.mixed([str(tmp_path / "none")], tmp_path / "a.mp3", tmp_path / "a.wav", lambda: False)


def test_a_blender_without_a_program_mixes_nothing():
    assert mixing.command() == [] or bpy.app.binary_path in mixing.command()
