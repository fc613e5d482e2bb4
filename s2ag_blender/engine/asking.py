"""A synthesis asked of the engine: what the engine that ships cannot read is decoded first, here in Blender."""

import time

from ...core.errors import Cancelled
from . import client, decoding


class Asked:
    """A :class:`client.Job` that may have to wait for its recording; has its ``stage``, ``value``, ``poll`` and ``outcome``.

    Raises :class:`WorkerFailed` if no engine can be started.
    """

    def __init__(self, engine: client.WorkerClient, params: dict):
        self._engine, self._params = engine, params
        self._job: client.Job | None = None
        self._decoding = decoding.Decoding(params["audio"]) if engine.ships and decoding.needed(params["audio"]) else None
        self.cancelled = False
        self.stage, self.value = "", 0.0
        if self._decoding is None:
            self._job = engine.request("synthesize", params)
        else:
            self.stage = self._decoding.stage

    def poll(self) -> bool:
        """Whether it ended; never waits. Raises what hinders a recording from being heard."""
        if self._job is None and self._decoding.poll():
            heard = self._decoding.outcome()
            if self.cancelled:
                raise Cancelled("Cancelled.")
            self._job = self._engine.request("synthesize", {**self._params, "audio": heard})
        if self._job is None:
            self.value = self._decoding.value
            return False
        done = self._job.poll()
        self.stage, self.value = self._job.stage, self._job.value
        return done

    def outcome(self) -> dict:
        """The engine's answer; raises the :class:`S2agError` that it ended with."""
        return self._job.outcome()

    def cancel(self) -> None:
        """Drop it, wherever it is."""
        self.cancelled = True
        if self._job is not None:
            self._engine.cancel(self._job)
        else:
            self._decoding.cancel()


def call(engine: client.WorkerClient, params: dict, progress=None) -> dict:
    """Ask and wait: the answer, or the :class:`S2agError` that it ended with."""
    if engine.ships and decoding.needed(params["audio"]):
        under_way = decoding.Decoding(params["audio"])
        try:
            while not under_way.poll():
                if progress:
                    progress(under_way.stage, under_way.value)
                time.sleep(client.PAUSE)
        finally:
            under_way.cancel()
        params = {**params, "audio": under_way.outcome()}
    return engine.call("synthesize", params, progress)
