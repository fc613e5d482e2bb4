"""Functions behind the panel, which scripts can call, too: request gestures from the engine, export, add characters."""

import contextlib
import unicodedata
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy

from ...core.declaration import NUMBERS, Setting
from ...core.errors import UsageError
from ...core.files import TEMPORARY_PREFIX
from ...core.meaning import document
from ...core.motion.motion import Motion
from ...core.settings import Models, Settings, names_with, sliders, table
from ..datablocks import ArmatureObject, Context
from ..engine import errors_log, synthesis_job
from ..engine.client import WorkerClient
from ..engine.engine_state import interpreter
from ..translations import translate
from . import menu_items, sources

_engine: WorkerClient | None = None


def engine(context: Context) -> WorkerClient:
    """Return this Blender's one warm engine; it starts the interpreter of the preferences with its first request."""
    global _engine
    if _engine is None:
        _engine = WorkerClient(interpreter(context), log=errors_log.add_line)
    return _engine


def stop_engine() -> None:
    """End the engine's process, if there is one."""
    global _engine
    if _engine is not None:
        _engine.close()
        _engine = None


def request(settings: Any, audio: str = "") -> dict:
    """Return the engine's parameters for a character's settings; ``audio`` is what it hears if that is not the named file.

    Raises :class:`UsageError` where something is not chosen."""
    audio = audio or bpy.path.abspath(settings.audio)
    if not audio:
        raise UsageError("No recording is chosen.", "Choose one in the panel.")
    params: dict[str, Any] = {"audio": audio}
    for name, setting in table(Settings).items():
        if setting.parts:
            params[name] = {part: _value(settings, about) for part, about in table(setting.parts).items()}
        elif setting.label and not setting.words and _is_sent(settings, setting):
            params[name] = _value(settings, setting)
    params |= menu_items.style_parameter(settings)
    params |= sources.words_parameters(settings, "" if settings.audio_source == "MIXDOWN" else audio)
    models = {one.name: _value(settings, one) for one in sliders(Models)}
    if not set(names_with(alternatives="words")) & set(params):
        del models["language"]  # only written words have one
    return params | {name: value for name, value in models.items() if value}


def _is_sent(settings: Any, setting: Setting) -> bool:
    """Return whether a setting is sent to the engine: switched on, not made meaningless by another, no empty text."""
    is_on = not setting.switch or getattr(settings, setting.switch)
    return is_on and not (setting.hidden_by and getattr(settings, setting.hidden_by)) and _value(settings, setting) != ""


def _value(settings: Any, setting: Setting) -> Any:
    """Return the value of a setting as the engine takes it."""
    value = getattr(settings, setting.identifier)
    if setting.kind in NUMBERS:
        return round(value, 4)  # Blender stores 0.8 as 0.800000012
    if setting.kind == "document" and value:
        return document.load(bpy.path.abspath(value))
    if setting.kind == "path":
        return bpy.path.abspath(value)
    return value.strip() if setting.kind == "text" else value


def start(context: Context, params: dict) -> synthesis_job.SynthesisJob:
    """Request gestures and return at once."""
    return synthesis_job.SynthesisJob(engine(context), params)


def cancel(job: synthesis_job.SynthesisJob | None) -> None:
    """Cancel a job; it has changed nothing in the file."""
    if job is not None and _engine is not None:
        job.cancel()


def poll(job: synthesis_job.SynthesisJob, progress: Callable[[str, float], None]) -> dict | None:
    """Return the finished job's result with the paths of its motions, or None while it runs; raise the error it ended with."""
    if not job.poll():
        progress(job.stage, job.value)
        return None
    return _with_warning(job.outcome())


def call(context: Context, params: dict, progress: Callable[[str, float], None] | None = None) -> dict:
    """Request gestures and wait, as in background mode; return the result with its motions loaded."""
    result = _with_warning(synthesis_job.call(engine(context), params, progress))
    return {**result, "motions": [take_motion(path) for path in result["motions"]]}


def take_motion(path: str) -> Motion:
    """Return a motion that the engine left; a file in a temporary folder of its own has served then and goes."""
    motion = Motion.load(path)
    if Path(path).parent.name.startswith(TEMPORARY_PREFIX):
        Path(path).unlink(missing_ok=True)
    return motion


def export(context: Context, armature: ArmatureObject, path: str) -> None:
    """Write the character with what it plays (``.bvh``, ``.fbx``, ``.glb``), or a film (``.mp4``), by the suffix of ``path``.

    Raises :class:`UsageError` for another suffix, :class:`OutputUnwritable` where writing fails."""
    if path.lower().endswith(".mp4"):
        film(context, path)
        return
    from ..characters import loading
    from ..characters.character import Character
    from ..render import export

    export.export(context.scene, Character(armature, tuple(loading.meshes(armature))), path)


def film(context: Context, path: str) -> None:
    """Film the scene's frames with the sequencer's sound: what the 3D viewport shows, without one what the camera sees.

    Raises :class:`UsageError` without viewport and camera, and the errors of :func:`render.film`."""
    from ..render import render

    area, scene, manager = context.area, context.scene, context.window_manager
    region = next((one for one in area.regions if one.type == "WINDOW"), None) if area and area.type == "VIEW_3D" else None
    viewport = region is not None and not bpy.app.background
    if not viewport and scene.camera is None:
        raise UsageError("The scene has no camera.", "Add one, and let it look at the character.")
    manager.progress_begin(0, 100)
    frame = scene.frame_current
    try:
        with bpy.context.temp_override(region=region) if viewport else contextlib.nullcontext():
            render.film(scene, path, progress=lambda share: manager.progress_update(100 * share), viewport=viewport)
    finally:
        manager.progress_end()
        scene.frame_set(frame)


def file_name(armature: ArmatureObject) -> str:
    """Return a file name in ASCII, without suffix, for what the character plays: character, recording and take."""
    from ..render import export

    name = export.animation_name(armature).replace(" – ", " - ")
    plain = unicodedata.normalize("NFKD", name.replace("ß", "ss")).encode("ascii", "ignore").decode()
    plain = "".join(" " if letter in '<>:"/\\|?*' or not letter.isprintable() else letter for letter in plain)
    return plain.strip(" .-") or "gestures"


def add_character(name: str, gender: str = "female") -> ArmatureObject:
    """Build ``human`` or ``mannequin`` in the current scene, with its default settings; return its armature object."""
    if name == "human":
        from ..characters import human

        armature = human.build(gender=gender).armature
    else:
        from ..characters import mannequin

        armature = mannequin.build().armature
    for one in sliders(Settings):
        if one.by_character and one.switch:
            setattr(armature.s2ag, one.switch, bool(one.by_character(name)))
        elif one.by_character:
            setattr(armature.s2ag, one.identifier, one.by_character(name))
    return armature


def _with_warning(result: dict) -> dict:
    """Add a warning to a result where the engine runs in a thread of Blender."""
    warnings = list(result.get("warnings", ()))
    if _engine is not None and _engine.inside:
        warnings.append(
            translate(
                "No other program can be started here, so the engine runs inside Blender: windows answer late while it "
                "works, and words without times are spread over the speech. Choose a Python in the preferences, or take words "
                "with times."
            )
        )
    return {**result, "warnings": warnings}
