"""The mannequin: rigid limbs on a plain skeleton that points where a motion says."""

import re

import bpy
import numpy as np
from s2ag.core.motion import handshape, skeleton
from s2ag.core.motion.hands import Hands
from s2ag.core.motion.motion import Motion
from s2ag.s2ag_blender.characters import mannequin, mannequin_recipe
from s2ag.s2ag_blender.keys.apply import apply_motion
from s2ag.s2ag_blender.rig import reading

FINGERS = ("index", "middle", "ring", "little")


def test_data_is_what_the_recipe_makes():
    stored, made = mannequin.DATA.read_text("utf-8"), mannequin_recipe.text()
    number = r"-?\d+\.\d+(?:e-\d+)?"
    assert re.sub(number, "", stored) == re.sub(number, "", made)
    assert np.allclose(*([float(one) for one in re.findall(number, text)] for text in (stored, made)), rtol=0, atol=1e-12)


def test_each_point_hangs_on_one_bone():
    character = mannequin.build()
    (body,) = character.meshes
    assert all(len(vertex.groups) == 1 and vertex.groups[0].weight == 1 for vertex in body.data.vertices)
    names = {group.name for group in body.vertex_groups}
    assert names == set(character.armature.data.bones.keys())


def test_limbs_are_closed_and_face_outwards():
    (body,) = mannequin.build().meshes
    mesh = body.data
    volume = sum(mesh.vertices[face.vertices[0]].co.dot(face.normal) * face.area / 3 for face in mesh.polygons)
    assert 0.04 < volume < 0.09  # of a slim person, in cubic metres
    edges = {}
    for face in mesh.polygons:
        for edge in face.edge_keys:
            edges[edge] = edges.get(edge, 0) + 1
    assert set(edges.values()) == {2}


def test_is_symmetric():
    (body,) = mannequin.build().meshes
    points = np.array([vertex.co for vertex in body.data.vertices])
    left, right = points[points[:, 0] > 0.05], points[points[:, 0] < -0.05] * [-1, 1, 1]
    assert len(left) == len(right)
    assert np.allclose(np.sort(left, 0), np.sort(right, 0), atol=1e-5)


def test_arms_point_where_the_motion_points(wave):
    character = mannequin.build()
    motion = wave(16)
    scene = bpy.context.scene
    scene.render.fps = 15
    apply_motion(character.armature, motion, 1)
    chains = reading.resolve_mapping(character.armature, reading.read(character.armature)).chains
    wanted = skeleton.canonical_to_blender(motion.directions)
    for row in (0, 4, 11):
        scene.frame_set(1 + row)
        for part in ("left_upper_arm", "left_forearm", "right_upper_arm", "right_forearm"):
            bone = character.armature.pose.bones[chains[part][0]]
            found = np.array((bone.tail - bone.head).normalized())
            angle = np.degrees(np.arccos(np.clip(found @ wanted[row, skeleton.EDGE_NAMES.index(part)], -1, 1)))
            assert angle < 0.1, part


def test_fingers_bend_as_the_motion_says():
    character = mannequin.build()
    directions = np.repeat(skeleton.REST[None], 2, 0)
    shape = np.tile(handshape.RELAXED, (2, 2, 1)).astype(np.float32)
    shape[0, :, :8], shape[1, :, :8] = 0.0, 80.0  # an open hand and a fist
    palms = np.repeat([[[1.0, 0, 0], [-1, 0, 0]]], 2, 0)
    bpy.context.scene.render.fps = 15
    motion = Motion(directions, hands=Hands.of(directions[:, [5, 8]], palms, shape))
    apply_motion(character.armature, motion, 1)
    for side in "LR":
        reach = []
        for frame in (1, 2):
            bpy.context.scene.frame_set(frame)
            pose = character.armature.pose.bones
            reach.append([(pose[f"{finger}_2.{side}"].tail - pose[f"hand.{side}"].head).length for finger in FINGERS])
        assert (np.array(reach[1]) < np.array(reach[0]) - 0.03).all()  # tips come to the palm
