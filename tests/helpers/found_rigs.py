"""Rigs that others made, opened in Blender: those of the material folder, and Rigify's."""

import bpy
import pytest


def armature():
    """The first armature of the file."""
    return next(item for item in bpy.data.objects if item.type == "ARMATURE")


def opened(path):
    """Open a ``.blend`` and return its armature."""
    bpy.ops.wm.open_mainfile(filepath=str(path))
    return armature()


def imported(path, kind=""):
    """Import a file by Blender's importer for its ending, or for ``kind``; ``fbx2`` is Blender's newer one of FBX."""
    kind = kind or path.suffix[1:]
    if kind == "fbx2" and "fbx_import" not in dir(bpy.ops.wm):
        pytest.skip("this Blender has one importer for FBX")
    read = {"fbx": bpy.ops.import_scene.fbx, "glb": bpy.ops.import_scene.gltf, "bvh": bpy.ops.import_anim.bvh}
    (read.get(kind) or (bpy.ops.wm.usd_import if kind == "usdc" else bpy.ops.wm.fbx_import))(filepath=str(there(path)))
    return armature()


def rocketbox(shared, name, kind="fbx"):
    """Import a character of Rocketbox, which comes posed."""
    return imported(shared / "rocketbox" / f"{name}.fbx", kind)


def naturalpoint(shared):
    """Import SmartBody's BVH skeleton; the importer keys every bone."""
    return imported(shared / "smartbody" / "PNGestures" / "skeletons" / "pnskeleton.bvh")


ENDINGS = (".blend", ".bvh", ".dae", ".fbx", ".glb", ".gltf", ".pmx", ".usd", ".usdc", ".vrm")


def files(shared):
    """Names of all files of the material folder that may hold a rig and that Blender can open."""
    return {path.name for path in shared.rglob("*") if path.suffix.lower() in ENDINGS}


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
