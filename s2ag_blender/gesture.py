"""What the panel does, as functions a script can call: ask the engine for gestures and key them on a character."""

import bpy

from ..core.errors import AudioUnreadable, UsageError
from ..core.motion import Motion
from ..core.styles import AFFECTS
from .client import Job, WorkerClient
from .preferences import interpreter

_engine: WorkerClient | None = None


def engine(context) -> WorkerClient:
    """The one warm engine of this Blender, started with the interpreter of the preferences when first asked something."""
    global _engine
    if _engine is None:
        _engine = WorkerClient(interpreter(context))
    return _engine


def stop_engine() -> None:
    """End the engine's process, if there is one."""
    global _engine
    if _engine is not None:
        _engine.close()
        _engine = None


def request(settings) -> dict:
    """The engine's parameters for a character's settings; raises :class:`UsageError` without a recording."""
    if not settings.audio:
        raise UsageError("No recording is chosen.", "Choose one in the panel.")
    params = {
        "audio": bpy.path.abspath(settings.audio),
        "style": settings.style,
        "seed": settings.seed,
        "intensity": settings.intensity,
        "affect": {name: _slider(settings, name) for name in AFFECTS},
        "rate": _slider(settings, "rate"),
        "hand": _slider(settings, "hand"),
        "mirror": settings.mirror,
    }
    if settings.transcript:
        params["transcript"] = bpy.path.abspath(settings.transcript)
    return params


def start(context, settings) -> Job:
    """Ask for gestures and return at once."""
    return engine(context).request("synthesize", request(settings))


def cancel(job: Job | None) -> None:
    """Ask the engine to drop a job; nothing in the file has been touched."""
    if job is not None and _engine is not None:
        _engine.cancel(job)


def poll(job: Job, progress) -> dict | None:
    """The finished job's result with its motions loaded, or None while it runs; raises the error it ended with."""
    if not job.poll():
        progress(job.stage, job.value)
        return None
    return _loaded(job.outcome())


def synthesize(context, settings, progress=None) -> dict:
    """Ask for gestures and wait: the headless way."""
    return _loaded(engine(context).call("synthesize", request(settings), progress))


def key(context, armature, result: dict) -> list[str]:
    """Key the first motion of ``result`` on ``armature`` and add the sound strip; returns warnings for the user."""
    from . import apply, sound

    settings = armature.s2ag
    warnings = list(result.get("warnings", ()))
    apply.apply_motion(
        armature, result["motions"][0], start_frame=settings.start_frame, scene=context.scene, report=warnings.append
    )
    if settings.add_sound:
        try:
            sound.add_sound(context.scene, bpy.path.abspath(settings.audio), settings.start_frame)
        except AudioUnreadable as error:  # the engine reads more formats than Blender's sound system
            warnings.append(f"The gestures are there, the sound strip is not: {error}")
    return warnings


def add_character(name: str, gender: str = "female"):
    """Build ``human`` or ``mannequin`` in the current scene; returns its armature object."""
    if name == "human":
        from . import human

        return human.build(gender=gender).armature
    from . import mannequin

    return mannequin.build().armature


def _slider(settings, name: str) -> float:
    """A slider's value as it was set: Blender keeps 0.8 as 0.800000012."""
    return round(getattr(settings, name), 4)


def _loaded(result: dict) -> dict:
    return {**result, "motions": [Motion.load(path) for path in result["motions"]]}
