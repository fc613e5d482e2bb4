"""Fits the model of hands by arm pose to captured hands; :mod:`core.synthesis.hand_synthesis` synthesizes hands from the table.

``python -m s2ag.core.learning.corpus.hand_model --material PATH -o core/synthesis/hands.json``
"""

import argparse
import json
from collections.abc import Iterable
from os import PathLike
from pathlib import Path

import numpy as np

from ...files import atomic_file
from ...motion import handshape, skeleton
from ...motion.hands import Hands
from ...synthesis.hand_synthesis import arm_features
from . import clips, library, smartbody

_SHAPES = 7
"""Number of typical handshapes."""
_RIDGE = 3.0
"""Regularisation of the least squares, in frames."""
_SAMPLE_STEP = 0.1
"""Seconds between the frames that are used."""
_MIN_PARTICIPATION = 0.55
"""Participation of an arm from which its handshape counts as the gesture's."""
_NEUTRAL_BENDS = (-12.0, 45.0), (0.0, 80.0)
"""Range in degrees of the bends at finger bases and of the rest of the fingers in neutral hands: no fists, no pointing."""


def captured_clips(material: str | PathLike) -> Iterable[clips.Clip]:
    """Yield all co-speech clips, including those with folded arms and hands on hips."""
    for family, (skeleton_file, roles) in library.SETS.items():
        folder = Path(material) / "smartbody" / family
        joints = smartbody.load_skeleton(folder / "skeletons" / skeleton_file)
        for path in sorted((folder / "motions").glob("*.skm")):
            if library.parse_name(path.stem) is None:
                continue
            try:
                yield clips.load(path, joints, roles, path.stem)
            except ValueError:
                continue


def fit(captures: Iterable[clips.Clip]) -> dict[str, np.ndarray]:
    """Fit ``palms`` and ``knuckles`` ``(16, 3)`` of a left arm by least squares; ``shapes`` ``(n, 12)``: typical handshapes."""
    inputs, palms, bends, shapes = [], [], [], []
    for clip in captures:
        hands = clip.fingers
        assert hands is not None  # clips.load reads them
        sampled = slice(None, None, max(1, round(_SAMPLE_STEP * clip.fps)))
        at = round(clip.emphasis * clip.fps)
        for side, (upper, fore) in enumerate(skeleton.ARMS):
            mirror = np.array([-1.0 if side else 1.0, 1, 1])
            arm = clip.directions[sampled].astype(float) * mirror
            inputs.append(arm_features(arm[:, upper], arm[:, fore]))
            palms.append(hands.palms[sampled, side] * mirror)
            bends.append(hands.knuckles[sampled, side] * mirror - arm[:, fore])
            if clip.thumbs and clip.hands[side] > _MIN_PARTICIPATION and _is_neutral(hands.shape[at, side]):
                shapes.append(hands.shape[at, side])
    inputs = np.concatenate(inputs)
    normal = inputs.T @ inputs + _RIDGE * np.eye(inputs.shape[1])
    solved = (np.linalg.solve(normal, inputs.T @ np.concatenate(part)) for part in (palms, bends))
    return dict(zip(("palms", "knuckles", "shapes"), (*solved, _cluster_means(np.array(shapes, float))), strict=True))


def fit_errors(captures: Iterable[clips.Clip], learnt: dict[str, np.ndarray]) -> tuple[float, float]:
    """Return the median errors of palms and knuckles in degrees."""
    off: tuple[list[np.ndarray], list[np.ndarray]] = [], []
    for clip in captures:
        hands = clip.fingers
        assert hands is not None
        for side, (upper, fore) in enumerate(skeleton.ARMS):
            mirror = np.array([-1.0 if side else 1.0, 1, 1])
            arm = clip.directions.astype(float) * mirror
            inputs = arm_features(arm[:, upper], arm[:, fore])
            fit = Hands.of(arm[:, fore] + inputs @ learnt["knuckles"], inputs @ learnt["palms"], np.zeros((len(arm), 12)))
            for angles, fitted, truth in zip(off, (fit.palms, fit.knuckles), (hands.palms, hands.knuckles), strict=True):
                angles.append(np.degrees(np.arccos(np.clip(np.sum(fitted * truth[:, side] * mirror, -1), -1, 1))))
    palms, knuckles = (float(np.median(np.concatenate(angles))) for angles in off)
    return palms, knuckles


def _is_neutral(shape: np.ndarray) -> bool:
    bends = (handshape.columns(shape, part) for part in ("base", "rest"))
    return all(low <= bend.min() and bend.max() <= high for bend, (low, high) in zip(bends, _NEUTRAL_BENDS, strict=True))


def _cluster_means(shapes: np.ndarray) -> np.ndarray:
    """Return the means of :data:`_SHAPES` clusters of handshapes: k-means from a farthest-point start."""
    means = [shapes.mean(0)]
    while len(means) < _SHAPES:
        means.append(shapes[np.min([np.linalg.norm(shapes - mean, axis=-1) for mean in means], 0).argmax()])
    means = np.array(means)
    for _ in range(50):
        nearest = np.linalg.norm(shapes[:, None] - means, axis=-1).argmin(1)
        means = np.array([shapes[nearest == n].mean(0) if (nearest == n).any() else means[n] for n in range(_SHAPES)])
    return means


def main() -> None:
    """Run the command of this module."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--material", required=True, type=Path, help="folder with smartbody/")
    parser.add_argument("-o", "--output", required=True, type=Path)
    options = parser.parse_args()
    captures = list(captured_clips(options.material))
    learnt = fit(captures)
    lines = [f' "{name}": {json.dumps(values.round(4 if name != "shapes" else 1).tolist())}' for name, values in learnt.items()]
    with atomic_file(options.output) as temporary:
        temporary.write_text("{\n" + ",\n".join(lines) + "\n}\n", "utf-8")
    palms, knuckles = fit_errors(captures, learnt)
    print(f"{len(captures)} clips; palms {palms:.1f} and knuckles {knuckles:.1f} degrees off, in the middle")


if __name__ == "__main__":
    main()
