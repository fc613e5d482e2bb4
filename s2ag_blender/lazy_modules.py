"""Modules that run when something of them is used, so that registering the extension costs what Blender then needs alone."""

import importlib.util
import sys
import threading
from functools import partial
from types import ModuleType
from typing import Any

_RUNNING = threading.RLock()


class _Asleep(ModuleType):
    """A module that runs when something that it defines is asked for.

    What all modules have is there before: Blender's preferences read ``__file__`` of each in ``sys.modules``, which must not
    grow meanwhile, as it does with the standard library's lazy modules."""

    def __getattr__(self, name: str) -> Any:
        with _RUNNING:
            if name.startswith("__") or self.__dict__.get("_is_running"):
                raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
            if type(self) is _Asleep:
                self._is_running = True
                try:
                    self.__spec__.loader.exec_module(self)  # pyright: ignore[reportOptionalMemberAccess]
                    object.__setattr__(self, "__class__", ModuleType)
                finally:
                    del self._is_running
        return getattr(self, name)


def lazily(*rooms: str) -> None:
    """Let ``from room import file`` give modules that have not run yet; ``from room.file import name`` runs it at once."""
    for room in rooms:
        package: Any = importlib.import_module(f".{room}", __package__)
        package.__getattr__ = partial(_module_of, package)


def _module_of(package: ModuleType, name: str) -> ModuleType:
    spec = importlib.util.find_spec(f"{package.__name__}.{name}")
    if spec is None or spec.loader is None:
        raise AttributeError(f"module {package.__name__!r} has no attribute {name!r}")
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    object.__setattr__(module, "__class__", _Asleep)
    setattr(package, name, module)
    return module


def has_run(module: ModuleType) -> bool:
    """Return whether a module of :func:`lazily` has run; before that it holds nothing that could be out of date."""
    return type(module) is ModuleType
