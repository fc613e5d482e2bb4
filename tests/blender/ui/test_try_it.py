"""One press in an empty scene."""

import os

import bpy
import pytest
from acted import drawn, press
from s2ag.core.sound import wavefile
from s2ag.s2ag_blender import compat
from s2ag.s2ag_blender.takes import engine_requests, sources
from s2ag.s2ag_blender.ui import try_it, views


@pytest.fixture
def empty(extension, monkeypatch):
    """The extension in an empty scene, with nothing set up: the engine that ships, whatever the tests' own is."""
    monkeypatch.delenv("S2AG_PYTHON", raising=False)
    engine_requests.stop_engine()
    yield bpy.context.scene
    engine_requests.stop_engine()


def test_the_example_is_there_with_its_words():
    assert try_it.VOICE.is_file() and try_it.VOICE.stat().st_size < 500_000
    assert os.path.basename(sources.transcript_beside(str(try_it.VOICE))) == "hello.txt"
    assert wavefile.read_header(try_it.VOICE) is not None  # builds of Blender without a sound system read WAV alone


def test_one_press_gestures_with_sound(empty):
    assert "s2ag.try_it" in drawn()
    press(bpy.ops.s2ag.try_it)
    human = bpy.context.active_object
    action = human.animation_data.action
    assert human.type == "ARMATURE" and action.frame_range[1] > 300 and empty.frame_end >= action.frame_range[1]
    keyed = {curve.data_path.split('"')[1] for curve in compat.curves(action)}
    assert {name for name in keyed if "finger" in name}, sorted(keyed)
    strips = compat.sequencer_strips(empty.sequence_editor)
    sounds = bpy.app.build_options.audaspace  # a bpy without Blender's sound system has the gestures alone
    assert [(strip.type, compat.strip_start(strip)) for strip in strips] == [("SOUND", empty.frame_start)] * sounds
    assert human.s2ag.takes and engine_requests.engine(bpy.context).ships


def test_the_person_stands_beside_what_is_there(empty):
    bpy.ops.mesh.primitive_cube_add(size=2)
    human = try_it.stage(bpy.context)
    bpy.context.view_layer.update()
    arms = [human.matrix_world @ bone.head_local for bone in human.data.bones]
    assert min(point.x for point in arms) > 1


def test_the_view_is_a_films_and_the_scene_stays(empty):
    bpy.ops.wm.read_factory_settings()
    scene = bpy.context.scene
    cube, before = scene.objects["Cube"], {item.name: item.matrix_world.copy() for item in scene.objects}
    human = try_it.stage(bpy.context)
    area = next(area for area in bpy.context.screen.areas if area.type == "VIEW_3D")
    with bpy.context.temp_override(area=area):
        views.frame_view(bpy.context)
    space = area.spaces.active
    assert space.local_view is not None and not space.overlay.show_overlays and space.shading.color_type == "TEXTURE"
    if bpy.app.version >= (5, 0):  # before, Blender gives objects their local view when it draws, which a window alone does
        assert cube.local_view_get(space) is False and human.local_view_get(space)
        worn = [item for item in scene.objects if item.type == "MESH" and item.find_armature() is human]
        assert all(item.local_view_get(space) for item in worn)
    assert bpy.context.view_layer.objects.active is human and list(bpy.context.selected_objects) == [human]
    assert not cube.hide_get() and not cube.hide_viewport
    assert all(scene.objects[name].matrix_world == matrix for name, matrix in before.items())


def test_a_character_out_of_view_is_turned_to(empty):
    """One that was imported beside Try It's person; a view that shows it, and a camera's, stay."""
    bpy.ops.wm.read_factory_settings()
    other = engine_requests.add_character("mannequin")
    bpy.context.view_layer.update()
    area = next(area for area in bpy.context.screen.areas if area.type == "VIEW_3D")
    view = area.spaces.active.region_3d

    def turned(x, perspective="PERSP"):
        other.location.x, view.view_perspective, before = x, perspective, view.view_location.copy()
        bpy.context.view_layer.update()
        with bpy.context.temp_override(area=area):
            views.show_character(bpy.context, other)
        return view.view_location != before

    assert not turned(0) and not turned(50, "CAMERA")
    assert turned(50) and (view.view_location - other.matrix_world.translation).length < 2
    assert other.dimensions.z < view.view_distance < 3 * other.dimensions.z
