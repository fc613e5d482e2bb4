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
_TOLERANCE = 0.2
"""Seconds within which a captured stroke is the filmed one."""


@dataclass(frozen=True)
class Row:
    """Figures of one film: median degrees of arm edges and palms, strokes filmed, found and made up, share of frames seen."""

    name: str
    half: bool
    edges: dict[int, np.ndarray]
    palms: np.ndarray
    strokes: tuple[int, int, int]
    seen: float


def run(folder: Path, recordings: Sequence[Path], blender: Callable[..., dict], tell: Callable[[str, float], None]) -> str:
    """Film, capture and compare; return the table as Markdown.

    Films and what was seen in them stay in ``folder``, and are not made again. Raises S2agError.
    """
    folder.mkdir(parents=True, exist_ok=True)
    estimator.python()
    shots = filmed.plan(folder)
    filmed.make(shots, recordings, blender, tell)
    rows, films = [], [(shot, path) for shot in shots for path in (shot.film, shot.worse)]
    for number, (shot, path) in enumerate(films):
        tell("look", number / len(films))
        kept = path.with_suffix(".seen.npz")
        rows.append(compare(shot, path, Landmarks.load(kept) if kept.is_file() else estimator.look(path, kept=kept)))
    return table(rows)


def compare(shot: filmed.Shot, path: Path, found: Landmarks) -> Row:
    """Compare what was captured from a film with what was filmed."""
    truth, (made, _) = Motion.load(shot.motion), motion.clean(found)
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
    one, other = (strokes.wrist_speeds(part[:count]).max(1) for part in (truth.directions, made.directions))
    wanted, got = (strokes.stroke_places(part, FPS) for part in (one, other))
    edges = {edge: off[:, edge] for edge in EDGES}
    told = len(wanted), _met(one, other), len(got) - _met(other, one)
    return Row(shot.name, path == shot.worse, edges, palms, told, float(seen.mean()))


def table(rows: Sequence[Row]) -> str:
    """Return figures of all films, full size and half size, and by character, camera and light, as Markdown."""
    groups: dict[str, list[Row]] = {"all films": [row for row in rows if not row.half]}
    groups["all films, half size"] = [row for row in rows if row.half]
    for number, kind in enumerate(("", "character", "camera", "light")):
        for name in dict.fromkeys(row.name.split("-")[number] for row in rows) if kind else ():
            groups[f"{kind} {name}"] = [row for row in rows if row.name.split("-")[number] == name]
    lines = ["| films | " + " | ".join(EDGES.values()) + " | palms | strokes found | made up | seen |"]
    lines.append("|---" * (len(EDGES) + 5) + "|")
    for name, group in groups.items():
        if not group:
            continue
        figures = [f"{np.median(np.concatenate([row.edges[edge] for row in group])):.1f}°" for edge in EDGES]
        palms = np.concatenate([row.palms.ravel() for row in group])
        palm = f"{np.nanmedian(palms):.0f}°" if np.isfinite(palms).any() else "-"
        wanted, hits, extra = (sum(row.strokes[k] for row in group) for k in range(3))
        share = f"{hits / max(wanted, 1):.0%} of {wanted}"
        seen = np.mean([row.seen for row in group])
        lines.append(f"| {name} ({len(group)}) | " + " | ".join([*figures, palm, share, str(extra), f"{seen:.0%}"]) + " |")
    goals = f"Goals: {GOALS['arm']:g}° an edge, {GOALS['palm']:g}° a palm, {GOALS['strokes']:.0%} of the strokes."
    return "\n".join([*lines, "", goals])


def _degrees(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.degrees(np.arccos(np.clip(np.sum(skeleton.normalize(one) * skeleton.normalize(other), -1), -1, 1)))


def _met(one: np.ndarray, other: np.ndarray) -> int:
    """Return how many strokes of the speeds ``one`` ``(n,)`` of the faster wrist ``other`` shows, too: as a peak at that time
    that is at least half as fast. Which of two peaks nearby counts as the stroke depends on little, so all are compared."""
    shown = np.array(peaks.find_peaks(other, strokes.PROMINENCE / 2, 3, 0.5).places, int)
    reach, hits = round(_TOLERANCE * FPS), 0
    for place in strokes.stroke_places(one, FPS):
        hits += bool((other[shown[np.abs(shown - place) <= reach]] >= one[place] / 2).any())
    return hits
