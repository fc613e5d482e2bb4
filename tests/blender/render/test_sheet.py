"""Sheets of samples: every cell shows its figure, gesture and label, and film and contact sheet have the right shape."""

import json

import bpy
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector
from s2ag.core.motion.motion import Motion
from s2ag.rigs import relative_turns
from s2ag.s2ag_blender import program
from s2ag.s2ag_blender.characters import mannequin
from s2ag.s2ag_blender.render import opengl, sheet

needs_opengl = pytest.mark.skipif(not opengl.is_available(), reason="this machine offers no OpenGL, not even in software")


@pytest.fixture
def cells(tmp_path, wave):
    """Five cells in three columns, the second a longer one."""
    made = []
    for number in range(5):
        path = tmp_path / f"{number}.npz"
        wave(8 if number != 1 else 16).save(path)
        label = [f"{number + 1}  a style", f"seed {number}"]
        made.append({"motion": str(path), "row": number // 3, "column": number % 3, "label": label})
    return made


def fill(cells):
    sheet._fill(bpy.context.scene, cells, [Motion.load(cell["motion"]) for cell in cells])
    return bpy.context.scene


def test_every_cell_holds_its_own_figure_and_label(cells):
    scene = fill(cells)
    bpy.context.view_layer.update()
    figures = [item for item in scene.objects if item.type == "ARMATURE"]
    labels = [item for item in scene.objects if item.type == "FONT"]
    assert len(figures) == 5 and len(labels) == 10
    assert len({item.data for item in scene.objects if item.type == "MESH" and item.parent}) < 40  # shared by all figures
    seen = []
    for figure in figures:
        spots = [figure.matrix_world @ figure.pose.bones[name].head for name in ("head", "hand.L", "hand.R")]
        views = [world_to_camera_view(scene, scene.camera, Vector(spot)) for spot in spots]
        (place,) = {(int((1 - up) * 2), int(across * 3)) for across, up, _ in views}
        seen.append(place)
    assert sorted(seen) == [(cell["row"], cell["column"]) for cell in cells]
    for item in labels:
        corners = [item.matrix_world @ Vector(corner) for corner in item.bound_box]
        across = [world_to_camera_view(scene, scene.camera, corner)[0] * 3 for corner in corners]
        assert int(min(across)) == int(max(across) - 1e-6)


def test_no_hand_reaches_into_another_cell(tmp_path):
    directions = np.tile(relative_turns.NEUTRAL, (8, 1, 1)).astype(np.float32)
    directions[:, [3, 4, 5]], directions[:, [6, 7, 8]] = (-1, 0, 0), (1, 0, 0)  # straight out
    made = []
    for number in range(4):
        path = tmp_path / f"{number}.npz"
        Motion(directions).save(path)
        made.append({"motion": str(path), "row": number // 2, "column": number % 2, "label": ["a style", "seed"]})
    scene = fill(made)
    scene.frame_set(4)
    figures = [item for item in scene.objects if item.type == "ARMATURE"]
    for figure in figures:
        spots = [figure.matrix_world @ bone.tail for bone in figure.pose.bones if bone.name.startswith(("hand", "middle_2"))]
        across = [world_to_camera_view(scene, scene.camera, Vector(spot))[0] * 2 for spot in spots]
        assert len(across) == 4 and int(min(across)) == int(max(across)), across


def test_long_labels_are_squeezed_into_their_cell(cells):
    cells[0]["label"][0] = "1  " + "a very long style:0.5+" * 6
    test_every_cell_holds_its_own_figure_and_label(cells)


def test_parts_move_as_the_skinned_mannequin_does(cells):
    scene = fill(cells[:1])
    whole = mannequin.build()
    figure = next(item for item in scene.objects if item.type == "ARMATURE")
    whole.armature.matrix_world = figure.matrix_world
    whole.armature.animation_data_create().action = figure.animation_data.action
    if hasattr(figure.animation_data, "action_slot"):
        setattr(whole.armature.animation_data, "action_slot", figure.animation_data.action_slot)  # noqa: B010
    scene.frame_set(5)
    graph = bpy.context.evaluated_depsgraph_get()
    body = whole.meshes[0].evaluated_get(graph)
    points = np.array([body.matrix_world @ vertex.co for vertex in body.data.vertices])
    part = next(item for item in scene.objects if item.parent is figure and item.parent_bone == "lower_arm.L")
    spot = np.array(part.evaluated_get(graph).matrix_world @ part.data.vertices[0].co)
    assert np.linalg.norm(points - spot, axis=1).min() < 0.01  # a part has fewer points than the whole


@pytest.mark.slow
@needs_opengl
def test_film_and_contact_sheet(cells, tmp_path, examples):
    outputs = [str(tmp_path / "sheet.mp4"), str(tmp_path / "sheet.png")]
    content = {"cells": cells, "audio": str(examples / "hello.flac"), "fps": 12, "outputs": outputs}
    (tmp_path / "job.json").write_text(json.dumps(content))
    said = []
    sheet.perform(sheet._read(tmp_path / "job.json"), program.EventWriter(said.append))
    film = (tmp_path / "sheet.mp4").read_bytes()
    assert b"avc1" in film and b"mp4a" in film
    scene = bpy.context.scene
    assert scene.frame_end == 1 + int(16 / 15 * 12)
    picture = bpy.data.images.load(outputs[1])
    wide, tall = scene.render.resolution_x // 3, scene.render.resolution_y // 2
    assert tuple(picture.size) == (wide * sheet.MOMENTS, tall * 5)
    pixels = np.array(picture.pixels[:]).reshape(5, tall, -1, wide, 4)
    assert pixels[..., :3].std(axis=(1, 3, 4)).min() > 0.02  # no cell is empty
    assert len({json.loads(line)["stage"] for line in said}) == 3
