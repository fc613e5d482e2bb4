"""One Blender kept alive for many clips: the task ``render`` of ``s2ag batch``, served to its crew."""

import os
from collections.abc import Callable, Collection
from dataclasses import replace
from pathlib import Path

from ...core import files
from ...core.batch import serving
from ...core.batch.folder import Folder, land
from .. import program
from . import job as jobs

FRAMES = "######"
"""Of the names of numbered images; core.batch.encode reads the same."""


def main(_arguments: list[str]) -> int:
    """Serve until the parent goes away."""
    return serving.serve({"render": render})


def render(params: dict, tell: Callable[[str], None]) -> dict:
    """``job``, ``folder``, ``name``, ``key``: files and images land, then the record, whose facts are returned.

    The job is one of :class:`job.Job` whose outputs are bare names, with ``places`` where they go and ``sequences``, each a
    ``folder`` that keeps images over a kill, their ``suffix``, and the ``place`` to which all go in the end, or None.
    """
    folder, name, content = Folder(params["folder"]), params["name"], dict(params["job"])
    places, sequences = content.pop("places"), content.pop("sequences")
    for sequence in sequences:
        os.makedirs(sequence["folder"], exist_ok=True)
    with folder.part() as part:
        job = jobs.Job.of({**content, "resume": True})
        performers = tuple(replace(one, outputs=_in(part, one.outputs)) for one in job.performers)
        numbered = tuple(os.path.join(one["folder"], FRAMES + one["suffix"]) for one in sequences)
        result = jobs.perform(replace(job, performers=performers, outputs=(*_in(part, job.outputs), *numbered)), _Teller(tell))
        for file, place in places.items():
            land(part / file, Path(place))
    landed = [Path(place) for place in places.values()]
    for sequence in sequences:
        if sequence["place"]:
            for left in Path(sequence["folder"]).glob(f"{files.MARK}*"):
                files.remove(left)
            land(Path(sequence["folder"]), Path(sequence["place"]))
            landed.append(Path(sequence["place"]))
    first, last = result["frames"]
    facts = {"first": first, "count": last - first + 1, "fps": result["fps"], "warnings": result["warnings"]}
    facts["images"] = _images(folder, sequences)
    folder.record("render", name).write(params["key"], landed, facts)
    return facts


def _in(part: Path, names: Collection[str]) -> tuple[str, ...]:
    return tuple(str(part / name) for name in names)


def _images(folder: Folder, sequences: list[dict]) -> str | None:
    """Where the pictures of the film are, relative to the batch."""
    pictures = [one["place"] or one["folder"] for one in sequences if one["suffix"] == ".png"]
    return Path(pictures[0]).relative_to(folder.root).as_posix() if pictures else None


class _Teller(program.Voice):
    """A job's voice that tells only how far it has come, most of which is rendering."""

    def __init__(self, tell: Callable[[str], None]):
        super().__init__(None)
        self._tell = tell

    def say(self, event: str, **content) -> None:
        if event == "progress" and content["stage"].startswith("write"):
            self._tell(content["stage"], content["value"])
