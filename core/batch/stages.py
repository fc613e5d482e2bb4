"""What there is to do: the steps of each stage, which of them are done, and running the others with a crew."""

import shutil
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path

from ..errors import S2agError
from ..model.catalogue import DEFAULT, facts_path
from .clip import CHARACTER_OUTPUTS, MODELS, MOTION_OUTPUTS, REQUESTED, SCENE_OUTPUTS, SEQUENCES, Clip, Unit, units
from .crew import PATIENCE, Crew, Task
from .folder import Folder, Record, digest, key
from .work import motion_paths

VERSION = 1
"""Raise it when the same inputs give other results: everything is then made anew."""


@dataclass(frozen=True)
class Step:
    """One task of a stage. ``facts`` is what it gave if it is done; ``key`` is None while an earlier stage is missing."""

    stage: str
    name: str
    line: int
    record: Record
    key: str | None = None
    task: Task | None = None
    facts: dict | None = None

    @property
    def state(self) -> str:
        """``done``, ``failed`` (the last try, of this very content), ``ready`` or ``waiting`` for an earlier stage."""
        if self.facts is not None:
            return "done"
        if self.key is None:
            return "waiting"
        failure = self.record.failure()
        return "failed" if failure and failure["key"] == self.key else "ready"


@dataclass(frozen=True)
class Batch:
    """Clips, the folder they are made in, and where word times are kept (:class:`synthesis.Session`)."""

    folder: Folder
    clips: Sequence[Clip]
    cache: str | None = None

    @cached_property
    def units(self) -> list[Unit]:
        """The clips grouped by scene."""
        return units(list(self.clips))

    @cached_property
    def _engine(self) -> Callable[..., list]:
        return lru_cache(maxsize=None)(_engine)

    def steps(self, stage: str, chosen: Sequence[Unit]) -> list[Step]:
        """Every step of a stage for the chosen units, as things stand now."""
        if stage == "synth":
            return [self._synth(clip) for unit in chosen for clip in unit.clips]
        filmed = [unit for unit in chosen if (unit.is_filmed if stage == "render" else "mp4" in unit.scene_outputs)]
        make = self._render if stage == "render" else self._encode
        return [make(unit, take) for unit in filmed for take in range(unit.takes)]

    def _synth(self, clip: Clip) -> Step:
        record = self.folder.record("synth", clip.name)
        asked = {name: getattr(clip, name) for name in REQUESTED if name != "transcript"}  # which counts by its content
        kinds = sorted({"npz", *clip.wanted(MOTION_OUTPUTS)})
        models = tuple(getattr(clip, name) for name in MODELS)
        engine = self._engine(models, not clip.no_transcript, clip.recognise)
        directed = [_content(path) for path in (clip.edits, clip.curves, clip.hears, clip.rhubarb) if path is not None]
        made_of = key("synth", engine, asked, kinds, _content(clip.audio), _content(clip.transcript), *directed)
        params = {"clip": clip.plain(), "cache": self.cache}
        return self._step("synth", clip.name, clip.line, record, made_of, params)

    def _render(self, unit: Unit, take: int) -> Step:
        name, line = unit.take_name(take), unit.clips[0].line
        record = self.folder.record("render", name)
        synths = [self._synth(clip) for clip in unit.clips]
        if any(step.facts is None for step in synths):
            return Step("render", name, line, record)
        motions = [step.facts["motions"][take] for step in synths]
        made_of = key("render", motions, [_shown(clip) for clip in unit.clips], unit.scene_outputs, self._look(unit))
        step = self._step("render", name, line, record, made_of, {"job": self._job(unit, take, made_of)})
        complete = step.facts is None or self._has_images(unit, step)
        return step if complete else replace(step, facts=None)

    def _encode(self, unit: Unit, take: int) -> Step:
        render = self._render(unit, take)
        record = self.folder.record("encode", render.name)
        if render.facts is None:
            return Step("encode", render.name, render.line, record)
        facts = render.facts
        params = {
            "images": str(self.folder.root / facts["images"]),
            **{name: facts[name] for name in ("first", "count", "fps")},
            "sounds": [(clip.audio, clip.delay) for clip in unit.clips],
        }
        return self._step("encode", render.name, render.line, record, key("encode", render.key), params)

    def _step(self, stage: str, name: str, line: int, record: Record, made_of: str, params: dict) -> Step:
        task = Task(stage, {**params, "folder": str(self.folder.root), "name": name, "key": made_of})
        return Step(stage, name, line, record, made_of, task, record.read(made_of))

    def _has_images(self, unit: Unit, step: Step) -> bool:
        """Whether the images of the film are still there, or are a film already."""
        if "mp4" not in unit.scene_outputs:
            return True
        images = self.folder.root / step.facts["images"]
        encoded = self.folder.record("encode", step.name).read(key("encode", step.key)) is not None
        return encoded or (images.is_dir() and len(list(images.glob("*.png"))) >= step.facts["count"])

    def _look(self, unit: Unit) -> dict:
        """Engine, resolution and so on of a unit, None where its ``.blend`` decides."""
        first = unit.clips[0]
        look = first.look
        return {
            "fps": first.fps,
            "start_frame": first.start_frame,
            "engine": first.engine or (look.engine if look else None),
            "resolution": first.resolution or (look.resolution if look else None),
            "samples": look.samples if look and first.engine in (None, look.engine) else None,
            "transparent": bool(look and look.transparent),
        }

    def _job(self, unit: Unit, take: int, made_of: str) -> dict:
        """The job for Blender (:class:`s2ag_blender.film.job.Job`) and where its files go."""
        name, folder = unit.take_name(take), self.folder
        performers, places = [], {}
        for clip in unit.clips:
            files = []
            for kind in clip.wanted(CHARACTER_OUTPUTS):
                suffix = CHARACTER_OUTPUTS[kind]
                files.append(f"{clip.take_name(take)}{suffix}")
                places[files[-1]] = str(folder.result(kind, clip.take_name(take), suffix))
            performers.append({
                "motions": [str(motion_paths(folder, clip)[take])],
                "outputs": files,
                **{part: getattr(clip, part) for part in ("audio", "character", "gender", "armature", "delay")},
                **{part: getattr(clip, part) for part in ("map", "face_map")},
            })  # fmt: skip
        scene, sequences = [], []
        for kind in unit.scene_outputs:
            if kind in SEQUENCES or (kind == "mp4" and "frames" not in unit.scene_outputs):
                suffix = ".png" if kind == "mp4" else SCENE_OUTPUTS[kind]
                place = None if kind == "mp4" else str(folder.result(kind, name))
                sequences.append({"folder": str(folder.work(name, kind, made_of)), "suffix": suffix, "place": place})
            elif kind != "mp4":
                scene.append(f"{name}{SCENE_OUTPUTS[kind]}")
                places[scene[-1]] = str(folder.result(kind, name, SCENE_OUTPUTS[kind]))
        return {"performers": performers, "outputs": scene, "places": places, "sequences": sequences, **self._look(unit)}


def perform(
    batch: Batch,
    stage: str,
    chosen: Sequence[Unit],
    command: Sequence[str],
    jobs: int,
    tell: Callable[[str, float, int, int], None] = lambda *_: None,
    patience: float = PATIENCE,
) -> list[tuple[Step, S2agError | None]]:
    """Do what is left of a stage with ``jobs`` processes of ``command``; gives what was tried, with the error if it failed.

    ``tell(stage, share, finished, total)`` hears of progress, share in 0..1. Failures are on record when this returns.
    """
    steps = [step for step in batch.steps(stage, chosen) if step.state in ("ready", "failed")]
    tasks = [Task(step.task.method, step.task.params, step) for step in steps]
    shares: dict[str, float] = {}
    tried = []
    with closing(Crew(command, jobs, patience).run(tasks)) as running:
        for task, outcome, share in running:
            shares[task.label.name] = share
            if outcome is not None:
                error = outcome if isinstance(outcome, S2agError) else None
                if error is not None:
                    task.label.record.fail(task.label.key, error)
                tried.append((task.label, error))
            tell(stage, sum(shares.values()) / len(tasks), len(tried), len(tasks))
    return tried


def settle(batch: Batch, chosen: Sequence[Unit]) -> None:
    """Delete images of films that are encoded, and those that were rendered with other settings."""
    for step in batch.steps("render", chosen):
        if step.key is not None:
            current = {batch.folder.work(step.name, kind, step.key) for kind in ("mp4", *SEQUENCES)}
            encoded = batch.folder.record("encode", step.name).read(key("encode", step.key)) is not None
            for images in batch.folder.works(step.name):
                if encoded or images not in current:
                    shutil.rmtree(images, ignore_errors=True)


def _engine(models: tuple, has_words: bool, recognises: bool) -> list:
    """Everything that gestures depend on beside the row: this program, and the models that have a say in them."""
    from ..meaning import vocabulary
    from ..performance import finishing
    from ..words import align, recognise

    named = dict(zip(MODELS, models, strict=True))
    weights = Path(named["checkpoint"] or DEFAULT)
    used = [VERSION, finishing.VERSION, _content(facts_path(weights)), _content(weights), named["backend"], named["device"]]
    if has_words:
        used += [align.VERSION, _content(named["vectors"]), _contents(named["aligner_model"]), named["language"]]
        used += [_content(vocabulary.PATH), _content(named["vocabulary"])]
    if recognises:
        used += [recognise.VERSION, _contents(named["recogniser_model"])]
    return used


def _shown(clip: Clip) -> dict:
    """What of a clip is seen and heard beside its motion."""
    file = Path(clip.character)
    shown = {name: getattr(clip, name) for name in ("character", "gender", "armature", "delay")}
    shown |= {name: _content(getattr(clip, name)) for name in ("map", "face_map")}
    if file.suffix:
        shown["character"] = _content(clip.character)
    return shown | {"name": clip.name, "audio": _content(clip.audio), "outputs": clip.wanted(CHARACTER_OUTPUTS)}


def _contents(folder: str | None) -> list | None:
    """Names and digests of the files in a folder, and in folders within."""
    files = sorted(Path(folder).rglob("*")) if folder else ()
    return [(path.relative_to(folder).as_posix(), _content(path)) for path in files if path.is_file()] if folder else None


def _content(path: str | Path | None) -> str | None:
    """A file's digest; one that cannot be read has none, and the stage that needs it will say so."""
    try:
        return digest(path)
    except OSError:
        return "unreadable"
