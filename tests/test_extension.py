"""The tree as a Blender extension: Blender's own validator and builder, and the built zip at work."""

import importlib.util
import json
import os
import subprocess
import sys
import tomllib
import wave
import zipfile
from fnmatch import fnmatch
from pathlib import Path

import pytest
from imports import PACKAGES, modules, statements
from s2ag.core.cli.parser import PACKAGE_VERBS
from s2ag.core.sound import audio

ROOT = Path(__file__).resolve().parents[1]
MOST_LINES = 40_000
"""Of Python in the zip, which is the extension and nothing else."""
GUARDED = {
    ("core.cli.outputs", "core.cli.motion_export"),
    ("core.cli.synthesis_options", "core.cli.cell_options"),
    ("core.editing.director", "core.motion.rhubarb"),
    ("core.model.loading", "core.model.torch_inference"),
    ("core.sound.audio", "core.sound.av_decoding"),
    ("core.synthesis.features", "core.model.table_features"),
    ("core.synthesis.generation", "core.model.windows"),
    ("core.vectors.table", "core.vectors.gensim_reader"),
    ("core.words.transcript", "core.words.recognise"),
    ("core.words.language", "core.words.aligner.espeak"),
    ("core.words.readers", "core.words.readers.subtitles"),
    ("core.words.readers", "core.words.readers.textgrid"),
    ("core.words.aligner.engines", "core.words.aligner.sphinx_engine"),
    ("core.words.aligner.lexicon", "core.words.aligner.espeak"),
}
"""Imports in functions. Those of ``core.cli`` follow a sentence that the package is needed, that of recognition ends in
one;
the others are not reached where the module is missing, as :mod:`core.optional_packages` tells, or need the full engine: the
first of them raises :class:`EngineMissing` without it, the next are for networks that only the first loads."""


def excluded(path, patterns):
    """Whether one of the manifest's patterns leaves out the file ``path`` (relative, with slashes) or a folder above it."""
    parts = path.split("/")
    folders = ["/".join(parts[:count]) for count in range(1, len(parts))]
    for pattern in patterns:
        places = folders if pattern.endswith("/") else [*folders, path]
        name = pattern.strip("/")
        if any(fnmatch(place if pattern.startswith("/") else place.rpartition("/")[2], name) for place in places):
            return True
    return False


def shipped():
    """Python files of the repository that go into the zip."""
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text("utf-8"))
    patterns = manifest["build"]["paths_exclude_pattern"]
    done = subprocess.run(["git", "ls-files", "*.py"], cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        pytest.skip("this is no checkout")
    return [path for path in done.stdout.splitlines() if not excluded(path, patterns)]


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
    assert {"blender_manifest.toml", "__init__.py", "LICENSE", "core/worker/server.py", "s2ag_blender/engine/client.py"} <= set(
        names
    )
    assert not [name for name in names if name.endswith((".whl", ".pyc", ".blend1", ".zip"))]
    outside = ("tests/", "examples/", "docs/", "farm/", "build/", "dist/", ".git/", ".ci/", "work/", "noxfile", "pyproject")
    assert not [name for name in names if name.startswith(outside) or "__pycache__" in name]
    assert built.stat().st_size <= 21_000_000


def test_the_zip_is_small_and_complete():
    paths = shipped()
    rooms = {path.rpartition("/")[0] for path in paths}
    assert not [room for room in rooms if room.startswith(("core/learning", "core/study", "core/batch", "core/setup"))]
    lines = sum(len((ROOT / path).read_text("utf-8").splitlines()) for path in paths)
    assert lines <= MOST_LINES, lines


def test_every_pattern_leaves_something_out():
    """A file or folder that moved takes its line in the manifest along."""
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text("utf-8"))
    places = [line.strip("/") for line in manifest["build"]["paths_exclude_pattern"] if line.startswith(("/core/", "/s2ag_b"))]
    assert places and not [place for place in places if not (ROOT / place).exists()]


def test_nothing_in_the_zip_imports_what_is_left_out():
    """Not in a function either, but for those that are guarded; the command line finds verbs of the package by name."""
    everything, paths = modules(*PACKAGES), set(shipped())
    inside = {name for name, path in everything.items() if path.relative_to(ROOT).as_posix() in paths}
    wrong = [
        f"{everything[name]}:{line}: {imported}"
        for name in sorted(inside)
        for imported, line in statements(name)
        if imported in everything and imported not in inside and (name, imported) not in GUARDED
    ]
    assert not wrong, f"left out of the zip, or not yet known to git: {wrong}"
    at_start = {(name, imported) for name in inside for imported, _ in statements(name, nested=False)}
    ever = {(name, imported) for name in inside for imported, _ in statements(name) if imported not in inside}
    assert ever >= GUARDED and not at_start & GUARDED


def test_the_builder_takes_what_the_patterns_say(built):
    assert {name for name in zipfile.ZipFile(built).namelist() if name.endswith(".py")} == set(shipped())


def test_commands_of_the_package_are_refused_in_a_sentence(built, tmp_path):
    zipfile.ZipFile(built).extractall(tmp_path)
    start = [sys.executable, "-P", str(tmp_path / "core" / "start.py"), "--", "core.cli.main"]
    for verb in (*PACKAGE_VERBS, "train"):
        done = subprocess.run([*start, verb, "--data", "x"], capture_output=True, text=True)
        assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
        assert f"{verb} is a command of the Python package" in done.stderr and "pip install" in done.stderr
    done = subprocess.run([*start, "styles"], capture_output=True, text=True)
    assert done.returncode == 0 and "calm lecturer" in done.stdout, done.stderr
    offered = subprocess.run([*start, "--help"], capture_output=True, text=True).stdout
    assert "animate" in offered and "bench" not in offered
    for outside in (["-o", "x.bvh"], ["-o", "x.npz", "--from", "sheet.json:1"]):
        done = subprocess.run([*start, "synth", *outside, "x.wav"], capture_output=True, text=True, cwd=tmp_path)
        assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
        assert "of the Python package s2ag" in done.stderr


def test_the_zip_gestures_without_the_full_engine_and_says_what_needs_it(built, tmp_path):
    """Also in a Python that has PyTorch and pocketsphinx: the modules that use them are not in the zip."""
    for package in ("torch", "av"):
        pytest.importorskip(package, reason="the zip is tried beside a full engine's packages")
    zipfile.ZipFile(built).extractall(tmp_path)
    start = [sys.executable, "-P", str(tmp_path / "core" / "start.py"), "--"]
    done = subprocess.run([*start, "core.worker.inventory", "--try"], capture_output=True, text=True)
    facts = json.loads(done.stdout)
    assert facts["gestured"] and not facts["problem"], done.stderr
    sound = audio.load(ROOT / "examples" / "hello.flac")
    with wave.open(str(tmp_path / "hello.wav"), "wb") as file:  # the zip reads no other recordings by itself
        file.setparams((1, 2, audio.SAMPLE_RATE, 0, "NONE", ""))
        file.writeframes((sound * 32767).astype("<i2").tobytes())
    hello = [str(tmp_path / "hello.wav"), "--text", "hello there", "-o", str(tmp_path / "hello.npz")]
    done = subprocess.run([*start, "core.cli.main", "synth", *hello, "--backend", "torch"], capture_output=True, text=True)
    assert done.returncode == 2 and "needs the full engine" in done.stderr and "s2ag[full]" in done.stderr, done.stderr
    env = {**os.environ, "S2AG_ALIGNER": "pocketsphinx"}
    done = subprocess.run([*start, "core.cli.main", "synth", *hello], capture_output=True, text=True, env=env)
    assert done.returncode == 0 and (tmp_path / "hello.npz").exists(), done.stderr


def test_worker_starts_from_the_installed_extension(built, tmp_path):
    """Laid out as Blender does it: the module is bl_ext.user_default.s2ag_blender, and no s2ag is installed."""
    folder = tmp_path / "bl_ext" / "user_default" / "s2ag_blender"
    zipfile.ZipFile(built).extractall(folder)
    code = (
        "import sys\n"
        "from bl_ext.user_default.s2ag_blender.s2ag_blender.engine.client import WorkerClient\n"
        "with WorkerClient() as client:\n"
        "    print(client.call('hello')['version'], client.inside, 's2ag' in sys.modules)\n"
    )
    variables = {name: value for name, value in os.environ.items() if name != "S2AG_PYTHON"}
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, env=variables)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [built.stem.rpartition("-")[2], "False", "False"]


def test_films_and_styles_in_the_zip_alone_say_what_to_install(built, tmp_path):
    """The buttons are there, and each ends in one sentence of what the package would do, without changing anything."""
    zipfile.ZipFile(built).extractall(tmp_path / "from_the_zip")
    (tmp_path / "talk.mp4").write_bytes(b"a film")
    (tmp_path / "talk.npz").write_bytes(b"a motion")
    lines = (
        "import os, bpy, from_the_zip",
        "bpy.ops.wm.read_factory_settings(use_empty=True)",
        "from_the_zip.register()",
        "bpy.ops.s2ag.add_mannequin()",
        "for name, file in (('capture_film', 'talk.mp4'), ('own_style', 'talk.npz')):",
        "    button = getattr(bpy.ops.s2ag, name)",
        "    assert button.poll() and button.get_rna_type().name",
        "    try:",
        "        button(filepath=os.path.abspath(file))",
        "    except RuntimeError as error:",
        "        print('told', name, str(error).strip().replace(chr(10), '|'), flush=True)",
        "print('takes', len(bpy.context.active_object.s2ag.takes), flush=True)",
        "os._exit(0)",
    )
    variables = {name: value for name, value in os.environ.items() if name != "S2AG_PYTHON"}
    command = [sys.executable, "-c", "\n".join(lines)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env={**variables, "PYTHONPATH": ""})
    told = [line for line in done.stdout.splitlines() if line.startswith(("told", "takes"))]
    assert len(told) == 3 and told[2] == "takes 0", done.stdout + done.stderr
    for line, name in zip(told, ("capture", "learn"), strict=False):
        assert f"{name} is a command of the Python package" in line and "pip install" in line and "|" not in line, line
