"""Operator that lets every selected character stand and wait, each in a way of its own; needs no engine."""
# pyright: reportInvalidTypeForm=false

import time
from collections.abc import Generator
from concurrent.futures import ThreadPoolExecutor

import bpy

from ...core.errors import S2agError
from ...core.settings import names_with
from ..datablocks import ArmatureObject, Context
from ..keys import apply
from ..rig import chosen_bones
from ..takes import drafts, session, stored_settings
from ..takes.operator_base import SlicedOperator, armature_of
from ..translations import translate, translate_error
from .bases import NeedsCharacter, OperatorResult, require_character


def idle_in_slices(
    armatures: list[ArmatureObject], start: int, scene: bpy.types.Scene, seconds: float, stillness: float, loop: bool
) -> Generator[float, None, tuple[list[bpy.types.Action], list[S2agError]]]:
    """Let each character idle from frame ``start``, with its style and its seed plus its number here; yield the share done
    wherever Blender may draw. Returns the actions, and why characters got none."""
    from ...core.synthesis import idling

    actions, errors, rate = [], [], apply.scene_fps(scene)
    with ThreadPoolExecutor(1) as pool:
        named = [[getattr(one.s2ag, name) for name in names_with(indexed=True)] for one in armatures]  # style and seed
        asked = [(seconds, style, seed + number, stillness, loop, rate) for number, (style, seed) in enumerate(named)]
        coming = [pool.submit(idling.idle, *each) for each in asked]
        for number, (armature, motion) in enumerate(zip(armatures, coming, strict=True)):
            while not motion.done():
                yield number / len(armatures)
                time.sleep(0.002)
            drafts.drop(armature)
            settings, about = armature.s2ag, {"scene": scene, "name": f"{armature.name} idle"}
            about |= {"mapping": chosen_bones.mapping_of_settings(settings), "strip": settings.result == "STRIP"}
            about |= {"options": stored_settings.options(settings)}
            slices = apply.apply_motion_in_slices(armature, motion.result(), start, **about)
            try:
                while True:
                    next(slices)
                    yield number / len(armatures)
            except StopIteration as end:
                actions.append(end.value)
            except S2agError as error:
                errors.append(error)
    return actions, errors


class S2AG_OT_idle(SlicedOperator, NeedsCharacter, bpy.types.Operator):
    """Let the selected characters stand and wait as people do, each in a way of its own"""

    bl_label = "Idle"
    shares_events = False

    seconds: bpy.props.FloatProperty(
        name="Seconds", subtype="TIME_ABSOLUTE", default=20.0, min=1.0, max=600.0, description="How long they wait"
    )
    stillness: bpy.props.FloatProperty(
        name="Stillness", default=0.5, min=0.0, max=1.0, subtype="FACTOR",
        description="0 fidgets every few seconds; 1 only breathes and sways",
    )  # fmt: skip
    loop: bpy.props.BoolProperty(name="Loop", default=True, description="End in the first pose, and move on across it")

    def slices(self, context: Context) -> Generator[float, None, tuple[list[bpy.types.Action], list[S2agError]]]:
        """Return the work on the selected characters, the active one first."""
        chosen = [armature_of(item) for item in sorted(context.selected_objects, key=lambda item: item.name)]
        armatures = list(dict.fromkeys([require_character(context), *(one for one in chosen if one is not None)]))
        scene = context.scene
        return idle_in_slices(armatures, scene.frame_start, scene, self.seconds, self.stillness, self.loop)

    def begun(self, context: Context) -> "session.SlicedRun":
        return session.SlicedRun(self.slices(context), translate("Idle"))

    def finished(self, outcome: tuple[list[bpy.types.Action], list[S2agError]]) -> OperatorResult:
        actions, errors = outcome
        for error in errors:
            self.report({"WARNING"} if actions else {"ERROR"}, translate_error(error))
        if actions:
            self.report({"INFO"}, translate("{count} characters wait", count=len(actions)))
        return {"FINISHED"} if actions else {"CANCELLED"}

    def failed(self, error: S2agError) -> OperatorResult:
        super().failed(error)
        return {"FINISHED"}  # characters that have an idle keep it, which can be undone
