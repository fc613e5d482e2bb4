"""Operators that make many actions: every selected character waits, needing no engine; one gestures to every sound strip."""
# pyright: reportInvalidTypeForm=false

import time
from collections.abc import Generator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import bpy

from ...core.errors import Cancelled, S2agError
from ...core.settings import names_with
from .. import compat
from ..datablocks import ArmatureObject, Context, current_context
from ..keys import apply
from ..rig import chosen_bones
from ..takes import drafts, generate, plans, session, sources, stored_settings, take_list
from ..takes.operator_base import SlicedOperator, armature_of, character
from ..translations import translate, translate_error
from .bases import NeedsCharacter, OperatorResult, require_character, why_unchangeable

Made = tuple[list[bpy.types.Action], list[S2agError]]


def idle_in_slices(
    armatures: list[ArmatureObject], start: int, scene: bpy.types.Scene, seconds: float, stillness: float, loop: bool
) -> Generator[float | None, None, Made]:
    """Let each character idle from frame ``start``, with its style and its seed plus its number here; yield the share done
    wherever Blender may draw. Returns the actions, and why characters got none or less."""
    from ...core.synthesis import idling

    actions, errors, rate = [], [], apply.scene_fps(scene)
    with ThreadPoolExecutor(1) as pool:
        named = [[getattr(one.s2ag, name) for name in names_with(indexed=True)] for one in armatures]  # style and seed
        for number, (armature, (style, seed)) in enumerate(zip(armatures, named, strict=True)):
            motion = pool.submit(idling.idle, seconds, style, seed + number, stillness, loop, rate)
            yield number / len(armatures)
            while not motion.done():  # alone: beside it, keying would hold Blender for longer
                yield number / len(armatures)
                time.sleep(0.002)
            drafts.drop(armature)
            settings, about = armature.s2ag, {"scene": scene, "name": f"{armature.name} idle"}
            about |= {"mapping": chosen_bones.mapping_of_settings(settings), "strip": settings.result == "STRIP"}
            about |= {"options": stored_settings.options(settings), "report": lambda told: errors.append(S2agError(told, ""))}
            slices = apply.apply_motion_in_slices(armature, motion.result(), start, **about)
            try:
                actions.append((yield from slices))
                if settings.result != "STRIP":
                    take_list.add_takes(armature, actions[-1:])
            except S2agError as error:
                errors.append(error)
    return actions, errors


class MakesMany(SlicedOperator, NeedsCharacter):
    """Base of operators whose work ends with actions, of which they tell, and with why others were not made."""

    def finished(self, outcome: Made) -> OperatorResult:
        actions, errors = outcome
        for error in errors:
            self.report({"WARNING"} if actions else {"ERROR"}, translate_error(error))
        if actions:
            self.report({"INFO"}, translate("Made: {names}", names=", ".join(one.name for one in actions)))
        return {"FINISHED"} if actions else {"CANCELLED"}

    def failed(self, error: S2agError) -> OperatorResult:
        super().failed(error)
        return {"FINISHED"}  # one undo step, even of a few


def gesture_in_slices(armature: ArmatureObject, names: list[str]) -> Generator[float | None, None, Made]:
    """Make a take for each sound strip, which plays on a strip of the NLA or layer of its own; yield as above."""
    who, actions, errors = plans.Handle.of(armature), [], []
    for number, name in enumerate(names):
        try:
            run = session.Run(current_context(), armature, _plan_strip(who.find(bpy.data.objects) or armature, name))
            try:
                while (outcome := run.step()) is None:
                    yield number / len(names)
                    time.sleep(0.002)
            finally:
                run.cancel()  # what has not ended
                run.end()
            actions += outcome.actions
        except Cancelled:
            raise
        except S2agError as error:
            errors.append(error)
    return actions, errors


def _plan_strip(armature: ArmatureObject, name: str) -> "plans.Plan":
    settings: Any = armature.s2ag
    asked = sources.settings_of_strip(settings, name)
    before = {name: getattr(settings, name) for name in asked}
    try:
        for name, value in asked.items():
            setattr(settings, name, value)
        return generate.plan(current_context(), armature)
    finally:
        for name, value in before.items():
            setattr(settings, name, value)


class S2AG_OT_generate_strips(MakesMany, bpy.types.Operator):
    """Let the character gesture to every sound strip that is not muted, with the words beside each recording"""

    bl_label = "Generate for All Strips"

    only: bpy.props.BoolProperty(name="Selected Strips", description="Leave out strips that are not selected")

    @classmethod
    def why_not(cls, context: Context) -> str:
        found = compat.sound_strips(context.scene)
        return why_unchangeable(character(context)) or ("" if found else translate("The sequencer has no sound strip"))

    def slices(self, context: Context) -> Generator[float | None, None, Made]:
        found = [one for one in compat.sound_strips(context.scene) if not one.mute and (one.select or not self.only)]
        return gesture_in_slices(require_character(context), [one.name for one in sorted(found, key=compat.visible_start)])


class S2AG_OT_idle(MakesMany, bpy.types.Operator):
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

    def slices(self, context: Context) -> Generator[float | None, None, Made]:
        """Return the work on the selected characters, the active one first."""
        chosen = [armature_of(item) for item in sorted(context.selected_objects, key=lambda item: item.name)]
        armatures = list(dict.fromkeys([require_character(context), *(one for one in chosen if one is not None)]))
        scene = context.scene
        return idle_in_slices(armatures, scene.frame_start, scene, self.seconds, self.stillness, self.loop)
