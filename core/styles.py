"""Styles: a named speaker, a blend of speakers, or a random point of the speakers' latent space (paper section 3.1.3).

Controls move the style along directions of that space that the network has learned.
"""

import difflib
import re

import numpy as np

from .errors import UnknownStyle, UsageError
from .settings import AFFECTS, CONTROLS, Settings, sliders

RANDOM = "random"
TAKE_SPREAD, TAKE_WISHES = 0.4, 0.6
"""Takes are there to choose from: how far they go, as a share of the way between speakers, and how much their controls vary."""
_TURN = 9
"""Frames in which one style becomes another that begins at a moment."""


def default(speakers: list[dict]) -> str:
    """Name of the speaker that performs when no style is asked for: the one marked as default, else the first."""
    return next((speaker["name"] for speaker in speakers if speaker.get("default")), speakers[0]["name"])


def parse(expression: str | dict, names: list[str]) -> dict[int, float] | None:
    """Turn a style into ``{speaker index: weight}`` with weights that sum to one, or None for a random style.

    ``expression`` is ``NAME``, ``NAME:0.6+NAME:0.4``, ``random``, or a mapping of names to weights; a walk has one for each
    of its :func:`steps`. Case, hyphens and underscores do not matter. Raises :class:`UnknownStyle`, which lists the nearest
    names.
    """
    pairs = _split(expression)
    if len(pairs) == 1 and _key(pairs[0][0]) == RANDOM:
        return None
    known = {_key(name): index for index, name in enumerate(names)}
    weights: dict[int, float] = {}
    for name, weight in pairs:
        if _key(name) not in known:
            raise UnknownStyle(f"There is no style {name!r}.", _suggest(name, names))
        if not (np.isfinite(weight) and weight >= 0):
            message = f"The weight of style {name!r} is {weight:g}."
            raise UnknownStyle(message, "Give weights of zero or more, as in A:0.6+B:0.4.")
        index = known[_key(name)]
        weights[index] = weights.get(index, 0.0) + weight
    total = sum(weights.values())
    if not total:
        raise UnknownStyle("All style weights are zero.", "Give at least one style a weight above zero.")
    return {index: weight / total for index, weight in weights.items()}


def steps(expression: str | dict) -> list[str | dict]:
    """The styles that a walk ``A > B > C`` comes by at even intervals, from the recording's start to its end; one otherwise."""
    return [part.strip() for part in expression.split(">")] if isinstance(expression, str) else [expression]


def along(points: np.ndarray, frames: int) -> np.ndarray:
    """A walk ``(..., points, size)`` at every frame, ``(..., frames, size)`` float32: straight from point to point."""
    count = points.shape[-2]
    at = np.linspace(0, count - 1, frames)
    here = np.minimum(at.astype(int), count - 2)
    share = (at - here)[:, None].astype(np.float32)
    return ((1 - share) * points[..., here, :] + share * points[..., here + 1, :]).astype(np.float32)


def turning(points: np.ndarray, frames: int, begins: np.ndarray) -> np.ndarray:
    """Points ``(..., points, size)`` of which each holds from its frame of ``begins`` ``(points - 1,)`` on, the first before;
    at every frame, ``(..., frames, size)`` float32.
    """
    found = np.repeat(points[..., :1, :], frames, axis=-2).astype(np.float32)
    for row, begin in enumerate(begins, 1):
        share = np.clip((np.arange(frames) - begin) / _TURN + 0.5, 0, 1)
        share = (share * share * (3 - 2 * share))[:, None].astype(np.float32)
        found = found + share * (points[..., row : row + 1, :] - found)
    return found.astype(np.float32)


def controls(affect: dict[str, float], rate: float = 0.0, hand: float = 0.0) -> np.ndarray:
    """Control values ``(5,)`` float32 in the order of :data:`CONTROLS`; ``affect`` may name any of :data:`AFFECTS`.

    Raises :class:`UsageError` for an unknown name and for what is no number from -1 to 1.
    """
    unknown = [name for name in affect if name not in AFFECTS]
    if unknown:
        raise UsageError(f"There is no affect {unknown[0]!r}.", f"Affects are {', '.join(AFFECTS)}.")
    values = {**affect, "rate": rate, "hand": hand}
    for name, value in values.items():
        number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
        if not (number and -1 <= value <= 1):
            shown = f"{value:g}" if number else repr(value)
            raise UsageError(f"The control {name} cannot be {shown}.", "Give a number from -1 to 1; 0 changes nothing.")
    return np.array([values.get(name, 0.0) for name in CONTROLS], np.float32)


def described(count: int) -> list[dict]:
    """``{"name", "description"}`` of the first ``count`` controls: what a checkpoint with so many can do."""
    controls = [one for one in sliders(Settings) if one.control]
    return [{"name": one.name, "description": one.tip} for one in controls[:count]]


def identities(take: int, takes: int, near: tuple = (), spread: float = 0.0, step: int = 1) -> list[tuple]:
    """What tells takes apart, ``(take, steps)`` each: numbers from ``take`` on, all with the steps ``near``.

    With a ``spread`` all are variations of that one take, a step away from it each; steps are numbered from ``step`` on. A
    step is ``(number, spread)``; a take reached by several steps is a variation of a variation.
    """
    near = tuple((int(number), float(size)) for number, size in near)
    if not spread:
        return [(take + number, near) for number in range(takes)]
    return [(take, (*near, (step + number, float(spread)))) for number in range(takes)]


def latent(
    weights: dict[int, float] | None, mean: np.ndarray, deviation: np.ndarray, seed: int, takes: int | list[tuple]
) -> np.ndarray:
    """Latent styles ``(takes, size)`` float32 from the speakers' ``mean`` and ``deviation``, both ``(speakers, size)``.

    The first take of a named style is the style itself; every further take is drawn from the speaker's distribution,
    which is widened, because it tells how sure the network is of a speaker rather than how far one may vary.
    A random style is a draw from the normal distribution that covers all speakers. Same seed, same styles.
    ``takes`` is how many, or :func:`identities`.
    """
    which = identities(0, takes) if isinstance(takes, int) else takes
    if weights is None:
        draws = _draws(seed, which, mean.shape[1], first=True)
        return (mean.mean(0) + draws * np.hypot(mean.std(0), deviation.mean(0))).astype(np.float32)
    share = np.zeros(len(mean))
    share[list(weights)] = list(weights.values())
    draws = _draws(seed, which, mean.shape[1])
    return (share @ mean + draws * np.hypot(share @ deviation, TAKE_SPREAD * mean.std(0))).astype(np.float32)


def vary(controls: np.ndarray, seed: int, takes: int | list[tuple]) -> np.ndarray:
    """Controls ``(..., takes, 5)`` float32 of every take, of ``(..., 5)``: the first as asked, the others a little different
    but for the hand.
    """
    which = identities(0, takes) if isinstance(takes, int) else takes
    wishes = _draws(seed, which, len(CONTROLS), 5)
    wishes[:, CONTROLS.index("hand")] = 0
    return np.clip(controls[..., None, :] + TAKE_WISHES * wishes, -1, 1).astype(np.float32)


def _draws(seed: int, which: list[tuple], size: int, *salt: int, first: bool = False) -> np.ndarray:
    """Normal numbers ``(takes, size)``: nothing for take 0 unless ``first``, and a step's share of as much for each step."""
    draws = np.zeros((len(which), size))
    for row, (take, steps) in zip(draws, which, strict=True):
        if take or first:
            row += np.random.default_rng((seed, take, *salt)).standard_normal(size)
        path = ()
        for number, spread in steps:
            path = (*path, number)
            row += spread * np.random.default_rng((seed, take, *salt, 0x5A1, *path)).standard_normal(size)
    return draws


def _split(expression: str | dict) -> list[tuple[str, float]]:
    if isinstance(expression, dict):
        return [(str(name), float(weight)) for name, weight in expression.items()] or [("", 1.0)]
    pairs = []
    for part in expression.split("+"):
        name, _, weight = part.partition(":")
        try:
            pairs.append((name.strip(), float(weight) if weight else 1.0))
        except ValueError:
            raise UnknownStyle(f"{weight.strip()!r} is not a weight.", "Write styles as A:0.6+B:0.4.") from None
    return pairs


def _key(name: str) -> str:
    return re.sub(r"[\s_-]+", " ", name.strip().lower())


def _suggest(name: str, names: list[str]) -> str:
    near = difflib.get_close_matches(_key(name), [_key(known) for known in names], n=3, cutoff=0.4)
    listed = [known for known in names if _key(known) in near] or names
    return f"Styles {'like it ' if near else ''}are: {', '.join(listed)}, or {RANDOM}."
