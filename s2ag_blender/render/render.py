"""Renders films, numbered images and stills of a scene, with any engine, without a display."""

import contextlib
import os
import re
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy

from ...core.errors import BlenderUnavailable, OutputUnwritable, UsageError
from ...core.files import atomic_file, check_output, temporary_folder
from .. import compat
from . import opengl, stage

ENGINES = ("workbench", "eevee", "cycles")
_FILM_SAMPLES = {"eevee": 16, "cycles": 16}
_STILL_SAMPLES = {"eevee": 32, "cycles": 48}
_FRAMES_PER_RUN = 24
"""Most frames per call of the renderer: Blender continues after an image that could not be written, until the call ends."""
_MIN_FREE_BYTES = 1_000_000
"""With fewer free bytes, a missing image is reported as a full disk."""
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
    """Render settings.

    ``engine`` is one of :data:`ENGINES`, or None for the scene's own with its own settings; ``percentage`` scales the
    resolution; ``samples`` are the engine's (None for a good choice; 1, 5, 8, 11, 16 or 32 with Workbench); ``transparent``
    leaves the background out."""

    engine: str | None = "workbench"
    percentage: int = 100
    samples: int | None = None
    transparent: bool = False


def film(
    scene: bpy.types.Scene,
    path: str | Path,
    look: Look = Look(),  # noqa: B008 - frozen
    progress: Callable[[float], None] = lambda share: None,
    viewport: bool = False,
) -> None:
    """Render the scene's frame range to H.264 with the sequencer's sound as AAC in an ``.mp4``, completely or not at all.

    ``progress`` is called with the share done (0..1) after every frame. ``viewport`` films what the context's 3D viewport shows
    instead of what the camera sees. Raises :class:`BlenderUnavailable` where the engine
    gets no OpenGL context, :class:`OutputUnwritable` where the file cannot be written."""
    with atomic_file(path) as temporary, _restore_settings(scene):
        if not viewport:
            _set_engine(scene, look, _FILM_SAMPLES, antialias="FXAA")
        render = scene.render
        compat.set_video(render.image_settings)
        render.image_settings.color_mode = "RGB"
        coding: Any = render.ffmpeg
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
        with _frame_handler(lambda current: progress((current.frame_current - scene.frame_start + 1) / total)):
            if viewport:
                bpy.ops.render.opengl(animation=True)
            else:
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

    Each image is written completely or not at all; ``resume`` keeps existing ones. Transparent images have an alpha channel.
    Raises the errors of :func:`film`."""
    path = check_output(path)
    places = {frame: numbered(path, frame) for frame in range(scene.frame_start, scene.frame_end + 1)}
    missing = [frame for frame, place in places.items() if not (resume and place.is_file())]
    first, last, done = scene.frame_start, scene.frame_end, len(places) - len(missing)

    def move_into_place(current: bpy.types.Scene) -> None:
        nonlocal done
        file = Path(current.render.frame_path(frame=current.frame_current))
        _check(file)
        os.replace(file, places[current.frame_current])
        done += 1
        progress(done / len(places))

    with temporary_folder(path.parent) as folder, _restore_settings(scene):
        _set_engine(scene, look, _FILM_SAMPLES, antialias="FXAA")
        compat.set_image(scene.render.image_settings, {".png": "PNG", ".exr": "OPEN_EXR"}[path.suffix.lower()])
        scene.render.image_settings.color_mode = "RGBA" if look.transparent else "RGB"
        scene.render.resolution_percentage = look.percentage
        scene.render.filepath = compat.plain_path(folder / ("######" + path.suffix.lower()))
        try:
            for scene.frame_start, scene.frame_end in _runs(missing):
                with _frame_handler(move_into_place):
                    _run(animation=True)
        finally:
            scene.frame_start, scene.frame_end = first, last
    if lost := sum(not place.is_file() for place in places.values()):
        message = f"{lost} of {len(places)} images in {path.parent} are gone: another program works there."
        raise OutputUnwritable(message, "Run it again when that one has ended.")


def numbered(path: Path, frame: int) -> Path:
    """Return the path of one frame: ``shot.0012.png`` for ``shot.####.png``."""
    return path.with_name(re.sub("#+", lambda match: f"{frame:0{len(match[0])}d}", path.name))


def still(scene: bpy.types.Scene, path: str | Path, frame: int, look: Look = Look()) -> None:  # noqa: B008 - frozen
    """Render one frame to a ``.png``, completely or not at all. Raises the errors of :func:`film`."""
    before = scene.frame_current
    with atomic_file(path) as temporary, _restore_settings(scene):
        _set_engine(scene, look, _STILL_SAMPLES, antialias="16")
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
    """Split ascending frames into gapless (first, last) runs of :data:`_FRAMES_PER_RUN` frames at most."""
    starts = [frame for frame, before in zip(frames, [None, *frames], strict=False) if before is None or frame != before + 1]
    ends = [frame for frame, after in zip(frames, [*frames[1:], None], strict=False) if after is None or after != frame + 1]
    size = _FRAMES_PER_RUN
    pairs = zip(starts, ends, strict=True)
    return [(first, min(first + size - 1, end)) for start, end in pairs for first in range(start, end + 1, size)]


def _set_engine(scene: Any, look: Look, samples: dict[str, int], antialias: str) -> None:
    """Set up the engine of a scene; ``samples`` by engine and ``antialias`` (of Workbench) are the defaults."""
    require_engine(look.engine, scene)
    scene.frame_step = 1
    if not _has_output(compat.compositing(scene)):
        scene.render.use_compositing = False  # Blender renders nothing where the compositor gives nothing
    if look.transparent:
        scene.render.film_transparent = True
    engine = look.engine
    if engine is None:
        return
    if engine == "workbench" and scene.render.engine != "BLENDER_WORKBENCH":
        stage.workbench(scene)  # a scene made for another engine has no settings for this one
    scene.render.engine = {"workbench": "BLENDER_WORKBENCH", "eevee": compat.eevee(), "cycles": "CYCLES"}[engine]
    if engine == "workbench":
        scene.display.render_aa = {None: antialias, 1: "OFF"}.get(look.samples, str(look.samples))
    elif engine == "eevee":
        scene.eevee.taa_render_samples = look.samples or samples[engine]
    else:
        scene.cycles.device = "CPU"
        scene.cycles.samples = look.samples or samples[engine]
        scene.cycles.use_denoising = True


def _has_output(tree: Any, outermost: bool = True) -> bool:
    """Return whether a compositor has an output that is not muted; file outputs of untrusted files are."""
    kinds = {"COMPOSITE", "OUTPUT_FILE"} | ({"GROUP_OUTPUT"} if outermost else set())
    nodes = [node for node in tree.nodes if not node.mute] if tree else []
    return any(node.type in kinds or (node.type == "GROUP" and _has_output(node.node_tree, False)) for node in nodes)


def _run(**arguments: Any) -> None:
    """Render; ``arguments`` are those of the operator. Raises :class:`BlenderUnavailable`."""
    try:
        bpy.ops.render.render(**arguments)
    except RuntimeError as error:
        raise BlenderUnavailable(f"Blender could not render: {str(error).strip().splitlines()[-1]}", _REMEDY) from error


def _check(path: Path) -> None:
    """Raise :class:`OutputUnwritable` or :class:`BlenderUnavailable` unless a rendered file exists and is not empty."""
    if not path.is_file() or not path.stat().st_size:
        if shutil.disk_usage(path.parent).free < _MIN_FREE_BYTES:
            raise OutputUnwritable(f"{path} cannot be written: the disk is full.", "Free space or choose another folder.")
        raise BlenderUnavailable("Blender rendered nothing, most likely because it got no OpenGL context.", _REMEDY)


@contextlib.contextmanager
def _frame_handler(callback: Callable[[bpy.types.Scene], None]) -> Iterator[None]:
    """Call ``callback(scene)`` after each written frame; its first error is raised when rendering has ended."""
    errors = []

    def written(current: bpy.types.Scene, *_: Any) -> None:
        try:
            if not errors:
                callback(current)
        except Exception as error:
            errors.append(error)

    bpy.app.handlers.render_write.append(written)
    try:
        yield
    finally:
        bpy.app.handlers.render_write.remove(written)
    if errors:
        raise errors[0]


@contextlib.contextmanager
def _restore_settings(scene: Any) -> Iterator[None]:
    """Restore all settings that rendering changes, so that a scene saved later has the user's own."""
    render = scene.render
    owners = [
        (render, ("engine", "filepath", "use_file_extension", "film_transparent", "use_compositing")),
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
