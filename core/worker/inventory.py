"""Lists what a Python has for the engine: ``python -m s2ag.core.worker.inventory`` prints one JSON object.

With ``--try`` it also generates gestures for a clip. :mod:`interpreter` runs this in a Python that is to be checked."""

import importlib
import importlib.metadata
import importlib.util
import json
import os
import platform
import sys
import tempfile
import wave
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..optional_packages import has_av, has_recogniser
from ..version import VERSION

PACKAGES = ("numpy", "torch", "safetensors", "av", "pocketsphinx", "pysubs2", "praatio")
"""Distributions, and modules of these names, that the worker imports if they are installed."""
NEEDED = ("numpy",)
"""The packages without which the engine does not run."""
_CLIP = Path(__file__).parents[1] / "assets" / "hello.mp3"


def take_inventory() -> dict:
    """Return versions, device and checkpoint as the worker sees them; ``problem`` is empty where it can run."""
    from ..errors import S2agError
    from ..model import checkpoint_metadata

    facts: dict[str, Any] = {
        "interpreter": sys.executable,
        "python": platform.python_version(),
        "s2ag": VERSION,
        "packages": {name: _version(name) for name in PACKAGES},
        "recogniser": has_recogniser(),
        "device": "",
        "checkpoint": "",
        "hash": "",
        "problem": _problem(),
    }
    try:
        checkpoint = checkpoint_metadata.describe()
        facts["checkpoint"], facts["hash"] = os.path.basename(checkpoint["path"]), checkpoint["hash"] or ""
    except S2agError as error:
        facts["problem"] = facts["problem"] or str(error)
    if not facts["problem"]:
        facts["device"] = _device()
    return facts


def _version(distribution: str) -> str:
    """Return the version of an installed package, else an empty text."""
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return ""


def _problem() -> str:
    """Return why the first needed or installed package does not import, such as for missing libraries; else an empty text."""
    for name in PACKAGES:
        if name not in NEEDED and importlib.util.find_spec(name) is None:
            continue
        try:
            importlib.import_module(name)
        except (ImportError, OSError) as error:
            text = (str(error).strip().splitlines() or [type(error).__name__])[0]
            return f"{name} does not load: {text[:200]}"
    return ""


def _device() -> str:
    """Return where the network runs by default, and which other device there is."""
    if importlib.util.find_spec("torch") is None:
        return "cpu"
    import torch

    other = "CUDA" if torch.cuda.is_available() else "Metal" if torch.backends.mps.is_available() else ""
    return f"cpu ({other} unused)" if other else "cpu"


def try_gesture() -> tuple[float, str]:
    """Generate gestures for the engine's own clip; return their seconds, and why that failed, else an empty text.

    The clip is an MP3 with a transcript, decoded and aligned like a user's recording, and the network runs by torch in a
    full engine. Where no decoder is installed, as in Blender's own Python, it is a tone in a WAV file."""
    import numpy as np

    from ..errors import S2agError
    from ..synthesis.session import Request, Session

    torch_inference = importlib.util.find_spec("torch") and importlib.util.find_spec("..model.torch_inference", __package__)
    backend = "torch" if torch_inference else None
    try:
        with tempfile.TemporaryDirectory(prefix="s2ag-") as folder:
            (motion,) = Session(backend=backend, cache="off").synthesize(Request(**_clip(Path(folder)))).motions
    except S2agError as error:
        return 0.0, str(error)
    except Exception as error:  # packages of untested versions may raise anything
        text = (str(error).strip().splitlines() or [""])[0]
        return 0.0, f"a clip is not gestured ({type(error).__name__}: {text[:200]})"
    still = float(np.ptp(motion.directions, axis=0).max()) < 0.1 or not np.isfinite(motion.directions).all()
    return motion.duration, "a clip is gestured without moving" if still else ""


def _clip(folder: Path) -> dict[str, Any]:
    """Return the clip as arguments of a request; a tone is written to ``folder``."""
    if has_av():
        from ..words.transcript_search import words_beside

        return {"audio": _CLIP, **words_beside(_CLIP)}
    import numpy as np

    with wave.open(str(folder / "tone.wav"), "wb") as file:
        file.setparams((1, 2, 16000, 0, "NONE", ""))
        file.writeframes((8000 * np.sin(np.arange(80000) / 20) * np.sin(np.arange(80000) / 3000)).astype("<i2").tobytes())
    return {"audio": folder / "tone.wav"}


def main(arguments: Sequence[str] = ()) -> int:
    """Print the inventory as JSON; with ``--try``, generate gestures first."""
    facts = take_inventory()
    if "--try" in arguments and not facts["problem"]:
        facts["gestured"], facts["problem"] = try_gesture()
    print(json.dumps(facts))
    return 0


if __name__ == "__main__":
    main(sys.argv[1:])
