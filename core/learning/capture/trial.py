"""How near captured motions are to those that were filmed: ``s2ag evaluate --capture``, and the fit of :mod:`correction`."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...files import atomic_file
from ...motion import skeleton
from ...motion.motion import Motion
from ...synthesis import strokes
from . import body, correction, estimator, filmed, hands, motion
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


def run(
    folder: Path, recordings: Sequence[Path], choosing: bool, blender: Callable[..., dict], tell: Callable[[str, float], None]
) -> str:
    """Film, capture and compare; return the table as Markdown. For ``choosing``, fit and write the correction first.

    Films and what was seen in them stay in ``folder``, and are not made again. Raises S2agError.
    """
    folder.mkdir(parents=True, exist_ok=True)
    estimator.python()
    shots = filmed.plan(folder, choosing)
    filmed.make(shots, recordings, choosing, blender, tell)
    seen = {}
    films = [(shot, path) for shot in shots for path in (shot.film, shot.worse)]
    for number, (shot, path) in enumerate(films):
        tell("look", number / len(films))
        kept = path.with_suffix(".seen.npz")
        seen[path] = shot, Landmarks.load(kept) if kept.is_file() else estimator.look(path, kept=kept)
    if choosing:
        fit([(found, Motion.load(shot.motion)) for shot, found in seen.values()])
    return table([compare(shot, path, found) for path, (shot, found) in seen.items()])


def fit(pairs: Sequence[tuple[Landmarks, Motion]]) -> None:
    """Learn the correction from what was seen of known motions, and write it."""
    arms, palms = [], []
    for found, truth in pairs:
        pose = body.read(found, corrected=False)
        known = truth.at(np.clip(found.times * truth.fps, 0, len(truth.directions) - 1), truth.fps)
        turned = np.einsum("fij,fkj->fki", pose.view, np.nan_to_num(found.world * body.TO_CANONICAL))
        for side, edges in enumerate(skeleton.ARMS):
            mirror, ok = (correction.MIRROR if side == 0 else np.ones(3)), pose.arms[:, side] > 0
            wanted = (known.directions[:, list(edges)] - pose.directions[:, list(edges)]) * mirror
            if ok.any():
                arms.append((body.arm_features(found, turned, pose.view, pose.seen, side)[ok], wanted[ok].reshape(-1, 6)))
            points = _placed(found, pose, side)
            ok &= np.isfinite(points).all((1, 2))
            if known.hands is not None and ok.any():
                forearm = pose.directions[ok, edges[1]]
                held = np.stack([known.hands.knuckles[ok, side], known.hands.palms[ok, side]], 1) * mirror
                palms.append((hands.features(points[ok], forearm, pose.view[ok], side == 0), held.reshape(-1, 6)))
    maps = {}
    for kind, parts in (("arm", arms), ("hand", palms)):
        maps[kind] = correction.fit(kind, *(np.concatenate([part[k] for part in parts]) for k in (0, 1)))
    with atomic_file(correction.FILE) as temporary:
        temporary.write_text(json.dumps(maps) + "\n", "utf-8")
    correction.forget()


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
    wanted, got = (np.array(strokes.stroke_times(part[:count])) for part in (truth.directions, made.directions))
    hits = _matched(wanted, got)
    edges = {edge: off[:, edge] for edge in EDGES}
    return Row(shot.name, path == shot.worse, edges, palms, (len(wanted), hits, len(got) - hits), float(seen.mean()))


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


def _placed(found: Landmarks, pose: body.Pose, side: int) -> np.ndarray:
    width, height = found.size
    points = (found.left, found.right)[side] * body.TO_CANONICAL * [width, height, width]
    return np.einsum("fij,fkj->fki", pose.view, points)


def _degrees(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.degrees(np.arccos(np.clip(np.sum(skeleton.normalize(one) * skeleton.normalize(other), -1), -1, 1)))


def _matched(wanted: np.ndarray, got: np.ndarray) -> int:
    """Return how many strokes were found, each captured one counting once."""
    hits, free = 0, list(got)
    for at in wanted:
        near = [one for one in free if abs(one - at) <= _TOLERANCE]
        if near:
            free.remove(min(near, key=lambda one: abs(one - at)))
            hits += 1
    return hits
