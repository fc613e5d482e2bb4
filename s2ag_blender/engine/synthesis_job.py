"""Synthesis requests to the engine; decodes recordings in Blender first, where the engine reads WAV files only."""

import time
from collections.abc import Callable

from ...core.errors import Cancelled
from . import client, decoding


class SynthesisJob:
    """A :class:`client.Job` whose recording may have to be decoded first; with ``stage``, ``value``, ``poll``, ``outcome``.

    Raises :class:`WorkerFailed` if no engine can be started."""

    def __init__(self, engine: client.WorkerClient, params: dict):
        self._engine, self._params = engine, params
        self._job: client.Job | None = None
        self._decoding = (
            decoding.Decoding(params["audio"]) if engine.ships and decoding.needs_decoding(params["audio"]) else None
        )
        self.cancelled = False
        self.stage, self.value = "", 0.0
        if self._decoding is None:
            self._job = engine.request("synthesize", params)
        else:
            self.stage = self._decoding.stage

    def poll(self) -> bool:
        """Return whether it has ended, without waiting; raise the :class:`S2agError` that decoding ended with."""
        if self._job is None and self._decoding is not None:
            if not self._decoding.poll():
                self.value = self._decoding.value
                return False
            wav = self._decoding.outcome()
            if self.cancelled:
                raise Cancelled("Cancelled.")
            self._job = self._engine.request("synthesize", {**self._params, "audio": wav})
        assert self._job is not None
        done = self._job.poll()
        self.stage, self.value = self._job.stage, self._job.value
        return done

    def outcome(self) -> dict:
        """Return the engine's result, once :meth:`poll` was true; raise the :class:`S2agError` that it ended with."""
        assert self._job is not None
        return self._job.outcome()

    def cancel(self) -> None:
        """Cancel decoding or synthesis."""
        self.cancelled = True
        if self._job is not None:
            self._engine.cancel(self._job)
        elif self._decoding is not None:
            self._decoding.cancel()


def call(engine: client.WorkerClient, params: dict, progress: Callable[[str, float], None] | None = None) -> dict:
    """Send a synthesis request, wait, and return its result; raise the :class:`S2agError` that it ended with."""
    if engine.ships and decoding.needs_decoding(params["audio"]):
        decoder = decoding.Decoding(params["audio"])
        try:
            while not decoder.poll():
                if progress:
                    progress(decoder.stage, decoder.value)
                time.sleep(client.PAUSE)
        finally:
            decoder.cancel()
        params = {**params, "audio": decoder.outcome()}
    return engine.call("synthesize", params, progress)
