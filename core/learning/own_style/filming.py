"""Films of performers for ``s2ag evaluate --own-styles``: Blender films them, and what is captured stays in a folder."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ...motion.motion import Motion
from ..capture import estimator, motion
from ..capture.filmed import CAMERAS, LIGHTS, RATE, Run

GENDERS = "female", "male"
SIZE = 352, 256
"""Pixels of the films."""
_SAME = 1e-3
"""How far a direction of a motion may be off and still be the filmed one: a twentieth of a degree."""


def through_films(
    folder: Path, motions: dict[str, list[np.ndarray]], run: Run, tell: Callable[[str, float], None]
) -> dict[str, list[Motion]]:
    """Film motions ``(frames, 9, 3)`` by style, and return what was captured of each.

    Women and men in turn perform them. Films of these very motions that lie in ``folder`` are not made again. Raises S2agError.
    """
    folder.mkdir(parents=True, exist_ok=True)
    seen = {}
    for number, (name, pieces) in enumerate(motions.items()):
        films = [folder / f"{name.replace(' ', '-')}-{row + 1}.mp4" for row in range(len(pieces))]
        for film, piece in zip(films, pieces, strict=True):
            if not _shows(film, piece):
                film.unlink(missing_ok=True)
                Motion(piece).save(film.with_suffix(".npz"))
        missing = [film for film in films if not film.is_file()]
        if missing:
            job = films[0].with_suffix(".json")
            job.write_text(json.dumps(_job(missing, GENDERS[number % len(GENDERS)])), "utf-8")
            run("render.capture_films", str(job), progress=lambda stage, share, name=name: tell(f"film {name}", share))
        seen[name] = [_captured(film, tell) for film in films]
    return seen


def _shows(film: Path, piece: np.ndarray) -> bool:
    """Return whether there is a film, and of this motion."""
    known = film.with_suffix(".npz")
    if not film.is_file() or not known.is_file():
        return False
    filmed = Motion.load(known).directions
    return filmed.shape == piece.shape and np.allclose(filmed, piece, atol=_SAME)


def _job(films: list[Path], gender: str) -> dict:
    seen = {"camera": CAMERAS["front"], "light": LIGHTS["studio"]}
    shots = [{"motion": str(film.with_suffix(".npz")), "output": str(film), **seen} for film in films]
    return {"character": "human", "gender": gender, "fps": RATE, "resolution": SIZE, "shots": shots}


def _captured(film: Path, tell: Callable[[str, float], None]) -> Motion:
    """Return what ``s2ag capture`` finds in a film; what was seen in it stays beside it."""
    kept = film.with_suffix(".seen.npz")
    return motion.clean(estimator.look(film, kept=kept, progress=lambda share: tell(f"look at {film.stem}", share)))[0]
