"""What goes on in this Blender: runs of the engine, one a character at a time, and what they have to tell. Never saved."""

import time

from ...core.errors import Cancelled, S2agError
from ..datablocks import ArmatureObject, Context
from ..engine import errors_log
from ..translations import told, told_error
from . import generate, gesture, stages

SLICE = 0.02
"""Seconds for which a run lays takes before Blender may draw again; one slice of one take can be longer."""


class Run:
    """One press of the button on its way: asks the engine, and finishes when its answer is here."""

    def __init__(self, context: Context, armature: ArmatureObject, planned: generate.Plan):
        self.planned = planned
        self.stage, self.value = "", 0.0
        self.cancelled = False
        self.count = len(planned.params.get("styles") or "1") * planned.params.get("takes", 1)
        self._job = gesture.start(context, planned.params)
        self._laying = None
        RUNS[armature.session_uid] = self

    @property
    def text(self) -> str:
        """What it is at, for people: which take of how many, where there are several."""
        if self.cancelled:
            return told("Cancelling")
        if self.count == 1 or not self.stage:
            return stages.shown(self.stage)
        if self._laying is None:
            return told("{stage}: {count} takes", stage=stages.shown(self.stage), count=self.count)
        number = min(int(self.value * self.count) + 1, self.count)
        return told("Writing take {number} of {count}", number=number, count=self.count)

    def step(self) -> generate.Outcome | None:
        """The outcome when it is done, None while it is not; never waits, and lays takes for no longer than a slice.

        Raises the :class:`S2agError` it ended with.
        """
        if self.cancelled:
            raise Cancelled("Cancelled.")
        if self._laying is not None:
            return self._lay()
        result = gesture.poll(self._job, self._note)
        if result is not None:
            self._laying, self.count = generate.finishing(self.planned, result), len(result["motions"])
            self.stage, self.value = stages.KEYING, 0.0
        return None

    def _lay(self) -> generate.Outcome | None:
        end = time.monotonic() + SLICE
        try:
            while time.monotonic() < end:
                self.value = next(self._laying)
        except StopIteration as done:
            return done.value
        return None

    def cancel(self) -> None:
        """Give up at once; the engine hears of it and drops what it was at."""
        self.cancelled = True
        gesture.cancel(self._job)
        if self._laying is not None:
            self._laying.close()  # takes what it has made with it

    def end(self) -> None:
        """Forget this run."""
        for uid in [uid for uid, run in RUNS.items() if run is self]:
            del RUNS[uid]

    def _note(self, stage: str, value: float) -> None:
        self.stage, self.value = stage, value


RUNS: dict[int, Run] = {}
"""Runs under way, by the character's number in this session."""
MESSAGES: dict[int, list[tuple[str, str]]] = {}
"""What a character's last run had to tell: texts and icons."""


def run_of(armature: ArmatureObject | None) -> Run | None:
    """The run under way for a character, or None."""
    return RUNS.get(armature.session_uid) if armature is not None else None


def messages(armature: ArmatureObject) -> list[tuple[str, str]]:
    """What the last run of a character had to tell."""
    return MESSAGES.get(armature.session_uid, [])


def fail(uid: int, error: S2agError) -> str:
    """Keep an error and its remedy for the panel, save the engine's log, and return both as one line."""
    lines = [(told(error.message), "ERROR")]
    if error.remedy:
        lines.append((told(error.remedy), "BLANK1"))
    MESSAGES[uid] = lines
    errors_log.save(error)
    return told_error(error)


def clear() -> None:
    """Cancel all runs and forget everything: another file has come."""
    for run in list(RUNS.values()):
        run.cancel()
    RUNS.clear()
    MESSAGES.clear()
