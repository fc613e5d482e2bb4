"""Coming and going of the extension within one Blender."""

import subprocess
import sys

import bpy
import pytest
import s2ag
from s2ag.s2ag_blender.takes import generate, session


@pytest.fixture(autouse=True)
def gone():
    """The extension is not there after a test, whatever happened in it."""
    yield
    if hasattr(bpy.types, "S2AG_PT_gestures"):
        s2ag.unregister()


def test_registering_twice_leaves_nothing_behind():
    for _ in range(2):
        s2ag.register()
        assert hasattr(bpy.types, "S2AG_PT_gestures") and hasattr(bpy.types.Object, "s2ag")
        s2ag.unregister()
        assert not hasattr(bpy.types, "S2AG_PT_gestures") and not hasattr(bpy.types.Object, "s2ag")
        assert not hasattr(bpy.types.WindowManager, "s2ag")
        events = (getattr(bpy.app.handlers, name) for name in ("load_pre", "save_pre", "undo_post", "redo_post"))
        assert not [handler for event in events for handler in event if handler.__module__.startswith("s2ag")]


def test_unregistering_while_it_runs(engine, voice):
    s2ag.register()
    bpy.ops.s2ag.add_mannequin()
    armature = bpy.context.active_object
    armature.s2ag.audio = str(voice)
    session.Run(bpy.context, armature, generate.plan(bpy.context, armature))
    s2ag.unregister()
    assert not session.RUNS and not hasattr(bpy.types.Object, "s2ag")


def test_registering_runs_little_and_needs_no_numpy():
    """Blender may not have loaded numpy yet, which takes longer than all of ours."""
    code = """
import os, sys, types, bpy
sys.modules["numpy"] = None
import s2ag
s2ag.register()
for module in sys.modules.values():  # as Blender's preferences do, and some Blenders when they quit
    getattr(module, "__file__", None)
ran = [name for name, module in sys.modules.items() if name.startswith("s2ag.") and type(module) is types.ModuleType]
print("ran", *ran, flush=True)
os._exit(0)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    _, *ran = next(line for line in done.stdout.splitlines() if line.startswith("ran ")).split()
    assert "s2ag.s2ag_blender.ui.panel" in ran
    heavy = ("rigs", "core.motion", "core.meaning", "core.synthesis", "s2ag_blender.keys.", "s2ag_blender.rig.")
    assert not [name for name in ran if name.removeprefix("s2ag.").startswith(heavy)]
