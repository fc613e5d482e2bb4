"""How much of a character's meshes hangs on each bone, and where."""

import bpy
import numpy as np

from ...rigs.chains import Skin
from ...rigs.plain import Bones
from . import girth

VERTICES = 4000
"""As many vertices of a character are looked at, evenly spread."""


def read(armature: bpy.types.Object, bones: Bones) -> Skin | None:
    """The skin of an armature's bones at rest, or None where no mesh hangs on them."""
    rows = {bone.name: row for row, bone in enumerate(armature.data.bones) if bone.use_deform}
    weights, sums = np.zeros(len(bones.names)), np.zeros((len(bones.names), 3))
    items = girth.meshes(armature)
    step = max(1, -(-sum(len(item.data.vertices) for item in items) // VERTICES))
    for item in items:
        groups = {group.index: rows[group.name] for group in item.vertex_groups if group.name in rows}
        points, vertices = girth.in_armature(armature, item), item.data.vertices
        pulled, places, shares = [], [], []  # thousands of tuples would call Python's collector, which is slower than all this
        for index in range(0, len(points), step):
            known = (pull for pull in vertices[index].groups.values() if pull.group in groups)
            pulls = [(groups[pull.group], pull.weight) for pull in known]
            whole = sum(weight for _, weight in pulls)
            if whole > 0:
                pulled += [row for row, _ in pulls]
                places += [index] * len(pulls)
                shares += [weight / whole for _, weight in pulls]
        if pulled:
            np.add.at(weights, pulled, shares)
            np.add.at(sums, pulled, np.array(shares)[:, None] * points[places])
    if not weights.any():
        return None
    return Skin(weights, sums / np.maximum(weights, 1e-9)[:, None])
