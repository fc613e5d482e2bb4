"""Measures how much of a character's meshes each bone deforms, and where."""

import numpy as np

from ...rigs.chains import Skin
from ...rigs.skeleton import Bones
from ..datablocks import ArmatureObject
from . import body_shape

VERTICES = 4000
"""Most vertices of a character that are sampled, evenly spread."""


def read(armature: ArmatureObject, bones: Bones) -> Skin | None:
    """Return the skin weights of an armature's bones at rest, or None where they deform no mesh."""
    rows = {bone.name: row for row, bone in enumerate(armature.data.bones) if bone.use_deform}
    weights, sums = np.zeros(len(bones.names)), np.zeros((len(bones.names), 3))
    items = body_shape.meshes(armature)
    step = max(1, -(-sum(len(item.data.vertices) for item in items) // VERTICES))
    for item in items:
        groups = {group.index: rows[group.name] for group in item.vertex_groups if group.name in rows}
        points, vertices = body_shape.in_armature(armature, item), item.data.vertices
        pulled, indices, shares = [], [], []  # thousands of tuples would trigger Python's slow garbage collector
        for index in range(0, len(points), step):
            pulls = [
                (groups[one.group], one.weight) for one in body_shape.vertex_weights(vertices[index]) if one.group in groups
            ]
            total = sum(weight for _, weight in pulls)
            if total > 0:
                pulled += [row for row, _ in pulls]
                indices += [index] * len(pulls)
                shares += [weight / total for _, weight in pulls]
        if pulled:
            np.add.at(weights, pulled, shares)
            np.add.at(sums, pulled, np.array(shares)[:, None] * points[indices])
    if not weights.any():
        return None
    return Skin(weights, sums / np.maximum(weights, 1e-9)[:, None])
