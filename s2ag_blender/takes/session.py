"""Current runs of the engine, at most one per character, and their messages. Never saved."""

import time
from collections.abc import Generator
from typing import Any, cast

import bpy

from ...core.errors import Cancelled, S2agError
from ..datablocks import ArmatureObject, Context, current_context
from ..engine import errors_log
from ..translations import translate, translate_error
from . import engine_requests, generate, stages, stored_settings, take_list

SLICE = 0.02
"""Seconds of keying before Blender may draw again; a single slice of a take can take longer."""


class SlicedRun:
    """A run of work in Blender's own process: ``slices`` yield the share done wherever Blender may draw."""

    def __init__(self, slices: Generator[float | None, None, Any], text: str = "") -> None:
        self.text, self.value = text, 0.0
        self._slices, self._cancelled = slices, False

    def step(self) -> Any:
        """Work for a slice; return the result when finished, else None. Raises what ended the work, or :class:`Cancelled`."""
        if self._cancelled:
            raise Cancelled("Cancelled.")
        end = time.monotonic() + SLICE
        try:
            while time.monotonic() < end:
                self.value = next(self._slices) or self.value
        except StopIteration as done:
            return done.value
        return None

    def cancel(self) -> None:
        """Stop the work at once."""
        self._cancelled = True
        self._slices.close()

    def end(self) -> None:
        """Close what the work has open."""
        self._slices.close()


class Run:
    """One run: requests motions from the engine and keys them when they arrive."""

    def __init__(self, context: Context, armature: ArmatureObject, planned: generate.Plan) -> None:
        self.planned = planned
        self.stage, self.value = "", 0.0
        self.cancelled = False
        self.count = planned.count
        self._job = engine_requests.start(context, planned.params)
        self._laying: SlicedRun | None = None
        RUNS[armature.session_uid] = self

    @property
    def text(self) -> str:
        """Return its progress for display: the stage, or which take of how many."""
        if self.cancelled:
            return translate("Cancelling")
        if self.count == 1 or not self.stage:
            return stages.shown(self.stage)
        if self._laying is None:
            return translate("{stage}: {count} takes", stage=stages.shown(self.stage), count=self.count)
        number = min(int(self.value * self.count) + 1, self.count)
        return translate("Writing take {number} of {count}", number=number, count=self.count)

    def step(self) -> generate.Outcome | None:
        """Poll the engine or key for a slice, without waiting; return the outcome when finished, else None.

        Raises the :class:`S2agError` with which the run ended."""
        if self.cancelled:
            raise Cancelled("Cancelled.")
        if self._laying is not None:
            outcome = self._laying.step()
            self.value = self._laying.value
            return outcome
        result = engine_requests.poll(self._job, self._note)
        if result is not None:
            self._laying, self.count = SlicedRun(generate.finish_in_slices(self.planned, result)), len(result["motions"])
            self.stage, self.value = stages.KEYING, 0.0
        return None

    def cancel(self) -> None:
        """Cancel at once, in the engine, too."""
        self.cancelled = True
        engine_requests.cancel(self._job)
        if self._laying is not None:
            self._laying.cancel()  # removes its actions

    def end(self) -> None:
        """Remove this run from the current ones."""
        for uid in [uid for uid, run in RUNS.items() if run is self]:
            del RUNS[uid]

    def _note(self, stage: str, value: float) -> None:
        self.stage, self.value = stage, value


RUNS: dict[int, Run] = {}
"""Current runs by the character's ``session_uid``."""
ERRORS: dict[int, tuple[tuple, list[tuple[str, str]]]] = {}
"""Why last runs failed, by ``session_uid``: what it was about (:func:`_cause`), and lines of (text, icon)."""


def run_of(armature: ArmatureObject | None) -> Run | None:
    """Return the current run of a character, or None."""
    return RUNS.get(armature.session_uid) if armature is not None else None


def messages(armature: ArmatureObject) -> list[tuple[str, str]]:
    """Return why a character's last run failed, as (text, icon), until that changes which it was about."""
    cause, lines = ERRORS.get(armature.session_uid, ((), []))
    return lines if lines and cause == _cause(armature) else []


def _cause(armature: ArmatureObject) -> tuple:
    """Return what an error can be about: the settings, the shown take and its markers, and what is chosen in the scene."""
    scene, take = current_context().scene, take_list.active(armature)
    marks = [] if take is None else [(one.name, one.frame, one.select) for one in take.action.pose_markers]
    chosen = [(one.name, one.frame) for one in scene.timeline_markers if one.select]
    preview = scene.use_preview_range and (scene.frame_preview_start, scene.frame_preview_end)
    target = armature.s2ag.target.name if armature.s2ag.target else ""
    return str(stored_settings.snapshot(armature.s2ag)), take and take.action.name, str(marks), str(chosen), preview, target


def fail(uid: int, error: S2agError) -> str:
    """Store an error and its remedy for the panel, save the engine's log, and return both as one line."""
    lines = [(translate(error.message), "ERROR")]
    if error.remedy:
        lines.append((translate(error.remedy), "BLANK1"))
    armature = next((one for one in bpy.data.objects if one.session_uid == uid), None)
    if armature is not None:
        ERRORS[uid] = _cause(cast(ArmatureObject, armature)), lines
    errors_log.save(error)
    return translate_error(error)


def clear() -> None:
    """Cancel all runs and drop all errors, because another file was opened."""
    for run in list(RUNS.values()):
        run.cancel()
    RUNS.clear()
    ERRORS.clear()
