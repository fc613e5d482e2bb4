"""Runs a module of this package by file path: ``python start.py -- MODULE ARGUMENTS``, or with ``blender -b --python``.

``MODULE`` is relative to the package: ``core.worker.server``, ``core.cli.main``, ``s2ag_blender.render.job``.

Blender's own Python has no package called s2ag, and runs isolated from environment variables and the working folder; so
the tree around this file is imported as a package, without changing ``sys.path``."""

import importlib
import importlib.util
import os
import sys
from pathlib import Path
from types import ModuleType


def import_package(name: str = "s2ag") -> ModuleType:
    """Import the tree around this file as the package ``name``."""
    root = Path(__file__).resolve().parent.parent
    spec = importlib.util.spec_from_file_location(name, root / "__init__.py", submodule_search_locations=[str(root)])
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def module_command(module: str) -> list[str]:
    """Return the command that runs ``module`` of this tree in the running Python, which need not have it installed.

    It is isolated from environment variables, which may be meant for another Python."""
    return [sys.executable, "-I", os.path.abspath(__file__), "--", module]


def package_command(python: str, module: str) -> list[str]:
    """Return the command that runs ``module`` of the package ``s2ag`` that is installed in ``python``.

    The working folder is not searched, so no folder there that is called ``s2ag`` takes the package's place."""
    return [python, "-P", "-m", f"s2ag.{module}"]


if __name__ == "__main__":
    module, *arguments = sys.argv[sys.argv.index("--") + 1 :]
    program = importlib.import_module(f"{import_package().__name__}.{module}")
    if status := program.main(arguments):
        sys.exit(status)
