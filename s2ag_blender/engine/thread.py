"""The engine in a thread of Blender's own process, for systems that let Blender start no other process."""

import contextlib
import importlib
import os
import queue
import threading

from ...core.worker import protocol


class Thread:
    """A worker with the interface of :class:`process.Process`. It cannot be killed; it stops when it next checks."""

    pid = None

    def __init__(self) -> None:
        # Imported by name, so that Blender's process imports the engine only where it must.
        worker = importlib.import_module("...core.worker.server", __package__)
        requests, self._requests = os.pipe()
        self._replies, replies = os.pipe()
        self.inbox: queue.SimpleQueue[bytes | str | None] = queue.SimpleQueue()
        self._outbox: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._worker = worker.Worker(requests, replies, alone=False)
        for work, pipes in ((self._work, (requests, replies)), (self._read, ()), (self._write, ())):
            threading.Thread(target=work, args=pipes, name="s2ag engine", daemon=True).start()

    def send(self, message: dict) -> None:
        """Queue a message of the protocol; never waits."""
        self._outbox.put(protocol.encode(message))

    def epitaph(self) -> str:
        """Return one sentence on how it ended."""
        return "The engine ended."

    def start_error(self) -> None:
        """Return None: it has been started."""

    def advice(self) -> str:
        """Return an empty text: there is no log with a remedy."""
        return ""

    def end(self) -> None:
        """Request a stop; a running request is dropped."""
        self._outbox.put(None)

    kill = end

    def _work(self, requests: int, replies: int) -> None:
        try:
            self._worker.run()
        finally:
            os.close(replies)
            os.close(requests)

    def _read(self) -> None:
        with os.fdopen(self._replies, "rb") as pipe:
            for line in pipe:
                self.inbox.put(line)
        self.inbox.put(None)

    def _write(self) -> None:
        with contextlib.suppress(OSError), os.fdopen(self._requests, "wb") as pipe:
            while (line := self._outbox.get()) is not None:
                pipe.write(line)
                pipe.flush()
