"""Blender as a module, with an empty file for every test; its home is set in the conftest above."""

import numpy as np
import pytest
from s2ag.core import skeleton
from s2ag.core.motion import Motion

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


@pytest.fixture(autouse=True)
def empty_file():
    """Every test starts from Blender's factory settings without any object."""
    bpy.ops.wm.read_factory_settings(use_empty=True)


@pytest.fixture(scope="session")
def wave():
    """A function from a number of frames to a motion: the average posture, its left forearm going up and down."""

    def make(frames: int = 16) -> Motion:
        directions = np.repeat(skeleton.MEAN_UNIT[None], frames, 0)
        directions[:, skeleton.EDGE_NAMES.index("left_forearm"), 1] += np.sin(np.linspace(0, 2 * np.pi, frames))
        return Motion(skeleton.normalize(directions).astype(np.float32), meta={"style": "test"})

    return make
