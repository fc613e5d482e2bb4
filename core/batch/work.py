"""The tasks that need no Blender, as served to a crew: ``python -m s2ag.core.batch.work``."""

import sys
import wave
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from ..motion import rhubarb, skeleton
from ..threads import share_cores
from . import encode, serving
from .checks import request
from .clip import MODELS, Clip
from .folder import Folder, digest, land

_SAVED = ("npz", "bvh", "json")
_KEPT = 3
"""Engines with other models that a process keeps, for manifests in which rows of several languages or networks alternate."""


class Synthesis:
    """The task ``synth``: one clip to motion files, with an engine that stays warm."""

    def __init__(self):
        self._open = lru_cache(maxsize=_KEPT)(_open)

    def __call__(self, params: dict, tell) -> dict:
        """``clip``, ``folder``, ``key``, ``cache``; files land, then the record."""
        clip, folder = Clip.of(params["clip"]), Folder(params["folder"])
        models = {name: getattr(clip, name) for name in MODELS}
        result = _perform(self._open(**models, cache=params["cache"]), clip, tell)
        with folder.part() as part:
            made = {}
            for take, motion in enumerate(result.motions):
                made |= _motion_files(motion, clip, take, folder, part)
            if "dataset" in clip.outputs:
                made |= _speech_files(clip, result.words, folder, part)
            digests = {place: digest(file) for file, place in made.items()}
            motions = [digests[path] for path in motion_paths(folder, clip)]
            for file, place in made.items():
                land(file, place)
        first = result.motions[0]
        facts = {"motions": motions, "recording": first.meta["audio"], "duration": first.duration, "warnings": result.warnings}
        folder.record("synth", clip.name).write(params["key"], list(made.values()), facts)
        return facts


def _open(**models):
    from ..performance.synthesis import Session

    return Session(**models)


def _perform(session, clip: Clip, tell):
    """The takes of a clip, after an animator's edits where it has some."""
    if clip.edits is None:
        result = session.synthesize(request(clip), tell)
    else:
        from ..direction import edits
        from ..direction.directing import Director

        result = Director(session).direct(request(clip), edits.load(clip.edits), tell)
    return result if clip.rhubarb is None else replace(result, motions=rhubarb.moved(result.motions, clip.rhubarb))


def motion_paths(folder: Folder, clip: Clip) -> list[Path]:
    """The motion of every take."""
    return [folder.result("npz", clip.take_name(take), ".npz") for take in range(clip.takes)]


def _motion_files(motion, clip: Clip, take: int, folder: Folder, part: Path) -> dict[Path, Path]:
    """Files of one take in ``part`` and their places; the ``.npz`` is always there, because rendering needs it."""
    from ...rigs import bvh
    from ..motion import as_json

    name = clip.take_name(take)
    savers = {"npz": lambda motion, path: motion.save(path), "bvh": bvh.save, "json": as_json.save}
    made = {}
    for kind in _SAVED:
        if kind == "npz" or kind in clip.outputs:
            file = part / f"{name}.{kind}"
            savers[kind](motion, file)
            made[file] = folder.result(kind, name, f".{kind}")
    if "dataset" in clip.outputs:
        file = part / f"{name}.dataset.npz"
        arrays = {"directions": motion.directions, "positions": skeleton.to_positions(motion.directions)}
        np.savez_compressed(file, **arrays, fps=np.float64(motion.fps))
        made[file] = folder.result("dataset/motion", name, ".npz")
    return made


def _speech_files(clip: Clip, words, folder: Folder, part: Path) -> dict[Path, Path]:
    """The recording as 16-bit WAV at 16 kHz, and its words with their times."""
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


def encode_film(params: dict, tell) -> dict:
    """The task ``encode``: ``images``, ``sounds``, ``fps``, ``first``, ``count``, ``folder``, ``name``, ``key`` to an MP4."""
    folder, name = Folder(params["folder"]), params["name"]
    place = folder.result("mp4", name, ".mp4")
    with folder.part() as part:
        film = part / f"{name}.mp4"
        encode.film(
            Path(params["images"]), params["first"], params["count"], params["fps"], params["sounds"], film,
            lambda share: tell("encode", share),
        )  # fmt: skip
        land(film, place)
    folder.record("encode", name).write(params["key"], [place], {})
    return {}


def main() -> int:
    """Serve until the parent goes away."""
    share_cores()
    return serving.serve({"synth": Synthesis(), "encode": encode_film})


if __name__ == "__main__":
    sys.exit(main())
