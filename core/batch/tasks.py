"""Child process of a crew for the tasks without Blender: ``python -m s2ag.core.batch.tasks``."""

import sys
import wave
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import S2agError
from ..motion import skeleton
from ..threads import set_passive_waiting
from . import child_server, encode
from .checks import request
from .clip import MODELS, Clip
from .folder import Folder, digest, move_to_place

if TYPE_CHECKING:
    from ..motion.motion import Motion
    from ..synthesis.session import Session

Tell = Callable[[str, float], None]
"""Receives progress: a stage and a value 0..1 within it."""

_MOTION_KINDS = ("npz", "bvh", "json")
_MAX_SESSIONS = 3
"""Sessions with different models that a process caches, for manifests that alternate between languages or networks."""


class Synthesis:
    """The task ``synth``: makes the motion files of one clip; models stay loaded between tasks."""

    def __init__(self):
        self._open = lru_cache(maxsize=_MAX_SESSIONS)(_open)

    def __call__(self, params: dict, tell: Tell) -> dict:
        """Write the files, then the record; ``params`` are ``clip``, ``folder``, ``key``, ``cache``, and ``inputs``, the
        digests of files that ``key`` was made of. Return the facts."""
        from ..editing.director import perform

        clip, folder = Clip.of(params["clip"]), Folder(params["folder"])
        models = {name: getattr(clip, name) for name in MODELS}
        result = perform(self._open(**models, cache=params["cache"]), request(clip), clip, tell)
        with folder.part() as part:
            files = {}
            for take, motion in enumerate(result.motions):
                files |= _motion_files(motion, clip, take, folder, part)
            if "dataset" in clip.outputs:
                files |= _speech_files(clip, result.words, folder, part)
            digests = {place: digest(file) for file, place in files.items()}
            motions = [digests[path] for path in motion_paths(folder, clip)]
            if changed := next((path for path, known in params["inputs"].items() if digest(path) != known), None):
                raise S2agError(f"{changed} was changed while it was read.", "Run the batch again.", "InputChanged")
            for file, place in files.items():
                move_to_place(file, place)
        first = result.motions[0]
        facts = {"motions": motions, "recording": first.meta["audio"], "duration": first.duration, "warnings": result.warnings}
        folder.record("synth", clip.name).write(params["key"], list(files.values()), facts)
        return facts


def _open(**models: Any) -> "Session":
    from ..synthesis.session import Session

    return Session(**models)


def motion_paths(folder: Folder, clip: Clip) -> list[Path]:
    """Return the path of every take's motion."""
    return [folder.result("npz", name, ".npz") for name in clip.take_names]


def _motion_files(motion: "Motion", clip: Clip, take: int, folder: Folder, part: Path) -> dict[Path, Path]:
    """Write the files of one take to ``part``; return them with their final paths. Rendering always needs the ``.npz``."""
    from ...rigs import bvh
    from ..motion import json_export

    name = clip.take_name(take)
    savers = {"npz": lambda motion, path: motion.save(path), "bvh": bvh.save, "json": json_export.save}
    files = {}
    for kind in _MOTION_KINDS:
        if kind == "npz" or kind in clip.outputs:
            file = part / f"{name}.{kind}"
            savers[kind](motion, file)
            files[file] = folder.result(kind, name, f".{kind}")
    if "dataset" in clip.outputs:
        file = part / f"{name}.dataset.npz"
        arrays = {"directions": motion.directions, "positions": skeleton.to_positions(motion.directions)}
        np.savez_compressed(file, **arrays, fps=np.float64(motion.fps))
        files[file] = folder.result("dataset/motion", name, ".npz")
    return files


def _speech_files(clip: Clip, words: Sequence[Sequence], folder: Folder, part: Path) -> dict[Path, Path]:
    """Write the recording (16-bit WAV, 16 kHz) and its timed words to ``part``; return them with their final paths."""
    import json

    from ..sound import audio

    sound, text = part / f"{clip.name}.wav", part / f"{clip.name}.words.json"
    with wave.open(str(sound), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(audio.SAMPLE_RATE)
        file.writeframes((np.clip(audio.load(clip.audio), -1, 1) * 32767).astype("<i2").tobytes())
    text.write_text(json.dumps({"words": [list(word) for word in words]}) + "\n", "utf-8")
    return {
        sound: folder.result("dataset/audio", clip.name, ".wav"),
        text: folder.result("dataset/words", clip.name, ".json"),
    }


def encode_film(params: dict, tell: Tell) -> dict:
    """Run the task ``encode``: images and sounds to an MP4.

    ``params`` are ``images``, ``sounds``, ``fps``, ``first``, ``count``, ``folder``, ``name``, ``key``.
    """
    folder, name = Folder(params["folder"]), params["name"]
    place = folder.result("mp4", name, ".mp4")
    with folder.part() as part:
        film = part / f"{name}.mp4"
        encode.film(
            Path(params["images"]), params["first"], params["count"], params["fps"], params["sounds"], film,
            lambda share: tell("encode", share),
        )  # fmt: skip
        move_to_place(film, place)
    folder.record("encode", name).write(params["key"], [place], {})
    return {}


def main() -> int:
    """Serve until the parent process ends."""
    set_passive_waiting()
    return child_server.serve({"synth": Synthesis(), "encode": encode_film})


if __name__ == "__main__":
    sys.exit(main())
