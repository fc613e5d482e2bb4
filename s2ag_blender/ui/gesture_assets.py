"""Operators that save gestures as assets, and that put a gesture at the playhead or at a word."""
# pyright: reportInvalidTypeForm=false

from typing import Any

import bpy

from ...core.editing.names import BEAT, REST
from ...core.errors import UsageError
from ...core.settings import names_with
from .. import provenance
from ..datablocks import ArmatureObject, Context
from ..keys import apply
from ..takes import gesture_assets, gesture_edits, gesture_insertion, gesture_kinds, menu_items, take_list, timing
from ..translations import translate
from .bases import OperatorResult, require_character
from .operators import NeedsCharacter

_ITEMS: list[Any] = []  # Blender does not keep the strings of enum items alive
_ASSET = "@"  # before the name of an asset among the kinds of gesture


_WHAT = (
    ("GESTURE", "Gesture at the Playhead", "The gesture of the selected take that is nearest to the current frame"),
    ("KIND", "Kind of Gesture", "A gesture as the vocabulary has it, without a take"),
    ("ACTION", "Whole Action", "All that the character's action does, such as an idle"),
)


def _shown_kinds() -> tuple[Any, ...]:
    return tuple(one for one in menu_items.kinds() if one[0] not in (BEAT, REST))


class S2AG_OT_save_gesture(NeedsCharacter, bpy.types.Operator):
    """Save the gesture at the playhead, a kind of gesture or the whole action as an asset that fits any rig"""

    bl_label = "Save Gesture as Asset"

    what: bpy.props.EnumProperty(name="What", description="What becomes an asset", items=_WHAT)
    kind: bpy.props.EnumProperty(
        name="Kind", description="What it shows", items=lambda operator, context: gesture_kinds.pictured(_shown_kinds())
    )
    title: bpy.props.StringProperty(name="Name", description="Name of the asset; if empty, what it shows")
    author: bpy.props.StringProperty(name="Author", description="Who made it")
    license: bpy.props.StringProperty(name="License", description="How others may use it", default="CC0 1.0")

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        return context.window_manager.invoke_props_dialog(self)

    def work(self, context: Context) -> str:
        armature = require_character(context)
        motion, catalogue, told, facts = self._found(context, armature)
        about = {"author": self.author, "license": self.license, "description": told}
        action = gesture_assets.save(armature, motion, self.title or told, catalogue, facts, **about)
        if bpy.data.filepath:
            gesture_assets.write_catalogues(bpy.data.filepath)
        return translate("{name} is in the asset library of this file", name=action.name)

    def _found(self, context: Context, armature: ArmatureObject) -> tuple[Any, str, str, dict[str, Any]]:
        """Return the motion, its catalogue, what it is in words, and its facts."""
        scene, fps = context.scene, apply.scene_fps(context.scene)
        if self.what == "KIND":
            motion = gesture_insertion.perform(self.kind)
            facts = {"stroke": motion.meta["stroke"], "kind": self.kind, "side": _moving_hand(motion)}
            return motion, "S2AG/Kinds", menu_items.gesture_label(self.kind), facts
        if self.what == "ACTION":
            data = armature.animation_data
            if data is None or data.action is None:
                raise UsageError("The character plays no action.", "Choose one in the Action Editor.")
            first, last = (round(at) for at in data.action.frame_range)
            motion = gesture_assets.capture(armature, scene, first, last)
            facts = {"side": _moving_hand(motion), "performer": _performer(data.action)}
            return motion, "S2AG/Actions", data.action.name, facts
        take = take_list.active(armature)
        gesture = gesture_edits.nearest_gesture(take.action, scene) if take is not None else None
        if take is None or gesture is None:
            raise UsageError("No take with gestures is selected.", "Generate one, or save a kind of gesture.")
        clock = timing.clock_of(provenance.require(take.action), fps)
        first, stroke, last = (round(float(clock.frame(at))) for at in (gesture.begin, gesture.at, gesture.end))
        motion = gesture_assets.capture(armature, scene, first, last)
        facts = {"stroke": (stroke - first) / fps, "kind": gesture.kind, "side": gesture.hand}
        facts |= {"performer": _performer(take.action)}
        told = f"{menu_items.gesture_label(gesture.kind)} {gesture.word}".strip()
        return motion, "S2AG/Gestures", told, facts


def _performer(action: bpy.types.Action) -> str:
    named = (provenance.read(action) or {}).get(names_with(indexed=True)[0], "")
    return named if isinstance(named, str) else " ".join(named)


def _moving_hand(motion: Any) -> str:
    arms = {"LEFT_ARM", "RIGHT_ARM"} & gesture_insertion.moving_parts(motion)
    return {"LEFT_ARM": "left", "RIGHT_ARM": "right"}[arms.pop()] if len(arms) == 1 else "both"


def _gestures(operator: Any, context: Any) -> list[Any]:
    """Return enum items for the gestures that are assets of this file, and for the kinds."""
    own = [(f"{_ASSET}{one.name}", one.name, "") for one in gesture_assets.assets()]
    _ITEMS[:] = [(name, label, told, 0, number) for number, (name, label, told) in enumerate([*own, *_shown_kinds()])]
    return _ITEMS


class S2AG_OT_insert_gesture(NeedsCharacter, bpy.types.Operator):
    """Let the character make one gesture at the playhead, in what it does already: an asset, or a kind of gesture"""

    bl_label = "Insert Gesture"
    bl_property = "gesture"

    gesture: bpy.props.EnumProperty(name="Gesture", description="What it shows", items=_gestures)
    asset: bpy.props.StringProperty(options={"HIDDEN", "SKIP_SAVE"})  # name of an action of the file ``library``
    library: bpy.props.StringProperty(subtype="FILE_PATH", options={"HIDDEN", "SKIP_SAVE"})
    word: bpy.props.IntProperty(
        name="Word", description="Number of the word of the selected take that it is made at, from 1; 0 is the playhead",
        default=0, min=0, options={"SKIP_SAVE"},
    )  # fmt: skip
    stroke: bpy.props.BoolProperty(
        name="Stroke at the Playhead", description="The end of its stroke is at the playhead, not its first frame"
    )
    mirror: bpy.props.BoolProperty(name="Mirror", description="Exchange left and right")
    size: bpy.props.FloatProperty(
        name="Size", description="How far the arms go, in sizes that it has", default=1.0, min=0.2, max=2.0, subtype="FACTOR"
    )
    blend_in: bpy.props.IntProperty(
        name="Blend In", description="Frames over which it comes out of what is there", default=12, min=0, subtype="TIME"
    )
    blend_out: bpy.props.IntProperty(
        name="Blend Out", description="Frames over which it goes back into what is there", default=10, min=0, subtype="TIME"
    )
    strip: bpy.props.BoolProperty(
        name="As a Strip", description="A strip above what the character does, instead of keys in a copy of its action"
    )

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        chosen: Any = getattr(context, "asset", None)
        if chosen is not None and chosen.id_type == "ACTION":
            self.asset, self.library = chosen.name, "" if chosen.local_id else chosen.full_library_path
        if self.asset or self.properties.is_property_set("gesture"):
            return self.execute(context)
        context.window_manager.invoke_search_popup(self)
        return {"RUNNING_MODAL"}

    def work(self, context: Context) -> str:
        armature, scene = require_character(context), context.scene
        warnings: list[str] = []
        motion, facts = self._motion()
        motion = gesture_insertion.scaled(motion.mirrored() if self.mirror else motion, self.size)
        frame, lands = self._frame(armature, scene)
        stroke = facts["stroke"] * apply.scene_fps(scene)
        first = round(frame - lands * stroke)
        about = {"strip": self.strip, "blend_in": self.blend_in, "blend_out": self.blend_out, "name": facts["name"]}
        gesture_insertion.insert(armature, scene, motion, first, **about, report=warnings.append)
        for warning in warnings:
            self.report({"WARNING"}, translate(warning))
        told = {"name": armature.name, "gesture": facts["name"], "frame": round(first + stroke)}
        return translate("{name}: {gesture}, fully at frame {frame}", **told)

    def _motion(self) -> tuple[Any, dict[str, Any]]:
        """Return the motion of the chosen gesture and its facts."""
        if not self.asset and not self.gesture.startswith(_ASSET):
            motion = gesture_insertion.perform(self.gesture)
            return motion, {**motion.meta, "name": menu_items.gesture_label(self.gesture)}
        name = self.asset or self.gesture.removeprefix(_ASSET)
        with gesture_assets.borrowed(name, bpy.path.abspath(self.library)) as action:
            held = gesture_assets.read_motion(action) if action is not None else None
        if held is None:
            raise UsageError(f"{name} is no gesture.", "Choose an asset that Save Gesture as Asset has made.")
        return held[0], {**held[1], "name": name}

    def _frame(self, armature: ArmatureObject, scene: bpy.types.Scene) -> tuple[float, bool]:
        """Return the scene frame that the gesture is made at, and whether its stroke lands there."""
        if not self.word:
            return scene.frame_current, self.stroke
        take = take_list.active(armature)
        return gesture_insertion.frame_of_word(take.action if take is not None else None, scene, self.word), True
