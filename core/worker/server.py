"""The worker process that keeps the network in memory for Blender: ``python -m s2ag.core.worker.server``.

Reads requests as JSON lines from standard input and writes replies to standard output; standard error is the log. The main
thread serves one request at a time; a second thread reads, so that running requests can be cancelled and the worker ends
with its parent. Heavy modules are imported with the first request that needs the network."""

import contextlib
import os
import platform
import queue
import sys
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..declaration import KINDS
from ..errors import Cancelled, EngineMissing, OutputUnwritable, S2agError, UsageError
from ..files import check_output, scratch_folder
from ..settings import Models, Settings, checkpoint_of, names_with, table
from ..threads import set_passive_waiting
from ..version import VERSION
from . import protocol

if TYPE_CHECKING:
    from ..editing.director import Director
    from ..synthesis.request import Request, Result
    from ..synthesis.session import Session

GRACE = 5.0
"""Seconds that a running request gets to end once the parent is gone."""

_PARAMETERS = {"audio": str} | {name: KINDS[one.kind] for name, one in table(Settings).items() if one.parameter}
_MODELS = tuple(table(Models))


class Worker:
    """Serves the protocol between two file descriptors until end of file or ``shutdown``.

    If it is ``alone`` in its process, it exits the process when a running request does not end within :data:`GRACE` seconds."""

    def __init__(self, requests: int, replies: int, alone: bool = True) -> None:
        self._alone = alone
        self._requests = requests
        self._replies = replies
        self._waiting: queue.SimpleQueue[dict | None] = queue.SimpleQueue()
        self._cancelled: set[int | str] = set()
        self._ending = threading.Event()
        self._writing = threading.Lock()
        self._session: Session | None = None
        self._director: Director | None = None
        self._models: dict | None = None
        self._served = 0
        self._folders = contextlib.ExitStack()
        self._folder: Path | None = None

    def run(self) -> None:
        """Serve until the parent is gone or sends ``shutdown``."""
        threading.Thread(target=self._read, daemon=True).start()
        with self._folders:
            while (message := self._waiting.get()) is not None:
                try:
                    self._serve(message)
                except BrokenPipeError:
                    return

    def _read(self) -> None:
        """Read lines: handle cancellations and shutdown at once, queue requests for the main thread."""
        try:
            for line in _lines(self._requests):
                if line.strip() and not self._accept(line):
                    break
        finally:
            self._ending.set()
            self._waiting.put(None)
            if self._alone:
                watchdog = threading.Timer(GRACE, os._exit, (1,))
                watchdog.daemon = True
                watchdog.start()

    def _accept(self, line: bytes) -> bool:
        """Queue or handle one line; return False if it was ``shutdown``."""
        try:
            message = protocol.decode(line)
        except protocol.NotProtocol as error:
            self._send(
                protocol.error_reply(None, UsageError(f"A request was {error}.", "Send one JSON object a line.", "BadRequest"))
            )
            return True
        method, request = message.get("method"), message.get("id")
        if method == "shutdown":
            return False
        if not isinstance(request, (int, str)):
            self._send(protocol.error_reply(None, UsageError("A request has no id.", "Give it a number.", "BadRequest")))
        elif method == "cancel":
            self._cancelled.add(request)
        else:
            self._cancelled.discard(request)
            self._waiting.put(message)
        return True

    def _serve(self, message: dict) -> None:
        """Handle a request and send its result or its error."""
        request = message["id"]
        try:
            if self._is_cancelled(request):
                raise Cancelled("Cancelled.")
            handlers = {"hello": self._hello, "styles": self._styles, "synthesize": self._synthesize}
            handler = handlers.get(str(message.get("method")))
            if handler is None:
                raise UsageError(
                    f"There is no method {message.get('method')!r}.", f"Methods are {', '.join(protocol.METHODS)}."
                )
            params = message.get("params") or {}
            if not isinstance(params, dict):
                raise UsageError("The params of a request must be an object.", "Send names and values.")
            _check_models(params)
            self._prepare_aligner(message)
            reply = {"id": request, "result": handler(request, params)}
        except S2agError as error:
            reply = protocol.error_reply(request, error)
        except ModuleNotFoundError as error:
            reply = protocol.error_reply(request, EngineMissing.of(error))
        except BrokenPipeError:
            raise
        except OSError as error:
            what = f"{error.filename or 'A file'} failed: {error.strerror or error}."
            reply = protocol.error_reply(request, OutputUnwritable(what, "Check the path and the free space."))
        except Exception as error:
            traceback.print_exc()
            reply = protocol.error_reply(
                request, S2agError(f"The engine failed: {_first_line(error)}", "Its log has the details.", "Internal")
            )
        self._cancelled.discard(request)
        self._send(reply)
        self._prepare_aligner(message)

    def _prepare_aligner(self, message: dict) -> None:
        """Start an aligner in advance if a request has words, but never within Blender's own process."""
        params, synthesizes = message.get("params"), message.get("method") == "synthesize"
        named = isinstance(params, dict) and any(params.get(name) for name in names_with(alternatives="words"))
        if self._alone and synthesizes and named:
            from ..words import align

            align.start_child()

    def _hello(self, request: int | str, params: dict) -> dict:
        """Return versions and the checkpoint's description; with ``warm`` load the network now, not with the first request."""
        from ..model import checkpoint_metadata

        result: dict[str, Any] = {"version": VERSION, "protocol": protocol.VERSION, "python": platform.python_version()}
        try:
            result["checkpoint"] = checkpoint_metadata.describe(checkpoint_of(params))
        except S2agError as error:
            result["checkpoint"] = None
            result["warning"] = str(error)
        description = result["checkpoint"] or {"speakers": [], "controls": []}
        result["styles"], result["controls"] = description["speakers"], description["controls"]
        if params.get("warm"):
            self._open(params).warm_up()
        return result

    def _styles(self, request: int | str, params: dict) -> dict:
        """Return the styles and controls of a checkpoint."""
        from ..model import checkpoint_metadata

        description = checkpoint_metadata.describe(checkpoint_of(params))
        return {"styles": description["speakers"], "controls": description["controls"]}

    def _synthesize(self, request: int | str, params: dict) -> dict:
        """Generate ``takes`` motions, in each of the style expressions ``styles`` if there are any, and save them."""
        from ..synthesis.session import Request

        options = _check_params(params)
        first = Request(**options)
        every = first.in_styles(_styles(params)) or [first]
        folder = Path(params.get("output_dir") or self._own_folder())
        self._served += 1
        stem = Path(first.audio).stem[:60] if params.get("output_dir") else str(self._served)
        paths = [check_output(folder / f"{stem}-{take + 1}.npz") for take in range(len(first.identities) * len(every))]
        last = ("", -1.0)

        def progress(stage: str, value: float) -> None:
            nonlocal last
            if self._is_cancelled(request):
                raise Cancelled("Cancelled.")
            if stage != last[0] or value >= last[1] + 0.01:
                last = (stage, value)
                self._send({"id": request, "event": "progress", "stage": stage, "value": round(float(value), 3)})

        results = self._generate(params, every, progress, lambda: self._is_cancelled(request))
        result = results[0]
        for motion, path in zip([motion for one in results for motion in one.motions], paths, strict=True):
            motion.save(path)
        return {
            "motions": [str(path) for path in paths],
            "words": [list(word) for word in result.words],
            "warnings": list(result.warnings),
            "seconds": round(sum(result.seconds.values()), 4),
            "stages": {stage: round(seconds, 4) for stage, seconds in result.seconds.items()},
        }

    def _own_folder(self) -> Path:
        """Return the folder of results, a new one where others have deleted it."""
        if self._folder is None or not self._folder.is_dir():
            self._folder = self._folders.enter_context(scratch_folder())
        return self._folder

    def _generate(
        self, params: dict, every: list["Request"], progress: Callable[[str, float], None], cancelled: Callable[[], bool]
    ) -> list["Result"]:
        """Return the results of all requests; a single one may have ``edits`` (:mod:`editing.edits`), the first ``forgiven`` of
        which are left out where they cannot be done."""
        session, edits, forgiven = self._open(params), params.get("edits"), params.get("forgiven", 0)
        if not isinstance(forgiven, int):
            raise UsageError("The parameter forgiven is no number.", "Give how many edits may be left out.")
        if edits is None:
            return session.synthesize_all(every, progress, cancelled)
        if len(every) > 1:
            raise UsageError("Several styles cannot be directed at once.", "Ask for the one that the edits are about.")
        from ..editing.director import Director

        self._director = self._director or Director(session)
        return [self._director.direct(every[0], edits, progress, cancelled, forgiven)]

    def _open(self, params: dict) -> "Session":
        """Return the session with these models; only the last one is kept, to bound memory."""
        models = {name: params[name] for name in _MODELS if params.get(name)}
        if self._session is None or models != self._models:
            from ..synthesis.session import Session

            self._session = self._director = None
            self._session, self._models = Session(**models, remember=True), models
        return self._session

    def _is_cancelled(self, request: int | str) -> bool:
        return self._ending.is_set() or request in self._cancelled

    def _send(self, message: dict) -> None:
        line = memoryview(protocol.encode(message))
        with self._writing:
            while line:
                line = line[os.write(self._replies, line) :]


def _check_params(params: dict) -> dict[str, Any]:
    """Return the parameters of a synthesis request, without absent ones.

    Raises :class:`UsageError` for unknown names and for values of the wrong type."""
    unknown = set(params) - set(_PARAMETERS) - set(_MODELS) - {"output_dir", "styles", "edits", "forgiven"}
    if unknown:
        raise UsageError(f"There is no parameter {sorted(unknown)[0]!r}.", f"Parameters are {', '.join(_PARAMETERS)}.")
    options = {name: params[name] for name in _PARAMETERS if params.get(name) is not None}
    if "audio" not in options:
        raise UsageError("The request names no audio.", "Give the path of a recording.")
    for name, value in options.items():
        if not isinstance(value, _PARAMETERS[name]) or (isinstance(value, bool) and _PARAMETERS[name] is not bool):
            raise UsageError(f"The parameter {name} cannot be {value!r}.", "Give a value of the right kind.")
    return options


def _check_models(params: dict) -> None:
    """Raise :class:`UsageError` unless the parameters that name models are texts; most are paths."""
    for name in (*_MODELS, "output_dir"):
        if not isinstance(params.get(name) or "", str):
            raise UsageError(f"The parameter {name} cannot be {params[name]!r}.", "Give text.")


def _styles(params: dict) -> list[str | dict]:
    """Return the style expressions of a request for several styles, else an empty list."""
    styles = params.get("styles") or []
    if not isinstance(styles, list) or len(styles) > 64 or not all(isinstance(style, (str, dict)) for style in styles):
        raise UsageError(f"The parameter styles cannot be {styles!r}.", "Give a list of up to 64 style expressions.")
    return styles


def _lines(descriptor: int) -> Iterator[bytes]:
    """Yield lines of a file descriptor until end of file, without locks that could outlive the thread."""
    rest: list[bytes] = []
    size = 0
    while chunk := os.read(descriptor, 65536):
        *lines, last = chunk.split(b"\n")
        for line in lines:
            yield b"".join((*rest, line))
            rest, size = [], 0
        size += len(last)
        if size <= protocol.LARGEST:
            rest.append(last)
        elif size - len(last) <= protocol.LARGEST:  # too long for :func:`protocol.decode`, which must refuse it
            rest = [b" " * (protocol.LARGEST + 1)]
    if size:
        yield b"".join(rest)


def _first_line(error: Exception) -> str:
    """Return the class of an exception and the first line of its message."""
    text = str(error).strip().splitlines()
    return f"{type(error).__name__}: {text[0][:200]}" if text else f"{type(error).__name__}."


def main(_arguments: Sequence[str] = ()) -> int:
    """Serve the protocol on standard input and output, moved to where libraries and child processes cannot use them."""
    set_passive_waiting()
    requests, replies = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    os.close(nothing)
    try:
        Worker(requests, replies).run()
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    code = main()
    sys.stderr.flush()
    os._exit(code)  # threads of libraries may abort it while Python shuts down
