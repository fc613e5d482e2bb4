"""What editors show: Try It's person as in a film, a character that is out of view, a timeline the whole range."""

import math
from typing import Any

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Euler, Vector

from ..datablocks import ArmatureObject, Context
from ..render import stage

_MIDDLE, _DISTANCE = 0.76, 0.95
"""Height of the middle of the picture and distance of the eye, in heights of the person: from the hips to above the head."""
_BACKGROUND = (0.55, 0.58, 0.6)
_AWAY = 1.7
"""Distance of the eye from a character that is turned to, in its largest dimension."""


def frame_view(context: Context) -> None:
    """Show the active person in the viewport in which the button was pressed as a film would: alone, lit, in colour, from its
    hips up, without bones, lines and grid. Only this viewport changes: overlays, shading, local view and where it looks from.
    """
    (region, space), armature = _viewport(context), context.view_layer.objects.active
    if region is None or armature is None:
        return
    space.overlay.show_overlays = False
    space.shading.type, space.shading.background_type = "SOLID", "VIEWPORT"
    space.shading.background_color = _BACKGROUND
    stage.light_brightly(space.shading)
    people = [armature, *(item for item in context.scene.objects if item.type == "MESH" and item.find_armature() is armature)]
    with context.temp_override(region=region):
        if space.local_view is None:
            for item in people:
                item.select_set(True)
            bpy.ops.view3d.localview(frame_selected=False)
            for item in people[1:]:
                item.select_set(False)
        tall = max((armature.matrix_world @ Vector(corner)).z for item in people for corner in item.bound_box)
        view = space.region_3d
        view.view_perspective = "PERSP"
        view.view_rotation = Euler((math.radians(87), 0, math.radians(8))).to_quaternion()
        view.view_location = armature.matrix_world.translation + Vector((0, 0, _MIDDLE * tall))
        view.view_distance = _DISTANCE * tall


def show_character(context: Context, armature: ArmatureObject) -> None:
    """Turn the viewport in which a button was pressed to a character that is out of it; what a camera sees stays."""
    region, space = _viewport(context)
    if region is None or space.region_3d.view_perspective == "CAMERA":
        return
    if space.local_view and not armature.local_view_get(space):
        with context.temp_override(region=region):
            bpy.ops.view3d.localview(frame_selected=False)
    view, middle = space.region_3d, armature.matrix_world @ (sum(map(Vector, armature.bound_box), Vector()) / 8)
    at = location_3d_to_region_2d(region, view, middle)
    if at is None or not (0 < at.x < region.width and 0 < at.y < region.height):
        view.view_location, view.view_distance = middle, _AWAY * max(*armature.dimensions)


def show_range(context: Context) -> None:
    """Let timelines show the whole range of the scene."""
    for area in context.screen.areas if context.screen else ():
        if area.type == "DOPESHEET_EDITOR":
            with context.temp_override(area=area, region=_main(area)):
                bpy.ops.anim.scene_range_frame()


def _viewport(context: Context) -> tuple[Any, Any]:
    """Return the main region and the space of the 3D viewport in which a button was pressed; None without one."""
    area: Any = context.area
    return (_main(area), area.spaces.active) if area is not None and area.type == "VIEW_3D" else (None, None)


def _main(area: Any) -> Any:
    return next(region for region in area.regions if region.type == "WINDOW")
