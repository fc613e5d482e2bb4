"""Checks whether this machine has what is needed to generate gestures."""

import importlib
import importlib.metadata
import importlib.util
import platform
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ..errors import S2agError
from ..model.checkpoint_metadata import describe
from ..optional_packages import RECOGNISER_ADVICE, has_recogniser
from ..words.aligner import engines, packed_model
from ..words.cache import Cache, default_folder
from . import blender

TORCH = (2, 4), (2, 14)
"""First version of torch that works, first that is untested; as in pyproject.toml."""
ENGINE, FULL = 'pip install "s2ag[engine]"', 'pip install "s2ag[full]"'
VECTORS = Path(__file__).parents[1] / "assets" / "words.npz"
SPACE = 1e9
"""Bytes that a minute of film may need for frames and temporary files."""


@dataclass(frozen=True)
class Check:
    """Result of a check: ``required`` says whether the main job needs it, ``remedy`` what to do if it is not ``ok``."""

    name: str
    ok: bool
    detail: str
    remedy: str = ""
    required: bool = True


def all_checks() -> Iterator[Check]:
    """Yield all checks, in the order in which the parts process a recording."""
    version = platform.python_version()
    yield Check("python", sys.version_info >= (3, 11), version, "Use Python 3.11 or newer.")
    yield _package("numpy", "numpy", "pip install numpy")
    yield _torch()
    yield _package("safetensors", "safetensors", f"For other networks: {FULL}", required=False)
    yield _package("av", "av", f"For all recordings but WAV: {ENGINE}", required=False)
    yield _package("pocketsphinx", "pocketsphinx", f"For other models of speech: {FULL}", required=False)
    yield _aligner()
    yield _vectors()
    yield _checkpoint()
    yield _package("gensim", "gensim", 'For your own word vectors: pip install "s2ag[vectors]"', required=False)
    yield _recogniser()
    yield _cache()
    yield from _blender()
    yield _space()


def _package(name: str, module: str, remedy: str, required: bool = True) -> Check:
    """Check whether a package imports; installed packages may lack libraries."""
    if importlib.util.find_spec(module) is None:
        return Check(name, False, "not installed", remedy, required)
    try:
        importlib.import_module(module)
    except (ImportError, OSError) as error:
        return Check(name, False, f"does not load: {str(error).splitlines()[0]}", f"Install it again: {remedy}", required)
    return Check(name, True, importlib.metadata.version(name), remedy, required)


def _torch() -> Check:
    found = _package("torch", "torch", f"For --backend torch and other networks: {FULL}", required=False)
    if not found.ok:
        return found
    numbers = tuple(int(part) for part in re.findall(r"\d+", found.detail)[:2])
    first, beyond = TORCH
    remedy = f"Versions from {first[0]}.{first[1]} to before {beyond[0]}.{beyond[1]} are known to work: {FULL}"
    return Check("torch", first <= numbers < beyond, found.detail, remedy, required=False)


def _aligner() -> Check:
    if not packed_model.ENGLISH.is_file():
        return Check("aligner", False, "no model of speech", f"Install s2ag again; {packed_model.ENGLISH.name} belongs to it.")
    return Check("aligner", True, engines.engine_name() or "numpy")


def _recogniser() -> Check:
    there = has_recogniser()
    return Check("recogniser", there, "installed" if there else "not installed", RECOGNISER_ADVICE, required=False)


def _cache() -> Check:
    cache = Cache(default_folder())
    files, size = cache.size()
    detail = f"{files} files, {size / 1e6:.1f} MB in {cache.folder}" if cache.folder else "off: words are placed anew each time"
    return Check("word times", cache.folder is not None, detail, "Unset S2AG_CACHE.", required=False)


def _vectors() -> Check:
    size = f"{VECTORS.stat().st_size / 1e6:.1f} MB" if VECTORS.is_file() else "missing"
    return Check("word vectors", VECTORS.is_file(), size, "Install s2ag again; core/assets/words.npz belongs to it.")


def _checkpoint() -> Check:
    try:
        found = describe()
    except S2agError as error:
        return Check("checkpoint", False, error.message, error.remedy)
    speakers = ", ".join(speaker["name"] for speaker in found["speakers"])
    return Check("checkpoint", True, f"{Path(found['path']).name} {found['hash'] or ''}, speakers: {speakers}")


def _blender() -> Iterator[Check]:
    """Check Blender and whether it renders, in its own process."""
    facts: dict = {}
    try:
        program = blender.command("probe")
        facts = blender.run("probe", talk="none")
    except S2agError as error:
        yield Check("blender", False, error.message, error.remedy)
        yield Check("rendering", False, "not tried", "Blender comes first.", required=False)
        return
    yield Check("blender", True, f"{facts['blender']} ({'the package bpy' if program[1] == '-P' else program[0]})")
    remedy = "Install a GL driver (Mesa's libegl1 and libgl1-mesa-dri do); .blend, .bvh, .fbx and .glb work without."
    renders = bool(facts["renders"])
    yield Check("rendering", renders, "works" if renders else "no frame came out", remedy, required=False)


def _space() -> Check:
    folder = tempfile.gettempdir()
    free = shutil.disk_usage(folder).free
    return Check(
        "disk", free > SPACE, f"{free / 1e9:.1f} GB free in {folder}", "Free some space, or set TMPDIR.", required=False
    )
