"""Keeps one Blender alive for many clips: serves the task ``render`` of ``s2ag batch``."""

import os
from collections.abc import Callable, Collection
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...core import files
from ...core.batch import child_server
from ...core.batch.folder import Folder, move_to_place
from .. import program
from . import job as jobs

FRAMES = "######"
"""Frame number in the names of numbered images; core.batch.encode reads the same."""


def main(_arguments: list[str]) -> int:
    """Serve until the parent process ends."""
    return child_server.serve({"render": render})


def render(params: dict[str, Any], tell: Callable[[str, float], None]) -> dict[str, Any]:
    """Run a job and move its files into place, then write its record; return the record's facts.

    ``params`` are ``job``, ``folder``, ``name``, ``key``. The job is one of :class:`job.Job` whose outputs are bare names,
    with ``places`` where they go and ``sequences``: each a ``folder`` that keeps images if the process is killed, their
    ``suffix``, and the final ``place`` of the folder, or None.
    """
    folder, name, content = Folder(params["folder"]), params["name"], dict(params["job"])
    places, sequences = content.pop("places"), content.pop("sequences")
    for sequence in sequences:
        os.makedirs(sequence["folder"], exist_ok=True)
    with folder.part() as part:
        job = jobs.Job.of({**content, "resume": True})
        performers = tuple(replace(one, outputs=_paths_in(part, one.outputs)) for one in job.performers)
        numbered = tuple(os.path.join(one["folder"], FRAMES + one["suffix"]) for one in sequences)
        outputs = (*_paths_in(part, job.outputs), *numbered)
        result = jobs.perform(replace(job, performers=performers, outputs=outputs), _RenderProgress(tell))
        for file, place in places.items():
            move_to_place(part / file, Path(place))
    written = [Path(place) for place in places.values()]
    for sequence in sequences:
        if sequence["place"]:
            for left in Path(sequence["folder"]).glob(f"{files.TEMPORARY_PREFIX}*"):
                files.remove(left)
            move_to_place(Path(sequence["folder"]), Path(sequence["place"]))
            written.append(Path(sequence["place"]))
    first, last = result["frames"]
    facts = {"first": first, "count": last - first + 1, "fps": result["fps"], "warnings": result["warnings"]}
    facts["images"] = _images(folder, sequences)
    folder.record("render", name).write(params["key"], written, facts)
    return facts


def _paths_in(part: Path, names: Collection[str]) -> tuple[str, ...]:
    return tuple(str(part / name) for name in names)


def _images(folder: Folder, sequences: list[dict]) -> str | None:
    """Return the folder of the film's images, relative to the batch."""
    pictures = [one["place"] or one["folder"] for one in sequences if one["suffix"] == ".png"]
    return Path(pictures[0]).relative_to(folder.root).as_posix() if pictures else None


class _RenderProgress(program.EventWriter):
    """A job's voice that passes on only the progress of writing files, which is mostly rendering."""

    def __init__(self, tell: Callable[[str, float], None]) -> None:
        super().__init__(lambda text: None)
        self._tell = tell

    def say(self, event: str, **content: Any) -> None:
        if event == "progress" and content["stage"].startswith("write"):
            self._tell(content["stage"], content["value"])
