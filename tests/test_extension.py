"""The tree as a Blender extension: Blender's own validator and builder, and the built zip at work."""

import importlib.util
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def blender_ext():
    """Blender's extension tool, run with plain Python."""
    spec = importlib.util.find_spec("bpy")
    if spec is None:
        pytest.skip("the package bpy, which brings Blender's extension tool, is not installed")
    # The wheel may be a package folder or one whose top module lies in a version folder.
    folders = {Path(place) for place in spec.submodule_search_locations or []} | set(Path(spec.origin).parents)
    found = [path for folder in folders for path in folder.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py")]
    if not found:
        pytest.skip("this bpy has no extension tool")

    def run(*arguments):
        return subprocess.run([sys.executable, str(found[0]), *map(str, arguments)], capture_output=True, text=True)

    return run


@pytest.fixture(scope="session")
def built(blender_ext, tmp_path_factory):
    """The extension's zip, built by Blender's own builder."""
    folder = tmp_path_factory.mktemp("built")
    done = blender_ext("build", "--source-dir", ROOT, "--output-dir", folder)
    assert done.returncode == 0, done.stdout + done.stderr
    (path,) = folder.glob("*.zip")
    return path


def test_tree_is_valid(blender_ext):
    done = blender_ext("validate", ROOT)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "warning" not in (done.stdout + done.stderr).lower()


def test_zip_is_valid(blender_ext, built):
    done = blender_ext("validate", built)
    assert done.returncode == 0, done.stdout + done.stderr


def test_zip_holds_the_extension_and_nothing_else(built):
    names = zipfile.ZipFile(built).namelist()
    assert {"blender_manifest.toml", "__init__.py", "LICENSE", "core/engine/worker.py", "s2ag_blender/engine/client.py"} <= set(
        names
    )
    assert not [name for name in names if name.endswith((".whl", ".pyc", ".blend1", ".zip"))]
    outside = ("tests/", "examples/", "docs/", "farm/", "build/", "dist/", ".git/", ".ci/", "work/")
    assert not [name for name in names if name.startswith(outside) or "__pycache__" in name]
    assert built.stat().st_size <= 20_000_000


def test_worker_starts_from_the_installed_extension(built, tmp_path):
    """Laid out as Blender does it: the module is bl_ext.user_default.s2ag_blender, and no s2ag is installed."""
    folder = tmp_path / "bl_ext" / "user_default" / "s2ag_blender"
    zipfile.ZipFile(built).extractall(folder)
    code = (
        "import sys\n"
        "from bl_ext.user_default.s2ag_blender.s2ag_blender.engine.client import WorkerClient\n"
        "with WorkerClient(python=sys.executable) as client:\n"
        "    print(client.call('hello')['version'], 's2ag' in sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [built.stem.rpartition("-")[2], "False"]
