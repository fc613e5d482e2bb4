"""Every task of this repository: ``nox --list`` shows them, ``nox -s lint tests`` runs two; .ci/run calls what must pass.

Environments are made by ``venv`` and filled by pip: uv takes PyTorch's CUDA build where pip takes what the index offers.
What stands behind ``--`` goes on to the tool: ``nox -s tests -- tests/rigs -k palms``. ``-R`` leaves environments as they are.
"""

import tempfile
from pathlib import Path

import nox

nox.needs_version = ">=2026.4"
nox.options.default_venv_backend = "venv"
nox.options.download_python = "never"
nox.options.sessions = ["lint", "tests"]

ROOT = Path(__file__).parent
EXTRAS = nox.project.load_toml("pyproject.toml")["project"]["optional-dependencies"]
SLOW = ("-m", "slow or not slow")
PARALLEL = ("-n", "auto", "--dist", "loadfile")

BLENDER = ROOT / "tests" / "blender"
RIGS = [BLENDER / "rig", BLENDER / "keys", *BLENDER.glob("*/test_*survey.py")]
PRESSED = ["bone_maps", "drop", "expectations", "learn", "operators", "presets", "settings", "try_it"]
EXTENSION = [BLENDER / "takes", *(BLENDER / "ui" / f"test_{name}.py" for name in PRESSED), *BLENDER.glob("test_transl*.py")]
WHOLE = [BLENDER, ROOT / "tests" / "test_extension.py"]
"""Tests that run beside a Blender: all of its side, or what touches what differs between versions."""


def asked(extra: str, package: str) -> list[str]:
    """The lines of an extra in pyproject.toml that ask for a package."""
    return [line for line in EXTRAS[extra] if line.startswith(package)]


def of_full(session: nox.Session, command: str) -> str:
    """Path of a command in the environment that :func:`full` makes."""
    folder = Path(session.cache_dir).parent / "full"
    found = [path for path in folder.glob(f"*/{command}*") if path.stem == command]
    if not found:
        session.error(f"{folder} has no {command}: nox -s full makes it")
    return str(found[0])


@nox.session(reuse_venv=True)
def full(session: nox.Session) -> None:
    """Make the environment that most sessions share: all extras for users and tests, and Blender as a module."""
    session.install("-e", ".[all,recognise,languages,dev]")


@nox.session(reuse_venv=True)
def lint(session: nox.Session) -> None:
    """Check style by ruff, and GitHub's workflows and issue forms by their schemas."""
    session.install(*asked("dev", "ruff"), *asked("dev", "check-jsonschema"))
    session.run("ruff", "check", ".")
    github = ROOT / ".github"
    for schema, files in {
        "workflows": github.glob("workflows/*.yml"),
        "issue-forms": github.glob("ISSUE_TEMPLATE/[!c]*.yml"),
        "issue-config": github.glob("ISSUE_TEMPLATE/config.yml"),
    }.items():
        session.run("check-jsonschema", "--builtin-schema", f"vendor.github-{schema}", *map(str, files))


@nox.session(venv_backend="none", requires=["full"])
def types(session: nox.Session) -> None:
    """Check types by pyright."""
    session.run(of_full(session, "pyright"), "--pythonpath", of_full(session, "python"), *session.posargs, external=True)


@nox.session(venv_backend="none", requires=["full"])
def tests(session: nox.Session) -> None:
    """Run all tests on all cores, slow ones included, and list those that took longest."""
    session.run(of_full(session, "pytest"), *PARALLEL, *SLOW, "--durations=15", *session.posargs, external=True)


@nox.session(requires=["full"])
@nox.parametrize(
    ["python", "bpy", "numpy", "paths"],
    [
        nox.param("3.11", "4.2.23", "1.26.4", RIGS + EXTENSION, id="4.2"),
        nox.param("3.11", "4.5.15", "1.26.4", WHOLE, id="4.5"),
        nox.param("3.11", "5.0.1", "1.26.4", WHOLE, id="5.0"),
        nox.param("3.13", "5.2.3", "2.5.5", RIGS + EXTENSION, id="5.2"),
    ],
)
def blender(session: nox.Session, bpy: str, numpy: str, paths: list[Path]) -> None:
    """Run the Blender side's tests beside one version with the numpy that it ships; the engine runs in ``full``."""
    session.install("-U", "setuptools>=77")
    session.install(f"bpy=={bpy}", f"numpy=={numpy}", *asked("dev", "pytest"))
    session.install("--no-deps", "--no-build-isolation", "-e", ".")
    what = session.posargs or map(str, paths)
    session.run("pytest", *PARALLEL, *SLOW, "--durations=15", *what, env={"S2AG_PYTHON": of_full(session, "python")})


@nox.session(python=["3.11", "3.13"], requires=["full"])
def alone(session: nox.Session) -> None:
    """Make gestures where pip brought numpy alone, of a WAV file; then with the extra ``engine``, of FLAC."""
    work, hello = Path(session.create_tmp()), ROOT / "examples" / "hello.flac"
    decode = "import sys, sounds, s2ag.core.sound.audio as audio; sounds.write_wav(sys.argv[2], audio.load(sys.argv[1]))"
    helpers = {"PYTHONPATH": str(ROOT / "tests" / "helpers")}
    session.run(of_full(session, "python"), "-c", decode, str(hello), str(work / "hello.wav"), env=helpers, external=True)
    session.install(".")
    with session.chdir(work):  # where no checkout is in the way of the package
        text = hello.with_suffix(".txt").read_text("utf-8")
        session.run("s2ag", "synth", "hello.wav", "--text", text, "-o", "hello.npz", "-o", "hello.bvh")
    session.run("python", "tests/alone.py", str(work / "hello.npz"))
    session.install(".[engine]")
    session.run("s2ag", "synth", str(hello), "-o", str(work / "again.npz"))
    session.run("python", "tests/alone.py", str(work / "again.npz"))


@nox.session(reuse_venv=True, name="zip")
def build_zip(session: nox.Session) -> None:
    """Build the extension into dist/ by Blender's own builder, and validate it."""
    session.install(*asked("blender", "bpy"))
    (builder,) = Path(session.virtualenv.location).rglob("addons_core/bl_pkg/cli/blender_ext.py")
    dist = ROOT / "dist"
    dist.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(dir=dist) as folder:
        session.run("python", str(builder), "build", "--source-dir", str(ROOT), "--output-dir", folder)
        (built,) = Path(folder).glob("*.zip")
        session.run("python", str(builder), "validate", str(built))
        built.replace(dist / built.name)


@nox.session(reuse_venv=True)
def site(session: nox.Session) -> None:
    """Build the documents as a site into dist/site; a link that leads nowhere fails."""
    session.install(*EXTRAS["site"])
    session.run("sphinx-build", "-q", "-W", "--keep-going", "-b", "html", "-c", "docs", ".", str(ROOT / "dist" / "site"))


@nox.session(venv_backend="none", requires=["full"])
def benchmarks(session: nox.Session) -> None:
    """Print the README's figures of speed."""
    what = session.posargs or ["tests/benchmarks"]
    session.run(of_full(session, "pytest"), *what, "--benchmark-only", "-s", external=True)


@nox.session(venv_backend="none", requires=["full"])
def golden(session: nox.Session) -> None:
    """Store the golden motions anew, after a change that is meant to be seen."""
    session.run(of_full(session, "python"), "tests/golden/remake.py", external=True)
