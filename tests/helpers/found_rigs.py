"""Rigs that others made, opened in Blender: Rocketbox and Mesh2Motion of the material folder, Rigify's."""

import bpy
import pytest


def armature():
    """The first armature of the file."""
    return next(item for item in bpy.data.objects if item.type == "ARMATURE")


def opened(path):
    """Open a ``.blend`` and return its armature."""
    bpy.ops.wm.open_mainfile(filepath=str(path))
    return armature()


def rocketbox(shared, name):
    """Import a character of Rocketbox, which comes posed."""
    bpy.ops.import_scene.fbx(filepath=str(there(shared / "rocketbox" / f"{name}.fbx")))
    return armature()


def mesh2motion(shared):
    """Append Mesh2Motion's human with its control rig."""
    if bpy.app.version < (4, 5):
        pytest.skip("the file was saved by a newer Blender")
    with bpy.data.libraries.load(str(there(shared / "mesh2motion" / "rig-human.blend"))) as (source, target):
        target.objects = source.objects
    for thing in target.objects:
        bpy.context.collection.objects.link(thing)
    return armature()


def there(path):
    if not path.is_file():
        pytest.skip(f"{path.name} is absent")
    return path
