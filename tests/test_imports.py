"""The import rules of the package, read from its source: who may import what, and what nobody may do."""

import ast
import subprocess
import sys
import tomllib

import pytest
import s2ag
from imports import ALL, ROOT, modules, reachable, tree
from s2ag.core.cli.parser import PACKAGE_VERBS

BLENDER = {"bpy", "mathutils", "bpy_extras", "bmesh", "gpu", "aud"}
HEAVY = {"torch", "scipy", "librosa", "gensim", "av", "pocketsphinx", "safetensors", "numba", "sklearn", "tqdm"}
VERSION_BOUND = {
    "fcurves",
    "sequences",
    "sequences_all",
    "strips_all",
    "channelbags",
    "channelbag",
    "action_slot",
    "media_type",
}


def every_source_file():
    return [ROOT / "__init__.py", ROOT / "__main__.py", *ALL.values()]


def offences(files, wrong):
    return [f"{path.relative_to(ROOT)}:{node.lineno}" for path in files for node in ast.walk(tree(path)) if wrong(node)]


def test_the_scan_sees_the_package():
    assert {"core.worker.server", "core.cli.main", "s2ag_blender.engine.client", "core.errors"} <= set(ALL)
    assert "core.worker.protocol" in reachable("s2ag_blender.engine.client")
    assert "torch" in reachable("core.synthesis.session")
    assert "torch" not in reachable("core.synthesis.session", nested=False)


@pytest.mark.parametrize("name", sorted(modules("core", "rigs")))
def test_core_and_rigs_never_reach_blender(name):
    assert not reachable(name) & BLENDER


@pytest.mark.parametrize("name", sorted(modules("rigs", "s2ag_blender")))
def test_blenders_process_never_reaches_the_engine(name):
    assert not reachable(name) & HEAVY


VERBS = [f"core.cli.{verb}" for verb in PACKAGE_VERBS]


@pytest.mark.parametrize("name", ["core.cli.parser", *VERBS, "core.worker.server", "core.synthesis.session"])
def test_nothing_heavy_at_start(name):
    assert not reachable(name, nested=False) & HEAVY


def test_importing_what_blender_imports_loads_numpy_at_most():
    light = [name for name in modules("rigs", "s2ag_blender") if not reachable(name, nested=False) & BLENDER]
    assert "s2ag_blender.engine.client" in light
    code = "import importlib, sys\nfor name in sys.argv[1:]: importlib.import_module('s2ag.' + name)\nprint(*sys.modules)"
    # Isolated from the tests' own folder; -S is not possible, because the installed package is found by site.
    done = subprocess.run([sys.executable, "-c", code, *light], capture_output=True, text=True, check=True)
    loaded = {name.split(".")[0] for name in done.stdout.split()}
    assert "numpy" in loaded
    assert not loaded & (HEAVY | BLENDER)


def test_the_front_door_loads_nothing_until_it_is_used():
    code = (
        "import sys, s2ag\n"
        "before = [name for name in sys.modules if name == 'numpy' or name.startswith('s2ag.core.synthesis')]\n"
        "print(before, *(getattr(s2ag, name).__name__ for name in s2ag.__all__))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["[]", "Motion", "Request", "Session"]


def test_imports_inside_the_package_are_relative():
    def wrong(node):
        return (isinstance(node, ast.ImportFrom) and node.level == 0 and node.module.split(".")[0] == "s2ag") or (
            isinstance(node, ast.Import) and any(alias.name.split(".")[0] == "s2ag" for alias in node.names)
        )

    assert not offences(every_source_file(), wrong)


def test_version_differences_live_in_compat():
    def wrong(node):
        if not isinstance(node, ast.Attribute):
            return False
        owner = ast.unparse(node.value)
        # A bag is what compat hands out, with the same face in every version.
        return (node.attr in VERSION_BOUND and owner not in ("compat", "bag")) or (
            node.attr == "version" and owner == "bpy.app"
        )

    files = [path for name, path in modules("s2ag_blender").items() if name != "s2ag_blender.compat"]
    assert not offences(files, wrong)


def test_nothing_is_pickled():
    def wrong(node):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        if {name.split(".")[0] for name in names} & {"pickle", "cPickle", "dill", "cloudpickle", "joblib", "shelve", "marshal"}:
            return True
        if not isinstance(node, ast.Call):
            return False
        options = {word.arg: ast.unparse(word.value) for word in node.keywords}
        unsafe = ast.unparse(node.func) == "torch.load" and options.get("weights_only") != "True"
        return unsafe or options.get("allow_pickle", "False") != "False"

    assert not offences(every_source_file(), wrong)


def test_nobody_edits_the_search_path():
    def wrong(node):
        attribute = isinstance(node, ast.Attribute) and node.attr == "path" and ast.unparse(node.value) == "sys"
        return attribute or (isinstance(node, ast.Import) and any(alias.name == "site" for alias in node.names))

    assert not offences(every_source_file(), wrong)


def test_one_version_everywhere():
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text("utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    assert s2ag.__version__ == manifest["version"] == project["project"]["version"]


def test_every_package_is_listed_for_installation():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    folders = {".".join(path.parent.relative_to(ROOT).parts) for path in ALL.values()}
    assert set(project["tool"]["setuptools"]["packages"]) == {"s2ag"} | {f"s2ag.{folder}" for folder in folders}


def test_doctor_knows_the_versions_of_torch():
    from s2ag.core.cli.machine_checks import TORCH

    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    wanted = next(line for line in project["project"]["optional-dependencies"]["full"] if line.startswith("torch"))
    first, beyond = (".".join(map(str, version)) for version in TORCH)
    assert wanted == f"torch>={first},<{beyond}"
