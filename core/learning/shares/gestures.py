"""Gestures that follow what is heard, said and shown by known shares of the arms' variance."""

import numpy as np

from ...motion.skeleton import EDGE_NAMES, FPS, MEAN_UNIT, normalize
from ...smoothing import gaussian
from .speech import VOICES, WORDS, Spoken

SHARES = {"loudness": 0.25, "words": 0.2, "speaker": 0.15, "timbre": 0.15, "posture": 0.2, "chance": 0.05}
"""Share of the arms' variance that follows each source:

- ``loudness``: how loud each word is;
- ``words``: which word is said, by a direction of its own;
- ``speaker``: who speaks, by a direction that arms take in phrases and leave in pauses;
- ``timbre``: affect that is heard alone, bright or dark, another in each phrase;
- ``posture``: affect that is seen alone: a lean of trunk and head that lasts a recording says which way, and how far, arms
  go at every word's onset;
- ``chance``: nothing.
"""
_SIZES = {"loudness": 1, "words": 3, "speaker": 3, "timbre": 1, "posture": 1, "chance": 3}
_ARMS = [EDGE_NAMES.index(f"{side}_{part}") for side in ("left", "right") for part in ("upper_arm", "forearm")]
_TRUNK = [EDGE_NAMES.index(name) for name in ("torso", "neck", "head")]
_SPREAD, _LEAN = 0.8, 0.15
"""Standard deviation of all arms together, and sideways lean of the trunk of the strongest affect, in unit directions."""
_SLOW, _QUICK = 0.2, 0.1
"""Seconds by which sources set in and fade, and by which onsets do."""
_KEY = 2026
"""The directions that sources move the arms in are the same for all data sets."""


def sources(spoken: Spoken, seed: int, number: int) -> tuple[dict[str, np.ndarray], float]:
    """Return each source over time, ``(frames, size)`` before it is scaled, and the affect that is seen, -1..1."""
    chance = np.random.default_rng((seed, number, 1))
    affect = float(chance.uniform(-1, 1))
    tracks = {name: np.zeros((spoken.frames, size)) for name, size in _SIZES.items()}
    codes = {name: _codes(name, count) for name, count in (("words", len(WORDS)), ("speaker", len(VOICES)))}
    onset = np.zeros((spoken.frames, 1))
    for (word, start, end), loud, tilt in zip(spoken.words, spoken.loudness, spoken.timbre, strict=True):
        here = slice(round(start * FPS), max(round(end * FPS), round(start * FPS) + 1))
        tracks["loudness"][here] = loud
        tracks["words"][here] = codes["words"][word]
        tracks["speaker"][here] = codes["speaker"][spoken.speaker]
        tracks["timbre"][here] = tilt
        onset[here.start : here.start + 1] = 1
    tracks["chance"] = chance.normal(size=tracks["chance"].shape)
    tracks = {name: gaussian(track, _SLOW * FPS) for name, track in tracks.items()}
    tracks["posture"] = affect * gaussian(onset - onset.mean(), _QUICK * FPS)
    return tracks, affect


def scales(pilot: list[dict[str, np.ndarray]]) -> dict[str, float]:
    """Return the factor on each source that gives it its share, from the sources of some recordings."""
    found = {}
    for name, share in SHARES.items():
        whole = np.concatenate([tracks[name] for tracks in pilot])
        found[name] = _SPREAD * np.sqrt(share / whole.var(0).sum())
    return found


def perform(tracks: dict[str, np.ndarray], affect: float, factors: dict[str, float]) -> np.ndarray:
    """Return directions ``(frames, 9, 3)`` of a recording with these sources."""
    moved = np.sum([factors[name] * tracks[name] @ basis for name, basis in axes().items()], axis=0)
    directions = np.repeat(MEAN_UNIT[None], len(moved), 0).astype(float)
    directions[:, _ARMS] += moved.reshape(-1, len(_ARMS), 3)
    directions[:, _TRUNK, 0] += _LEAN * affect
    return normalize(directions)


def axes() -> dict[str, np.ndarray]:
    """Return the orthonormal directions ``(size, 12)`` in which each source moves the four bones of the arms."""
    whole = np.linalg.qr(np.random.default_rng(_KEY).normal(size=(12, 12)))[0].T
    ends = np.cumsum(list(_SIZES.values()))
    return {name: whole[end - size : end] for (name, size), end in zip(_SIZES.items(), ends, strict=True)}


def arms(directions: np.ndarray) -> np.ndarray:
    """Return the four bones of the arms ``(..., 12)`` of directions ``(..., 9, 3)``."""
    return directions[..., _ARMS, :].reshape(*directions.shape[:-2], 3 * len(_ARMS))


def _codes(name: str, count: int) -> np.ndarray:
    """Return a unit direction ``(count, 3)`` for each word or speaker."""
    return normalize(np.random.default_rng((_KEY, len(name))).normal(size=(count, 3)))
