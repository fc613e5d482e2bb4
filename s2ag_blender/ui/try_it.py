"""One press in an empty scene: a person, a voice and its words, gestures, and the timeline plays."""

from pathlib import Path

import bpy
from mathutils import Vector

from ...core.errors import S2agError
from ..takes import gesture, session, takes
from ..takes.running import Generating
from ..translations import told, told_error

VOICE = Path(__file__).parents[2] / "core" / "assets" / "hello.mp3"
"""The example voice; its words lie beside it."""
_ASIDE = 1.0
"""Metres between the person and what stands in the scene already."""


def stage(context) -> bpy.types.Object:
    """Add the person with the example voice, active, beside whatever is there; returns its armature."""
    armature = gesture.add_character("human")
    context.view_layer.update()
    corners = [item.matrix_world @ corner for item, corner in _corners(context.scene, armature)]
    if corners:
        armature.location.x += max(corner.x for corner in corners) + _ASIDE
    for selected in context.selected_objects:
        selected.select_set(False)
    armature.select_set(True)
    context.view_layer.objects.active = armature
    armature.s2ag.audio_source, armature.s2ag.transcript_source = "FILE", "FILE"
    armature.s2ag.audio = str(VOICE)
    armature.s2ag.hands = 1.0
    return armature


def _corners(scene, armature):
    """Corners of the boxes of all meshes that were here before."""
    for item in scene.objects:
        if item.type == "MESH" and item.find_armature() is not armature:
            yield from ((item, Vector(corner)) for corner in item.bound_box)


class S2AG_OT_try_it(Generating, bpy.types.Operator):
    """Add a person who says the example with gestures, and play it"""

    bl_idname = "s2ag.try_it"
    bl_label = "Try It"

    @classmethod
    def poll(cls, context):
        if context.mode != "OBJECT":
            cls.poll_message_set(told("Go to object mode first"))
            return False
        if session.RUNS:
            cls.poll_message_set(told("Gestures are being made"))
            return False
        return True

    def execute(self, context):
        return super().execute(context) if self._staged(context) else {"CANCELLED"}

    def invoke(self, context, event):
        if bpy.app.background or context.window is None:
            return self.execute(context)
        if not self._staged(context):
            return {"CANCELLED"}
        _frame(context)
        return super().invoke(context, event)

    def _staged(self, context) -> bool:
        try:
            stage(context)
        except S2agError as error:
            self.report({"ERROR"}, told_error(error))
            return False
        return True

    def _done(self, uid, name, outcome):
        scene = bpy.context.scene
        armature = next((item for item in scene.objects if item.session_uid == uid), None)
        if armature is not None and takes.active(armature) is not None:
            takes.fit(armature, scene)
        scene.frame_set(scene.frame_start)
        if not bpy.app.background and not bpy.context.screen.is_animation_playing:
            bpy.ops.screen.animation_play()
        return super()._done(uid, name, outcome)


def _frame(context) -> None:
    """Bring the person into the view that the button was pressed in, from the front."""
    region = next((region for region in context.area.regions if region.type == "WINDOW"), None) if context.area else None
    if region is not None and context.area.type == "VIEW_3D":
        with context.temp_override(region=region):
            bpy.ops.view3d.view_axis(type="FRONT")
            bpy.ops.view3d.view_selected()
