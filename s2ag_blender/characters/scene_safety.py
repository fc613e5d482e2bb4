"""Disables what rendering an untrusted .blend would run, or write to unexpected places.

Blender itself blocks scripts, registered texts and scripted drivers (``use_scripts=False``). Everything else is switched off by
its own setting, so that a saved copy still has it and its owner can switch it on again."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy


def disarm() -> list[str]:
    """Disarm the open file; return a sentence for each kind of thing that was switched off."""
    switched = {
        "scripts of Freestyle": _freestyle(),
        "file outputs of the compositor": _file_outputs(),
        "programs in OSL": _osl(),
        "caches on disk": _caches(),
    }
    sentences = [
        f"{count} {what} would run or write when the file is rendered, and were switched off."
        for what, count in switched.items()
        if count
    ]
    far = _far_libraries()
    return sentences + ([f"The file is linked to {far} libraries outside its folder, which were loaded, too."] if far else [])


def _freestyle() -> int:
    """Switch off the script modules of Freestyle; return their number."""
    modules = [
        module
        for scene in bpy.data.scenes
        for layer in scene.view_layers
        for module in layer.freestyle_settings.modules
        if module.use and module.script
    ]
    for module in modules:
        module.use = False
    return len(modules)


def _trees() -> list[bpy.types.NodeTree]:
    own = [getattr(scene, "node_tree", None) for scene in bpy.data.scenes]  # until 4.5
    materials = [*bpy.data.materials, *bpy.data.worlds, *bpy.data.lights]
    return [tree for tree in (*own, *bpy.data.node_groups, *(one.node_tree for one in materials)) if tree]


def _file_outputs() -> int:
    """Mute the file output nodes of all node trees; return their number."""
    nodes = [node for tree in _trees() for node in tree.nodes if node.type == "OUTPUT_FILE" and not node.mute]
    for node in nodes:
        node.mute = True
    return len(nodes)


def _osl() -> int:
    """Switch off OSL, which can write files, in scenes and custom cameras; return their number."""
    scenes: list[Any] = [scene for scene in bpy.data.scenes if getattr(getattr(scene, "cycles", None), "shading_system", False)]
    for scene in scenes:
        scene.cycles.shading_system = False
    cameras = [camera for camera in bpy.data.cameras if camera.type == "CUSTOM"]
    for camera in cameras:
        camera.type = "PERSP"
    return len(scenes) + len(cameras)


def _caches() -> int:
    """Switch off caches that a frame change would write to folders named by the file; return their number."""
    caches = [cache for item in bpy.data.objects for cache in _point_caches(item)]
    worlds = [scene.rigidbody_world for scene in bpy.data.scenes if scene.rigidbody_world]
    caches += [world.point_cache for world in worlds]
    disk = [cache for cache in caches if cache.use_disk_cache and not cache.use_external]
    for cache in disk:
        cache.use_disk_cache = False
    fluids = [one for item in bpy.data.objects for one in item.modifiers if one.type == "FLUID" and _replays(one)]
    for fluid in fluids:
        fluid.show_viewport = fluid.show_render = False
    renders = [scene.render for scene in bpy.data.scenes if scene.render.use_render_cache]
    for render in renders:
        render.use_render_cache = False
    return len(disk) + len(fluids) + len(renders)


def _point_caches(item: Any) -> Iterator[bpy.types.PointCache]:
    """Yield the point caches of an object's simulations."""
    yield from (one.point_cache for one in item.modifiers if one.type in ("CLOTH", "SOFT_BODY"))
    yield from (one.point_cache for one in item.particle_systems)
    for one in item.modifiers:
        if one.type == "DYNAMIC_PAINT" and one.canvas_settings:
            yield from (surface.point_cache for surface in one.canvas_settings.canvas_surfaces)


def _replays(fluid: Any) -> bool:
    """Return whether a fluid modifier would bake during playback."""
    settings = fluid.domain_settings
    return bool(settings and settings.cache_type == "REPLAY" and (fluid.show_viewport or fluid.show_render))


def _far_libraries() -> int:
    """Return the number of linked libraries outside the file's folder; their contents were disarmed as well."""
    home = Path(bpy.data.filepath).resolve().parent
    paths = (Path(bpy.path.abspath(library.filepath)).resolve() for library in bpy.data.libraries)
    return sum(not path.is_relative_to(home) for path in paths)
