"""The library that ``s2ag gestures`` builds, read back: assets with all that a browser shows, which another rig makes."""

import bpy
import numpy as np
import pytest
import s2ag
from s2ag.core.cli.main import main
from s2ag.core.errors import UsageError
from s2ag.s2ag_blender import gesture_library, program
from s2ag.s2ag_blender.takes import gesture_assets


def build(path, **asked):
    voice = program.EventWriter([].append)
    return gesture_library.perform({"output": str(path), "kinds": None, "idles": [], **asked}, voice)["assets"]


def test_a_library_is_read_back_and_another_rig_makes_what_is_in_it(tmp_path):
    path = tmp_path / "library.blend"
    assert build(path, kinds=["shrug", "left"], idles=[2.0]) == ["Shrug", "Left Hand", "Idle 1"]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(str(path), link=True, assets_only=True) as (there, wanted):
        assert sorted(there.actions) == ["Idle 1", "Left Hand", "Shrug"]
        wanted.actions = list(there.actions)
    listed = dict(line.split(":")[:2] for line in (tmp_path / "blender_assets.cats.txt").read_text().splitlines()[1:])
    shown = {}
    for action in wanted.actions:
        told = action.asset_data
        assert (told.author, told.license) == ("S2AG for Blender", "CC0 1.0")
        picture = np.array(action.preview.image_pixels_float).reshape(256, 256, 4)
        assert 0.02 < (picture[..., 3] > 0.5).mean() < 0.5, action.name
        shown[action.name] = listed[told.catalog_id], {tag.name for tag in told.tags}
    assert shown == {
        "Shrug": ("S2AG/Kinds", {"shrug", "both"}),
        "Left Hand": ("S2AG/Kinds", shown["Left Hand"][1]),
        "Idle 1": ("S2AG/Idles", {"idle", "both", "warm host"}),
    }
    bpy.ops.wm.read_factory_settings(use_empty=True)
    s2ag.register()
    try:
        bpy.ops.s2ag.add_human()
        human = bpy.context.active_object
        bpy.context.scene.frame_set(10)
        assert bpy.ops.s2ag.insert_gesture(asset="Idle 1", library=str(path)) == {"FINISHED"}
        assert bpy.ops.s2ag.insert_gesture(asset="Shrug", library=str(path)) == {"FINISHED"}
        first, last = human.animation_data.action.frame_range
        assert last - first >= 47 and not gesture_assets.assets()
    finally:
        s2ag.unregister()


def test_what_no_library_can_be(tmp_path, capsys):
    with pytest.raises(UsageError, match="no kind of gesture called shru"):
        build(tmp_path / "few.blend", kinds=["shru"])
    for asked in (["-o", "few.fbx"], ["-o", "few.blend", "--idles", "101"], ["-o", "few.blend", "--seconds", "0"]):
        assert main(["gestures", *asked]) == 2 and "s2ag: " in capsys.readouterr().err
