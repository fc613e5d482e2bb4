"""Keys motions on characters and writes files: ``python -m s2ag.s2ag_blender.render.job JOB.json``, in a process of its own.

The job is a JSON object with the fields of :class:`Job`; with a single performer it may have the fields of
:class:`Performer` itself. JSON lines on stdout report on it: ``progress`` (stage, value 0..1), then one ``result`` or
``error`` (kind, message, remedy). The exit status is 0, or 2 after an error."""

import contextlib
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import bpy
import numpy as np

from ...core import json_text
from ...core.errors import UsageError
from ...core.files import check_output
from ...core.motion import skeleton
from ...core.motion.motion import Motion
from .. import program
from ..characters.character import Character

RENDERED = (".mp4", ".png", ".exr")


@dataclass(frozen=True)
class Performer:
    """A character with its ``motions`` (``.npz`` paths; the last one becomes active) and ``audio`` or None.

    They begin ``delay`` seconds into the scene; ``seated`` is auto, off, on or a table's height in metres. ``map`` and
    ``face_map`` are paths or None, ``outputs`` are files of this character alone (.bvh, .fbx, .glb, .usd)."""

    motions: tuple[str, ...]
    audio: str | None = None
    character: str = "human"
    gender: str = "female"
    armature: str | None = None
    map: str | None = None
    face_map: str | None = None
    delay: float = 0.0
    seated: str = "auto"
    outputs: tuple[str, ...] = ()


@dataclass(frozen=True)
class Job:
    """A job. ``outputs`` are files of the scene, or of the first performer where the suffix is that of a character file.

    A stem with ``####`` is a series of numbered images; ``resume`` keeps existing ones. ``engine``, ``resolution``,
    ``samples`` and ``fps`` are the scene's own if None; ``frame`` of a still is the most expressive one if None."""

    performers: tuple[Performer, ...]
    outputs: tuple[str, ...] = ()
    start_frame: int = 1
    fps: float | None = None
    engine: str | None = "workbench"
    resolution: tuple[int, int] | None = (960, 540)
    percentage: int = 100
    samples: int | None = None
    transparent: bool = False
    frame: int | None = None
    resume: bool = False

    @classmethod
    def of(cls, content: dict) -> "Job":
        """Create a job from its JSON; raises TypeError for unknown fields."""
        content = dict(content)
        if "performers" not in content:
            own = {one.name for one in fields(Performer)} - {"outputs"}
            content["performers"] = [{name: content.pop(name) for name in own & set(content)}]
        performers = tuple(Performer(**_tuples(one)) for one in content.pop("performers"))
        return cls(performers, **_tuples(content))

    @classmethod
    def read(cls, path: str | Path) -> "Job":
        """Read a job file; raises :class:`UsageError`."""
        try:
            return cls.of(json_text.read(path))
        except (OSError, ValueError, TypeError, AttributeError) as error:
            raise UsageError(f"{path} is not a job: {error}", "Let s2ag animate write it.") from error


def main(arguments: list[str]) -> int:
    """Run the job file named by ``arguments``; return the exit status."""
    return program.run(arguments, lambda path, voice: perform(Job.read(path), voice))


def perform(job: Job, voice: program.EventWriter) -> dict:
    """Do the job in this Blender, whose open file is lost; return the ``result`` event's content. Raises S2agError."""
    from ...rigs import maps
    from ...rigs.faces import shapes
    from ..characters import loading
    from ..keys import apply
    from ..rig import facemaps
    from . import render, stage
    from .sound import add_sound

    for path in (*job.outputs, *(path for one in job.performers for path in one.outputs)):
        check_output(path)
    motions = [[Motion.load(path) for path in one.motions] for one in job.performers]
    if not motions or not all(motions):
        raise UsageError("The job names no motion.", "Give at least one .npz file.")
    maps_of = [maps.load(one.map) if one.map else None for one in job.performers]
    wanted = [(one.character, one.gender, one.armature, own) for one, own in zip(job.performers, maps_of, strict=True)]
    warnings: list[str] = []
    with voice.stage("character"):
        scene, characters, theirs = loading.build_scene(wanted)
        for one, character in zip(job.performers, characters, strict=True):
            if one.face_map:
                facemaps.store_face_map(character.armature, shapes.load(one.face_map))
        warnings += [sentence for character in characters for sentence in character.disarmed]
        if any(Path(path).suffix.lower() in RENDERED for path in job.outputs):
            render.require_engine(job.engine, scene)
        _set_rate(scene, job.fps)  # else that of the .blend or the .fbx, or Blender's 24
        apply.require_rate(scene)
    with voice.stage("keyframes"):
        spans, sounds = [], []
        for one, character, played in zip(job.performers, characters, motions, strict=True):
            start = job.start_frame + round(one.delay * scene.render.fps / scene.render.fps_base)
            spans.append(_key_motions(scene, character, played, start, one.seated, warnings))
            sounds += [add_sound(scene, one.audio, start).sound] if one.audio else []
        span = job.start_frame, max(end for _, end in spans)
    with voice.stage("stage"):
        if theirs:
            stage.add_missing_camera_and_light(scene, characters)
            if job.resolution:
                scene.render.resolution_x, scene.render.resolution_y = job.resolution
                scene.render.resolution_percentage = 100
        else:
            stage.set_up_scene(scene, characters, job.resolution or (960, 540), backdrop=not job.transparent)
    _set_range(scene, span, theirs)
    _spare_inputs([Path(path) for path in (*job.outputs, *(path for one in job.performers for path in one.outputs))])
    for path in job.outputs:
        _write(job, scene, characters[0], Path(path), span, sounds, motions[0][-1], voice)
    for one, character, own in zip(job.performers, characters, spans, strict=True):
        for path in one.outputs:
            _write(job, scene, character, Path(path), own, sounds, motions[0][-1], voice)
    fps = scene.render.fps / scene.render.fps_base
    outputs = [*job.outputs, *(path for one in job.performers for path in one.outputs)]
    return {"outputs": outputs, "warnings": warnings, "frames": list(span), "fps": fps, "seconds": voice.seconds}


def _spare_inputs(outputs: Sequence[Path]) -> None:
    """Raise :class:`UsageError` for an output that the open file reads: libraries, images, sounds, caches, fonts."""
    read = {Path(path).resolve() for path in bpy.utils.blend_paths(absolute=True, packed=True)}
    for path in outputs:
        if path.resolve() in read:
            raise UsageError(f"The output {path} is read by the scene.", "Give every output a name of its own.")


def expressive_frame(motion: Motion) -> int:
    """Return the row of ``motion`` that is most expressive in a still: hands high, away from the body, and slow."""
    joints = skeleton.canonical_to_blender(skeleton.to_positions(motion.directions))
    hands = joints[:, [skeleton.JOINTS.index(f"{side}_wrist") for side in ("left", "right")]]
    if len(hands) < 3:
        return 0
    lift = np.clip(hands[..., 2] - np.median(hands[..., 2]), -0.3, 0.3).sum(1)
    reach = np.linalg.norm(hands[..., :2], axis=-1).sum(1)
    speed = np.linalg.norm(np.gradient(hands, 1 / motion.fps, axis=0), axis=-1).sum(1)
    return int(np.argmax(lift + 0.6 * reach - 0.25 * speed))


def _key_motions(
    scene: bpy.types.Scene, character: Character, motions: Sequence[Motion], start: int, seated: str, warnings: list[str]
) -> tuple[int, int]:
    """Key each motion in its own action, the last one active; return its first and last frame."""
    from ...rigs.goals import Options
    from ..keys.apply import apply_motion

    options = Options(seated=seated.upper()) if seated in ("auto", "off", "on") else Options(seated="ON", table=float(seated))
    about = {"scene": scene, "mapping": character.mapping, "options": options, "report": warnings.append}
    for motion in motions:
        apply_motion(character.armature, motion, start, **about)
    fps = scene.render.fps / scene.render.fps_base
    return start, start + max(int(np.ceil((len(motions[-1].directions) - 1) * fps / motions[-1].fps - 1e-6)), 1)


def _write(
    job: Job, scene: bpy.types.Scene, character: Character, path: Path, span: tuple[int, int],
    sounds: Sequence[bpy.types.Sound], motion: Motion, voice: program.EventWriter
) -> None:  # fmt: skip
    """Write one output file by its suffix, limited to the frames ``span``; stills show the best frame of ``motion``."""
    from . import export, render

    kind, name = path.suffix.lower(), f"write {path.name}"
    size = job.percentage * scene.render.resolution_percentage // 100
    look = render.Look(job.engine, size, job.samples, job.transparent)
    with voice.stage(name):
        if kind == ".blend":
            with contextlib.ExitStack() as portable:
                for sound in sounds:
                    portable.enter_context(export.portable_sound(sound, path.parent))
                export.export(scene, character, path)
            return
        with _limit_range(scene, span):
            if "#" in path.stem and kind in (".png", ".exr"):
                render.images(scene, path, look, job.resume, lambda share: voice.progress(name, share))
            elif kind == ".mp4":
                render.film(scene, path, look, lambda share: voice.progress(name, share))
            elif kind == ".png":
                fps = scene.render.fps / scene.render.fps_base
                frame = span[0] + round(expressive_frame(motion) * fps / motion.fps) if job.frame is None else job.frame
                render.still(scene, path, frame, look)
            else:
                export.export(scene, character, path)


def _set_rate(scene: bpy.types.Scene, fps: float | None) -> None:
    if fps:
        scene.render.fps = max(round(fps), 1)
        scene.render.fps_base = scene.render.fps / fps


def _set_range(scene: bpy.types.Scene, span: tuple[int, int], theirs: bool) -> None:
    """Set the frame range: our own scene has the length of the motion, the user's (``theirs``) is only extended to it."""
    if not theirs:
        scene.frame_start = span[0]
        scene.frame_set(span[0])
    scene.frame_end = max(scene.frame_end, span[1]) if theirs else span[1]


@contextlib.contextmanager
def _limit_range(scene: bpy.types.Scene, span: tuple[int, int]) -> Iterator[None]:
    """Limit the scene to the frames ``span`` in a ``with`` block."""
    before = scene.frame_start, scene.frame_end
    scene.frame_start, scene.frame_end = span
    try:
        yield
    finally:
        scene.frame_start, scene.frame_end = before


def _tuples(content: dict) -> dict:
    return {key: tuple(value) if isinstance(value, list) else value for key, value in content.items()}


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
