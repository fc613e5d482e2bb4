"""A recording that is dropped on a character: it becomes the character's recording, and a small dialog offers to gesture."""

from pathlib import Path

import bpy
from bpy_extras import view3d_utils

from ...core.words.beside import beside
from ..takes.running import armature_of, character
from ..translations import told

EXTENSIONS = (".wav", ".flac", ".mp3", ".ogg")


def character_under(context, x: int, y: int):
    """The armature whose mesh or bones lie under the pixel ``x``, ``y`` of the 3D viewport's region, or None."""
    region, view = context.region, context.region_data
    if view is None:
        return None
    origin = view3d_utils.region_2d_to_origin_3d(region, view, (x, y))
    direction = view3d_utils.region_2d_to_vector_3d(region, view, (x, y))
    hit, *_, item, _ = context.scene.ray_cast(context.evaluated_depsgraph_get(), origin, direction)
    if hit and (found := armature_of(item.original)):
        return found
    near = [(_distance(region, view, item, (x, y)), item.name) for item in context.visible_objects if item.type == "ARMATURE"]
    distance, name = min(near, default=(None, ""))
    return context.scene.objects[name] if distance is not None and distance < 60 else None


def target(context, x: int | None = None, y: int | None = None):
    """Who is meant: the character under the mouse, else the active one, else the scene's only one, else None."""
    found = character_under(context, x, y) if x is not None else None
    found = found or character(context)
    if found is None:
        armatures = [item for item in context.scene.objects if item.type == "ARMATURE"]
        found = armatures[0] if len(armatures) == 1 else None
    return found


def give(armature, recording: str) -> str:
    """Make ``recording`` the character's; returns the transcript beside it, which is taken too, or an empty string."""
    settings = armature.s2ag
    settings.audio_source, settings.audio = "FILE", recording
    settings.transcript_source = "FILE"
    settings.transcript = str(beside(bpy.path.abspath(recording)) or "")
    return settings.transcript


def _distance(region, view, armature, pixel) -> float:
    """Pixels from ``pixel`` to the nearest joint of an armature."""
    world = armature.matrix_world
    joints = (view3d_utils.location_3d_to_region_2d(region, view, world @ bone.head) for bone in armature.pose.bones)
    return min(((joint.x - pixel[0]) ** 2 + (joint.y - pixel[1]) ** 2) ** 0.5 for joint in joints if joint is not None)


class S2AG_OT_drop_recording(bpy.types.Operator):
    """Let the character gesture to this recording"""

    bl_idname = "s2ag.drop_recording"
    bl_label = "Gesture to This Recording"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    filepath: bpy.props.StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE", "HIDDEN"})
    character: bpy.props.StringProperty(name="Character", description="Armature that gestures", options={"SKIP_SAVE"})
    generate: bpy.props.BoolProperty(
        name="Generate Now", description="Make the gestures at once, with the settings of the character", default=True
    )

    def invoke(self, context, event):
        found = target(context, event.mouse_region_x, event.mouse_region_y)
        if found is not None:
            self.character = found.name
        return context.window_manager.invoke_props_dialog(self, width=360)

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.label(text=Path(self.filepath).name, icon="SOUND", translate=False)
        layout.prop_search(self, "character", context.scene, "objects", icon="ARMATURE_DATA")
        armature = armature_of(context.scene.objects.get(self.character))
        if armature is not None:
            layout.prop(armature.s2ag, "style_pick")
            layout.prop(armature.s2ag, "intensity", slider=True)
        found = beside(self.filepath)
        if found:
            layout.label(text=told("{name} beside it tells the words", name=found.name), icon="CHECKMARK", translate=False)
        else:
            layout.label(text="No transcript beside it: the sound alone gestures", icon="INFO")
        layout.prop(self, "generate")

    def execute(self, context):
        named = context.scene.objects.get(self.character) if self.character else target(context)
        armature = armature_of(named)
        if armature is None:
            self.report({"ERROR"}, told("There is no character to gesture; select one"))
            return {"CANCELLED"}
        give(armature, self.filepath)
        for item in context.selected_objects:
            item.select_set(item == armature)
        armature.select_set(True)
        context.view_layer.objects.active = armature
        if not self.generate:
            return {"FINISHED"}
        # A window waits for the engine with a progress bar; without one the call itself waits.
        how = "EXEC_DEFAULT" if bpy.app.background else "INVOKE_DEFAULT"
        return {"CANCELLED"} if bpy.ops.s2ag.generate(how) == {"CANCELLED"} else {"FINISHED"}


class S2AG_FH_recording(bpy.types.FileHandler):
    bl_idname = "S2AG_FH_recording"
    bl_label = "Recording for a Gesturing Character"
    bl_import_operator = "s2ag.drop_recording"
    bl_file_extensions = ";".join(EXTENSIONS)

    @classmethod
    def poll_drop(cls, context):
        """Only on the 3D viewport of a scene with a character: elsewhere a sound is what it always was."""
        area = context.area
        return bool(area and area.type == "VIEW_3D" and any(item.type == "ARMATURE" for item in context.scene.objects))


CLASSES = (S2AG_OT_drop_recording, S2AG_FH_recording)
