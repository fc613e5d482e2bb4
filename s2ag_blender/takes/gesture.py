"""What the panel does, as functions a script can call: ask the engine for gestures and key them on a character."""

import bpy

from ...core.errors import UsageError
from ...core.motion.motion import Motion
from ...core.settings import AFFECTS
from ..engine import asking, errors_log
from ..engine.client import WorkerClient
from ..engine.known import interpreter
from ..translations import told
from . import choices, sources

_engine: WorkerClient | None = None


def engine(context) -> WorkerClient:
    """The one warm engine of this Blender, started with the interpreter of the preferences when first asked something."""
    global _engine
    if _engine is None:
        _engine = WorkerClient(interpreter(context), log=errors_log.note)
    return _engine


def stop_engine() -> None:
    """End the engine's process, if there is one."""
    global _engine
    if _engine is not None:
        _engine.close()
        _engine = None


def request(settings, audio: str = "") -> dict:
    """The engine's parameters for a character's settings; ``audio`` is what it hears if that is not the named file.

    Raises :class:`UsageError` where something is not chosen.
    """
    audio = audio or bpy.path.abspath(settings.audio)
    if not audio:
        raise UsageError("No recording is chosen.", "Choose one in the panel.")
    params = {
        "audio": audio,
        "style": choices.expression(settings),
        "seed": settings.seed,
        "takes": settings.take_count,
        "intensity": slider(settings, "intensity"),
        "affect": {name: slider(settings, name) for name in AFFECTS},
        "rate": slider(settings, "rate"),
        "hand": slider(settings, "hand"),
        "meaning": slider(settings, "meaning"),
        "hands": slider(settings, "hands"),
        "stance": slider(settings, "stance"),
        "mirror": settings.mirror,
        "listen": settings.listen,
        **({"turn": settings.turn.strip()} if settings.turn.strip() and not settings.listen else {}),
        **_face(settings),
        **sources.words(settings, "" if settings.audio_source == "MIXDOWN" else audio),
    }
    if settings.checkpoint:
        params["checkpoint"] = bpy.path.abspath(settings.checkpoint)
    if settings.language.strip() and {"transcript", "text"} & set(params):
        params["language"] = settings.language.strip()
    return params


def _face(settings) -> dict:
    """The engine's parameters of a face, where one is wanted."""
    if not settings.face:
        return {}
    return {"face": slider(settings, "face_intensity"), "face_smoothness": slider(settings, "face_smoothness")}


def start(context, params: dict) -> asking.Asked:
    """Ask for gestures and return at once."""
    return asking.Asked(engine(context), params)


def cancel(job: asking.Asked | None) -> None:
    """Drop a job; nothing in the file has been touched."""
    if job is not None and _engine is not None:
        job.cancel()


def poll(job: asking.Asked, progress) -> dict | None:
    """The finished job's result with the paths of its motions, or None while it runs; raises the error it ended with."""
    if not job.poll():
        progress(job.stage, job.value)
        return None
    return _warned(job.outcome())


def call(context, params: dict, progress=None) -> dict:
    """Ask for gestures and wait: the headless way. The result has its motions loaded."""
    result = _warned(asking.call(engine(context), params, progress))
    return {**result, "motions": [Motion.load(path) for path in result["motions"]]}


def export(context, armature, path: str) -> None:
    """Write the character with what it plays as ``.bvh``, ``.fbx`` or ``.glb``, by the suffix of ``path``.

    Raises :class:`UsageError` for another suffix, :class:`OutputUnwritable` where writing fails.
    """
    from ..cast import cast
    from ..cast.character import Character
    from ..film import export

    export.export(context.scene, Character(armature, tuple(cast.meshes(armature))), path)


def file_name(armature) -> str:
    """What to call a file of what the character plays, without suffix: character and take."""
    from ..film import export

    name = export.called(armature).replace(" – ", " - ")
    return "".join(" " if letter in '<>:"/\\|?*' or not letter.isprintable() else letter for letter in name).strip(" .")


def add_character(name: str, gender: str = "female"):
    """Build ``human`` or ``mannequin`` in the current scene; returns its armature object, whose legs are ours to move."""
    if name == "human":
        from ..cast import human

        armature = human.build(gender=gender).armature
    else:
        from ..cast import mannequin

        armature = mannequin.build().armature
    armature.s2ag.stance = 1.0
    armature.s2ag.face = name == "human"
    return armature


def slider(settings, name: str) -> float:
    """A slider's value as it was set: Blender keeps 0.8 as 0.800000012."""
    return round(getattr(settings, name), 4)


def _warned(result: dict) -> dict:
    warnings = list(result.get("warnings", ()))
    if _engine is not None and _engine.inside:
        warnings.append(
            told(
                "No other program can be started here, so the engine runs inside Blender: windows answer late while it "
                "works, and words without times are spread over the speech. Choose a Python in the preferences, or take words "
                "with times."
            )
        )
    return {**result, "warnings": warnings}
