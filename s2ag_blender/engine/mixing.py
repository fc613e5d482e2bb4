"""Recordings decoded by Blender's mixer, where its Python has no ``aud`` though Blender plays sound (Debian's 4.3).

The mixer is an operator that holds Blender until it is done, so another Blender, without a window, runs it:
``blender --background --python core/start.py -- s2ag_blender.engine.mixing {"source": ..., "target": ...}``.
"""

import json
import os
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import bpy

from ...core import child
from ...core.engine import protocol
from ...core.errors import AudioUnreadable, Cancelled, WorkerFailed
from .. import compat, program

_START = Path(__file__).parents[2] / "core" / "start.py"
_PAUSE = 0.02


def command() -> list[str]:
    """What runs this module, without its argument; [] where this is no application, or one without sound."""
    if not (bpy.app.build_options.audaspace and bpy.app.binary_path):
        return []
    options = ["--background", "--factory-startup", "--python-exit-code", "1", "--python", str(_START)]
    return [bpy.app.binary_path, *options, "--", "s2ag_blender.engine.mixing"]


def mixed(blender: list[str], source: Path, target: Path, stopped: Callable[[], bool]) -> None:
    """Write the sound of ``source`` as a stereo WAV of its own rate to ``target``, by another ``blender`` (:func:`command`).

    Its end may be followed by a frame of silence, and by as much of it as a header promised in vain. Raises
    :class:`AudioUnreadable`, :class:`WorkerFailed`, and :class:`Cancelled` soon after ``stopped()``.
    """
    request = json.dumps({"source": str(source), "target": str(target)})
    with tempfile.TemporaryFile() as said:
        process = _started([*blender, request], said)
        with process.stdin:
            while process.poll() is None:
                if stopped():
                    child.end(process)
                    process.wait()
                    raise Cancelled("Cancelled.")
                time.sleep(_PAUSE)
        said.seek(0)
        told = [event for line in said if (event := protocol.event(line))]
    if told and told[-1].get("event") == "error":
        raise protocol.revive(told[-1])
    if not told:
        what = f"A second Blender, which was to decode the recording, ended with status {process.returncode}."
        raise WorkerFailed(what, "Try again, or save the recording as WAV.")


def main(arguments: list[str]) -> int:
    """Mix the file that the JSON text in ``arguments`` names; tells as :func:`program.run` does."""
    return program.run(arguments, lambda request, voice: _mix(**json.loads(request)), "recording")


def _mix(source: str, target: str) -> dict:
    try:
        sound = bpy.data.sounds.load(source)
        rate, scene = int(sound.samplerate), bpy.context.scene
        if not rate:
            raise RuntimeError("Blender finds no sound in it")
        strip = compat.sequencer_strips(scene.sequence_editor_create()).new_sound("recording", source, 1, 1)
        scene.frame_start, scene.frame_end = 1, max(int(compat.strip_length(strip)), 1)
        options = {"container": "WAV", "codec": "PCM", "format": "F32", "mixrate": rate}
        bpy.ops.sound.mixdown(filepath=target, check_existing=False, **options)
    except RuntimeError as error:
        what = f"{source} is not a readable recording ({str(error).strip().rstrip('.')})."
        raise AudioUnreadable(what, "Export it again, for instance as WAV, FLAC or MP3.") from error
    return {"rate": rate}


def _started(arguments: list[str], said) -> subprocess.Popen:
    pipes = {"stdin": subprocess.PIPE, "stdout": said, "stderr": subprocess.DEVNULL}
    try:
        return subprocess.Popen(arguments, env={**os.environ, child.HELD: ""}, **pipes, **child.apart())
    except OSError as error:
        what = f"A second Blender, which decodes recordings here, cannot be started: {error.strerror}."
        raise WorkerFailed(what, "Save the recording as WAV.") from error
