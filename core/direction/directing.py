"""Takes as an animator directs them: one edit after the other, each by making the phrase around it anew.

What an edit does not touch stays to the bit: frames outside its spans are those of the take. Inside, the generator leads
from the poses before to those behind, and through the core of the gesture that is asked for; of a few seeds the best one is
taken, by where the stroke lands, which hand makes it, how large it is and how hard the joins are.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace

import numpy as np

from ..errors import UsageError
from ..motion.motion import Motion
from ..performance.memory import signature
from ..performance.request import Request, Result
from ..performance.stages import Stages
from ..performance.synthesis import Session
from . import doing
from .aims import State
from .edits import check
from .filling import Filler

_KEPT = 4
"""Takes that are remembered with their edits."""


class Director:
    """A session whose takes can be directed. It remembers the last few takes after each of their edits, so that another edit
    costs only itself.
    """

    def __init__(self, session: Session):
        session.remember()
        self.session = session
        self._known: dict[str, list[tuple[str, State]]] = {}

    def direct(
        self,
        request: Request,
        edits: Sequence[dict],
        progress: Callable[[str, float], None] = lambda stage, value: None,
        cancelled: Callable[[], bool] = lambda: False,
    ) -> Result:
        """The one take of a request after its edits (:mod:`edits`), and warnings on what could not be had.

        Same request, same edits, same checkpoint: the same motion. Raises what :meth:`Session.synthesize` raises, and
        :class:`UsageError` for edits that cannot be done.
        """
        if request.takes != 1:
            raise UsageError(f"{request.takes} takes cannot be directed at once.", "Ask for the one that the edits are about.")
        edits, key = check(edits), _key(request)
        known = self._known.pop(key, [])
        stages = Stages(progress, cancelled)
        if not known:
            result = self.session.synthesize(request, progress, cancelled)
            known = [("", State.of(result.motions[0], result.warnings))]
        self._known[key] = known = self._on(request, known, edits, stages)
        for old in list(self._known)[:-_KEPT]:
            del self._known[old]
        state = known[-1][1]
        heard, performers = self.session.hear(request, stages)
        return Result([state.motion], heard.words, list(state.warnings), dict(stages.seconds), performers.own)

    def apply(
        self,
        request: Request,
        motion: Motion,
        edits: Sequence[dict],
        progress: Callable[[str, float], None] = lambda stage, value: None,
        cancelled: Callable[[], bool] = lambda: False,
    ) -> tuple[Motion, list[str]]:
        """A ``motion`` that came of a request, whatever was edited in it before, after these edits; and warnings.

        What its provenance tells of former edits holds on: styles that they began, poses and places that they keep.
        """
        state = State.of(motion).after(check(motion.meta.get("edits", [])))
        state = self._on(request, [("", state)], check(edits), Stages(progress, cancelled))[-1][1]
        return state.motion, list(state.warnings)

    def _on(self, request: Request, known: list, edits: list[dict], stages: Stages) -> list:
        """States after each edit, of which the first ones are known."""
        same = 0
        texts = [json.dumps(edit, sort_keys=True) for edit in edits]
        while same < len(texts) and same + 1 < len(known) and known[same + 1][0] == texts[same]:
            same += 1
        states = known[: same + 1]
        if same < len(edits):
            filler = Filler(self.session, request, stages)
            for number in range(same, len(edits)):
                made = doing.do(filler, states[-1][1], edits[number], number + 1)
                states.append((texts[number], made))
        return states


def _key(request: Request) -> str:
    """What tells requests apart."""
    told = {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in asdict(request).items()}
    return json.dumps([signature(replace(request)), told], default=_plain, sort_keys=True)


def _plain(value):
    return value.tolist() if isinstance(value, np.ndarray) else str(value)
