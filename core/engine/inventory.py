"""What the engine has to run with: ``python -m s2ag.core.engine.inventory`` loads it all and prints one JSON object.

Blender runs this with the interpreter it found and shows the answer in the preferences.
"""

import importlib
import importlib.metadata
import importlib.util
import json
import os
import platform
import sys

from ..extras import recogniser
from ..version import VERSION

PACKAGES = {
    "numpy": "numpy",
    "torch": "torch",
    "safetensors": "safetensors",
    "av": "av",
    "pocketsphinx": "pocketsphinx",
    "pysubs2": "pysubs2",
    "praatio": "praatio",
}
"""Distribution name -> module, of everything that the worker imports where it is there."""
NEEDED = ("numpy",)
"""Without these there is no engine; each of the others adds something."""


def take() -> dict:
    """Versions, device and checkpoint as the worker will see them; ``problem`` is empty where it can work."""
    from ..errors import S2agError
    from ..model import catalogue

    found = {
        "interpreter": sys.executable,
        "python": platform.python_version(),
        "s2ag": VERSION,
        "packages": {name: _version(name) for name in PACKAGES},
        "recogniser": recogniser(),
        "device": "",
        "checkpoint": "",
        "hash": "",
        "problem": _problem(),
    }
    try:
        checkpoint = catalogue.describe()
        found["checkpoint"], found["hash"] = os.path.basename(checkpoint["path"]), checkpoint["hash"] or ""
    except S2agError as error:
        found["problem"] = found["problem"] or str(error)
    if not found["problem"]:
        found["device"] = _device()
    return found


def _version(distribution: str) -> str:
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return ""


def _problem() -> str:
    """The first package that is needed or installed and does not import: its libraries may be missing."""
    for name, module in PACKAGES.items():
        if name not in NEEDED and importlib.util.find_spec(module) is None:
            continue
        try:
            importlib.import_module(module)
        except (ImportError, OSError) as error:
            text = (str(error).strip().splitlines() or [type(error).__name__])[0]
            return f"{name} does not load: {text[:200]}"
    return ""


def _device() -> str:
    """Where the network runs, and what else there is."""
    if importlib.util.find_spec("torch") is None:
        return "cpu"
    import torch

    other = "CUDA" if torch.cuda.is_available() else "Metal" if torch.backends.mps.is_available() else ""
    return f"cpu ({other} unused)" if other else "cpu"


def main(_arguments: list[str] = ()) -> int:
    """Print what there is."""
    print(json.dumps(take()))
    return 0


if __name__ == "__main__":
    main()
