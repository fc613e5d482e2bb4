"""Applies an animator's edits to a take, one after the other, by regenerating the phrase around each.

Frames outside the spans of an edit stay equal to the bit. Inside, the generator leads from the poses before to those after,
and through the core of the requested gesture; the best of several seeds is used, judged by the time, hand and size of the
stroke and by how sudden the joins are.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from os import PathLike
from typing import Any

import numpy as np

from ..errors import UsageError
from ..motion import rhubarb
from ..motion.motion import Motion
from ..synthesis.request import Request, Result
from ..synthesis.session import Session
from ..synthesis.session_cache import recording_key
from ..synthesis.stages import Stages
from . import edit_actions
from .edits import check
from .edits import of as edits_of
from .provenance import request_from_meta
from .regeneration import Regenerator
from .targets import State

_MAX_TAKES = 4
"""Takes whose states after each edit are cached."""


class Director:
    """Edits takes of a session.

    It caches the states of the last few takes after each of their edits, so that a further edit costs only itself.
    """

    def __init__(self, session: Session):
        session.remember()
        self.session = session
        self._states: dict[str, list[tuple[str, State]]] = {}

    def direct(
        self,
        request: Request,
        edits: Sequence[dict],
        progress: Callable[[str, float], None] = lambda stage, value: None,
        cancelled: Callable[[], bool] = lambda: False,
        forgiven: int = 0,
    ) -> Result:
        """Return the take of a request after ``edits`` (:mod:`edits`), with warnings on what could not be achieved.

        The same request, edits and checkpoint give the same motion. Of the first ``forgiven`` edits those that cannot be
        applied are passed over with a warning; their numbers, from 0, are ``meta["unmet"]``. Raises what
        :meth:`Session.synthesize` raises, and :class:`UsageError` for other edits that cannot be applied, and if the request
        is for several takes.
        """
        if (count := len(request.identities)) != 1:
            raise UsageError(f"{count} takes cannot be directed at once.", "Ask for the one that the edits are about.")
        edits, key = check(edits), _key(request)
        states = self._states.pop(key, [])
        stages = Stages(progress, cancelled)
        if not states:
            result = self.session.synthesize(request, progress, cancelled)
            states = [("", State.of(result.motions[0], result.warnings))]
        self._states[key] = states = self._continue(request, states, edits, stages, forgiven)
        for old in list(self._states)[:-_MAX_TAKES]:
            del self._states[old]
        state = states[-1][1]
        heard, performers = self.session.hear(request, stages)
        return Result([state.motion], heard.words, list(state.warnings), dict(stages.seconds), performers.own)

    def edit(
        self,
        motion: Motion,
        edits: Sequence[dict],
        audio: str | PathLike,
        progress: Callable[[str, float], None] = lambda stage, value: None,
        **words: Any,
    ) -> tuple[Motion, list[str]]:
        """Apply edits to a ``motion`` of the recording ``audio``, which may have been edited before; return it with warnings.

        Style changes, poses and hand places of earlier edits, known from its provenance, are kept; ``words`` are as in
        :func:`provenance.request_from_meta`. Raises :class:`UsageError` for edits that cannot be applied, and where recording
        or weights are not those of the take.
        """
        request, stages = request_from_meta(motion.meta, audio, **words), Stages(progress, lambda: False)
        if motion.meta.get("checkpoint") != self.session.checkpoint.hash:
            remedy = "Name those with --checkpoint."
            raise UsageError("The take was made by other weights, so phrases would not fit in.", remedy)
        heard, _ = self.session.hear(request, stages)
        if motion.meta.get("audio") != heard.digest:
            raise UsageError("The take is of another recording.", "Name the one that it was made for.")
        state = State.of(motion).after(check(motion.meta.get("edits", [])))
        state = self._continue(request, [("", state)], check(edits), stages)[-1][1]
        return state.motion, list(state.warnings)

    def _continue(
        self, request: Request, cached: list[tuple[str, State]], edits: list[dict], stages: Stages, forgiven: int = 0
    ) -> list[tuple[str, State]]:
        """Return the states after each edit, each with its edit as JSON, reusing ``cached`` ones of the same first edits."""
        same = 0
        texts = [json.dumps(edit, sort_keys=True) for edit in edits]
        while same < len(texts) and same + 1 < len(cached) and cached[same + 1][0] == texts[same]:
            same += 1
        states = cached[: same + 1]
        if same < len(edits):
            filler = Regenerator(self.session, request, stages)
            for number in range(same, len(edits)):
                state = edit_actions.apply_edit(filler, states[-1][1], edits[number], number + 1, number < forgiven)
                states.append((texts[number], state))
        return states


def perform(
    session: Session, request: Request, documents: Any, progress: Callable[[str, float], None] = lambda stage, value: None
) -> Result:
    """Synthesise a request and apply the ``documents`` to it, anything that names them as :class:`settings.Documents` does: the
    options of a command, a row of a manifest.
    """
    edits, cues = edits_of(documents), getattr(documents, "rhubarb", None)
    result = session.synthesize(request, progress) if edits is None else Director(session).direct(request, edits, progress)
    return result if cues is None else replace(result, motions=rhubarb.with_cues(result.motions, cues))


def _key(request: Request) -> str:
    """Return the cache key of a request: its fields and the signature of its files."""
    fields = {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in asdict(request).items()}
    return json.dumps([recording_key(replace(request)), fields], default=_to_json, sort_keys=True)


def _to_json(value: object) -> object:
    return value.tolist() if isinstance(value, np.ndarray) else str(value)
