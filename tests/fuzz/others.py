"""Two processes at the same files, one of which stops at a moment and goes on, or is killed, when the other has been there.

They may be neighbours, in containers that see no process of each other under one host name, or on machines of one share.
"""

import contextlib
import ctypes
import json
import os
import platform
import signal
import socket
import sys
from collections.abc import Callable
from pathlib import Path

import trouble
from s2ag.core import files

PLACES = ("neighbour", "container", "machine")
ENDS = ("goes on", "goes on", "killed before", "killed after", "interrupted")
_NEWUTS, _NEWUSER, _NEWPID, _PDEATHSIG = 0x04000000, 0x10000000, 0x20000000, 1


def meet(job, place, found: dict, moment: int, later: int, calm: dict[str, str]) -> list[str]:
    """Let one process begin a job and stop, another do the same job, and the first one end as it is ``found`` to."""
    end, where = found["act"], found["what"]
    first = _Process(job, place.root, moment, where, "alpha")
    stopped = first.stopped()
    if stopped and end == "killed before":
        first.end(signal.SIGKILL)
    other = _Process(job, place.root, later if end == "killed after" else -1, where, "beta")
    if end == "killed after" and other.stopped():  # both are on the way
        other.end(signal.SIGKILL)
    told = {"the other": other.told()}
    if stopped and end in ("killed after", "interrupted"):
        first.end(signal.SIGKILL if end == "killed after" else signal.SIGTERM)
    told["the first"] = first.told()
    wrong = []
    for who, one in told.items():
        busy = found["job"] == "batch" and "Another s2ag batch is at work" in one["sentences"]
        if one["wrong"]:
            wrong.append(f"{who}: {one['wrong']}")
        elif one["ended"] and not (one["killed"] or busy or one["done"]):
            wrong.append(f"{who} said {one['sentences']}")
        elif not (one["ended"] or one["killed"]):
            wrong.append(f"{who} died")
    done = [who for who, one in told.items() if one["done"]]
    if done and place.made() != calm:
        wrong.append(f"{done} made {sorted(place.made().items() ^ calm.items())}")
    if where == "machine":  # whose files stay for a day, as nobody can know
        for path in place.root.rglob(f"{files.TEMPORARY_PREFIX}alpha@*"):
            if not first.killed and not path.name.endswith(".lock"):
                wrong.append(f"{path.name} was left")
            files.remove(path)
        for path in place.root.rglob(f"{files.TEMPORARY_PREFIX}beta@*"):
            files.remove(path)
    return wrong


class _Process:
    """A copy of this process that runs a job, stops at a moment, and tells how it ended."""

    def __init__(self, job, root: Path, moment: int, where: str, host: str):
        self.killed = False
        hears, self._says = os.pipe()
        self._hears, says = os.pipe()
        sys.stdout.flush()
        self.pid = os.fork()
        if not self.pid:
            with contextlib.suppress(BaseException):
                ctypes.CDLL(None).prctl(_PDEATHSIG, signal.SIGKILL)
                os.close(self._says)
                os.close(self._hears)
                _apart(where, host, lambda: _work(job, root, moment, says, hears))
            os._exit(1)
        os.close(hears)
        os.close(says)
        self._heard = b""

    def stopped(self) -> bool:
        """Wait until it has come to its moment, or to its end; return whether it has stopped."""
        self._hear(b"\n")
        return self._heard.startswith(b"stopped")

    def end(self, number: int) -> None:
        """Kill it where it stands, or let it go on into an interruption."""
        self.killed = True
        os.kill(int(self._heard.split()[1]), number)

    def told(self) -> dict:
        """Let it go on to its end, and return what it told of it."""
        with contextlib.suppress(BrokenPipeError):
            os.write(self._says, b"go\n")
        while self._hear(None):
            pass
        os.close(self._says)
        os.close(self._hears)
        os.waitpid(self.pid, 0)
        lines = [line for line in self._heard.splitlines() if line.startswith(b"{")]
        empty = {"done": False, "sentences": "", "wrong": "", "ended": False, "killed": self.killed}
        return empty | (json.loads(lines[0]) | {"ended": True} if lines else {})

    def _hear(self, until: bytes | None) -> bool:
        while until is None or until not in self._heard:
            more = os.read(self._hears, 1 << 16)
            if not more:
                return False
            self._heard += more
        return True


def _work(job, root: Path, moment: int, says: int, hears: int) -> None:
    """In the copy: run the job and tell how it ended."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    files._SWEPT.clear()  # as a new process, which has swept nothing yet
    number = os.readlink("/proc/self")  # /proc shows the ids that the parent knows

    def stop() -> None:
        os.write(says, f"stopped {number}\n".encode())
        os.read(hears, 3)

    with trouble.at_moment(root, moment, stop):
        told = trouble.outcome(job.run)
    with contextlib.suppress(BaseException):
        job.close()
    if "KeyboardInterrupt" in told.wrong:
        told.wrong, told.sentences = "", "interrupted"
        files.delete_unfinished()
    os.write(says, json.dumps(vars(told)).encode() + b"\n")
    os._exit(0)


def _apart(where: str, host: str, work: Callable[[], None]) -> None:
    """Do ``work`` in a place: as the first process of a new namespace, perhaps under another host name."""
    if where == "neighbour":
        return work()
    libc = ctypes.CDLL(None, use_errno=True)
    user = 0 if os.geteuid() == 0 else _NEWUSER
    if libc.unshare(user | _NEWPID | _NEWUTS):
        return work()  # not allowed here
    if where == "machine":
        libc.sethostname(host.encode(), len(host))
        assert socket.gethostname() == host
    platform._uname_cache = None  # as a new process
    child = os.fork()
    if child:
        os.waitpid(child, 0)
        os._exit(0)
    libc.prctl(_PDEATHSIG, signal.SIGKILL)
    work()


def are_possible() -> bool:
    """Whether processes can be put apart here."""
    child = os.fork()
    if not child:
        os._exit(bool(ctypes.CDLL(None).unshare((0 if os.geteuid() == 0 else _NEWUSER) | _NEWPID | _NEWUTS)))
    return os.waitpid(child, 0)[1] == 0
