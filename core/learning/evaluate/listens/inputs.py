"""What reaches the network in one performance, group by group, so that groups can be exchanged between performances.

The inputs are recorded at the network's door while the session performs as for a user, so that they are what it hears, however
the stages before it choose them.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from ....model.mfcc_timing import mfcc_slice
from ....motion import stroke_requests
from ....synthesis import generation
from ....synthesis.request import Request
from ....synthesis.session import Session
from ....synthesis.stages import Stages

GROUPS = {
    "noise": ("noise",),
    "asked strokes": ("asked",),
    "style": ("style", "seeds"),
    "prosody": ("prosody",),
    "words": ("words",),
    "MFCC": ("mfcc",),
    "heard affect": ("affect",),
    "all that is heard": ("prosody", "words", "mfcc", "affect"),
}
"""Groups of inputs and the fields of :class:`Inputs` that each exchanges. A style comes with its rest pose."""


@dataclass(frozen=True)
class Inputs:
    """Inputs of ``T`` frames: ``mfcc`` ``(Ta, 40)``, ``words`` ``(T, 300)``, ``prosody`` ``(T, n)``, given poses ``seeds``
    ``(T, noise + 1)``, ``asked`` strokes ``(T, 7)``, ``style`` ``(T, size)`` as chosen, ``affect`` ``(T, size)``: what heard
    affect adds to it, and ``noise`` ``(T, noise)``.
    """

    mfcc: np.ndarray
    words: np.ndarray
    prosody: np.ndarray
    seeds: np.ndarray
    asked: np.ndarray
    style: np.ndarray
    affect: np.ndarray
    noise: np.ndarray

    @property
    def frames(self) -> int:
        """Number of frames."""
        return len(self.seeds)

    def cut(self, frames: int) -> "Inputs":
        """Return the first ``frames``."""
        ends = {one.name: getattr(self, one.name)[:frames] for one in fields(self)}
        return Inputs(**{**ends, "mfcc": self.mfcc[: mfcc_slice(0, frames).stop]})

    def exchange(self, other: "Inputs", group: str) -> "Inputs":
        """Return these inputs with a group of :data:`GROUPS` of others that are equally long."""
        return replace(self, **{name: getattr(other, name) for name in GROUPS[group]})


def record(session: Session, request: Request) -> Inputs:
    """Return the inputs of the first take of a request, of at most nine minutes, by a network that draws from noise."""
    full = _record(session, request)
    if not getattr(request, "follow", 0):
        return full
    plain = _record(session, replace(request, **{"follow": 0.0}))
    return replace(full, style=plain.style, affect=full.style - plain.style)


def perform(network: Any, inputs: Inputs, encoded: np.ndarray | None = None) -> np.ndarray:
    """Return the directions ``(T, 9, 3)`` that a network draws; with ``encoded``, its affective encoder sees those given poses
    instead.
    """
    heard = network.hear(inputs.mfcc, inputs.words, inputs.seeds if encoded is None else encoded, inputs.prosody)
    heard = network.told(heard, inputs.asked)
    return network.draw(heard, inputs.style + inputs.affect, inputs.seeds, inputs.noise)[0]


class _Door:
    """Stands before a network, lets everything through, and keeps what is passed in."""

    shares = False

    def __init__(self, network: Any) -> None:
        self._network, self.seen = network, {}

    def __getattr__(self, name: str) -> Any:
        return getattr(self._network, name)

    def hear(self, mfcc: np.ndarray, words: np.ndarray, seeds: np.ndarray, prosody: np.ndarray | None = None) -> None:
        prosody = np.zeros((len(seeds), 0), np.float32) if prosody is None else prosody
        self.seen |= {"mfcc": mfcc, "words": words, "prosody": prosody}

    def told(self, heard: None, asked: np.ndarray) -> None:
        self.seen["asked"] = asked

    def draw(
        self, heard: None, style: np.ndarray, seeds: np.ndarray, noise: np.ndarray, begins: Callable[[], None] = lambda: None
    ) -> tuple[np.ndarray, np.ndarray]:
        style = np.broadcast_to(style, (len(seeds), style.shape[-1]))
        self.seen |= {"style": style, "seeds": seeds, "noise": noise}
        return np.zeros((len(seeds), 9, 3), np.float32), np.zeros((len(seeds), len(self._network.usual)), np.float32)


def _record(session: Session, request: Request) -> Inputs:
    """Return the inputs of a performance, all of its style as chosen."""
    heard, performers = session.hear(request, Stages(lambda stage, value: None, lambda: False))
    door = _Door(session.checkpoint.network)
    generation.generate(replace(session.checkpoint, network=door), heard, [performers])
    seen = door.seen
    unasked = np.zeros((len(seen["seeds"]), len(stroke_requests.CHANNELS)), np.float32)
    return Inputs(**{"asked": unasked, "affect": np.zeros_like(seen["style"]), **seen})
