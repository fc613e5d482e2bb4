"""Lists what a Python has for the engine: ``python -m s2ag.core.engine.inventory`` prints one JSON object.

With ``--try`` it also gestures a clip. :mod:`interpreter` runs this in a Python that is to be checked.
"""

import importlib
import importlib.metadata
import importlib.util
import json
import os
import platform
import sys
import tempfile
import wave
from pathlib import Path

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


_CLIP = Path(__file__).parents[1] / "assets" / "hello.mp3"


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


def gestured() -> tuple[float, str]:
    """Seconds of gestures for the clip that comes with the engine, and why there are none.

    The clip is an MP3 with its words, decoded and aligned as a user's would be, and performed by torch where that is; where
    nothing decodes, as in Blender's own Python, it is a tone in a WAV file.
    """
    import numpy as np

    from ..errors import S2agError
    from ..performance.synthesis import Request, Session

    backend = "torch" if importlib.util.find_spec("torch") else None
    try:
        with tempfile.TemporaryDirectory(prefix="s2ag-") as folder:
            (motion,) = Session(backend=backend, cache="off").synthesize(Request(**_clip(Path(folder)))).motions
    except S2agError as error:
        return 0.0, str(error)
    except Exception as error:  # whatever a package of another version raises is what is looked for
        text = (str(error).strip().splitlines() or [""])[0]
        return 0.0, f"a clip is not gestured ({type(error).__name__}: {text[:200]})"
    still = float(np.ptp(motion.directions, axis=0).max()) < 0.1 or not np.isfinite(motion.directions).all()
    return motion.duration, "a clip is gestured without moving" if still else ""


def _clip(folder: Path) -> dict:
    if importlib.util.find_spec("av"):
        return {"audio": _CLIP, "transcript": _CLIP.with_suffix(".txt")}
    import numpy as np

    with wave.open(str(folder / "tone.wav"), "wb") as file:
        file.setparams((1, 2, 16000, 0, "NONE", ""))
        file.writeframes((8000 * np.sin(np.arange(80000) / 20) * np.sin(np.arange(80000) / 3000)).astype("<i2").tobytes())
    return {"audio": folder / "tone.wav"}


def main(arguments: list[str] = ()) -> int:
    """Print what there is; with ``--try``, after it has made gestures."""
    found = take()
    if "--try" in arguments and not found["problem"]:
        found["gestured"], found["problem"] = gestured()
    print(json.dumps(found))
    return 0


if __name__ == "__main__":
    main(sys.argv[1:])
