"""Jobs of the product, warm and in one process, with the folder that they work in."""

import contextlib
import hashlib
import io
import json
import os
import shutil
import tempfile
from pathlib import Path

import pairs
from s2ag.core import files
from s2ag.core.batch import folder_lock, manifest, stages, tasks
from s2ag.core.batch.folder import Folder
from s2ag.core.cli import main as command_line
from s2ag.core.worker import protocol
from s2ag.core.worker.server import Worker

WORDS = {
    "none": None, "times": (".json", '[["hello", 0.0, 0.05], ["there", 0.06, 0.1]]'), "text": (".txt", "hello there, *yes*")
}  # fmt: skip
DOCUMENT = {"format": 1, "curves": {"intensity": [[0, 1], [2, 2]]}}


class Place:
    """Folders ``in``, ``out``, ``temporary``, ``cache`` and ``home`` below a root, which is where the process works."""

    def __init__(self, root: Path):
        self.root, self.words, self.job = root, None, ""
        for name in ("in", "out", "temporary", "cache", "home"):
            self.folder(name).mkdir()
        tempfile.tempdir = str(self.folder("temporary"))

    def folder(self, name: str) -> Path:
        return self.root / name

    def file(self, name: str) -> Path:
        """The recording, its words (or none), the curves, or a result."""
        names = {"sound": "in/voice.wav", "words": f"in/words{self.words or '.txt'}", "document": "in/curves.json"}
        return self.root / names.get(name, "out/npz/voice.npz" if self.job == "batch" else "out/voice.npz")

    def set_up(self, found: dict, anew: bool = True) -> None:
        """Write what comes in; ``anew`` also removes all that was made."""
        files._SWEPT.clear()  # as a new process, which has swept nothing yet
        self.job = found["job"]
        for name in ("in", "out", "temporary", "cache", "home"):
            path = self.folder(name)
            if path.is_symlink() or path.is_file() or (anew and path.is_dir()) or name == "in":
                shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink(missing_ok=True)
            path.mkdir(exist_ok=True)
        for path in self.folder("out").rglob("*"):
            if path.suffix in (".npz", ".bvh") and (path.is_dir() or not path.is_file()):
                path.rmdir() if path.is_dir() and not path.is_symlink() else path.unlink()
        words = WORDS[found["words"]]
        self.words = words and words[0]
        pairs.write_wav(self.file("sound"), pairs.SOUNDS[found["sound"]](found["count"]))
        self.file("document").write_text(json.dumps(DOCUMENT), "utf-8")
        if words:
            self.file("words").write_text(words[1], "utf-8")
        os.chdir(self.folder("home"))

    def made(self) -> dict[str, str]:
        """Digest of every result."""
        found = [path for path in self.folder("out").rglob("*") if path.suffix in (".npz", ".bvh") and path.is_file()]
        found = [path for path in found if ".s2ag@" not in str(path)]
        return {str(path.relative_to(self.root)): hashlib.sha256(path.read_bytes()).hexdigest() for path in found}

    def left(self) -> list[str]:
        """Unfinished files of nobody, after a sweep."""
        files._SWEPT.clear()
        found = {path.parent for path in self.root.rglob(f"{files.TEMPORARY_PREFIX}*")}
        for folder in found:
            files.delete_leftovers(folder)
        return [f"{path.relative_to(self.root)} was left" for path in self.root.rglob(f"{files.TEMPORARY_PREFIX}*")]


class WorkerJob:
    """The engine behind Blender: one request over the protocol, its results in the worker's own folder or in ``out``."""

    def __init__(self, place: Place):
        self.place, (self._replies, end) = place, os.pipe()
        self.worker = Worker(0, end, alone=False)
        self._given = 0

    @property
    def session(self):
        return self.worker._open({})

    def run(self) -> tuple[str, str] | None:
        self._given += 1
        params = {"audio": str(self.place.file("sound")), "curves": DOCUMENT["curves"]}
        params |= {"transcript": str(self.place.file("words"))} if self.place.words else {}
        self.worker._serve({"id": self._given, "method": "synthesize", "params": params})
        answer, rest = {}, b""
        while answer.get("id") != self._given or "event" in answer:
            while b"\n" not in rest:
                rest += os.read(self._replies, 1 << 16)
            line, _, rest = rest.partition(b"\n")
            answer = protocol.decode(line)
        if error := answer.get("error"):
            return error["message"], error["remedy"]
        (path,) = answer["result"]["motions"]
        try:
            shutil.copy(path, self.place.file("result"))
        except OSError:  # a folder has gone after the answer
            return "The result cannot be taken over.", "It is not the engine's."
        return None

    def close(self) -> None:
        self.worker._folders.close()
        self.worker._folder = None


class CommandJob:
    """``s2ag synth`` with two outputs."""

    def __init__(self, place: Place):
        self.place = place

    def run(self) -> tuple[str, str] | None:
        said, result = io.StringIO(), self.place.file("result")
        command = ["synth", self.place.file("sound"), "--curves", self.place.file("document"), "-o", result]
        command += ["-o", result.with_suffix(".bvh"), *(("--transcript", self.place.file("words")) if self.place.words else ())]
        with contextlib.redirect_stderr(said):
            status = command_line.main([str(one) for one in command])
        if status == command_line.INTERRUPTED:
            return "It was interrupted.", "It was asked for."
        if status:
            what, _, remedy = said.getvalue().strip().rpartition(". ")
            return what.replace("\n", " "), remedy
        return None

    def close(self) -> None:
        pass


class BatchJob:
    """One clip of a batch, as the process of a pool makes it."""

    def __init__(self, place: Place):
        self.place, self._make = place, tasks.Synthesis()

    def run(self) -> tuple[str, str] | None:
        table = self.place.folder("home") / "clips.jsonl"
        row = {"name": "voice", "audio": str(self.place.file("sound")), "curves": str(self.place.file("document"))}
        row |= {"transcript": str(self.place.file("words"))} if self.place.words else {"no_transcript": True}
        try:
            table.write_text(json.dumps(row) + "\n", "utf-8")
        except OSError:
            return "The home is gone.", "It is not the job's."
        try:
            batch = stages.Batch(Folder(self.place.folder("out")), manifest.read(table)[0], str(self.place.folder("cache")))
            with folder_lock.lock_clips(batch.folder.root, ["synth"], ["voice"]):
                batch.folder.sweep()
                (step,) = batch.steps("synth", batch.units)
                if step.state != "done":
                    self._make(step.task.params, lambda stage, share: None)
        except OSError as error:  # which the command line and the pool's process tell as this
            return f"{error.filename or 'A file'} failed: {error.strerror or error}.", "Check the path and the free space."
        return None

    def close(self) -> None:
        pass


JOBS = {"worker": WorkerJob, "command": CommandJob, "batch": BatchJob}
