"""Styles: a named speaker, a blend of speakers, or a random point of the speakers' latent space (paper section 3.1.3).

Controls move the style along learned directions of that space."""

import difflib
import re
from collections.abc import Mapping, Sequence

import numpy as np

from . import own_styles
from .errors import UnknownStyle, UsageError
from .settings import AFFECTS, CONTROLS, Settings, sliders
from .style_names import RANDOM, split_sequence  # noqa: F401

TAKE_SPREAD, TAKE_CONTROL_SPREAD = 0.4, 0.6
"""Variation between takes: of styles, as a share of the spread between speakers, and of controls (standard deviations)."""
_TRANSITION_FRAMES = 9
"""Frames of the transition from one style to the next."""


def default_speaker(speakers: list[dict]) -> str:
    """Return the name of the default speaker: the one marked as default, else the first."""
    return next((speaker["name"] for speaker in speakers if speaker.get("default")), speakers[0]["name"])


_MOST = 1e6
"""Largest weight of a style in a blend, and the reciprocal of the smallest above zero: shares beyond cannot be seen."""


def parse(expression: str | dict, names: list[str]) -> dict[int, float] | None:
    """Convert a style into ``{speaker index: weight}`` with weights that sum to one, or None for a random style.

    ``expression`` is ``NAME``, ``NAME:0.6+NAME:0.4``, ``random``, or a mapping of names to weights; for a sequence of
    styles parse each of its :func:`split_sequence`. Case, hyphens and underscores do not matter. Raises :class:`UnknownStyle`,
    which lists the nearest names."""
    pairs = _split(expression)
    if len(pairs) == 1 and _key(pairs[0][0]) == RANDOM:
        return None
    indices = {_key(name): index for index, name in enumerate(names)}
    weights: dict[int, float] = {}
    for name, weight in pairs:
        if _key(name) not in indices:
            raise UnknownStyle(f"There is no style {name!r}.", _suggest(name, names))
        if not (weight == 0 or 1 / _MOST <= weight <= _MOST):  # a sum of others may be infinite, or nothing divided by nothing
            message = f"The weight of style {name!r} is {weight:g}."
            raise UnknownStyle(message, "Give weights of zero, or up to a million, as in A:0.6+B:0.4.")
        index = indices[_key(name)]
        weights[index] = weights.get(index, 0.0) + weight
    total = sum(weights.values())
    if not total:
        raise UnknownStyle("All style weights are zero.", "Give at least one style a weight above zero.")
    return {index: weight / total for index, weight in weights.items()}


def performers(speakers: list[dict], steps: Sequence[str | dict], weights: str) -> list[dict]:
    """Return the speakers of a checkpoint, and after them the styles of one's own (:mod:`own_styles`) that ``steps`` name.

    Raises :class:`UnknownStyle` for files that are none, and for styles that were learned for other ``weights`` (a hash)."""
    known, own = {RANDOM, *(_key(speaker["name"]) for speaker in speakers)}, {}
    for name in (name for step in steps for name, _ in _split(step)):
        found = None if _key(name) in known else own_styles.find(name)
        if found and found["weights"] != weights:
            remedy = "Learn it again from its own figures: s2ag learn FILE.json."
            raise UnknownStyle(f"The style {name!r} was learned for other weights.", remedy)
        own |= {_key(name): {**found, "name": name}} if found else {}
    return [*speakers, *own.values()]


def interpolate_sequence(points: np.ndarray, frames: int) -> np.ndarray:
    """Interpolate evenly spaced styles ``(..., points, size)`` linearly: ``(..., frames, size)`` float32."""
    count = points.shape[-2]
    position = np.linspace(0, count - 1, frames)
    low = np.minimum(position.astype(int), count - 2)
    share = (position - low)[:, None].astype(np.float32)
    return ((1 - share) * points[..., low, :] + share * points[..., low + 1, :]).astype(np.float32)


def switch_at_frames(points: np.ndarray, frames: int, begins: np.ndarray) -> np.ndarray:
    """Switch smoothly to the next of the styles ``(..., points, size)`` at each frame of ``begins`` ``(points - 1,)``.

    Returns the style of every frame, ``(..., frames, size)`` float32."""
    result = np.repeat(points[..., :1, :], frames, axis=-2).astype(np.float32)
    for row, begin in enumerate(begins, 1):
        share = np.clip((np.arange(frames) - begin) / _TRANSITION_FRAMES + 0.5, 0, 1)
        share = (share * share * (3 - 2 * share))[:, None].astype(np.float32)
        result = result + share * (points[..., row : row + 1, :] - result)
    return result.astype(np.float32)


def controls(affect: Mapping[str, float], rate: float = 0.0, hand: float = 0.0) -> np.ndarray:
    """Return control values ``(5,)`` float32 in the order of :data:`CONTROLS`; ``affect`` may have any of :data:`AFFECTS`.

    Raises :class:`UsageError` for unknown names and for values that are not numbers from -1 to 1."""
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


def describe_controls(count: int) -> list[dict]:
    """Return ``{"name", "description"}`` of the first ``count`` controls, those of a checkpoint with that many."""
    controls = [slider for slider in sliders(Settings) if slider.control]
    return [{"name": control.name, "description": control.tip} for control in controls[:count]]


def take_identities(
    take: int, takes: int, near: Sequence[Sequence[float]] = (), spread: float = 0.0, step: int = 1
) -> list[tuple]:
    """Return the identities ``(take, steps)`` of takes: numbers from ``take`` on, all with the steps ``near``.

    With a ``spread`` all are variations of take number ``take``, each one step away from it; steps are numbered from
    ``step`` on. A step is ``(number, spread)``; several steps make a variation of a variation."""
    path = tuple((int(number), float(size)) for number, size in near)
    if not spread:
        return [(take + number, path) for number in range(takes)]
    return [(take, (*path, (step + number, float(spread)))) for number in range(takes)]


def sample_styles(
    weights: dict[int, float] | None, mean: np.ndarray, deviation: np.ndarray, seed: int, takes: int | list[tuple]
) -> np.ndarray:
    """Sample latent styles ``(takes, size)`` float32 from the speakers' ``mean`` and ``deviation`` ``(speakers, size)``.

    The first take of a named style is the style itself; further takes are sampled from the speaker's distribution, widened
    because it expresses the network's uncertainty rather than a speaker's variation. A random style is sampled from the
    normal distribution over all speakers. Equal seeds give equal styles. ``takes`` is a number, or :func:`take_identities`."""
    which = take_identities(0, takes) if isinstance(takes, int) else takes
    if weights is None:
        draws = _draws(seed, which, mean.shape[1], first=True)
        return (mean.mean(0) + draws * np.hypot(mean.std(0), deviation.mean(0))).astype(np.float32)
    share = np.zeros(len(mean))
    share[list(weights)] = list(weights.values())
    draws = _draws(seed, which, mean.shape[1])
    return (share @ mean + draws * np.hypot(share @ deviation, TAKE_SPREAD * mean.std(0))).astype(np.float32)


def vary_controls(controls: np.ndarray, seed: int, takes: int | list[tuple]) -> np.ndarray:
    """Return the controls ``(..., takes, 5)`` float32 of every take from ``(..., 5)``: unchanged in the first take, varied
    in the others except for the hand."""
    which = take_identities(0, takes) if isinstance(takes, int) else takes
    variation = _draws(seed, which, len(CONTROLS), 5)
    variation[:, CONTROLS.index("hand")] = 0
    return np.clip(controls[..., None, :] + TAKE_CONTROL_SPREAD * variation, -1, 1).astype(np.float32)


def _draws(seed: int, which: list[tuple], size: int, *salt: int, first: bool = False) -> np.ndarray:
    """Return normal noise ``(takes, size)``: zeros for take 0 unless ``first``, plus noise scaled by spread for each step."""
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
        name, colon, weight = part.rpartition(":")
        if not colon or part.lower().rstrip().endswith(own_styles.SUFFIX):  # C:\\ada.json has no weight
            name, weight = part, ""
        try:
            pairs.append((name.strip(), float(weight) if weight else 1.0))
        except ValueError:
            raise UnknownStyle(f"{weight.strip()!r} is not a weight.", "Write styles as A:0.6+B:0.4.") from None
    return pairs


def _key(name: str) -> str:
    return re.sub(r"[\s_-]+", " ", name.strip().lower())


def _suggest(name: str, names: list[str]) -> str:
    matches = difflib.get_close_matches(_key(name), [_key(candidate) for candidate in names], n=3, cutoff=0.4)
    listed = [candidate for candidate in names if _key(candidate) in matches] or names
    return f"Styles {'like it ' if matches else ''}are: {', '.join(listed)}, or {RANDOM}."
