"""Films and stills of a scene, with any engine, without a display."""

import contextlib
from collections.abc import Callable
from pathlib import Path

import bpy

from ..core.errors import BlenderUnavailable, UsageError
from ..core.files import whole_file
from . import compat, opengl

ENGINES = ("workbench", "eevee", "cycles")
_FILM_SAMPLES = {"eevee": 16, "cycles": 16}
_STILL_SAMPLES = {"eevee": 32, "cycles": 48}
_REMEDY = 'Render with the engine "cycles", which needs no OpenGL, or install a software one (Mesa: libegl1, libgl1-mesa-dri).'


def require_engine(engine: str | None, scene) -> None:
    """Raise :class:`UsageError` or :class:`BlenderUnavailable` unless ``engine`` (the scene's, if None) can render here."""
    if engine is not None and engine not in ENGINES:
        raise UsageError(f"There is no render engine {engine}.", f"Choose one of: {', '.join(ENGINES)}.")
    name = engine or scene.render.engine.removeprefix("BLENDER_").lower()
    if bpy.app.background and name != "cycles" and not opengl.is_available():
        raise BlenderUnavailable(f"The engine {name} needs OpenGL, and this machine offers none.", _REMEDY)


def film(
    scene,
    path: str | Path,
    engine: str | None = "workbench",
    percentage: int = 100,
    progress: Callable[[float], None] = lambda share: None,
) -> None:
    """Render the scene's frame range to H.264 with the sequencer's sound as AAC in an ``.mp4``, whole or not at all.

    ``engine`` is one of :data:`ENGINES`, or None for the scene's own with its own settings. ``percentage`` scales the
    resolution. ``progress`` hears the share done after every frame. Raises :class:`BlenderUnavailable` where the engine
    gets no OpenGL context, :class:`OutputUnwritable` where the file cannot be written.
    """
    with whole_file(path) as temporary, _kept(scene):
        _engine(scene, engine, _FILM_SAMPLES, antialias="FXAA")
        render = scene.render
        compat.set_video(render.image_settings)
        render.image_settings.color_mode = "RGB"
        coding = render.ffmpeg
        coding.format, coding.codec, coding.constant_rate_factor = "MPEG4", "H264", "HIGH"
        coding.ffmpeg_preset, coding.gopsize = "GOOD", 18
        coding.audio_codec, coding.audio_bitrate, coding.audio_channels = "AAC", 160, "MONO"
        render.resolution_percentage = percentage
        for side in ("x", "y"):  # H.264 stores colour at half resolution
            even = getattr(render, f"resolution_{side}") * percentage // 100 // 2 * 2
            setattr(render, f"resolution_{side}", max(even, 2))
        render.resolution_percentage = 100
        render.use_file_extension = False
        render.filepath = str(temporary)
        with _counted(scene, progress):
            _run(animation=True)
        _check(temporary)


def still(scene, path: str | Path, frame: int, engine: str | None = "workbench", percentage: int = 100) -> None:
    """Render one frame to a ``.png``, whole or not at all; arguments and errors as for :func:`film`."""
    before = scene.frame_current
    with whole_file(path) as temporary, _kept(scene):
        _engine(scene, engine, _STILL_SAMPLES, antialias="16")
        compat.set_image(scene.render.image_settings)
        scene.render.resolution_percentage = percentage
        scene.render.use_file_extension = False
        scene.render.filepath = str(temporary)
        scene.frame_set(frame)
        try:
            _run(write_still=True)
        finally:
            scene.frame_set(before)
        _check(temporary)


def _engine(scene, engine: str | None, samples: dict, antialias: str) -> None:
    require_engine(engine, scene)
    if engine is None:
        return
    scene.render.engine = {"workbench": "BLENDER_WORKBENCH", "eevee": compat.eevee(), "cycles": "CYCLES"}[engine]
    if engine == "workbench":
        scene.display.render_aa = antialias
    elif engine == "eevee":
        scene.eevee.taa_render_samples = samples[engine]
    else:
        scene.cycles.device = "CPU"
        scene.cycles.samples = samples[engine]
        scene.cycles.use_denoising = True


def _run(**how) -> None:
    try:
        bpy.ops.render.render(**how)
    except RuntimeError as error:
        raise BlenderUnavailable(f"Blender could not render: {str(error).strip().splitlines()[-1]}", _REMEDY) from error


def _check(path: Path) -> None:
    if not path.is_file() or not path.stat().st_size:
        raise BlenderUnavailable("Blender rendered nothing, most likely because it got no OpenGL context.", _REMEDY)


@contextlib.contextmanager
def _counted(scene, progress):
    """Tell ``progress`` the share of the range done, whenever a frame has been written."""
    total = scene.frame_end - scene.frame_start + 1

    def written(current, *_):
        progress((current.frame_current - scene.frame_start + 1) / total)

    bpy.app.handlers.render_write.append(written)
    try:
        yield
    finally:
        bpy.app.handlers.render_write.remove(written)


@contextlib.contextmanager
def _kept(scene):
    """Give every setting back that rendering needs to change, so that a saved scene is the user's own."""
    render = scene.render
    owners = [
        (render, ("engine", "filepath", "use_file_extension", "resolution_x", "resolution_y", "resolution_percentage")),
        (scene.display, ("render_aa",)),
        (scene.eevee, ("taa_render_samples",)),
    ]
    if hasattr(scene, "cycles"):
        owners.append((scene.cycles, ("device", "samples", "use_denoising")))
    media = ("media_type",) if hasattr(render.image_settings, "media_type") else ()
    owners.append((render.image_settings, (*media, "file_format", "color_mode")))
    owners.append((render.ffmpeg, ("format", "codec", "constant_rate_factor", "ffmpeg_preset", "gopsize")))
    owners.append((render.ffmpeg, ("audio_codec", "audio_bitrate", "audio_channels")))
    values = [(owner, name, getattr(owner, name)) for owner, names in owners for name in names]
    try:
        yield
    finally:
        for owner, name, value in values:
            setattr(owner, name, value)
