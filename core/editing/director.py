"""Applies an animator's edits to a take, one after the other, by regenerating the phrase around each; changes of style and of
feeling come first, whenever they were decided, so that all others stand in them.

Frames outside the spans of an edit stay equal to the bit. Inside, the generator leads from the poses before to those after,
and through the core of the requested gesture; the best of several seeds is used, judged by the time, hand and size of the
stroke and by how sudden the joins are."""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from ..errors import UsageError
from ..motion.motion import Motion
from ..synthesis.request import Request, Result
from ..synthesis.session import Session
from ..synthesis.session_cache import recording_key
from ..synthesis.stages import Stages
from . import edit_actions
from .edits import before_turn, check, performing_order
from .edits import of as edits_of
from .regeneration import Regenerator
from .targets import State

_MAX_TAKES = 4
"""Takes whose states after each edit are cached."""


class Director:
    """Edits takes of a session.

    It caches the states of the last few takes after each of their edits, so that a further edit costs only itself."""

    def __init__(self, session: Session):
        session.remember()
        self.session = session
        self._states: dict[str, list[tuple[str, State]]] = {}

    def direct(
        self, request: Request, edits: Sequence[dict], progress: Callable[[str, float], None] = lambda stage, value: None,
        cancelled: Callable[[], bool] = lambda: False, forgiven: int = 0
    ) -> Result:  # fmt: skip
        """Return the take of a request after ``edits`` (:mod:`edits`), with warnings on what could not be achieved.

        The same request, edits and checkpoint give the same motion. Of the first ``forgiven`` edits, and of those before a
        later change of style or feeling, those that cannot be applied are passed over with a warning; their numbers, from 0,
        are ``meta["unmet"]``. Raises what :meth:`Session.synthesize` raises, and :class:`UsageError` for other edits that
        cannot be applied, and if the request is for several takes."""
        if (count := len(request.identities)) != 1:
            raise UsageError(f"{count} takes cannot be directed at once.", "Ask for the one that the edits are about.")
        edits, key = check(edits), _key(request)
        states = self._states.pop(key, [])
        stages = Stages(progress, cancelled)
        if not states:
            result = self.session.synthesize(request, progress, cancelled)
            states = [("", State.of(result.motions[0], result.warnings))]
        order = performing_order(edits)
        self._states[key] = states = self.go_on(request, states, edits, order, stages, forgiven)
        for old in list(self._states)[:-_MAX_TAKES]:
            del self._states[old]
        state = states[-1][1]
        heard, performers = self.session.hear(request, stages)
        motion = documented(state.motion, edits, order, [[] for _ in edits]) if edits else state.motion
        return Result([motion], heard.words, list(state.warnings), dict(stages.seconds), performers.own)

    def go_on(
        self, request: Request, cached: list[tuple[str, State]], edits: list[dict], order: list[int], stages: Stages,
        forgiven: int = 0
    ) -> list[tuple[str, State]]:  # fmt: skip
        """Return the states after each edit of ``order``, numbers of ``edits``, each with its edit as text; ``cached`` ones of
        the same first edits are reused."""
        same = 0
        texts = [f"{number} {json.dumps(edits[number], sort_keys=True)}" for number in order]
        may_fail = [number < forgiven or before_turn(edits, number) for number in order]
        while same < len(texts) and same + 1 < len(cached) and cached[same + 1][0] == texts[same]:
            if order[same] in cached[same + 1][1].motion.meta.get("unmet", ()) and not may_fail[same]:
                break
            same += 1
        states = cached[: same + 1]
        if same < len(order):
            filler = Regenerator(self.session, request, stages)
            for number, text, is_forgiven in list(zip(order, texts, may_fail, strict=True))[same:]:
                state = edit_actions.apply_edit(filler, states[-1][1], edits[number], number + 1, is_forgiven)
                states.append((text, state))
        return states


def documented(motion: Motion, edits: list[dict], order: Sequence[int], touched: list[list]) -> Motion:
    """Return a motion whose provenance has the ``edits``, those it could not do, and what each ``touched`` before and in
    ``order``, where its last edits are those of ``order``."""
    done = motion.meta.get("touched", [])
    for number, spans in zip(order, done[len(done) - len(order) :], strict=True):
        touched[number] = [*touched[number], *spans]
    meta = {**motion.meta, "edits": edits, "touched": touched}
    return replace(motion, meta={**meta, "unmet": sorted(set(meta["unmet"]))} if "unmet" in meta else meta)


def perform(
    session: Session, request: Request, documents: Any, progress: Callable[[str, float], None] = lambda stage, value: None
) -> Result:
    """Synthesise a request and apply the ``documents`` to it, anything that names them as :class:`settings.Documents` does: the
    options of a command, a row of a manifest."""
    edits, cues = edits_of(documents), getattr(documents, "rhubarb", None)
    result = session.synthesize(request, progress) if edits is None else Director(session).direct(request, edits, progress)
    if cues is None:
        return result
    from ..motion.rhubarb import with_cues  # the extension's zip leaves it out

    return replace(result, motions=with_cues(result.motions, cues))


def _key(request: Request) -> str:
    """Return the cache key of a request: its fields and the signature of its files."""
    whole = [recording_key(replace(request)), asdict(request)]
    return json.dumps(whole, default=lambda one: one.tolist() if isinstance(one, np.ndarray) else str(one), sort_keys=True)
