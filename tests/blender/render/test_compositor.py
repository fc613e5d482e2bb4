"""Pictures of scenes whose compositor gives none: file outputs of untrusted files are muted, and may be all that it has."""

import bpy
import pytest
from s2ag.s2ag_blender import compat
from s2ag.s2ag_blender.characters import scene_safety
from s2ag.s2ag_blender.render import render

LOOK = render.Look(engine="cycles", samples=1)


@pytest.fixture
def scene():
    bpy.ops.object.camera_add()
    made = bpy.context.scene
    made.camera = bpy.context.object
    made.render.resolution_x = made.render.resolution_y = 16
    made.frame_start, made.frame_end = 1, 2
    return made


def composed(scene, *kinds):
    """Give the scene a compositor of these nodes."""
    if hasattr(scene, "compositing_node_group"):
        scene.compositing_node_group = bpy.data.node_groups.new("own", "CompositorNodeTree")
    else:
        scene.use_nodes = True
    tree = compat.compositing(scene)
    tree.nodes.clear()
    for kind in kinds:
        tree.nodes.new(f"CompositorNode{kind}")


@pytest.mark.parametrize("kinds", [(), ("OutputFile",), ("RLayers", "OutputFile"), ("Viewer",)], ids=str)
def test_a_compositor_that_gives_no_picture_is_passed_by(scene, tmp_path, kinds):
    composed(scene, *kinds)
    assert any("file outputs" in told for told in scene_safety.disarm()) == ("OutputFile" in kinds)
    render.still(scene, tmp_path / "still.png", 1, LOOK)
    render.images(scene, tmp_path / "####.png", LOOK)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["0001.png", "0002.png", "still.png"]
    assert scene.render.use_compositing
