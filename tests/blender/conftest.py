"""Blender as a module, with an empty file for every test; its home is set in the conftest above."""

import atexit
import os
import sys

import numpy as np
import pytest
from s2ag.core.motion import skeleton
from s2ag.core.motion.motion import Motion

try:
    import bpy
except ImportError as error:
    bpy, MISSING = None, f"bpy cannot be imported here: {error}"


class Skipped(pytest.Module):
    """A test file that cannot even be imported without Blender."""

    def collect(self):
        pytest.skip(MISSING, allow_module_level=True)


def pytest_pycollect_makemodule(module_path, parent):
    """Skip what stands in this folder, with the reason, where there is no Blender."""
    return Skipped.from_parent(parent, path=module_path) if bpy is None else None


_STATUS = []


def pytest_sessionfinish(session, exitstatus):
    """Note how the tests went."""
    _STATUS.append(int(exitstatus))


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config):
    """Leave without Python's own end: the 4.2 wheel crashes there once any property had an update, get or set function."""
    if bpy is not None and bpy.app.version < (4, 5) and _STATUS:
        atexit._run_exitfuncs()
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(_STATUS[0])


@pytest.fixture(autouse=True)
def empty_file():
    """Every test starts from Blender's factory settings without any object."""
    bpy.ops.wm.read_factory_settings(use_empty=True)


@pytest.fixture(scope="module")
def extension():
    """The extension registered for a whole test file, so that its engine stays warm."""
    import s2ag

    s2ag.register()
    yield
    s2ag.unregister()


@pytest.fixture(scope="session")
def engine():
    """A Python that can run the engine, beside a checkpoint to run."""
    from s2ag.core.errors import WorkerFailed
    from s2ag.s2ag_blender.engine import client

    try:
        return client.find_interpreter()
    except WorkerFailed as error:
        pytest.skip(str(error))


@pytest.fixture(scope="session")
def rigify_saved(tmp_path_factory):
    """Files with Rigify's metarig and control rig, made by this Blender."""
    import rigify_files

    return rigify_files.build(tmp_path_factory.mktemp("rigify"))


@pytest.fixture
def figure(extension):
    """A mannequin, active and selected."""
    assert bpy.ops.s2ag.add_mannequin() == {"FINISHED"}
    return bpy.context.active_object


@pytest.fixture(scope="session")
def voice(tmp_path_factory):
    """Three seconds that sound like somebody who speaks, as a WAV; every Blender and engine reads it."""
    from sounds import RATE, write_wav

    time = np.arange(3 * RATE) / RATE
    syllables = np.clip(np.sin(2 * np.pi * 3 * time), 0, 1) * (0.6 + 0.4 * np.sin(2 * np.pi * 0.7 * time))
    buzz = sum(np.sin(2 * np.pi * 140 * harmonic * time) / harmonic for harmonic in range(1, 12))
    path = tmp_path_factory.mktemp("voice") / "voice.wav"
    write_wav(path, 0.3 * syllables * buzz)
    return path


@pytest.fixture
def speaker(figure, engine, voice):
    """A mannequin with a recording, ready for the button."""
    figure.s2ag.audio = str(voice)
    return figure


@pytest.fixture
def sound_system(tmp_path):
    """Skips where this Blender was built without sound."""
    try:
        import aud  # noqa: F401
    except ImportError as error:
        pytest.skip(f"this Blender was built without sound: {error}")


@pytest.fixture(scope="session")
def wave():
    """A function from a number of frames to a motion: the average posture, its left forearm going up and down."""

    def make(frames: int = 16) -> Motion:
        directions = np.repeat(skeleton.MEAN_UNIT[None], frames, 0)
        directions[:, skeleton.EDGE_NAMES.index("left_forearm"), 1] += np.sin(np.linspace(0, 2 * np.pi, frames))
        return Motion(skeleton.normalize(directions).astype(np.float32), meta={"style": "test"})

    return make
