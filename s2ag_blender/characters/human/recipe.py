"""Defines the human's shape by MakeHuman shape targets, for an adult woman and an adult man, and its skin weights; used when
packing the data."""

import numpy as np

from . import shoulders, source

_BODY = {
    "female": {"averagemuscle-averageweight": 0.5, "minmuscle-averageweight": 0.2, "averagemuscle-minweight": 0.3},
    "male": {"averagemuscle-averageweight": 0.75, "averagemuscle-minweight": 0.25},
}
"""Weights of MakeHuman's body builds; they add up to one."""

_IDEAL = {"female": 0.4, "male": 0.35}
"""Weights of MakeHuman's ideal proportions."""

_LIMBS = {f"hands/{side}-hand-fingers-distance-decr": 0.7 for side in "lr"} | {
    f"arms/{side}-upperarm-shoulder-muscle-decr": 0.5 for side in "lr"
}
"""Fingers closer together than the base mesh spreads them, and narrower shoulders."""

_ANCESTRY = {
    "female": {"caucasian": 0.5, "asian": 0.25, "african": 0.25},
    "male": {"caucasian": 0.6, "asian": 0.15, "african": 0.25},
}
_FACE = {
    "female": {
        "head/head-oval": 0.25,
        "head/head-age-decr": 0.2,
        "mouth/mouth-angles-up": 0.55,
        "mouth/mouth-upperlip-volume-incr": 0.3,
        "mouth/mouth-lowerlip-volume-incr": 0.2,
        "nose/nose-width2-decr": 0.3,
        "nose/nose-scale-vert-decr": 0.2,
        "chin/chin-width-decr": 0.2,
        "cheek/l-cheek-bones-incr": 0.3,
        "cheek/r-cheek-bones-incr": 0.3,
        "eyes/l-eye-scale-incr": 0.35,
        "eyes/r-eye-scale-incr": 0.35,
        "eyes/l-eye-height2-incr": 0.25,
        "eyes/r-eye-height2-incr": 0.25,
        "torso/measure-shoulder-dist-decr": 0.4,
    },
    "male": {
        "head/head-square": 0.2,
        "mouth/mouth-angles-up": 0.5,
        "mouth/mouth-lowerlip-volume-incr": 0.2,
        "chin/chin-prominent-incr": 0.2,
        "chin/chin-width-incr": 0.15,
        "nose/nose-width2-decr": 0.2,
        "eyes/l-eye-scale-incr": 0.3,
        "eyes/r-eye-scale-incr": 0.3,
        "eyes/l-eye-height2-incr": 0.25,
        "eyes/r-eye-height2-incr": 0.25,
        "torso/measure-shoulder-dist-decr": 0.35,
        "neck/neck-scale-horiz-decr": 0.35,
    },
}


def person(gender: str) -> np.ndarray:
    """Return points (19158, 3) of the base mesh in the shape of a young adult: metres, z up, facing -y, soles at z = 0."""
    weights = dict(_LIMBS)
    for build, part in _BODY[gender].items():
        weights[f"macrodetails/universal-{gender}-young-{build}"] = part
        weights[f"macrodetails/proportions/{gender}-young-{build}-idealproportions"] = part * _IDEAL[gender]
    weights |= {f"macrodetails/{origin}-{gender}-young": part for origin, part in _ANCESTRY[gender].items()}
    points = source.to_blender(source.morph(weights | _FACE[gender]))
    body = np.unique(source.base_mesh().faces["body"])
    points[:, 2] -= points[body, 2].min()
    return shoulders.lowered(points)


def weights(name: str) -> tuple[list[str], np.ndarray]:
    """Return the names of the deforming bones of the rig ``name`` and weights (19158, bones) float32."""
    bones, table = source.weights(name)
    return bones, shoulders.divided(name, bones, table, [person(gender) for gender in _BODY])
