"""The stage: hips, head and gesturing hands are in the picture, and a user's own scene keeps what it has."""

import bpy
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Matrix, Vector
from s2ag.s2ag_blender.characters import mannequin
from s2ag.s2ag_blender.render import stage


def in_picture(scene, point) -> bool:
    x, y, depth = world_to_camera_view(scene, scene.camera, Vector(point))
    return 0 < x < 1 and 0 < y < 1 and depth > 0


@pytest.mark.parametrize("resolution", [(960, 720), (1280, 720), (720, 720), (720, 1280)])
def test_camera_holds_hips_head_and_spread_arms(resolution):
    scene = bpy.context.scene
    character = mannequin.build()
    stage.set_up_scene(scene, [character], resolution)
    bpy.context.view_layer.update()
    bones = character.armature.data.bones
    shoulder, arm = bones["upper_arm.L"].head_local, 0.68
    for point in (bones["hips"].head_local, bones["head"].tail_local, *(bones[f"hand.{side}"].head_local for side in "LR")):
        assert in_picture(scene, point)
    for side in (1, -1):
        assert in_picture(scene, (side * (shoulder.x + arm), -0.05, shoulder.z))
    assert not in_picture(scene, bones["foot.L"].tail_local) or resolution[1] >= resolution[0]


def test_camera_goes_where_the_character_faces():
    scene = bpy.context.scene
    character = mannequin.build()
    character.armature.matrix_world = Matrix.Translation((3, 1, 0.5)) @ Matrix.Rotation(np.pi / 2, 4, "Z") @ Matrix.Scale(2, 4)
    stage.set_up_scene(scene, [character])
    away = np.array(scene.camera.matrix_world.translation) - [3, 1, 0.5]
    assert away[0] > 3 and abs(away[1]) < 0.3 * away[0]  # turned by a quarter, -y has become +x
    bpy.context.view_layer.update()
    assert in_picture(scene, character.armature.matrix_world @ character.armature.data.bones["head"].tail_local)


def test_height_counts_the_meshes():
    place = stage.Place.of(mannequin.build())
    assert 1.7 < place.height < 1.85
    assert abs(place.ground[2]) < 0.02
    assert np.allclose(place.facing, [0, -1, 0], atol=1e-3) and np.allclose(place.left, [1, 0, 0], atol=1e-3)


def test_a_lit_scene_with_a_camera_stays_as_it_is():
    scene = bpy.context.scene
    character = mannequin.build()
    camera = bpy.data.objects.new("Mine", bpy.data.cameras.new("Mine"))
    light = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    for item in (camera, light):
        scene.collection.objects.link(item)
    scene.camera = camera
    before = set(bpy.data.objects), scene.world, scene.view_settings.view_transform, scene.display.shading.color_type
    stage.add_missing_camera_and_light(scene, [character])
    assert (set(bpy.data.objects), scene.world, scene.view_settings.view_transform, scene.display.shading.color_type) == before
    assert scene.camera is camera


def test_only_what_a_scene_lacks_is_added():
    scene = bpy.context.scene
    character = mannequin.build()
    scene.world = bpy.data.worlds.new("Mine")
    stage.add_missing_camera_and_light(scene, [character])
    assert scene.camera is not None and scene.world.name == "Mine"
    assert not [item for item in scene.objects if item.type == "LIGHT" or item.name.startswith("Backdrop")]
