"""Blender as a module, in its own empty home, with an empty file for every test."""

import os
import tempfile

import pytest

# Set before the first import of bpy: packages of an extension installed on this machine would shadow the environment's.
_HOME = tempfile.TemporaryDirectory(prefix="s2ag-blender-")
os.environ["BLENDER_USER_RESOURCES"] = _HOME.name
os.environ["BLENDER_USER_EXTENSIONS"] = os.path.join(_HOME.name, "extensions")

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
