"""Operators that edit the gestures of a take and flip through its versions."""
# pyright: reportInvalidTypeForm=false

from typing import Any, cast

import bpy

from ...core.editing import gestures
from ...core.editing.edits import LARGEST, LEAST
from ...core.errors import S2agError, UsageError
from ...core.meaning import vocabulary
from .. import compat, provenance
from ..datablocks import ArmatureObject, Context
from ..takes import constraints, generate, gesture_edits, retiming, session, take_list, versions
from ..takes.operator_base import GeneratingOperator
from ..translations import translate, translate_error
from .bases import OperatorResult, require_character
from .take_ops import OfTake, OnTake, selected

_HANDS = (("left", "Left Hand", ""), ("right", "Right Hand", ""), ("both", "Both Hands", ""))
_AS_IT_IS = ("keep", "As It Is", "")
_RESET: Any = {"SKIP_SAVE"}  # else Blender starts with the values of the last press: a changed hand also grows
_KINDS = (
    (gestures.BEAT, "Beat", "A stroke that the performer makes elsewhere in the take"),
    *((name, name.replace("_", " ").capitalize(), "") for name in vocabulary.load_vocabulary().gestures),
)
LABELS = {name: label for name, label, _ in (*_KINDS, *_HANDS)}
"""Labels of kinds and hands."""
_SEARCH_ITEMS: list[tuple[str, str, str]] = []  # Blender does not keep the strings of enum items alive


class _Directing(OfTake):
    """Base of operators that make the next version of a take from edits; the former version is kept."""

    at_gesture = True
    """Whether the edit is about the gesture at the playhead."""
    pins = cast(Any, ())
    """Poses and places that the edits keep."""

    @classmethod
    def unknown(cls, take: Any) -> str:
        has_gestures = provenance.read(take.action) and gesture_edits.GESTURES in take.action
        return "" if has_gestures else translate("The gestures of this take are not known: generate it again")

    def planned(self, context: Context, armature: ArmatureObject) -> generate.Plan:
        action = take_list.active(armature).action
        before, new = self.edits(context, action)
        pins = {"pins": self.pins} if self.pins else {}
        return generate.plan(context, armature, **gesture_edits.plan_arguments(action, [*before, *new]), **pins)

    def edits(self, context, action) -> tuple[list, list]:
        """Return the edits that the take was made with, and the new ones."""
        gesture = gesture_edits.nearest_gesture(action, context.scene) if self.at_gesture else None
        if self.at_gesture and gesture is None:
            raise UsageError("The take has no gesture.", "Add one.")
        return gesture_edits.edits_of(action), [self.edit(context, action, gesture)]

    def edit(self, context: Context, action: bpy.types.Action, gesture: Any) -> dict[str, Any]:
        """Return the new edit; ``gesture`` is the one at the playhead, None if the edit is about no gesture."""
        raise NotImplementedError


def _edit_options(operator: Any) -> dict[str, Any]:
    """Return the kind, hand and size chosen in the operator, without those to be left as they are."""
    options: dict[str, Any] = {name: getattr(operator, name) for name in ("kind", "hand")}
    options = {name: value for name, value in options.items() if value != "keep"}
    return options | ({"size": round(operator.size, 3)} if abs(operator.size - 1) > 1e-3 else {})


class S2AG_OT_apply_markers(_Directing, bpy.types.Operator):
    """Move gestures to where their pose markers are now, and delete those whose markers are gone"""

    bl_idname = "s2ag.apply_markers"
    bl_label = "Apply Markers"

    def edits(self, context: Context, action: bpy.types.Action) -> tuple[list, list]:
        new = gesture_edits.edits_from_markers(action, context.scene)
        if not new:
            raise UsageError("All markers are where they were.", "Move or delete pose markers of the action first.")
        return gesture_edits.edits_of(action), new


class S2AG_OT_delete_gesture(_Directing, bpy.types.Operator):
    """Make the phrase at the playhead anew without its gesture"""

    bl_idname = "s2ag.delete_gesture"
    bl_label = "Delete Gesture"

    def edit(self, context: Context, action: bpy.types.Action, gesture: Any) -> dict[str, Any]:
        return {"do": "delete", "at": gesture.at}


class S2AG_OT_change_gesture(_Directing, bpy.types.Operator):
    """Give the gesture at the playhead another kind, hand or size"""

    bl_idname = "s2ag.change_gesture"
    bl_label = "Change Gesture"

    kind: bpy.props.EnumProperty(name="Kind", description="What it shows", items=(_AS_IT_IS, *_KINDS), options=_RESET)
    hand: bpy.props.EnumProperty(name="Hand", description="Which hand makes it", items=(_AS_IT_IS, *_HANDS), options=_RESET)
    size: bpy.props.FloatProperty(
        name="Size", description="How large it is, in sizes that it has", default=1.0, min=LEAST, max=LARGEST, options=_RESET
    )

    def edit(self, context: Context, action: bpy.types.Action, gesture: Any) -> dict[str, Any]:
        changes = _edit_options(self)
        if not changes:
            raise UsageError("Nothing is to be changed.", "Choose another kind, hand or size.")
        return {"do": "change", "at": gesture.at, **changes}


class S2AG_OT_add_gesture(_Directing, bpy.types.Operator):
    """Add a gesture whose stroke is at the playhead"""

    bl_idname = "s2ag.add_gesture"
    bl_label = "Add Gesture"
    at_gesture = False

    kind: bpy.props.EnumProperty(name="Kind", description="What it shows", items=_KINDS, options=_RESET)
    hand: bpy.props.EnumProperty(name="Hand", description="Which hand makes it", items=(_AS_IT_IS, *_HANDS), options=_RESET)
    size: bpy.props.FloatProperty(
        name="Size", description="How large it is, in sizes that it has", default=1.0, min=LEAST, max=LARGEST, options=_RESET
    )
    word: bpy.props.IntProperty(default=-1, options={"HIDDEN", "SKIP_SAVE"})  # number of a word to add it at

    def edit(self, context: Context, action: bpy.types.Action, gesture: Any) -> dict[str, Any]:
        if self.word >= 0:
            word, nth = gesture_edits.word_occurrence(action, self.word)
            return {"do": "add", "word": word, "nth": nth, **_edit_options(self)}
        return {
            "do": "add",
            "at": gesture_edits.seconds_at(action, context.scene, context.scene.frame_current),
            **_edit_options(self),
        }


def _word_items(operator: Any, context: Any) -> list[tuple[str, str, str]]:
    """Return enum items for the words of the selected take, labelled with their start in seconds."""
    take = selected(context)[1]
    words = gesture_edits.stored_words(take.action) if take is not None else []
    _SEARCH_ITEMS[:] = [(str(number), f"{word}  {start:.1f} s", "") for number, (word, start, _) in enumerate(words)]
    return _SEARCH_ITEMS


class S2AG_OT_add_at_word(OnTake, bpy.types.Operator):
    """Search the words of the take, and add a gesture at the one that is chosen"""

    bl_idname = "s2ag.add_at_word"
    bl_label = "Add Gesture at Word"
    bl_options = {"REGISTER"}  # the operator that it calls adds the undo step
    bl_property = "word"

    word: bpy.props.EnumProperty(name="Word", description="Where its stroke is", items=_word_items, options={"SKIP_SAVE"})
    kind: bpy.props.EnumProperty(name="Kind", description="What it shows", items=_KINDS)

    @classmethod
    def poll(cls, context: Context) -> bool:
        if not super().poll(context):
            return False
        if not gesture_edits.stored_words(take_list.active(require_character(context)).action):
            cls.poll_message_set(translate("The words of this take are not known"))
            return False
        return True

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        context.window_manager.invoke_search_popup(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: Context) -> OperatorResult:
        operators: Any = bpy.ops
        operators.s2ag.add_gesture("INVOKE_DEFAULT", True, kind=self.kind, word=int(self.word))
        return {"FINISHED"}


class S2AG_OT_reroll_range(_Directing, bpy.types.Operator):
    """Make a range of the take anew, each time with another seed; flip through what came"""

    bl_idname = "s2ag.reroll_range"
    bl_label = "Re-Roll Range"

    what: bpy.props.EnumProperty(
        name="Range",
        description="What is made anew",
        items=(
            ("PREVIEW", "Preview Range", "From the first to the last frame of the preview range"),
            ("GESTURES", "Selected Gestures", "From the first to the last gesture whose pose marker is selected"),
            ("WORDS", "Selected Words", "From the first to the last word whose timeline marker is selected"),
        ),
    )

    def edits(self, context: Context, action: bpy.types.Action) -> tuple[list, list]:
        armature = require_character(context)
        span = gesture_edits.RANGES[self.what](action, context.scene, armature.s2ag)
        return gesture_edits.reroll_edits(take_list.active(armature), span)


class S2AG_OT_keep_pose(_Directing, bpy.types.Operator):
    """Keep what is keyed now: gestures flow into these poses and out of them, and later edits leave them"""

    bl_idname = "s2ag.keep_pose"
    bl_label = "Keep Pose"

    what: bpy.props.EnumProperty(
        name="Poses",
        description="Which poses are kept, of the selected bones in pose mode, else of all",
        items=(
            ("PLAYHEAD", "At the Playhead", "The pose on the current frame"),
            ("KEYS", "Selected Keys", "The poses on the frames of selected keys"),
        ),
    )

    def edits(self, context: Context, action: bpy.types.Action) -> tuple[list, list]:
        armature, scene = require_character(context), context.scene
        bones = compat.selected_bones(armature) if armature.mode == "POSE" else None
        frames = constraints.keyed_frames(action, bones) if self.what == "KEYS" else [float(scene.frame_current)]
        new, self.pins = constraints.pose_edits(armature, action, scene, frames, bones or None)
        return gesture_edits.edits_of(action), new


class S2AG_OT_keep_place(_Directing, bpy.types.Operator):
    """Keep the wrist of a hand at the chosen object, over the preview range or at the playhead"""

    bl_idname = "s2ag.keep_place"
    bl_label = "Keep Hand at Object"

    hand: bpy.props.EnumProperty(name="Hand", description="Which hand is kept", items=_HANDS[:2])
    pointing: bpy.props.BoolProperty(
        name="Point", description="Point at the object with a stretched arm instead of holding it", options={"SKIP_SAVE"}
    )

    def edits(self, context: Context, action: bpy.types.Action) -> tuple[list, list]:
        armature, scene = require_character(context), context.scene
        if armature.s2ag.target is None:
            raise UsageError("No object is chosen.", "Choose what the hand is to hold or point at.")
        span = scene.frame_current, scene.frame_current
        if scene.use_preview_range:
            span = scene.frame_preview_start, scene.frame_preview_end
        target = armature.s2ag.target
        new, self.pins = constraints.place_edit(armature, action, scene, span, self.hand, target, self.pointing)
        return gesture_edits.edits_of(action), new


class S2AG_OT_follow_sound(GeneratingOperator, bpy.types.Operator):
    """Bring the selected take, with all its versions, to where its sound is now: moved, trimmed, stretched, or said anew"""

    bl_idname = "s2ag.follow_sound"
    bl_label = "Follow Sound"

    @classmethod
    def poll(cls, context: Context) -> bool:
        if not OnTake.poll.__func__(cls, context):
            return False
        armature = require_character(context)
        if session.run_of(armature) is not None:
            cls.poll_message_set(translate("Gestures are being made"))
            return False
        if not retiming.change(take_list.active(armature).action, context.scene):
            cls.poll_message_set(translate("The sound strip lies where it lay"))
            return False
        return True

    def planned(self, context: Context, armature: ArmatureObject) -> generate.Plan:
        return generate.follow_arguments(context, armature)

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        what = _sound_change(context)
        return super().invoke(context, event) if what.replaced or what.grown else self.execute(context)

    def execute(self, context: Context) -> OperatorResult:
        what = _sound_change(context)
        if what.replaced or what.grown:
            return super().execute(context)
        try:
            retiming.follow(require_character(context), context.scene)
        except S2agError as error:
            self.report({"ERROR"}, translate_error(error))
            return {"CANCELLED"}
        self.report({"INFO"}, retiming.change_sentence(what))
        return {"FINISHED"}


def _sound_change(context: Context) -> retiming.Change:
    """Return how the sound of the selected take has changed, where a poll has made sure that it has."""
    what = retiming.change(take_list.active(require_character(context)).action, context.scene)
    assert what is not None
    return what


class _OnVersions(OnTake):
    """Base of operators on the versions of a take."""

    @classmethod
    def poll(cls, context: Context) -> bool:
        if not super().poll(context):
            return False
        if versions.version_position(take_list.active(require_character(context)))[1] < 2:
            cls.poll_message_set(translate("This take has one version only"))
            return False
        return True


class S2AG_OT_flip_version(_OnVersions, bpy.types.Operator):
    """Show what the selected take was before an edit, or another alternative; nothing is made anew"""

    bl_idname = "s2ag.flip_version"
    bl_label = "Flip Versions"

    back: bpy.props.BoolProperty(
        name="Back", description="Show the version before instead of the next one", options={"SKIP_SAVE"}
    )

    def execute(self, context: Context) -> OperatorResult:
        versions.flip(require_character(context), -1 if self.back else 1)
        return {"FINISHED"}


class S2AG_OT_drop_versions(_OnVersions, bpy.types.Operator):
    """Delete all versions of the selected take but the one that is shown"""

    bl_idname = "s2ag.drop_versions"
    bl_label = "Keep This Version"

    def execute(self, context: Context) -> OperatorResult:
        count = versions.drop_others(require_character(context))
        self.report({"INFO"}, translate("{count} versions deleted", count=count))
        return {"FINISHED"}


CLASSES = (
    S2AG_OT_apply_markers,
    S2AG_OT_delete_gesture,
    S2AG_OT_change_gesture,
    S2AG_OT_add_gesture,
    S2AG_OT_add_at_word,
    S2AG_OT_reroll_range,
    S2AG_OT_keep_pose,
    S2AG_OT_keep_place,
    S2AG_OT_follow_sound,
    S2AG_OT_flip_version,
    S2AG_OT_drop_versions,
)
