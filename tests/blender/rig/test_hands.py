"""Fingers, twist bones and the trunk's shape on real armatures."""

import bpy
import handed
import numpy as np
import pytest
import rigging
from bodies import body
from hands import FINGERS, with_hands
from s2ag.core.motion.motion import Motion
from s2ag.rigs.goals import Options
from s2ag.rigs.proportions import guess_trunk
from s2ag.rigs.skeleton import Mapping
from s2ag.s2ag_blender import compat, provenance
from s2ag.s2ag_blender.keys.apply import apply_motion
from s2ag.s2ag_blender.rig import body_shape, hands, reading

LITTLE = "left_little2"


def keyed(action, item):
    """{bone: number of keys} of an action."""
    names = {bone.name: f'pose.bones["{bone.name}"].rot' for bone in item.pose.bones}
    curves = compat.curves(action)
    found = {name: [len(c.keyframe_points) for c in curves if c.data_path.startswith(path)] for name, path in names.items()}
    return {name: counts[0] for name, counts in found.items() if counts}


@pytest.fixture
def gestured(wave):
    """A function that makes a character with hands, lets ``change(item)`` alter it, and keys a motion on it."""

    def make(change=lambda item: None, options=None):
        whole = with_hands()
        item = rigging.make_armature(whole)
        change(item)
        return item, apply_motion(item, wave(), 1, mapping=whole.mapping, options=options), whole

    return make


def test_fingers_get_one_key_and_arms_get_all(gestured):
    item, action, _ = gestured()
    counts = keyed(action, item)
    for side in ("left", "right"):
        assert all(counts[f"{side}_{finger}{link}"] == 1 for finger in FINGERS for link in (1, 2, 3))
        assert counts[f"{side}_fore"] > 1
    pose = rigging.evaluated(item, 5)
    rest = np.array(item.data.bones["left_little3"].head_local)
    hand = pose["left_hand"] @ np.linalg.inv(np.array(item.data.bones["left_hand"].matrix_local))
    moved = np.linalg.inv(hand) @ pose["left_little3"][:, 3] - [*rest, 1]
    assert moved[2] < -1  # the palm of a T pose looks down


def test_no_fingers_when_not_wanted(gestured):
    item, action, _ = gestured(options=Options(fingers=0.0))
    assert not [name for name in keyed(action, item) if "little" in name]


def posed(item):
    bone = item.pose.bones[LITTLE]
    bone.rotation_mode = "XYZ"
    bone.rotation_euler.x = 0.3


def constrained(item):
    item.pose.bones[LITTLE].constraints.new("LIMIT_ROTATION")


def locked(item):
    item.pose.bones[LITTLE].lock_rotation[1] = True


def driven(item):
    item.pose.bones[LITTLE].driver_add("rotation_quaternion", 1)


def keyed_by_the_user(item):
    item.pose.bones[LITTLE].keyframe_insert("rotation_quaternion", frame=1)


@pytest.mark.parametrize("change", [posed, constrained, locked, driven, keyed_by_the_user])
def test_what_the_user_did_with_a_finger_stays(gestured, change):
    free = []

    def changed(item):
        change(item)
        free.extend(hands.free_bones(item))

    item, action, _ = gestured(changed)
    assert LITTLE not in keyed(action, item) and LITTLE not in free and "left_middle2" in free
    assert keyed(action, item)["left_middle2"] == 1
    if change is posed:
        bpy.context.scene.frame_set(5)
        assert item.pose.bones[LITTLE].rotation_euler.x == pytest.approx(0.3)


def test_a_second_performance_keys_them_again(gestured, wave):
    item, first, whole = gestured()
    bpy.context.scene.frame_set(4)
    second = apply_motion(item, wave(), 1, mapping=whole.mapping)
    assert second != first and provenance.read(second) is not None
    assert keyed(second, item)[LITTLE] == 1
    values = [[c.evaluate(1) for c in compat.curves(action) if LITTLE in c.data_path] for action in (first, second)]
    np.testing.assert_allclose(*values, atol=1e-6)


@pytest.mark.parametrize("mode", ["QUATERNION", "XYZ", "AXIS_ANGLE"])
def test_a_pose_that_a_take_left_standing_is_nobodys(wave, mode):
    whole = with_hands()
    item = rigging.make_armature(whole)
    for bone in item.pose.bones:
        bone.rotation_mode = mode
    moving = Motion(wave().directions, hands=handed.hands(wave().directions))
    apply_motion(item, moving, 1, mapping=whole.mapping)
    bpy.context.scene.frame_set(7)
    left = item.pose.bones[LITTLE].matrix_basis.to_quaternion().angle
    item.animation_data.action = None
    bpy.context.scene.frame_set(2)
    assert item.pose.bones[LITTLE].matrix_basis.to_quaternion().angle == pytest.approx(left) and left > 0.01
    drawn = item.pose.bones["left_index2"]
    drawn.rotation_mode = "QUATERNION"
    drawn.rotation_quaternion = (0.9, 0.3, 0.3, 0.1)
    free = hands.free_bones(item)
    assert LITTLE in free and "right_middle2" in free and "left_index2" not in free
    assert "left_index2" in hands.free_bones(item, posed=True)
    plain = apply_motion(item, Motion(wave().directions), 1, mapping=whole.mapping)
    assert LITTLE in keyed(plain, item) and "left_index2" not in keyed(plain, item)
    assert keyed(apply_motion(item, moving, 1, mapping=whole.mapping), item)["left_index2"] > 1


def trunk(item, width, depth, groups=("spine2",), transform=None):
    """An elliptic tube around the spine, skinned to ``groups``, in centimetres like the bodies of the tests."""
    turn, height = (
        grid.ravel() for grid in np.meshgrid(np.linspace(0, 2 * np.pi, 40, endpoint=False), np.linspace(90, 146, 40))
    )
    points = np.stack([width * np.cos(turn), depth * np.sin(turn), height], -1)
    mesh = bpy.data.meshes.new("Trunk")
    skin = bpy.data.objects.new("Trunk", mesh)
    bpy.context.collection.objects.link(skin)
    if transform is not None:
        skin.matrix_world = transform
        bpy.context.view_layer.update()
        inverse = np.array(skin.matrix_world.inverted() @ item.matrix_world)
        points = points @ inverse[:3, :3].T + inverse[:3, 3]
    mesh.from_pydata(points.tolist(), [], [])
    for name in groups:
        skin.vertex_groups.new(name=name).add(range(len(points)), 1.0, "REPLACE")
    skin.modifiers.new("Armature", "ARMATURE").object = item
    return skin


def test_the_trunk_is_measured_whatever_the_transforms_of_its_mesh():
    from mathutils import Matrix

    whole = body()
    item = rigging.make_armature(whole)
    item.matrix_world = Matrix.LocRotScale((3, 1, 0), None, (0.01, 0.01, 0.01)) @ Matrix.Rotation(0.7, 4, "Z")
    bones = reading.read(item)
    assert body_shape.read_trunk(item, bones, whole.mapping) is None
    trunk(item, 19, 12, transform=Matrix.Rotation(1.0, 4, "X") @ Matrix.Scale(0.5, 4))
    found = body_shape.read_trunk(item, bones, whole.mapping)
    np.testing.assert_allclose(found.halves, [[19, 12]] * len(found.halves), rtol=0.03)


def test_a_trunk_of_few_points_is_measured_by_its_edges():
    whole = body()
    item = rigging.make_armature(whole)
    skin = trunk(item, 15, 10)
    skin.data.clear_geometry()
    turn = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    rings = [np.stack([15 * np.cos(turn), 10 * np.sin(turn), np.full(40, height)], -1) for height in (50.0, 90.0, 146.0)]
    strips = [(row + k, row + k + 40) for row in (0, 40) for k in range(40)]
    skin.data.from_pydata(np.concatenate(rings).tolist(), strips, [])
    skin.vertex_groups.new(name="spine2").add(range(120), 1.0, "REPLACE")
    found = body_shape.read_trunk(item, reading.read(item), whole.mapping)
    usual = guess_trunk(reading.read(item), whole.mapping)
    assert len(found.heights) > 12 and found.heights[0] < usual.heights[0]
    np.testing.assert_allclose(found.halves, [[15, 10]] * len(found.halves), rtol=0.03)


def test_a_head_is_measured_where_a_mesh_shows_it():
    whole = body()
    item = rigging.make_armature(whole)
    bones = reading.read(item)
    trunk(item, 15, 10)
    assert body_shape.read_trunk(item, bones, whole.mapping).skull is None
    head = trunk(item, 9, 11, groups=("head",))
    for vertex in head.data.vertices:
        vertex.co.z = 150 + (vertex.co.z - 90) / 56 * 24
    found = body_shape.read_trunk(item, bones, whole.mapping)
    np.testing.assert_allclose(found.skull.halves, [9, 11, 12], rtol=0.07)
    np.testing.assert_allclose(found.halves, [[15, 10]] * len(found.halves), rtol=0.03)


def test_shape_keys_count_as_they_are_set():
    whole = body()
    item = rigging.make_armature(whole)
    skin = trunk(item, 15, 10)
    skin.shape_key_add(name="Basis")
    broad = skin.shape_key_add(name="Broad")
    for point in broad.data:
        point.co.x *= 2
    for value in (0.0, 0.4):
        broad.value = value
        found = body_shape.read_trunk(item, reading.read(item), whole.mapping)
        np.testing.assert_allclose(found.halves, [[15 * (1 + value), 10]] * len(found.halves), rtol=0.03)


def test_arms_sleeves_and_hidden_meshes_do_not_count():
    whole = body("I")
    item = rigging.make_armature(whole)
    bones = reading.read(item)
    trunk(item, 30, 30, groups=("left_upper",))
    trunk(item, 40, 40).hide_render = True
    assert body_shape.read_trunk(item, bones, whole.mapping) is None
    trunk(item, 15, 10)
    assert body_shape.read_trunk(item, bones, whole.mapping).halves[5, 0] == pytest.approx(15, rel=0.03)
    assert guess_trunk(bones, whole.mapping).halves[0, 0] == pytest.approx(0.75 * 18)


def test_control_rigs_find_the_trunk_by_where_its_bones_are():
    """The mapped controls carry no skin: bones with other names beside the spine do."""
    whole = body()
    joints = dict(whole.joints) | {
        "DEF_a": ((0, 0.5, 106), "root"),
        "DEF_b": ((0, 0.5, 125), "root"),
        "DEF_arm": ((30, 1, 130), "root"),
    }
    item = rigging.make_armature(type(whole)(joints, whole.chains))
    bones = reading.read(item)
    trunk(item, 17, 11, groups=("DEF_b",))
    trunk(item, 60, 60, groups=("DEF_arm",))
    found = body_shape.read_trunk(item, bones, Mapping(whole.chains, hips="hips"))
    np.testing.assert_allclose(found.halves, [[17, 11]] * len(found.halves), rtol=0.03)
