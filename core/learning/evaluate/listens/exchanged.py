"""What the network listens to: performances of two recordings with one group of inputs exchanged between them.

Shares of the arms' variance are Sobol's, estimated as Jansen does (Saltelli et al. 2010): the total share of a group is the
variance that it has part in, alone or with others; the first-order share is what it makes alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ....errors import UsageError
from ....model.mfcc_timing import PHASE_PERIOD
from ....motion import skeleton
from ..generation import Generator, PerformanceOptions
from ..talks import Talk
from . import inputs
from .emotion import Progress, silent
from .inputs import Inputs
from .recordings import cut_excerpts

PAIRS = 90
_EXCERPT, _BEGINNING = 10.0, 1.0
"""Seconds of each recording that are performed, and their first ones, which every rest pose shares and which do not count."""
_GIVEN = 15
"""Frames of a seed motion."""


@dataclass(frozen=True)
class _Pair:
    """Two performances ``(T, 9, 3)`` of independent recording, style and seed, and their inputs."""

    inputs: tuple[Inputs, Inputs]
    motions: tuple[np.ndarray, np.ndarray]


def draw_pairs(
    generator: Generator, talks: Sequence[Talk], count: int = PAIRS, seed: int = 0, progress: Progress = silent
) -> list[tuple[Inputs, Inputs]]:
    """Draw pairs of different excerpts of recordings, performed by random styles and seeds, and return their inputs.

    All are equally long. Raises :class:`UsageError` for less than two excerpts.
    """
    random, excerpts = np.random.default_rng(seed), cut_excerpts(talks, _EXCERPT, 2 * count)
    if len(excerpts) < 2:
        raise UsageError("There is too little speech to exchange.", f"Name recordings of {2 * _EXCERPT:g} s and more.")
    generator.session.remember()
    chosen = np.array([random.choice(len(excerpts), 2, replace=False) for _ in range(count)]).ravel()
    recorded: dict[int, Inputs] = {}
    for number, place in enumerate(np.argsort(chosen, kind="stable")):  # one recording after another is heard
        progress("record inputs", number / len(chosen))
        wish = PerformanceOptions(generator.names[random.integers(len(generator.names))], int(random.integers(1 << 30)))
        request = generator.request(excerpts[int(chosen[place])], wish, hands=0)
        recorded[int(place)] = inputs.record(generator.session, request)
    step = int(np.lcm(PHASE_PERIOD, generator.session.checkpoint.config.flow_patch))
    frames = min(one.frames for one in recorded.values()) // step * step
    cut = [recorded[place].cut(frames) for place in range(len(chosen))]
    return list(zip(cut[::2], cut[1::2], strict=True))


def shares(network: Any, pairs: Sequence[tuple[Inputs, Inputs]], progress: Progress = silent) -> dict[str, dict[str, float]]:
    """Return by group (:data:`inputs.GROUPS`) ``total`` and ``first`` share of the arms' variance, and ``degrees`` that arms
    move where it is exchanged within each of the ``pairs``, which are independent of each other.
    """
    drawn = _drawn(network, pairs)
    start = round(_BEGINNING * skeleton.FPS)
    arms = np.stack([_arms(motion, start) for pair in drawn for motion in pair.motions])
    variance = float(((arms - arms.mean(axis=0)) ** 2).sum(axis=(1, 2, 3)).mean())
    groups = [name for name in inputs.GROUPS if name != "heard affect" or _hears_affect(drawn)]
    result = {}
    for number, name in enumerate(groups):
        progress(f"exchange {name}", number / len(groups))
        own, other, degrees = [], [], []
        for pair in drawn:
            for this, that in ((0, 1), (1, 0)):
                mixed = inputs.perform(network, pair.inputs[this].exchange(pair.inputs[that], name))
                own.append(_square(mixed, pair.motions[this], start))
                other.append(_square(mixed, pair.motions[that], start))
                degrees.append(_apart(mixed, pair.motions[this], start))
        result[name] = {
            "total": float(0.5 * np.mean(own) / variance),
            "first": float(1 - 0.5 * np.mean(other) / variance),
            "degrees": float(np.mean(degrees)),
        }
    return result


def seed_motion(network: Any, pairs: Sequence[tuple[Inputs, Inputs]], progress: Progress = silent) -> dict[str, float]:
    """Return what a second of other motion, given at the start instead of the rest pose, changes: degrees of the arms.

    ``next_second`` and ``second_after``: beside the same performance from the rest pose. ``encoder``: in the next second where
    only the affective encoder sees another motion, while the given frames themselves stay.
    """
    found, drawn = [], _drawn(network, pairs)
    for number, pair in enumerate(drawn):
        progress("give seed motions", number / len(drawn))
        plain, (first, second) = pair.inputs[0], (_given(pair.inputs[0], motion) for motion in pair.motions)
        moved = inputs.perform(network, replace(plain, seeds=first))
        encoded = inputs.perform(network, replace(plain, seeds=first), encoded=second)
        rows = [slice(_GIVEN, 2 * _GIVEN), slice(2 * _GIVEN, 3 * _GIVEN)]
        from_rest = [_apart(moved[row], pair.motions[0][row]) for row in rows]
        found.append([*from_rest, _apart(moved[rows[0]], encoded[rows[0]])])
    return dict(zip(("next_second", "second_after", "encoder"), np.mean(found, axis=0).tolist(), strict=True))


def _drawn(network: Any, pairs: Sequence[tuple[Inputs, Inputs]]) -> list[_Pair]:
    return [_Pair(pair, (inputs.perform(network, pair[0]), inputs.perform(network, pair[1]))) for pair in pairs]


def _given(plain: Inputs, motion: np.ndarray) -> np.ndarray:
    """Return the given poses of inputs with a second from the middle of a motion at their start."""
    seeds, middle = plain.seeds.copy(), len(motion) // 2
    size = skeleton.MEAN.size
    seeds[:_GIVEN] = seeds[:1]  # hands as at the start
    seeds[:_GIVEN, :size] = (motion[middle : middle + _GIVEN] - skeleton.MEAN).reshape(_GIVEN, size)
    return seeds


def _hears_affect(pairs: Sequence[_Pair]) -> bool:
    return any(one.affect.any() for pair in pairs for one in pair.inputs)


def _arms(motion: np.ndarray, start: int = 0) -> np.ndarray:
    return np.asarray(motion, float)[start:, skeleton.ARM_EDGES]


def _square(first: np.ndarray, second: np.ndarray, start: int) -> float:
    return float(((_arms(first, start) - _arms(second, start)) ** 2).sum())


def _apart(first: np.ndarray, second: np.ndarray, start: int = 0) -> float:
    """Return the mean angle in degrees between the arms of two motions."""
    chord = np.linalg.norm(_arms(first, start) - _arms(second, start), axis=-1)
    return float(np.degrees(2 * np.arcsin(np.clip(chord / 2, 0, 1))).mean())
