"""The engine in a thread of Blender's own process, for systems that let Blender start no other. The face is a process's."""

import contextlib
import importlib
import os
import queue
import threading

from ...core.engine import protocol


class Thread:
    """A worker that cannot be killed, but is told to stop at its next look."""

    pid = None

    def __init__(self):
        # By name: what Blender's process imports holds nothing of the engine but where it must.
        worker = importlib.import_module("...core.engine.worker", __package__)
        requests, self._requests = os.pipe()
        self._replies, replies = os.pipe()
        self.inbox: queue.SimpleQueue = queue.SimpleQueue()
        self._outbox: queue.SimpleQueue = queue.SimpleQueue()
        self._worker = worker.Worker(requests, replies, alone=False)
        for work, ends in ((self._work, (requests, replies)), (self._hear, ()), (self._write, ())):
            threading.Thread(target=work, args=ends, name="s2ag engine", daemon=True).start()

    def send(self, message: dict) -> None:
        self._outbox.put(protocol.encode(message))

    def epitaph(self) -> str:
        """One sentence on how it ended."""
        return "The engine ended."

    def advice(self) -> str:
        return ""

    def end(self) -> None:
        """Ask it to stop; what it is at is dropped."""
        self._outbox.put(None)

    kill = end

    def _work(self, requests: int, replies: int) -> None:
        try:
            self._worker.run()
        finally:
            os.close(replies)
            os.close(requests)

    def _hear(self) -> None:
        with os.fdopen(self._replies, "rb") as pipe:
            for line in pipe:
                self.inbox.put(line)
        self.inbox.put(None)

    def _write(self) -> None:
        with contextlib.suppress(OSError), os.fdopen(self._requests, "wb") as pipe:
            while (line := self._outbox.get()) is not None:
                pipe.write(line)
                pipe.flush()
