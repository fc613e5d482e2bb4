"""Applies edits to a take that is a file: what it was made of is known from its provenance."""

from collections.abc import Callable, Sequence
from os import PathLike
from typing import Any

import numpy as np

from ..errors import UsageError
from ..motion.motion import Motion
from ..synthesis.session import Session
from ..synthesis.stages import Stages
from . import semantic_gestures
from .director import Director, documented
from .edits import TURNS, check, performing_order
from .provenance import request_from_meta
from .targets import State

_REMADE = ("move", "delete", "rest", "change", "add", "reroll")
"""Edits that a later change of style or feeling would undo; poses and places are fixed frames that it leaves."""


def edit_take(
    session: Session, motion: Motion, edits: Sequence[dict], audio: str | PathLike,
    progress: Callable[[str, float], None] = lambda stage, value: None, **words: Any
) -> tuple[Motion, list[str]]:  # fmt: skip
    """Apply edits to a ``motion`` of the recording ``audio``, which may have been edited before; return it with warnings.

    Earlier edits are kept; where a change of style or feeling performs their moments anew, they are done again. ``words`` are
    as in :func:`request_from_meta`. Raises :class:`UsageError` for edits that cannot be applied, and where recording or weights
    are not those of the take."""
    request, stages = request_from_meta(motion.meta, audio, **words), Stages(progress, lambda: False)
    if motion.meta.get("checkpoint") != session.checkpoint.hash:
        remedy = "Name those with --checkpoint."
        raise UsageError("The take was made by other weights, so phrases would not fit in.", remedy)
    director = Director(session)
    heard, _ = session.hear(request, stages)
    if motion.meta.get("audio") != heard.digest:
        raise UsageError("The take is of another recording.", "Name the one that it was made for.")
    made = check(motion.meta.get("edits", []))
    every = [*made, *check(edits)]
    state, new = State.of(motion).after(made), performing_order(every[len(made) :])
    new = [len(made) + number for number in new]
    turns, others = ([number for number in new if (every[number]["do"] in TURNS) == turn] for turn in (True, False))
    state = director.go_on(request, [("", state)], every, turns, stages)[-1][1]
    anew = [span for one in state.motion.meta.get("touched", [])[len(made) :] for span in one]
    lost = motion.meta.get("unmet", ())
    again = [number for number, edit in enumerate(made) if number not in lost and _lies_in(edit, anew, motion)]
    state = director.go_on(request, [("", state)], every, again + others, stages)[-1][1]
    if not every:
        return state.motion, list(state.warnings)
    touched = [*motion.meta.get("touched", []), *([] for _ in every)][: len(every)]
    return documented(state.motion, every, turns + again + others, touched), list(state.warnings)


def _lies_in(edit: dict, spans: Sequence[Sequence[float]], motion: Motion) -> bool:
    """Return whether what an edit made lies in spans of seconds that were performed anew since."""
    if edit["do"] not in _REMADE:
        return False
    if edit["do"] == "add" and "word" in edit:
        times = [semantic_gestures.word_time(motion.words, edit["word"], edit.get("nth", 1))]
    elif "from" in edit:
        return any(edit["from"] < stop and start < edit["to"] for start, stop in spans)
    else:
        times = np.atleast_1d(edit["to"] if "to" in edit else edit["at"])
    return any(start <= at <= stop for start, stop in spans for at in times)
