"""Hands on characters as Blender's importers leave them: every bone at rest, or most of them posed by the file."""

import bpy
import found_rigs
import handed
import numpy as np
import people
import pytest
from bodies import performance
from mathutils import Euler
from s2ag.core.motion.motion import Motion
from s2ag.rigs import fingers
from s2ag.s2ag_blender import compat
from s2ag.s2ag_blender.characters import human, mannequin
from s2ag.s2ag_blender.keys.apply import apply_motion
from s2ag.s2ag_blender.rig import dependencies, hands, reading

pytestmark = pytest.mark.slow

SIDES = ("left", "right")
KINDS = {"fbx": "fbx", "fbx2": "fbx", "glb": "glb", "usdc": "usdc"}
"""Blender's importers, and the endings of their files."""


def pose(item):
    """Turn every bone by a few degrees, as node rotations of a file that differ from those of its skin's bind pose."""
    random = np.random.default_rng(4)
    for bone in item.pose.bones:
        bone.matrix_basis = Euler(random.uniform(-0.15, 0.15, 3)).to_matrix().to_4x4()
    bpy.context.view_layer.update()


def keyed(item):
    """Key a motion; for each side whether the hand is keyed, which fingers are not, and the sentences told."""
    bones, told, directions = reading.read(item), [], performance(20, size=0.3)
    mapping, free = reading.resolve_mapping(item, bones), hands.free_bones(item, posed=True)
    usable = np.array([name in free for name in bones.names])
    action = apply_motion(item, Motion(directions, hands=handed.hands(directions)), 1, report=told.append)
    curves = compat.curves(action)
    moving = {dependencies.bone_of(curve.data_path) for curve in curves if len(curve.keyframe_points) > 1}
    found = [fingers.find_hand(bones, mapping, side) or fingers.find_hand(bones, mapping, side, usable) for side in SIDES]
    rows = [row for hand in found if hand for chain in (*hand.fingers, hand.thumb) for row in chain[:3]]
    wrists = [mapping.chains[f"{side}_hand"][0] in moving for side in SIDES]
    return wrists, len(rows), [bones.names[row] for row in rows if bones.names[row] not in moving], told


@pytest.fixture(scope="module", params=human.RIGS)
def files(request, tmp_path_factory):
    """Paths ``{(kind, posed): path}`` of a person on one of the rigs, written by Blender's exporters."""
    folder, paths = tmp_path_factory.mktemp(request.param), {}
    bpy.ops.wm.read_factory_settings(use_empty=True)
    item = people.armature(request.param)
    for mesh in list(item.children):  # skin is enough to bind bones to
        if mesh.name == "Human Skin":
            mesh.shape_key_clear()
        else:
            bpy.data.objects.remove(mesh)
    for posed in (False, True):
        if posed:
            pose(item)
        for kind, suffix in KINDS.items():
            paths[kind, posed] = folder / f"{posed}.{suffix}"
        bpy.ops.export_scene.fbx(filepath=str(paths["fbx", posed]), bake_anim=False)
        bpy.ops.export_scene.gltf(filepath=str(paths["glb", posed]), export_rest_position_armature=False)
        bpy.ops.wm.usd_export(filepath=str(paths["usdc", posed]), export_animation=False)
    return request.param, paths


@pytest.mark.parametrize("posed", [False, True], ids=["relaxed", "posed"])
@pytest.mark.parametrize("kind", KINDS)
def test_hands_and_fingers_of_an_imported_person_are_keyed(files, kind, posed):
    rig, paths = files
    bpy.ops.wm.read_factory_settings(use_empty=True)
    item = found_rigs.imported(paths[kind, posed], kind)
    turned = [bone.name for bone in item.pose.bones if bone.matrix_basis.to_quaternion().angle > 1e-3]
    if kind != "usdc" or bpy.app.version >= (4, 5):  # older ones read the rest pose alone
        assert len(turned) > (0.6 * len(item.pose.bones) if posed else 5)
    wrists, count, still, told = keyed(item)
    assert all(wrists) and not still
    if rig == "cmu_mb":  # a hand is one bone there, and a finger another
        assert count == 0 and told == ["No fingers were found below the hands, so each hand moves as a whole."]
    else:
        assert count == 30 and not told


def without_keys(shared):
    item = found_rigs.naturalpoint(shared)
    item.animation_data_clear()
    return item


FOUND = {
    "Male_Adult_01.fbx": lambda shared: found_rigs.rocketbox(shared, "Male_Adult_01"),
    "Female_Adult_01.fbx": lambda shared: found_rigs.rocketbox(shared, "Female_Adult_01"),
    "Male_Adult_01.fbx, newer importer": lambda shared: found_rigs.rocketbox(shared, "Male_Adult_01", "fbx2"),
    "Female_Adult_01.fbx, newer importer": lambda shared: found_rigs.rocketbox(shared, "Female_Adult_01", "fbx2"),
    "rig-human.blend": found_rigs.mesh2motion,
    "pnskeleton.bvh": without_keys,
    "mannequin": lambda shared: mannequin.build().armature,
}


@pytest.mark.parametrize("posed", [False, True], ids=["rest", "posed"])
@pytest.mark.parametrize("name", FOUND)
def test_hands_and_fingers_of_what_others_made_are_keyed(shared, name, posed):
    item = FOUND[name](shared)
    if posed:
        pose(item)
    wrists, count, still, told = keyed(item)
    assert all(wrists) and not still and not told
    assert count == {"pnskeleton.bvh": 28, "mannequin": 20}.get(name, 30)  # its thumbs have two bones, its fingers two


def test_every_rig_file_at_hand_is_tried(shared):
    assert found_rigs.files(shared) == {name for name in FOUND if "." in name and "," not in name}


@pytest.mark.parametrize("posed", [False, True], ids=["rest", "posed"])
@pytest.mark.parametrize("number", [0, 1], ids=["metarig", "controls"])
def test_hands_and_fingers_of_rigify_are_keyed(rigify_saved, number, posed):
    item = found_rigs.opened(rigify_saved[number])
    if posed:
        pose(item)
    wrists, count, still, told = keyed(item)
    assert all(wrists) and count == 30 and not still and not told


def test_what_the_importer_keyed_stays_and_is_told(shared):
    wrists, count, still, told = keyed(found_rigs.naturalpoint(shared))
    assert not any(wrists) and len(still) == count
    assert len([one for one in told if "is keyed, locked or held" in one]) == 2
    assert len([one for one in told if "fingers do not move" in one]) == 2


@pytest.mark.parametrize("change", ["key", "lock", "constrain", "drive"])
def test_what_counts_as_a_wish(change):
    item = people.armature("mixamo")
    name = next(bone.name for bone in item.pose.bones if bone.name.endswith("LeftHandIndex2"))
    bone = item.pose.bones[name]
    if change == "key":
        bone.keyframe_insert("rotation_quaternion", frame=1)
    if change == "lock":
        bone.lock_rotation[0] = True
    if change == "constrain":
        bone.constraints.new("LIMIT_ROTATION")
    if change == "drive":
        bone.driver_add("rotation_quaternion", 1)
    assert name not in hands.free_bones(item, posed=True)
    wrists, _, still, told = keyed(item)
    assert all(wrists) and name in still and not told


def test_without_hands_of_a_motion_a_posed_hand_stays():
    item = people.armature("mixamo")
    before = {bone.name: np.array(bone.matrix_basis) for bone in item.pose.bones if "HandIndex" in bone.name}
    apply_motion(item, Motion(performance(20, size=0.3)), 1)
    bpy.context.scene.frame_set(9)
    for name, matrix in before.items():
        np.testing.assert_allclose(item.pose.bones[name].matrix_basis, matrix, atol=1e-6)
