"""A motion file onto the active character: one action more, in File > Import and the menu of gestures."""

import bpy
import numpy as np
import pytest
from s2ag.rigs import bvh
from s2ag.s2ag_blender import provenance
from s2ag.s2ag_blender.characters import mannequin
from s2ag.s2ag_blender.ui import import_motion


@pytest.fixture
def figure(extension):
    armature = mannequin.build().armature
    bpy.context.view_layer.objects.active = armature
    return armature


@pytest.mark.parametrize("kind", [".npz", ".bvh"])
def test_a_file_becomes_an_action(figure, wave, tmp_path, kind):
    path, motion = tmp_path / f"talk{kind}", wave(31)
    motion.save(path) if kind == ".npz" else bvh.save(motion, path)
    scene = bpy.context.scene
    scene.render.fps, scene.frame_start = 15, 5
    assert bpy.ops.s2ag.import_motion(filepath=str(path)) == {"FINISHED"}
    action = figure.animation_data.action
    assert "talk" in action.name and provenance.read(action) is not None
    assert tuple(np.round(action.frame_range)) == (5, 35)
    scene.frame_set(20)
    assert bpy.ops.s2ag.import_motion(filepath=str(path), at_playhead=True, mirror=True) == {"FINISHED"}
    other = figure.animation_data.action
    assert other != action and tuple(np.round(other.frame_range)) == (20, 50) and action.use_fake_user


def test_a_file_of_another_kind_changes_nothing(figure, tmp_path):
    (tmp_path / "a.bvh").write_text("no hierarchy")
    with pytest.raises(RuntimeError, match="is no BVH file"):
        bpy.ops.s2ag.import_motion(filepath=str(tmp_path / "a.bvh"))
    assert figure.animation_data is None or figure.animation_data.action is None


def test_it_waits_for_a_character(extension):
    assert not bpy.ops.s2ag.import_motion.poll()
    drawn = [getattr(draw, "__name__", "") for draw in bpy.types.TOPBAR_MT_file_import._dyn_ui_initialize()]
    assert import_motion.draw_in_import.__name__ in drawn
