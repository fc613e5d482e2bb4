"""Shapes shoulders that hold with arms down and up; used when packing the data.

MakeHuman's rest pose has arms half raised, its shoulder stands high above the joint, and the upper arm has half of the skin
between joint and neck. As the arm goes down that skin rises and makes shoulders square; as it goes up, it sinks in."""

import numpy as np

from ....core.motion.interpolation import smoothstep
from . import source

_LOWERED = 0.3
"""Share of its height above the joint that the shoulder loses."""

_ARM = 0.234
"""Length in metres of the upper arm for which the reaches below were chosen."""

_ACROSS = np.array([0.9, 0.0, -0.43]) / np.hypot(0.9, 0.43)
"""Where the arm begins: the direction away from the trunk that divides the skin of both (side, depth, height)."""

_BEFORE, _BEHIND = 0.06, 0.08
"""Metres over which the arm's share of the skin grows, before and behind the joint, on top of the shoulder."""


def lowered(points: np.ndarray) -> np.ndarray:
    """Return ``points`` (19158, 3) of a person, in metres, whose shoulders slope; joints stay where they are."""
    faces = source.base_mesh().faces
    joints = np.unique(np.concatenate([rows.ravel() for name, rows in faces.items() if name.startswith("joint-")]))
    shaped, above = points.copy(), np.array([0.35, 0.0, 1.0]) / np.hypot(0.35, 1.0)
    for side, sign in (("l", 1), ("r", -1)):
        away, size = _from_joint(points, side)
        near = 1 - smoothstep((np.linalg.norm(away * [1, 0.8, 1], axis=1) - 0.05) / 0.09)
        less = _LOWERED * near * np.maximum(away @ above, 0)
        less[joints] = 0
        shaped -= size * less[:, None] * above * [sign, 1, 1]
    return shaped


def divided(name: str, bones: list[str], weights: np.ndarray, people: list[np.ndarray]) -> np.ndarray:
    """Return ``weights`` (19158, bones) of the rig ``name`` where the clavicle has the top of the shoulder as far as the joint.

    ``people`` are the points (19158, 3) of all persons that share them."""
    rig = source.rig(name)[0]
    for side in "lr":
        joint = f"joint-{side}-shoulder"
        root = next(bone for bone in bones if rig[bone]["head"].get("cube_name") == joint)
        arm = np.array([_is_below(rig, bone, root) for bone in bones])
        had = weights[:, arm].sum(1)
        share = np.mean([_share(points, side, had) for points in people], 0)
        weights = weights * np.where(arm, np.divide(share, had, out=np.zeros_like(had), where=had > 0)[:, None], 1)
        weights[:, bones.index(rig[root]["parent"])] += had - share
    return weights.astype(np.float32)


def _share(points: np.ndarray, side: str, had: np.ndarray) -> np.ndarray:
    """Return the arm's share (n,) of the skin at ``points``, never more than it ``had``; below the joint it stays."""
    away, _ = _from_joint(points, side)
    reach = 0.55 + 0.45 * smoothstep(away[:, 2] / 0.06 + 0.5)
    wanted = smoothstep((away @ _ACROSS + _BEFORE * reach) / ((_BEFORE + _BEHIND) * reach))
    near = (1 - smoothstep((np.linalg.norm(away, axis=1) - 0.13) / 0.05)) * smoothstep((away[:, 2] + 0.03) / 0.08)
    return had - near * np.maximum(had - wanted, 0)


def _from_joint(points: np.ndarray, side: str) -> tuple[np.ndarray, float]:
    """Return ``points`` from a shoulder's joint, x away from the trunk, in units of a usual arm's metres; and the unit."""
    faces = source.base_mesh().faces
    joint, elbow = (points[np.unique(faces[f"joint-{side}-{name}"])].mean(0) for name in ("shoulder", "elbow"))
    size = float(np.linalg.norm(elbow - joint)) / _ARM
    return (points - joint) * [1 if side == "l" else -1, 1, 1] / size, size


def _is_below(rig: dict, bone: str, root: str) -> bool:
    while bone and bone != root:
        bone = rig[bone]["parent"]
    return bool(bone)
