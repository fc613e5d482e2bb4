"""The child process of a crew: runs one task after another until its parent ends. Also runs in Blender.

Each line of standard input is ``{"id", "method", "params"}``; the reply is ``progress`` events and one ``result`` or
``error`` with the same id, as in :mod:`protocol`. All other output is redirected to standard error.
"""

import os
import queue
import sys
import threading
from collections.abc import Callable, Mapping
from typing import NoReturn

from .. import crash_log
from ..errors import EngineMissing, OutputUnwritable, S2agError, UsageError
from ..files import delete_unfinished
from ..worker import protocol

Handler = Callable[[dict, Callable[[str, float], None]], dict]
"""Runs a task: takes its parameters and a progress function ``tell(stage, value)``, returns its result (JSON)."""


def serve(handlers: Mapping[str, Handler]) -> NoReturn:
    """Take over standard input and output, and serve ``handlers`` by name; exits the process at the end of the input."""
    requests, replies = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    sys.stdout.flush()
    os.dup2(2, 1)
    waiting: queue.SimpleQueue = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(requests, waiting), daemon=True).start()
    while True:
        _send(replies, _answer(protocol.decode(waiting.get()), handlers, replies))


def _listen(requests: int, waiting: queue.SimpleQueue) -> None:
    """Queue every line of input. At its end the parent is gone: exit at once, whatever the main thread is doing."""
    with os.fdopen(requests, "rb") as lines:
        for line in lines:
            waiting.put(line)
    delete_unfinished()
    os._exit(0)


def _answer(message: dict, handlers: Mapping[str, Handler], replies: int) -> dict:
    """Run one task and return the reply, which is an error for every exception."""
    number = message["id"]

    def tell(stage: str, value: float) -> None:
        _send(replies, {"id": number, "event": "progress", "stage": stage, "value": round(float(value), 4)})

    try:
        if message.get("method") not in handlers:
            raise UsageError(f"There is no task {message.get('method')!r}.", f"Tasks are {', '.join(handlers)}.")
        return {"id": number, "result": handlers[message["method"]](message["params"], tell)}
    except S2agError as error:
        return protocol.error_reply(number, error)
    except ModuleNotFoundError as error:
        return protocol.error_reply(number, EngineMissing.of(error))
    except OSError as error:
        what = f"{error.filename or 'A file'} failed: {error.strerror or error}."
        return protocol.error_reply(number, OutputUnwritable(what, "Check the path and the free space."))
    except Exception as error:
        what = f"{type(error).__name__}: {(str(error).strip().splitlines() or ['no message'])[0][:200]}"
        return protocol.error_reply(number, S2agError(what, crash_log.write_log(error), "Internal"))


def _send(replies: int, message: dict) -> None:
    """Write a message to the file descriptor, completely."""
    line = memoryview(protocol.encode(message))
    while line:
        line = line[os.write(replies, line) :]
