"""Names for Blender's datablocks by what they hold, for annotations; at run time they are the plain types.

Blender's stubs give an object's data as one of fifteen types and every pointer as optional. A parameter of these types says
what a function needs. ``s2ag`` is the group of properties that ``ui.properties`` registers."""

from typing import TYPE_CHECKING, Any, TypeGuard, cast

import bpy

if TYPE_CHECKING:

    class ArmatureObject(bpy.types.Object):
        data: bpy.types.Armature
        pose: bpy.types.Pose
        s2ag: Any

    class MeshObject(bpy.types.Object):
        data: bpy.types.Mesh

    class WindowManager(bpy.types.WindowManager):
        s2ag: Any

    class Context(bpy.types.Context):
        scene: bpy.types.Scene
        view_layer: bpy.types.ViewLayer
        window_manager: WindowManager
        preferences: bpy.types.Preferences
        window: bpy.types.Window | None
        screen: bpy.types.Screen
        area: bpy.types.Area | None
        region: bpy.types.Region
        region_data: bpy.types.RegionView3D | None

    Slot = bpy.types.ActionSlot
    Bag = bpy.types.ActionChannelbag
    SoundStrip = bpy.types.SoundStrip
else:
    ArmatureObject = MeshObject = bpy.types.Object
    WindowManager, Context = bpy.types.WindowManager, bpy.types.Context
    Slot = Bag = SoundStrip = object  # before 4.4 there are no slots, an action is its own bag, and strips have other classes


def is_armature(item: bpy.types.Object | None) -> TypeGuard[ArmatureObject]:
    """Return whether ``item`` is an armature object."""
    return item is not None and item.type == "ARMATURE"


def is_mesh(item: bpy.types.Object | None) -> TypeGuard[MeshObject]:
    """Return whether ``item`` is a mesh object."""
    return item is not None and item.type == "MESH"


def current_context() -> Context:
    """Return Blender's context, with a scene and a view layer."""
    return cast(Context, bpy.context)
