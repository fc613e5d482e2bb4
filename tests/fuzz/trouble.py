"""What may happen to files, folders and processes at a moment of a run, and how it is seen whether the run ended well."""

import contextlib
import ctypes
import os
import resource
import shutil
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pairs
from s2ag.core.errors import S2agError

OF_FILES = ("delete", "empty", "half", "twice", "zeros", "other", "folder", "pipe", "loop", "closed", "moved", "touched")
OF_FOLDERS = ("delete", "file", "loop", "closed", "read-only", "moved", "emptied", "new")
_EVENTS = {
    *("open", "os.mkdir", "os.remove", "os.rename", "os.rmdir", "os.listdir", "os.scandir", "os.chmod", "os.truncate"),
    *("os.utime", "os.link", "os.symlink", "tempfile.mkstemp", "tempfile.mkdtemp", "shutil.rmtree", "glob.glob"),
}
"""Operations on files that Python tells of before it does them, with a path as first argument."""
_RLIMITS = {"size": resource.RLIMIT_FSIZE, "handles": resource.RLIMIT_NOFILE}


class _Moments:
    """The one hook of this process, which can never be taken out."""

    def __init__(self):
        self.root, self.at, self.count, self.do, self.on, self.added = "", -1, 0, lambda: None, False, False

    def __call__(self, event: str, given: tuple) -> None:
        if not self.on or event not in _EVENTS or not given:
            return
        path = os.fsdecode(given[0]) if isinstance(given[0], (str, bytes, os.PathLike)) else ""
        if path.startswith(self.root):
            self.count += 1
            if self.count == self.at:
                self.on = False
                self.do()
                self.on = True


MOMENTS = _Moments()


@contextlib.contextmanager
def at_moment(root: Path, moment: int, do: Callable[[], None]) -> Iterator[Callable[[], int]]:
    """Do something just before the ``moment``-th operation on files below ``root``; yield a function that counts them."""
    if not MOMENTS.added:
        sys.addaudithook(MOMENTS)
    MOMENTS.root, MOMENTS.at, MOMENTS.count, MOMENTS.do, MOMENTS.on, MOMENTS.added = str(root), moment, 0, do, True, True
    try:
        yield lambda: MOMENTS.count
    finally:
        MOMENTS.on = False


@dataclass
class Outcome:
    """Whether a job made its result, the sentences in which it ended otherwise, and what is wrong with them."""

    done: bool = False
    sentences: str = ""
    wrong: str = ""


def outcome(run: Callable[[], tuple[str, str] | None]) -> Outcome:
    """Run a job that returns None or its two sentences, or raises them."""
    try:
        told = run()
    except S2agError as error:
        told = error.message, error.remedy
    except BaseException:  # whatever else comes out is what is looked for
        return Outcome(wrong=traceback.format_exc(limit=-8))
    if told is None:
        return Outcome(done=True)
    good = all(text and text.isprintable() and len(text) < 2000 for text in told)
    ours = "The engine failed" in told[0] or "mistake in s2ag" in told[0]
    return Outcome(sentences=str(told), wrong="" if good and not ours else f"its sentences are {told}")


class Act:
    """Something that happens once and can be undone. ``changes`` says whether a result may differ by it."""

    def __init__(self, do: Callable[[], object], undo: Callable[[], object], changes: bool):
        self._do, self.undo, self.changes, self.happened = do, undo, changes, False

    def do(self) -> None:
        """Let it happen, if it can: a file may be gone by now."""
        self.happened = True
        with contextlib.suppress(OSError):
            self._do()


def act(place, found: dict) -> Act:
    """The trouble of a situation."""
    if found["kind"] == "limits":
        return _limit(found["what"], found["act"])
    if found["kind"] == "vanished":
        return _of_folder(place.folder(found["what"]), found["act"], found["what"] in ("in", "out", "home"))
    path = place.file(found["what"])
    return Act(lambda: _of_file(path, found["act"]), lambda: _open_again(path), changes=True)


def _limit(what: str, amount: int) -> Act:
    """Files may not grow beyond some bytes, as on a full disk, or no more than some may be open."""
    kind = _RLIMITS[what]
    before = resource.getrlimit(kind)

    def do() -> None:
        resource.setrlimit(kind, (amount if what == "size" else handles() + amount, before[1]))

    return Act(do, lambda: resource.setrlimit(kind, before), changes=False)


def _of_folder(path: Path, what: str, changes: bool) -> Act:
    aside = path.with_name(path.name + " aside")

    def do() -> None:
        if what == "closed":
            path.chmod(0)
        elif what == "read-only":
            path.chmod(0o500)
        elif what == "moved":
            path.rename(aside)
        elif what == "emptied":
            for one in path.iterdir():
                _remove(one)
        else:
            _remove(path)
            {"file": path.touch, "loop": lambda: path.symlink_to(path), "new": path.mkdir}.get(what, bool)()

    def undo() -> None:
        if path.is_dir() and not path.is_symlink():
            path.chmod(0o700)
        if aside.is_dir():
            _remove(path)
            aside.rename(path)

    return Act(do, undo, changes)


def _of_file(path: Path, what: str) -> None:
    data = path.read_bytes()
    if what == "delete":
        path.unlink()
    elif what in ("empty", "half", "twice", "zeros"):
        path.write_bytes({"empty": b"", "half": data[: len(data) // 2], "twice": 2 * data, "zeros": bytes(len(data))}[what])
    elif what == "other":  # as editors do: a new file in the place of the old one
        new = path.with_name("new")
        if path.suffix == ".wav":
            pairs.write_wav(new, np.random.default_rng(len(data)).normal(0, 0.1, 1200))
        else:
            new.write_bytes(data.replace(b"hello", b"you"))
        new.replace(path)
    elif what == "closed":
        path.chmod(0)
    elif what == "moved":
        path.rename(path.with_name("elsewhere"))
    elif what == "touched":
        path.touch()
    else:
        path.unlink()
        {"folder": path.mkdir, "pipe": lambda: os.mkfifo(path), "loop": lambda: path.symlink_to(path)}[what]()


def _open_again(path: Path) -> None:
    if path.exists() and not path.is_dir():
        path.chmod(0o600)


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        path.chmod(0o700)
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def handles() -> int:
    """How many files this process has open."""
    return len(os.listdir("/proc/self/fd"))


def threads(before: int) -> int:
    """How many threads there are, as soon as there are no more than before, or after some seconds."""
    end = time.monotonic() + 20
    while threading.active_count() > before and time.monotonic() < end:
        time.sleep(0.01)
    return threading.active_count()


def give_up_powers() -> None:
    """Obey permissions, which root does not: files may be owned, but not read or written against them."""
    if os.geteuid():
        return
    libc = ctypes.CDLL(None, use_errno=True)
    header, powers = (ctypes.c_uint32 * 2)(0x20080522, 0), (ctypes.c_uint32 * 6)()
    libc.capget(header, powers)
    powers[0] &= ~0b110  # of the effective ones: reading and searching, whatever the permissions say
    libc.capset(header, powers)
