"""People to put bones to the test: each is built once a process, which takes two seconds, and then comes from a file."""

import tempfile
from pathlib import Path

import bpy
from s2ag.s2ag_blender.characters import human

_FOLDER = tempfile.TemporaryDirectory(prefix="s2ag-people-")


def armature(rig="default"):
    """The armature of a woman on a rig, in the current scene with all her parts."""
    path = Path(_FOLDER.name) / f"{rig}.blend"
    if not path.is_file():
        built = human.build(rig)
        bpy.data.libraries.write(str(path), {built.collection}, fake_user=True)
        return built.armature
    with bpy.data.libraries.load(str(path)) as (_, wanted):
        wanted.collections = ["Human"]
    bpy.context.scene.collection.children.link(wanted.collections[0])
    (item,) = (item for item in wanted.collections[0].objects if item.type == "ARMATURE")
    return item
