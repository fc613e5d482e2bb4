"""Modules that run when something of them is used, so that registering the extension costs what Blender then needs alone."""

import importlib.util
import sys
from functools import partial
from types import ModuleType
from typing import Any


def lazily(*rooms: str) -> None:
    """Let ``from room import file`` give modules that have not run yet; ``from room.file import name`` runs it at once."""
    for room in rooms:
        package: Any = importlib.import_module(f".{room}", __package__)
        package.__getattr__ = partial(_module_of, package)


def _module_of(package: ModuleType, name: str) -> ModuleType:
    spec = importlib.util.find_spec(f"{package.__name__}.{name}")
    if spec is None or spec.loader is None:
        raise AttributeError(f"module {package.__name__!r} has no attribute {name!r}")
    spec.loader = importlib.util.LazyLoader(spec.loader)
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    setattr(package, name, module)
    return module


def has_run(module: ModuleType) -> bool:
    """Return whether a module of :func:`lazily` has run; before that it holds nothing that could be out of date."""
    return type(module) is ModuleType
