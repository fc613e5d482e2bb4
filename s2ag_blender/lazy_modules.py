"""Modules that run when something of them is used, so that registering the extension costs what Blender then needs alone."""

import importlib.util
import sys
from collections.abc import Callable
from types import ModuleType


def lazily(room: str) -> Callable[[str], ModuleType]:
    """Return the ``__getattr__`` of a package, by which ``from room import file`` gives a module that has not run yet.

    ``from room.file import name`` runs it at once, as anywhere."""

    def module_of(name: str) -> ModuleType:
        spec = importlib.util.find_spec(f"{room}.{name}")
        if spec is None or spec.loader is None:
            raise AttributeError(f"module {room!r} has no attribute {name!r}")
        spec.loader = importlib.util.LazyLoader(spec.loader)
        module = importlib.util.module_from_spec(spec)
        sys.modules[spec.name] = module
        spec.loader.exec_module(module)
        setattr(sys.modules[room], name, module)
        return module

    return module_of


def has_run(module: ModuleType) -> bool:
    """Return whether a module that :func:`lazily` gave has run; before that it holds nothing that could be out of date."""
    return type(module) is ModuleType
