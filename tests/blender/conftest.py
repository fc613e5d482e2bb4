"""Blender as a module, with an empty file for every test; its home is set in the conftest above."""

import pytest

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
