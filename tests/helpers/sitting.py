"""Characters put on a chair, and how deep their hands lie in their thighs, by the vertices of their meshes."""

import bpy
import numpy as np
from mathutils import Matrix, Vector
from mathutils.bvhtree import BVHTree
from s2ag.rigs import legs
from s2ag.rigs.skeleton import character_frame
from s2ag.s2ag_blender.rig import body_shape, reading


class Sitter:
    """A character whose thighs are turned up by ``degrees``, knees bent by as much; ``left`` and ``up`` (3,) are its own."""

    def __init__(self, item, degrees=84.0):
        self.item, self.bones = item, reading.read(item)
        self.mapping = reading.resolve_mapping(item, self.bones)
        self.left, _, self.up = character_frame(self.bones, self.mapping)
        self.legs = legs.find(self.bones, self.mapping, self.up)
        for leg in self.legs.pair:
            outward = np.sign(self.bones.heads[leg.thigh] @ self.left)
            self.turn(leg.thigh, self.left, -degrees)
            self.turn(leg.thigh, self.up, 8 * outward)
            self.turn(leg.shin, self.left, degrees)

    def turn(self, row, axis, degrees):
        bpy.context.view_layer.update()
        bone = self.item.pose.bones[self.bones.names[row]]
        about = Matrix.Translation(bone.matrix.translation)
        bone.matrix = about @ Matrix.Rotation(np.radians(degrees), 4, Vector(axis.tolist())) @ about.inverted() @ bone.matrix
        bpy.context.view_layer.update()

    def hips(self):
        """The middle between the hip joints (3,) in the scene."""
        heads = [self.item.matrix_world @ self.item.pose.bones[self.bones.names[leg.thigh]].head for leg in self.legs.pair]
        return np.mean(heads, axis=0)

    def posed(self):
        """Matrices of pelvis, legs and feet, as they are now."""
        rows = [row for row in range(len(self.bones.names)) if {row, *self.bones.ancestors(row)} & set(self.legs.rows()[1:])]
        bpy.context.view_layer.update()
        return np.array([self.item.pose.bones[self.bones.names[row]].matrix for row in (self.legs.pelvis, *rows)])

    def below(self, row, without=-1):
        rows = range(len(self.bones.names))
        return {self.bones.names[one] for one in rows if row in (one, *self.bones.ancestors(one)) and one != without
                and without not in self.bones.ancestors(one)}  # fmt: skip

    def depth(self, frame):
        """How deep, in metres, the deepest vertex of a hand lies in a thigh at a frame, and all vertices of hands (n, 3)."""
        bpy.context.scene.frame_set(frame)
        scene = bpy.context.evaluated_depsgraph_get()
        thighs = set.union(*(self.below(leg.thigh, leg.shin) for leg in self.legs.pair))
        hands = set.union(*(self.below(self.bones.row(self.mapping.chains[f"{side}_hand"][0])) for side in ("left", "right")))
        points, faces, tips = [], [], []
        for item in body_shape.meshes(self.item):
            names = {group.index: group.name for group in item.vertex_groups}
            pulls = [[(one.weight, names[one.group]) for one in vertex.groups] for vertex in item.data.vertices]
            owners = [max(each, default=(0, ""))[1] for each in pulls]
            seen = item.evaluated_get(scene).to_mesh()
            if len(seen.vertices) != len(owners):
                continue
            places = [item.matrix_world @ vertex.co for vertex in seen.vertices]
            inside = {row for row, owner in enumerate(owners) if owner in thighs}
            theirs = [list(face.vertices) for face in seen.polygons if inside.issuperset(face.vertices)]
            faces += [[len(points) + row for row in face] for face in theirs]
            points += places
            tips += [place for place, owner in zip(places, owners, strict=True) if owner in hands]
        tree, up, deepest = BVHTree.FromPolygons(points, faces), Vector((0, 0, 1)), 0.0
        for tip in tips:
            near, normal, _, apart = tree.find_nearest(tip, 0.1)
            if near is not None and (tip - near).dot(normal) < 0 and all(tree.ray_cast(tip, way)[0] for way in (up, -up)):
                deepest = max(deepest, apart)
        return deepest, np.array(tips)
