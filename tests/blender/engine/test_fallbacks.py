"""Where Blender has no sound system, or may start no other program, it says so and what to do, in the user's words."""

import importlib.util
import shutil
import sys

import bpy
import numpy as np
import pytest
import s2ag
from s2ag.core.errors import AudioUnreadable
from s2ag.s2ag_blender.engine import client, decoding
from s2ag.s2ag_blender.takes import engine_requests, session
from sounds import write_wav


@pytest.fixture
def tone(tmp_path):
    path = tmp_path / "tone.wav"
    write_wav(path, 0.3 * np.sin(np.arange(48000) / 20))
    return str(path)


@pytest.fixture
def voiceless(monkeypatch):
    """A Blender without ``aud``, as Debian builds it, and a Python without ``av``."""
    found = importlib.util.find_spec
    monkeypatch.setitem(sys.modules, "aud", None)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *rest: None if name == "av" else found(name, *rest))


def test_a_blender_without_sound_reads_wav_and_says_that_it_reads_nothing_else(voiceless, tone, tmp_path):
    assert not decoding.needs_decoding(tone)
    shutil.copy(decoding.__file__, tmp_path / "voice.mp3")
    with pytest.raises(AudioUnreadable, match="no sound system") as caught:
        decoding.needs_decoding(str(tmp_path / "voice.mp3"))
    assert "to WAV" in caught.value.remedy and "pip" not in str(caught.value)


def test_the_panel_says_that_the_engine_runs_inside_blender(tone, tmp_path, monkeypatch):
    monkeypatch.delenv("S2AG_PYTHON", raising=False)
    monkeypatch.setattr(client.sys, "executable", str(tmp_path / "python3"))
    engine_requests.stop_engine()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    s2ag.register()
    try:
        bpy.ops.s2ag.add_mannequin()
        figure = bpy.context.active_object
        figure.s2ag.audio = tone
        assert bpy.ops.s2ag.generate() == {"FINISHED"}
        assert not session.messages(figure)
        assert "the engine runs inside Blender" in figure.s2ag.takes[0].warnings
    finally:
        engine_requests.stop_engine()
        s2ag.unregister()
