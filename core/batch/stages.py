"""The steps of each stage of a batch, with their states, and running the unfinished ones with a crew."""

import shutil
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from os import PathLike
from pathlib import Path

from ..declaration import columns
from ..errors import S2agError
from ..model.checkpoint_metadata import locate, metadata_path
from ..settings import Documents, Settings, checkpoint_of, names_with
from .clip import CHARACTER_OUTPUTS, MODELS, MOTION_OUTPUTS, REQUESTED, SCENE_OUTPUTS, SEQUENCES, Clip, Unit, units
from .folder import Folder, Record, content_hash, digest
from .process_pool import PATIENCE, ProcessPool, Task
from .tasks import motion_paths

VERSION = 1
"""Increase it when the same inputs give other results: all steps are then repeated."""

_EXTRAS = sorted(
    name
    for name, one in {**columns(Settings), **columns(Documents)}.items()
    if one.kind in ("path", "document") and not one.words
)
"""Columns that name further files which a motion depends on."""


@dataclass(frozen=True)
class Step:
    """One task of a stage. ``facts`` is its result if it is done; ``key``, the hash of its inputs, and ``task`` are None while
    an earlier stage is missing.
    """

    stage: str
    name: str
    line: int
    record: Record
    key: str | None = None
    task: Task | None = None
    facts: dict | None = None

    @property
    def state(self) -> str:
        """``done``, ``failed`` (the last attempt with the same inputs), ``ready`` or ``waiting`` (for an earlier stage)."""
        if self.facts is not None:
            return "done"
        if self.key is None:
            return "waiting"
        failure = self.record.failure()
        return "failed" if failure and failure["key"] == self.key else "ready"


@dataclass(frozen=True)
class Batch:
    """Clips, the folder of their results, and the cache of word times (:class:`session.Session`)."""

    folder: Folder
    clips: Sequence[Clip]
    cache: str | None = None

    @cached_property
    def units(self) -> list[Unit]:
        """The clips grouped by scene."""
        return units(list(self.clips))

    @cached_property
    def _engine_facts(self) -> Callable[..., list]:
        return lru_cache(maxsize=None)(_engine_facts)

    def steps(self, stage: str, chosen: Sequence[Unit]) -> list[Step]:
        """Return every step of a stage for the chosen units, in its current state."""
        if stage == "synth":
            return [self._synth(clip) for unit in chosen for clip in unit.clips]
        filmed = [unit for unit in chosen if (unit.is_filmed if stage == "render" else "mp4" in unit.scene_outputs)]
        make = self._render if stage == "render" else self._encode
        return [make(unit, take) for unit in filmed for take in unit.numbers]

    def _synth(self, clip: Clip) -> Step:
        """Return the step that synthesises a clip's motions."""
        record = self.folder.record("synth", clip.name)
        words = names_with(words=True, kind="path")  # count by their content, below
        settings = {name: getattr(clip, name) for name in REQUESTED if name not in words}
        kinds = sorted({"npz", *clip.wanted(MOTION_OUTPUTS)})
        models = tuple(getattr(clip, name) for name in MODELS)
        is_written = any(getattr(clip, name) for name in names_with(alternatives="words"))
        engine = self._engine_facts(models, not clip.no_transcript, not (clip.no_transcript or is_written))
        extras = [_content(getattr(clip, name)) for name in _EXTRAS if getattr(clip, name) is not None]
        texts = [_content(getattr(clip, name)) for name in words]
        inputs = content_hash("synth", engine, settings, kinds, _content(clip.audio), *texts, *extras)
        paths = filter(None, (getattr(clip, name) for name in ("audio", *words, *_EXTRAS)))
        params = {"clip": clip.plain(), "cache": self.cache, "inputs": {str(path): _content(path) for path in paths}}
        return self._step("synth", clip.name, clip.line, record, inputs, params)

    def _render(self, unit: Unit, take: int) -> Step:
        """Return the step that applies a take to its characters in Blender and exports or renders it."""
        name, line = unit.take_name(take), unit.clips[0].line
        record = self.folder.record("render", name)
        synths = [self._synth(clip).facts for clip in unit.clips]
        motions = [facts["motions"][take] for facts in synths if facts is not None]
        if len(motions) < len(synths):
            return Step("render", name, line, record)
        inputs = content_hash(
            "render", motions, [_visible_facts(clip) for clip in unit.clips], unit.scene_outputs, self._look(unit)
        )
        step = self._step("render", name, line, record, inputs, {"job": self._job(unit, take, inputs)})
        complete = step.facts is None or self._has_images(unit, step, step.facts)
        return step if complete else replace(step, facts=None)

    def _encode(self, unit: Unit, take: int) -> Step:
        """Return the step that encodes a take's images as a film."""
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
        return self._step("encode", render.name, render.line, record, content_hash("encode", render.key), params)

    def _step(self, stage: str, name: str, line: int, record: Record, inputs: str, params: dict) -> Step:
        task = Task(stage, {**params, "folder": str(self.folder.root), "name": name, "key": inputs})
        return Step(stage, name, line, record, inputs, task, record.read(inputs))

    def _has_images(self, unit: Unit, step: Step, facts: dict) -> bool:
        """Return whether the rendered images still exist or are already encoded as a film."""
        if "mp4" not in unit.scene_outputs:
            return True
        images = self.folder.root / facts["images"]
        encoded = self.folder.record("encode", step.name).read(content_hash("encode", step.key)) is not None
        return encoded or (images.is_dir() and len(list(images.glob("*.png"))) >= facts["count"])

    def _look(self, unit: Unit) -> dict:
        """Return the render settings of a unit; None for those that its ``.blend`` defines."""
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

    def _job(self, unit: Unit, take: int, inputs: str) -> dict:
        """Return the job for Blender (:class:`s2ag_blender.render.job.Job`) with the paths of its outputs."""
        name, folder = unit.take_name(take), self.folder
        characters, places = [], {}
        for clip in unit.clips:
            files = []
            for kind in clip.wanted(CHARACTER_OUTPUTS):
                suffix = CHARACTER_OUTPUTS[kind]
                files.append(f"{clip.take_name(take)}{suffix}")
                places[files[-1]] = str(folder.result(kind, clip.take_name(take), suffix))
            characters.append({
                "motions": [str(motion_paths(folder, clip)[take])],
                "outputs": files,
                **{part: getattr(clip, part) for part in ("audio", "character", "gender", "armature", "delay")},
                **{part: getattr(clip, part) for part in ("map", "face_map", "seated")},
            })  # fmt: skip
        scene, sequences = [], []
        for kind in unit.scene_outputs:
            if kind in SEQUENCES or (kind == "mp4" and "frames" not in unit.scene_outputs):
                suffix = ".png" if kind == "mp4" else SCENE_OUTPUTS[kind]
                place = None if kind == "mp4" else str(folder.result(kind, name))
                sequences.append({"folder": str(folder.work(name, kind, inputs)), "suffix": suffix, "place": place})
            elif kind != "mp4":
                scene.append(f"{name}{SCENE_OUTPUTS[kind]}")
                places[scene[-1]] = str(folder.result(kind, name, SCENE_OUTPUTS[kind]))
        return {"performers": characters, "outputs": scene, "places": places, "sequences": sequences, **self._look(unit)}


def run_stage(
    batch: Batch,
    stage: str,
    chosen: Sequence[Unit],
    command: Sequence[str],
    jobs: int,
    tell: Callable[[str, float, int, int], None] = lambda stage, share, finished, total: None,
    patience: float = PATIENCE,
) -> list[tuple[Step, S2agError | None]]:
    """Run the unfinished steps of a stage with ``jobs`` processes of ``command``; return each with its error, or None.

    ``tell(stage, share, finished, total)`` receives progress, share in 0..1. Failures are also recorded in files.
    """
    steps = [step for step in batch.steps(stage, chosen) if step.state in ("ready", "failed")]
    tasks = [Task(step.task.method, step.task.params, step) for step in steps if step.task is not None]
    shares: dict[str, float] = {}
    results = []
    with closing(ProcessPool(command, jobs, patience).run(tasks)) as running:
        for task, outcome, share in running:
            shares[task.label.name] = share
            if outcome is not None:
                error = outcome if isinstance(outcome, S2agError) else None
                if error is not None:
                    task.label.record.fail(task.label.key, error)
                results.append((task.label, error))
            tell(stage, sum(shares.values()) / len(tasks), len(results), len(tasks))
    return results


def delete_leftovers(batch: Batch, chosen: Sequence[Unit]) -> None:
    """Delete images that are encoded as films, and those that were rendered with other settings."""
    for step in batch.steps("render", chosen):
        if step.key is not None:
            current = {batch.folder.work(step.name, kind, step.key) for kind in ("mp4", *SEQUENCES)}
            encoded = batch.folder.record("encode", step.name).read(content_hash("encode", step.key)) is not None
            for images in batch.folder.works(step.name):
                if encoded or images not in current:
                    shutil.rmtree(images, ignore_errors=True)


def _engine_facts(models: tuple[str | None, ...], has_words: bool, recognises: bool) -> list:
    """Return all inputs of a motion that are not in its row: versions of this program, and hashes of the models used."""
    from ..meaning import sentence, vocabulary
    from ..synthesis import postprocess
    from ..words import align, recognise

    named = dict(zip(MODELS, models, strict=True))
    weights = locate(checkpoint_of(named))
    used = [
        VERSION,
        postprocess.VERSION,
        _content(metadata_path(weights)),
        _content(weights),
        named["backend"],
        named["device"],
    ]
    if has_words:
        used += [align.VERSION, _content(named["vectors"]), _contents(named["aligner_model"]), named["language"]]
        used += [_content(vocabulary.PATH), _content(named["vocabulary"]), *map(_content, sentence.files(named["language"]))]
    if recognises:
        used += [recognise.VERSION, _contents(named["recogniser_model"])]
    return used


def _visible_facts(clip: Clip) -> dict:
    """Return the inputs of a clip's rendering, except its motion."""
    file = Path(clip.character)
    facts = {name: getattr(clip, name) for name in ("character", "gender", "armature", "delay")}
    facts |= {name: _content(getattr(clip, name)) for name in ("map", "face_map")}
    if clip.seated != "auto":  # as rows of before have it
        facts["seated"] = clip.seated
    if file.suffix:
        facts["character"] = _content(clip.character)
    return facts | {"name": clip.name, "audio": _content(clip.audio), "outputs": clip.wanted(CHARACTER_OUTPUTS)}


def _contents(folder: str | None) -> list[tuple[str, str | None]] | None:
    """Return names and digests of all files in a folder, recursively."""
    if not folder:
        return None
    files = sorted(Path(folder).rglob("*"))
    return [(path.relative_to(folder).as_posix(), _content(path)) for path in files if path.is_file()]


def _content(path: str | PathLike | None) -> str | None:
    """Return a file's digest, "unreadable" if it cannot be read: the stage that needs it reports that."""
    try:
        return digest(path)
    except OSError:
        return "unreadable"
