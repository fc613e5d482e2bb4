"""Fits a style to a manner: trials perform a recording and are measured (:mod:`manner`).

A style is a point of the latent space, a taste (:data:`accent_selection.FACTS`), a scale of the noise and a pose to wait in.
It begins at the speaker of the checkpoint that is most like the source; then a plane is laid through the manners of trials
around it, and the style goes where the plane meets the source, as far as that is sure."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ... import own_styles
from ...errors import UsageError
from ...files import scratch_folder
from ...motion import rest, skeleton
from ...sound import audio
from ...synthesis import accent_selection, generation, postprocess
from ...synthesis.request import Request
from ...synthesis.session import Session
from ...synthesis.stages import Stages
from ..evaluate.generation import write_wave
from . import camera, manner
from .source import Source

STAGE_SECONDS = 120.0
"""Seconds on which trials perform, from the middles of all recordings."""
ROUNDS, TRIALS, AXES = 5, 18, 14
"""Rounds of trials, trials of each, and axes of the space of styles (principal ones of the speakers) in which they lie."""
_FIRST = 3
"""Performances of each speaker before the first round."""
_BATCH, _SURE, _SURE_OF_FILMS = 6, 8.0, 4.0
"""Performances at once; squared distance of manners at which a speaker is less likely by the factor e, of sources that are
motions, and of films, of which figures count less."""
_REACH, _NEAR, _PRIOR, _STAY, _LONGEST = 0.35, 1.0, 0.3, 4.0, 1.5
"""Spread of trials, in deviations of the speakers; how near they must be to count, squared; weights against steep planes and
of staying at the beginning; the longest step."""
_SEED, _LAST_SEED = 10_000, 997
_READY = 0.7
_SCALES = np.array(list(manner.FIGURES.values()))


class Style(NamedTuple):
    """What a performer is made of: ``point`` ``(size,)``, ``taste`` ``(8,)``, ``chance`` and ``rest`` ``(9, 3)``."""

    point: np.ndarray
    taste: np.ndarray
    chance: float
    rest: np.ndarray


class Fit(NamedTuple):
    """A fitted style, the shares of the speakers where it began, its manner, and how far from the source the beginning was."""

    style: Style
    shares: np.ndarray
    manner: dict[str, float]
    beginning: float


class Stage:
    """A recording, on which styles perform and are measured; ``known``: the manners ``(speakers, figures)`` of the checkpoint's
    speakers, once they are."""

    def __init__(self, session: Session, sound: str | PathLike, takes: int = 1):
        self.checkpoint = session.checkpoint
        self.known: np.ndarray | None = None
        self._request = Request(sound, stance=0.0, face=0.0, hands=0.0, takes=takes, style=session.styles()[0]["name"])
        self._heard, self._cast = session.hear(self._request, Stages(lambda stage, value: None, lambda: False))

    def perform(self, styles: Sequence[Style], seed: int = 0) -> list[dict[str, float]]:
        """Return the manner of each style's performance; seeds as in :meth:`show`."""
        return [manner.measure(motions) for motions in self.show(styles, seed)]

    def show(self, styles: Sequence[Style], seed: int = 0) -> list[list[np.ndarray]]:
        """Return the takes ``(frames, 9, 3)`` of each style's performance; each has a seed of its own, from ``seed`` on."""
        count = self._request.takes
        cast = [
            replace(
                self._cast,
                request=replace(self._cast.request, seed=seed + number),
                latents=np.tile(one.point.astype(np.float32), (count, 1, 1)),
                rests=one.rest[None].astype(np.float32),
                chances=np.array([one.chance]),
                tastes=one.taste[None],
            )
            for number, one in enumerate(styles)
        ]
        drawn = generation.generate(self.checkpoint, self._heard, cast)
        pairs = zip(cast, drawn.split([count] * len(cast)), strict=True)
        made = [postprocess.express(self.checkpoint, self._heard, *pair) for pair in pairs]
        return [[motion.directions for motion in motions] for motions in made]


def staged(session: Session, sounds: Sequence[Path]) -> Stage:
    """Return a stage of the middles of recordings, one after the other, as often as makes two minutes."""
    most, parts = round(STAGE_SECONDS * audio.SAMPLE_RATE) // len(sounds), []
    for sound in sounds:
        samples = audio.load(sound)
        start = max(len(samples) - most, 0) // 2
        parts.append(samples[start : start + most])
    joined = np.concatenate(parts)
    with scratch_folder() as folder:
        write_wave(joined, folder / "stage.wav")
        return Stage(session, folder / "stage.wav", max(round(STAGE_SECONDS * audio.SAMPLE_RATE / len(joined)), 1))


def learn(session: Session, source: Source, name: str, progress: Callable[[float], None]) -> tuple[dict, str]:
    """Return a style as :mod:`own_styles` writes it, and its figures beside the source's as text.

    Raises :class:`UsageError` for weights whose speakers have no tastes."""
    checkpoint = session.checkpoint
    if not checkpoint.draws or any(accent_selection.speaker_taste(one.get("answers")) is None for one in checkpoint.speakers):
        raise UsageError("These weights have no styles that could be learned.", "Leave out --checkpoint.")
    found = fit(staged(session, source.sounds), source, progress)
    ready = [one.get("semantic", _READY) for one in checkpoint.speakers]
    style = {
        "format": own_styles.FORMAT,
        "name": name,
        "description": f"Learned from {source.seconds / 60:.1f} minutes of motion.",
        "weights": checkpoint.hash,
        "point": found.style.point.round(5).tolist(),
        "chance": round(found.style.chance, 4),
        "rest": np.round(found.style.rest, 4).tolist(),
        "semantic": round(float(found.shares @ ready), 3),
        "answers": dict(zip(accent_selection.FACTS, found.style.taste.round(4).tolist(), strict=True)),
        "manner": source.manner,
        "seconds": source.seconds,
    }
    like = checkpoint.speakers[int(found.shares.argmax())]["name"]
    return style, _table(source, found, name, like)


def fit(stage: Stage, source: Source, progress: Callable[[float], None] = lambda value: None) -> Fit:
    """Fit a style to the manner of a source."""
    target = np.array([source.manner.get(name, 0.0) for name in manner.FIGURES]) / _SCALES
    trust = source.trust or dict.fromkeys(source.manner, 1.0)
    counts = np.sqrt([trust.get(name, 0.0) for name in manner.FIGURES])
    known = speakers(stage.checkpoint)
    places, parts = np.stack([_numbers(one) for one in known]), _FIRST + ROUNDS
    found = stage.known
    if found is None:
        found = stage.known = np.mean([_perform(stage, known, progress, part, parts) for part in range(_FIRST)], axis=0)
    off = ((counts * (found - target)) ** 2).sum(1) / (_SURE_OF_FILMS if source.trust else _SURE)
    shares = np.exp(off.min() - off)
    shares /= shares.sum()
    waits = source.waits
    if waits is None:
        waits = skeleton.normalize(np.tensordot(shares, np.stack([one.rest for one in known]), 1))
        nod = list(manner.FIGURES).index("nod")
        waits = camera.bowed(waits, (target - shares @ found)[nod] * _SCALES[nod]) if counts[nod] else waits
    centre = places.mean(0)
    tried, sizes, axes = np.linalg.svd(places - centre, full_matrices=False)
    tried, axes = tried[:, :AXES] * np.sqrt(len(known)), (sizes[:, None] * axes)[:AXES] / np.sqrt(len(known))
    start = here = shares @ tried
    random = np.random.default_rng(0)
    for part in range(_FIRST, parts):
        trials = here + _REACH * random.standard_normal((TRIALS, len(axes)))
        made = _perform(stage, [_style(centre + one @ axes, waits) for one in trials], progress, part, parts)
        tried, found = np.concatenate([tried, trials]), np.concatenate([found, made])
        here = _step(tried, counts * (found - target), here, start)
    ends = [_style(shares @ places, waits), _style(centre + here @ axes, waits)]
    manners = [manner.mean(stage.perform([one] * _BATCH, _LAST_SEED)) for one in ends]
    apart = [manner.apart(source.manner, one, source.trust) for one in manners]
    best = apart.index(min(apart))
    return Fit(ends[best], shares, manners[best], apart[0])


def speakers(checkpoint: Any) -> list[Style]:
    """Return the speakers of a checkpoint."""
    rows = zip(checkpoint.network.speakers[0].astype(float), checkpoint.speakers, strict=True)
    return [
        Style(
            point,
            np.asarray(accent_selection.speaker_taste(one.get("answers"))),
            float(one.get("chance", 1.0)),
            np.array(one.get("rest", rest.REST), float),
        )
        for point, one in rows
    ]


def _perform(stage: Stage, styles: Sequence[Style], progress: Callable[[float], None], part: int, parts: int) -> np.ndarray:
    """Return the manners of performances ``(styles, figures)`` in units of :data:`manner.FIGURES`, each of another seed."""
    rows = []
    for first in range(0, len(styles), _BATCH):
        made = stage.perform(styles[first : first + _BATCH], _SEED + 1000 * part + first)
        rows += [list(one.values()) for one in made]
        progress((part + min(first + _BATCH, len(styles)) / len(styles)) / parts)
    return np.array(rows) / _SCALES


def _numbers(style: Style) -> np.ndarray:
    """Return a style as numbers of a flat space: the point, and logarithms of its taste and its noise."""
    rate, size, spread, left, right, both, ready, end = np.maximum(style.taste, 1e-3)
    hands = [np.log(right / left), np.log(2 * both / (left + right))]
    return np.concatenate([style.point, np.log([rate, size, spread, ready, end, style.chance]), hands])


def _style(numbers: np.ndarray, waits: np.ndarray) -> Style:
    """Turn :func:`_numbers` back."""
    (rate, size, spread, ready, end, chance), (side, both) = np.exp(numbers[-8:-2]), np.exp(numbers[-2:])
    one, two = 2 / (2 + both), both / (2 + both)
    hands = one / (1 + side), one * side / (1 + side), two
    return Style(numbers[:-8], np.array([rate, size, spread, *hands, ready, end]), float(min(chance, 1.15)), waits)


def _step(tried: np.ndarray, off: np.ndarray, here: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Return where the plane through how far manners were ``off`` near ``here`` is nearest to 0, and not far from ``start``."""
    weights = np.exp(-((tried - here) ** 2).sum(1) / _NEAR / len(here))[:, None] + 0.01
    rows = np.concatenate([tried - here, np.ones((len(tried), 1))], 1)
    stiff = np.diag([*np.full(len(here), _PRIOR), 1e-3])
    plane = np.linalg.solve(rows.T @ (weights * rows) + stiff, rows.T @ (weights * off))
    slopes, now = plane[:-1], plane[-1]
    move = np.linalg.solve(slopes @ slopes.T + _STAY * np.eye(len(here)), _STAY * (start - here) - slopes @ now)
    return here + move * min(1.0, _LONGEST / max(float(np.linalg.norm(move)), 1e-9))


def _table(source: Source, found: Fit, name: str, like: str) -> str:
    theirs, seen = manner.told(found.manner), manner.told(source.manner)
    apart = manner.apart(source.manner, found.manner, source.trust)
    lines = [
        f"{'':30}{'source':>10}{name[:12]:>14}",
        *(f"{what:30}{mine:10.2f}{theirs[what]:14.2f}" for what, mine in seen.items()),
        f"{name} is {apart:.2f} from its source, {like}, where it began, {found.beginning:.2f} "
        "(1: as two performances of one style).",
    ]
    return "\n".join(lines)
