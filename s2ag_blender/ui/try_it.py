"""Operator that adds a person with the example recording, generates gestures and plays them, in one press."""

from collections.abc import Iterator
from pathlib import Path

import bpy
from mathutils import Vector

from ...core.errors import S2agError
from ..datablocks import ArmatureObject, Context, current_context, is_armature
from ..takes import engine_requests, generate, session, take_list
from ..takes.operator_base import GeneratingOperator
from ..translations import translate, translate_error
from .bases import Button, OperatorResult
from .views import frame_view, show_range

VOICE = Path(__file__).parents[2] / "core" / "assets" / "hello.wav"
"""The example recording; its transcript is beside it."""
_GAP = 1.0
"""Metres between the person and the meshes that are in the scene already."""


def stage(context: Context) -> ArmatureObject:
    """Add the person beside the meshes of the scene, with the example recording, active; return its armature."""
    armature = engine_requests.add_character("human")
    context.view_layer.update()
    corners = [item.matrix_world @ corner for item, corner in _corners(context.scene, armature)]
    if corners:
        armature.location.x += max(corner.x for corner in corners) + _GAP
    for selected in context.selected_objects:
        selected.select_set(False)
    armature.select_set(True)
    context.view_layer.objects.active = armature
    armature.s2ag.audio_source, armature.s2ag.transcript_source = "FILE", "FILE"
    armature.s2ag.audio = str(VOICE)
    armature.s2ag.hands = 1.0
    return armature


def _corners(scene: bpy.types.Scene, armature: ArmatureObject) -> Iterator[tuple[bpy.types.Object, Vector]]:
    """Yield the corners of the bounding boxes of all meshes but the armature's own, each with its object."""
    for item in scene.objects:
        if item.type == "MESH" and item.find_armature() is not armature:
            yield from ((item, Vector(corner)) for corner in item.bound_box)


class S2AG_OT_try_it(GeneratingOperator, Button, bpy.types.Operator):
    """Add a person who says the example with gestures, and play it"""

    bl_label = "Try It"

    @classmethod
    def why_not(cls, context: Context) -> str:
        if context.mode != "OBJECT":
            return translate("Go to object mode first")
        return translate("Gestures are being made") if session.RUNS else ""

    def execute(self, context: Context) -> OperatorResult:
        return super().execute(context) if self._stage(context) else {"CANCELLED"}

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        if bpy.app.background or context.window is None:
            return self.execute(context)
        if not self._stage(context):
            return {"CANCELLED"}
        frame_view(context)
        return super().invoke(context, event)

    def _stage(self, context: Context) -> bool:
        """Add the person; report an error and return False where that fails."""
        try:
            stage(context)
        except S2agError as error:
            self.report({"ERROR"}, translate_error(error))
            return False
        return True

    def finished(self, outcome: "generate.Outcome") -> OperatorResult:
        context = current_context()
        scene = context.scene
        armature = next((item for item in scene.objects if item.session_uid == self._uid and is_armature(item)), None)
        if armature is not None and take_list.active(armature) is not None:
            take_list.fit_scene(armature, scene)
            show_range(context)
        scene.frame_set(scene.frame_start)
        scene.sync_mode = "AUDIO_SYNC"
        if not bpy.app.background and not context.screen.is_animation_playing:
            bpy.ops.screen.animation_play()
        return super().finished(outcome)
