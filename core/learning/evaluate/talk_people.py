"""The people that performances are held against: captured talk by kind, and data sets that the user has."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path

import numpy as np

from ...errors import UsageError
from ...motion import skeleton
from ...motion.motion import Motion
from ...smoothing import gaussian
from . import talk_split
from .comparisons import evenly_spaced

_NOISY = {"m_conversation": 0.05}
"""Seconds by which captures are smoothed whose hands tremble more than the others' of the library."""
MOST_SECONDS = 1200.0
"""Seconds of a data set that are read: more changes no figure."""


@dataclass(frozen=True)
class People:
    """Motions ``(frames, 9, 3)`` by kind of people, and the kinds that a judge is ``asked`` about; the others train it."""

    kinds: dict[str, list[np.ndarray]]
    asked: list[str] = field(default_factory=list)

    @property
    def motions(self) -> dict[str, list[np.ndarray]]:
        """The kinds that are asked about."""
        return {kind: self.kinds[kind] for kind in self.asked}


def load(material: str | PathLike, reported: bool = True, data: Sequence[str | PathLike] = ()) -> People:
    """Load captured talk below ``material``, and the test split of folders of ``s2ag data``, one kind each.

    ``reported``: judges are asked about what is kept for reports alone, and all else only trains them; otherwise what is kept
    is not read at all. Raises :class:`UsageError` where there are no clips.
    """
    kinds, asked = {}, []
    for kind, names in talk_split.KINDS.items():
        kept = [name for name in names if name in talk_split.CAPTURED_REPORTED]
        names = kept if reported and kept else [name for name in names if name not in kept]
        if names:
            kinds[kind] = [captured(material, name) for name in names]
            asked += [kind] * bool(kept or not reported)
    for folder in data:
        kinds[Path(folder).name] = performances(folder)
        asked.append(Path(folder).name)
    return People(kinds, asked)


def performed(material: str | PathLike, reported: bool = True) -> list[Motion]:
    """Return the captured talk that judges are asked about with its hands. Raises :class:`UsageError` as :func:`load`."""
    from ..corpus import rocketbox_clips

    names = talk_split.CAPTURED_REPORTED if reported else talk_split.CAPTURED_CHOSEN_ON
    folder = Path(material) / rocketbox_clips.FOLDER
    hands = {name: rocketbox_clips.load(folder / f"{name}.npz").hands for name in names}
    return [Motion(captured(material, name), hands=hands[name]) for name in names]


def captured(material: str | PathLike, name: str) -> np.ndarray:
    """Return a clip's directions ``(frames, 9, 3)``. Raises :class:`UsageError` where it is missing."""
    from ..corpus import rocketbox_clips

    try:
        motion = rocketbox_clips.load(Path(material) / rocketbox_clips.FOLDER / f"{name}.npz").directions
    except ValueError as error:
        raise UsageError(f"{material} holds no captured talk: {error}.", "Name the folder with rocketbox_clips/.") from error
    return skeleton.normalize(gaussian(motion, _NOISY[name] * skeleton.FPS)) if name in _NOISY else motion


def performances(folder: str | PathLike) -> list[np.ndarray]:
    """Return performances of a data set's test split, of all of it where it has none, evenly spread over it."""
    from ..train.storage import load_arrays

    arrays, meta = load_arrays(folder)
    if meta["fps"] != skeleton.FPS:
        raise UsageError(f"{folder} has {meta['fps']:g} frames a second.", "Convert it again without --fps.")
    starts, split = arrays["starts"], np.asarray(arrays["split"])
    rows = np.flatnonzero(split == 2) if (split == 2).any() else np.arange(len(split))
    most = max(int(MOST_SECONDS / np.mean(np.diff(starts)[rows]) * skeleton.FPS), 2)
    rows = evenly_spaced(rows.tolist(), most)
    return [skeleton.normalize(arrays["directions"][starts[row] : starts[row + 1]].astype(np.float32)) for row in rows]
