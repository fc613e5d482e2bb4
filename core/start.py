"""Starts a module of this package by the path of this file: ``python start.py -- MODULE ARGUMENTS``, or the same with
``blender -b --python``.

``MODULE`` is named from the package's root: ``core.engine.worker``, ``core.cli.main``, ``s2ag_blender.film.job``.

Blender's own Python has no package called s2ag, and where Blender starts helpers with it, it is isolated from paths and the
working folder; so the tree around this file is made a package, without touching ``sys.path``.
"""

import importlib
import importlib.util
import os
import sys
from pathlib import Path


def package(name: str = "s2ag"):
    """Import the tree around this file as the package ``name``."""
    root = Path(__file__).resolve().parent.parent
    spec = importlib.util.spec_from_file_location(name, root / "__init__.py", submodule_search_locations=[str(root)])
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def module_command(python: str, module: str) -> list[str]:
    """The command that runs ``module`` of this package in ``python``, where it need not be installed.

    The Python that runs this is isolated from what the user's variables say of another one.
    """
    return [python, "-I" if python == sys.executable else "-P", os.path.abspath(__file__), "--", module]


if __name__ == "__main__":
    module, *arguments = sys.argv[sys.argv.index("--") + 1 :]
    started = importlib.import_module(f"{package().__name__}.{module}")
    if status := started.main(arguments):
        sys.exit(status)
