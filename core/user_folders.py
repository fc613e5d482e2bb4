"""The user's own folders by the convention of the platform: for caches, and for weights that a command has made."""

import os
import sys
from pathlib import Path

ENVIRONMENT_VARIABLE = "S2AG_DATA"
"""Environment variable that names another folder for data."""


def cache() -> Path:
    """Return the folder of caches; raises ``RuntimeError`` where the user of this process has no home."""
    return _platform_folder("Cache", "Caches", "XDG_CACHE_HOME", ".cache")


def data() -> Path:
    """Return the folder of data, which only commands of the user write to; raises ``RuntimeError`` as :func:`cache`."""
    named = os.environ.get(ENVIRONMENT_VARIABLE, "").strip()
    return Path(named) if named else _platform_folder("Data", "Application Support", "XDG_DATA_HOME", ".local/share")


def _platform_folder(windows: str, macos: str, variable: str, linux: str) -> Path:
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "s2ag" / windows
    if sys.platform == "darwin":
        return Path.home() / "Library" / macos / "s2ag"
    setting = os.environ.get(variable, "")
    return (Path(setting) if os.path.isabs(setting) else Path.home() / linux) / "s2ag"
