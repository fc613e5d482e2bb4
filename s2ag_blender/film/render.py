"""Films and stills of a scene, with any engine, without a display."""

import contextlib
import os
import re
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import bpy

from ...core.errors import BlenderUnavailable, OutputUnwritable, UsageError
from ...core.files import check_output, part_folder, whole_file
from .. import compat
from . import opengl, stage

ENGINES = ("workbench", "eevee", "cycles")
_FILM_SAMPLES = {"eevee": 16, "cycles": 16}
_STILL_SAMPLES = {"eevee": 32, "cycles": 48}
_STRETCH = 24
"""Frames rendered at a time: Blender goes on after an image that could not be written, and is stopped after these."""
_LITTLE = 1_000_000
"""Bytes; with less left it is the full disk that lost an image."""
_REMEDY = 'Render with the engine "cycles", which needs no OpenGL, or install a software one (Mesa: libegl1, libgl1-mesa-dri).'


def require_engine(engine: str | None, scene: bpy.types.Scene) -> None:
    """Raise :class:`UsageError` or :class:`BlenderUnavailable` unless ``engine`` (the scene's, if None) can render here."""
    if engine is not None and engine not in ENGINES:
        raise UsageError(f"There is no render engine {engine}.", f"Choose one of: {', '.join(ENGINES)}.")
    name = engine or scene.render.engine.removeprefix("BLENDER_").lower()
    if bpy.app.background and name != "cycles" and not opengl.is_available():
        raise BlenderUnavailable(f"The engine {name} needs OpenGL, and this machine offers none.", _REMEDY)


@dataclass(frozen=True)
class Look:
    """``engine`` is one of :data:`ENGINES`, or None for the scene's own with its own settings; ``percentage`` scales the
    resolution, ``samples`` are the engine's (a good choice if None; 1, 5, 8, 11, 16 or 32 of Workbench), ``transparent``
    leaves the background out.
    """

    engine: str | None = "workbench"
    percentage: int = 100
    samples: int | None = None
    transparent: bool = False


def film(
    scene: bpy.types.Scene,
    path: str | Path,
    look: Look = Look(),  # noqa: B008 - frozen
    progress: Callable[[float], None] = lambda share: None,
) -> None:
    """Render the scene's frame range to H.264 with the sequencer's sound as AAC in an ``.mp4``, whole or not at all.

    ``progress`` hears the share done after every frame. Raises :class:`BlenderUnavailable` where the engine
    gets no OpenGL context, :class:`OutputUnwritable` where the file cannot be written.
    """
    with whole_file(path) as temporary, _kept(scene):
        _engine(scene, look, _FILM_SAMPLES, antialias="FXAA")
        render = scene.render
        compat.set_video(render.image_settings)
        render.image_settings.color_mode = "RGB"
        coding = render.ffmpeg
        coding.format, coding.codec, coding.constant_rate_factor = "MPEG4", "H264", "HIGH"
        coding.ffmpeg_preset, coding.gopsize = "GOOD", 18
        coding.audio_codec, coding.audio_bitrate, coding.audio_channels = "AAC", 160, "MONO"
        for side in ("x", "y"):  # H.264 stores colour at half resolution
            even = getattr(render, f"resolution_{side}") * look.percentage // 100 // 2 * 2
            setattr(render, f"resolution_{side}", max(even, 2))
        render.resolution_percentage = 100
        render.use_file_extension = False
        render.filepath = compat.plain_path(temporary)
        total = scene.frame_end - scene.frame_start + 1
        with _handled(lambda current: progress((current.frame_current - scene.frame_start + 1) / total)):
            _run(animation=True)
        _check(temporary)


def images(
    scene: bpy.types.Scene,
    path: str | Path,
    look: Look = Look(),  # noqa: B008 - frozen
    resume: bool = False,
    progress: Callable[[float], None] = lambda share: None,
) -> None:
    """Render the scene's frame range to numbered images: ``shot.####.png`` (8 bit) or ``.exr`` (half floats, lossless).

    Every image lands whole; with ``resume`` those that are there are kept. Transparent images have an alpha channel. Errors
    are those of :func:`film`.
    """
    path = check_output(path)
    places = {frame: numbered(path, frame) for frame in range(scene.frame_start, scene.frame_end + 1)}
    missing = [frame for frame, place in places.items() if not (resume and place.is_file())]
    first, last, done = scene.frame_start, scene.frame_end, len(places) - len(missing)

    def landed(current, *_) -> None:
        nonlocal done
        file = Path(current.render.frame_path(frame=current.frame_current))
        _check(file)
        os.replace(file, places[current.frame_current])
        done += 1
        progress(done / len(places))

    with part_folder(path.parent) as folder, _kept(scene):
        _engine(scene, look, _FILM_SAMPLES, antialias="FXAA")
        compat.set_image(scene.render.image_settings, {".png": "PNG", ".exr": "OPEN_EXR"}[path.suffix.lower()])
        scene.render.image_settings.color_mode = "RGBA" if look.transparent else "RGB"
        scene.render.resolution_percentage = look.percentage
        scene.render.filepath = compat.plain_path(folder / ("######" + path.suffix.lower()))
        try:
            for scene.frame_start, scene.frame_end in _runs(missing):
                with _handled(landed):
                    _run(animation=True)
        finally:
            scene.frame_start, scene.frame_end = first, last
    if lost := sum(not place.is_file() for place in places.values()):
        message = f"{lost} of {len(places)} images in {path.parent} are gone: another program works there."
        raise OutputUnwritable(message, "Run it again when that one has ended.")


def numbered(path: Path, frame: int) -> Path:
    """The place of one frame: ``shot.0012.png`` for ``shot.####.png``."""
    return path.with_name(re.sub("#+", lambda found: f"{frame:0{len(found[0])}d}", path.name))


def still(scene: bpy.types.Scene, path: str | Path, frame: int, look: Look = Look()) -> None:  # noqa: B008 - frozen
    """Render one frame to a ``.png``, whole or not at all; errors as for :func:`film`."""
    before = scene.frame_current
    with whole_file(path) as temporary, _kept(scene):
        _engine(scene, look, _STILL_SAMPLES, antialias="16")
        compat.set_image(scene.render.image_settings)
        scene.render.image_settings.color_mode = "RGBA" if look.transparent else "RGB"
        scene.render.resolution_percentage = look.percentage
        scene.render.use_file_extension = False
        scene.render.filepath = compat.plain_path(temporary)
        scene.frame_set(frame)
        try:
            _run(write_still=True)
        finally:
            scene.frame_set(before)
        _check(temporary)


def _runs(frames: list[int]) -> list[tuple[int, int]]:
    """First and last of every stretch without a gap, :data:`_STRETCH` frames long at most."""
    starts = [frame for frame, before in zip(frames, [None, *frames], strict=False) if before is None or frame != before + 1]
    ends = [frame for frame, after in zip(frames, [*frames[1:], None], strict=False) if after is None or after != frame + 1]
    whole = zip(starts, ends, strict=True)
    return [(first, min(first + _STRETCH - 1, end)) for start, end in whole for first in range(start, end + 1, _STRETCH)]


def _engine(scene: bpy.types.Scene, look: Look, samples: dict, antialias: str) -> None:
    require_engine(look.engine, scene)
    scene.frame_step = 1
    if look.transparent:
        scene.render.film_transparent = True
    engine = look.engine
    if engine is None:
        return
    if engine == "workbench" and scene.render.engine != "BLENDER_WORKBENCH":
        stage.workbench(scene)  # a scene made for another engine has not been set up for this one
    scene.render.engine = {"workbench": "BLENDER_WORKBENCH", "eevee": compat.eevee(), "cycles": "CYCLES"}[engine]
    if engine == "workbench":
        scene.display.render_aa = {None: antialias, 1: "OFF"}.get(look.samples, str(look.samples))
    elif engine == "eevee":
        scene.eevee.taa_render_samples = look.samples or samples[engine]
    else:
        scene.cycles.device = "CPU"
        scene.cycles.samples = look.samples or samples[engine]
        scene.cycles.use_denoising = True


def _run(**how) -> None:
    try:
        bpy.ops.render.render(**how)
    except RuntimeError as error:
        raise BlenderUnavailable(f"Blender could not render: {str(error).strip().splitlines()[-1]}", _REMEDY) from error


def _check(path: Path) -> None:
    if not path.is_file() or not path.stat().st_size:
        if shutil.disk_usage(path.parent).free < _LITTLE:
            raise OutputUnwritable(f"{path} cannot be written: the disk is full.", "Free space or choose another folder.")
        raise BlenderUnavailable("Blender rendered nothing, most likely because it got no OpenGL context.", _REMEDY)


@contextlib.contextmanager
def _handled(landed: Callable):
    """Call ``landed(scene)`` whenever a frame has been written; what it raises is raised when rendering has ended."""
    failed = []

    def written(current, *_) -> None:
        try:
            if not failed:
                landed(current)
        except Exception as error:
            failed.append(error)

    bpy.app.handlers.render_write.append(written)
    try:
        yield
    finally:
        bpy.app.handlers.render_write.remove(written)
    if failed:
        raise failed[0]


@contextlib.contextmanager
def _kept(scene: bpy.types.Scene):
    """Give every setting back that rendering needs to change, so that a saved scene is the user's own."""
    render = scene.render
    owners = [
        (render, ("engine", "filepath", "use_file_extension", "film_transparent")),
        (scene, ("frame_step",)),
        (render, ("resolution_x", "resolution_y", "resolution_percentage")),
        (scene.display, ("render_aa",)),
        (scene.display.shading, ("light", "studio_light", "color_type")),
        (scene.display.shading, ("show_cavity", "show_shadows", "show_specular_highlight")),
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
