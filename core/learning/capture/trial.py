"""How near captured motions are to those that were filmed: ``s2ag evaluate --capture``."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...motion import skeleton
from ...motion.motion import Motion
from ...motion.skeleton import FPS
from ...sound import peaks
from ...synthesis import strokes
from . import estimator, filmed, motion
from .landmarks import Landmarks

EDGES = {4: "left upper arm", 5: "left forearm", 7: "right upper arm", 8: "right forearm"}
GOALS = {"arm": 10.0, "palm": 20.0, "strokes": 0.9}
_TOLERANCE, _LEAST, _SHARE = 0.2, 0.1, 0.5
"""Seconds within which a captured stroke is the filmed one; metres that the wrist goes in a stroke that counts; share of the
least speed, prominence and way of strokes from which on a movement answers one."""


@dataclass(frozen=True)
class Row:
    """Figures of one film: median degrees of arm edges and palms, strokes filmed, found, captured and made up, share of frames
    seen, and whether the camera's place was told."""

    shot: filmed.Shot
    half: bool
    edges: dict[int, np.ndarray]
    palms: np.ndarray
    strokes: tuple[int, int, int, int]
    seen: float
    known: bool = False


def run(
    folder: Path,
    recordings: Sequence[Path],
    characters: Sequence[tuple[str, str]],
    blender: Callable[..., dict],
    tell: Callable[[str, float], None],
) -> str:
    """Film characters, capture and compare; return the table as Markdown.

    Films and what was seen in them stay in ``folder``, and are not made again. Raises S2agError.
    """
    folder.mkdir(parents=True, exist_ok=True)
    estimator.python()
    shots = filmed.plan(folder, characters)
    filmed.make(shots, recordings, blender, tell)
    rows, films = [], [(shot, path) for shot in shots for path in (shot.film, shot.worse)]
    for number, (shot, path) in enumerate(films):
        tell("look", number / len(films))
        kept = path.with_suffix(".seen.npz")
        found = Landmarks.load(kept) if kept.is_file() else estimator.look(path, kept=kept)
        rows += [compare(shot, path, found, known) for known in (False, True)]
    return table(rows)


def compare(shot: filmed.Shot, path: Path, found: Landmarks, known: bool = False) -> Row:
    """Compare what was captured from a film with what was filmed; ``known``: where the camera stood was told."""
    truth, (made, _) = Motion.load(shot.motion), motion.clean(found, filmed.CAMERAS[shot.camera][:2] if known else None)
    count = min(len(truth.directions), len(made.directions))
    seen = np.ones(count, bool)
    for start, end in made.meta["unseen"]:
        seen[round(start * made.fps) : round(end * made.fps)] = False
    off = _degrees(made.directions[:count], truth.directions[:count])[seen]
    palms = np.zeros((0, 2))
    if made.hands is not None and truth.hands is not None:
        shown = np.stack([np.isfinite(part[:, 0, 0]) for part in (found.left, found.right)], 1)
        at = np.clip(np.searchsorted(found.times, np.arange(count) / made.fps), 0, len(found) - 1)
        palms = np.where(shown[at], _degrees(made.hands.palms[:count], truth.hands.palms[:count]), np.nan)[seen]
    edges = {edge: off[:, edge] for edge in EDGES}
    told = count_strokes(truth.directions, made.directions)
    return Row(shot, path == shot.worse, edges, palms, told, float(seen.mean()), known)


def table(rows: Sequence[Row]) -> str:
    """Return figures of all films, full size and half size, and by character, camera and light, as Markdown."""
    groups: dict[str, list[Row]] = {}
    for known, told in ((False, ""), (True, ", camera told")):
        for half, size in ((False, ""), (True, ", half size")):
            groups[f"all films{size}{told}"] = [row for row in rows if (row.half, row.known) == (half, known)]
    for kind, field in (("character", "who"), ("camera", "camera"), ("light", "light")):
        for row in (row for row in rows if not row.known):
            groups.setdefault(f"{kind} {getattr(row.shot, field)}", []).append(row)
    lines = ["| films | " + " | ".join(EDGES.values()) + " | palms | strokes found | made up | seen |"]
    lines.append("|---" * (len(EDGES) + 5) + "|")
    for name, group in groups.items():
        if not group:
            continue
        figures = [f"{np.median(np.concatenate([row.edges[edge] for row in group])):.1f}°" for edge in EDGES]
        palms = np.concatenate([row.palms.ravel() for row in group])
        palm = f"{np.nanmedian(palms):.0f}°" if np.isfinite(palms).any() else "-"
        wanted, hits, got, extra = (sum(row.strokes[k] for row in group) for k in range(4))
        share, false = f"{hits / max(wanted, 1):.0%} of {wanted}", f"{extra / max(got, 1):.0%} of {got}"
        seen = np.mean([row.seen for row in group])
        lines.append(f"| {name} ({len(group)}) | " + " | ".join([*figures, palm, share, false, f"{seen:.0%}"]) + " |")
    goals = f"Goals: {GOALS['arm']:g}° an edge, {GOALS['palm']:g}° a palm, {GOALS['strokes']:.0%} of the strokes."
    return "\n".join([*lines, "", goals])


def _degrees(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.degrees(np.arccos(np.clip(np.sum(skeleton.normalize(one) * skeleton.normalize(other), -1), -1, 1)))


def count_strokes(truth: np.ndarray, made: np.ndarray) -> tuple[int, int, int, int]:
    """Return how many strokes a motion ``(frames, 9, 3)`` has, how many of them a captured one shows, how many strokes that one
    has, and how many of these are none in the first.

    A stroke is a peak of a wrist's speed, as :mod:`strokes` finds them, in which the wrist goes 10 centimetres. The other
    motion shows it by a stroke of the same hand within 0.2 seconds that is at least half as large, fast and prominent as a
    stroke must be; each answers one alone."""
    counts, both = np.zeros(4, int), min(len(truth), len(made))
    for one, other in zip(*(strokes.wrist_speeds(part[:both]).T for part in (truth, made)), strict=True):
        wanted, got = _strokes(one), _strokes(other)
        counts += len(wanted), _met(wanted, _strokes(other, _SHARE)), len(got), len(got) - _met(got, _strokes(one, _SHARE))
    return tuple(counts.tolist())


def _strokes(speed: np.ndarray, share: float = 1.0) -> list[int]:
    """Return the frames of strokes of a wrist ``(n,)``, also of those that only have a share of what makes a stroke."""
    places = peaks.find_peaks(speed, share * strokes.PROMINENCE, round(share * strokes.APART * FPS), 0.5).places
    result = []
    for place in places[speed[places] > share * strokes.SPEED].tolist():
        start, hold = strokes.stroke_span(speed.tolist(), place)
        if speed[start : hold + 1].sum() / FPS >= share * _LEAST:
            result.append(place)
    return result


def _met(wanted: Sequence[int], shown: Sequence[int]) -> int:
    """Return how many of some frames have one of others nearby for themselves."""
    left, reach, hits = list(shown), _TOLERANCE * FPS, 0
    for place in wanted:
        near = next((other for other in left if abs(other - place) <= reach), None)
        if near is not None:
            left.remove(near)
            hits += 1
    return hits
