"""What captured hands do on an arm's pose, as the small table that performances without hands take theirs from.

``python -m s2ag.core.learning.corpus.manners --material PATH -o core/performance/hands.json``
"""

import argparse
import json
from collections.abc import Iterable
from os import PathLike
from pathlib import Path

import numpy as np

from ...files import whole_file
from ...motion import handshape, skeleton
from ...motion.hands import Hands
from ...performance.living import features
from . import clips, library, skm

_SHAPES = 7
_STEADY = 3.0
"""Ridge, in frames."""
_EVERY = 0.1
"""Seconds between frames that count."""
_FAR = 0.55
"""Participation from which on a hand's shape is a gesture's own."""
_OPEN = (-12.0, 45.0), (0.0, 80.0)
"""Degrees of bases and rests of fingers in hands that mean nothing by their shape: no fists, no pointing."""


def captured(material: str | PathLike) -> Iterable[clips.Clip]:
    """All co-speech clips, those with folded arms and hands on hips, too."""
    for family, (skeleton_file, roles) in library.SETS.items():
        folder = Path(material) / "smartbody" / family
        joints = skm.load_skeleton(folder / "skeletons" / skeleton_file)
        for path in sorted((folder / "motions").glob("*.skm")):
            if library.parse_name(path.stem) is None:
                continue
            try:
                yield clips.load(path, joints, roles, path.stem)
            except ValueError:
                continue


def learn(found: Iterable[clips.Clip]) -> dict[str, np.ndarray]:
    """``palms`` and ``knuckles`` ``(16, 3)`` by least squares of a left arm, ``shapes`` ``(n, 12)`` as strokes have them."""
    seen, palms, bends, shapes = [], [], [], []
    for clip in found:
        hands = clip.fingers
        few = slice(None, None, max(1, round(_EVERY * clip.fps)))
        at = round(clip.emphasis * clip.fps)
        for side, (upper, fore) in enumerate(skeleton.ARMS):
            mirror = np.array([-1.0 if side else 1.0, 1, 1])
            arm = clip.directions[few].astype(float) * mirror
            seen.append(features(arm[:, upper], arm[:, fore]))
            palms.append(hands.palms[few, side] * mirror)
            bends.append(hands.knuckles[few, side] * mirror - arm[:, fore])
            if clip.thumbs and clip.hands[side] > _FAR and _means_nothing(hands.shape[at, side]):
                shapes.append(hands.shape[at, side])
    seen = np.concatenate(seen)
    normal = seen.T @ seen + _STEADY * np.eye(seen.shape[1])
    solved = (np.linalg.solve(normal, seen.T @ np.concatenate(part)) for part in (palms, bends))
    return dict(zip(("palms", "knuckles", "shapes"), (*solved, _typical(np.array(shapes, float))), strict=True))


def errors(found: Iterable[clips.Clip], learnt: dict[str, np.ndarray]) -> tuple[float, float]:
    """Median degrees that palms and knuckles of clips lie from what was learnt."""
    off = [], []
    for clip in found:
        for side, (upper, fore) in enumerate(skeleton.ARMS):
            mirror = np.array([-1.0 if side else 1.0, 1, 1])
            arm = clip.directions.astype(float) * mirror
            seen = features(arm[:, upper], arm[:, fore])
            made = Hands.of(arm[:, fore] + seen @ learnt["knuckles"], seen @ learnt["palms"], np.zeros((len(arm), 12)))
            captured = clip.fingers.palms, clip.fingers.knuckles
            for angles, mine, theirs in zip(off, (made.palms, made.knuckles), captured, strict=True):
                angles.append(np.degrees(np.arccos(np.clip(np.sum(mine * theirs[:, side] * mirror, -1), -1, 1))))
    return tuple(float(np.median(np.concatenate(angles))) for angles in off)


def _means_nothing(shape: np.ndarray) -> bool:
    bends = (handshape.columns(shape, part) for part in ("base", "rest"))
    return all(low <= bend.min() and bend.max() <= high for bend, (low, high) in zip(bends, _OPEN, strict=True))


def _typical(shapes: np.ndarray) -> np.ndarray:
    """Middles of :data:`_SHAPES` groups of handshapes, from the farthest apart to where they settle."""
    middles = [shapes.mean(0)]
    while len(middles) < _SHAPES:
        middles.append(shapes[np.min([np.linalg.norm(shapes - middle, axis=-1) for middle in middles], 0).argmax()])
    middles = np.array(middles)
    for _ in range(50):
        nearest = np.linalg.norm(shapes[:, None] - middles, axis=-1).argmin(1)
        middles = np.array([shapes[nearest == n].mean(0) if (nearest == n).any() else middles[n] for n in range(_SHAPES)])
    return middles


def main() -> None:
    """The command of this module."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--material", required=True, type=Path, help="folder with smartbody/")
    parser.add_argument("-o", "--output", required=True, type=Path)
    options = parser.parse_args()
    found = list(captured(options.material))
    learnt = learn(found)
    lines = [f' "{name}": {json.dumps(values.round(4 if name != "shapes" else 1).tolist())}' for name, values in learnt.items()]
    with whole_file(options.output) as temporary:
        temporary.write_text("{\n" + ",\n".join(lines) + "\n}\n", "utf-8")
    palms, knuckles = errors(found, learnt)
    print(f"{len(found)} clips; palms {palms:.1f} and knuckles {knuckles:.1f} degrees off, in the middle")


if __name__ == "__main__":
    main()
