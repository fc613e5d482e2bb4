"""Operators that edit the gestures of a take."""
# pyright: reportInvalidTypeForm=false

import json
from collections.abc import Callable
from typing import Any, cast

import bpy

from ...core.editing.names import LARGEST, LEAST
from ...core.errors import UsageError
from .. import compat, provenance
from ..datablocks import ArmatureObject, Context
from ..takes import constraints, generate, gesture_edits, gesture_kinds, menu_items, take_list
from ..takes.menu_items import HANDS
from ..translations import translate
from .bases import OperatorResult, require_character
from .take_ops import OfTake, OnTake, selected

AS_IT_IS = ("keep", "As It Is", "")
RESET: Any = {"SKIP_SAVE"}  # else Blender starts with the values of the last press: a changed hand also grows
_REMEMBERED: Any = {"HIDDEN", "SKIP_SAVE"}
_SEARCH_ITEMS: list[tuple[str, str, str]] = []  # Blender does not keep the strings of enum items alive


def kinds(operator: Any, context: Any) -> Any:
    """Return the items of the kinds of a gesture, each with its picture."""
    return gesture_kinds.pictured(menu_items.kinds())


def kinds_or_same(operator: Any, context: Any) -> Any:
    """Return the items of the kinds of a gesture, behind the one that changes nothing."""
    return gesture_kinds.pictured(menu_items.kinds((AS_IT_IS,)))


class Directing(OfTake):
    """Base of operators that make the next version of a take from edits; the former version is kept."""

    at_gesture = True
    """Whether the edit is about the gesture at the playhead."""
    pins = cast(Any, ())
    """Poses and places that the edits keep."""
    about: bpy.props.FloatVectorProperty(size=2, default=(-1.0, -1.0), options=_REMEMBERED)
    """What the edit is about, in seconds: a gesture, a moment or a range. Kept when the edit is done again with other values
    (F9), since the move of the playhead there was no undo step."""
    chosen: bpy.props.StringProperty(options=_REMEMBERED)
    """The choice by which the range was found, or as JSON what was selected in the editors."""

    @classmethod
    def unknown(cls, take: Any) -> str:
        has_gestures = provenance.read(take.action) and gesture_edits.GESTURES in take.action
        return "" if has_gestures else translate("The gestures of this take are not known: generate it again")

    def planned(self, context: Context, armature: ArmatureObject) -> "generate.Plan":
        action = take_list.active(armature).action
        before, new = self.edits(context, action)
        pins = {"pins": self.pins} if self.pins else {}
        arguments = gesture_edits.plan_arguments(action, [*before, *new])
        return generate.plan(context, armature, **arguments, **pins, forgiven=len(before))

    def edits(self, context, action) -> tuple[list, list]:
        """Return the edits that the take was made with, and the new ones."""
        gesture = gesture_edits.nearest_gesture(action, context.scene, self.about[0]) if self.at_gesture else None
        if self.at_gesture and gesture is None:
            raise UsageError("The take has no gesture.", "Add one.")
        if gesture is not None:
            self.about = gesture.at, gesture.at
        return gesture_edits.edits_of(action), [self.edit(context, action, gesture)]

    def moment(self, context: Context, action: bpy.types.Action) -> float:
        """Return the seconds at the playhead when the button was pressed."""
        if self.about[0] < 0:
            at = gesture_edits.seconds_at(action, context.scene, context.scene.frame_current)
            self.about = at, at
        return round(self.about[0], 4)

    def frames(self, span: tuple[float, float]) -> tuple[float, float]:
        """Return the scene frames ``span``, or those of the press of the button."""
        if self.chosen != "FRAMES":
            self.about, self.chosen = span, "FRAMES"
        return self.about[0], self.about[1]

    def selection(self, find: Callable[[], list]) -> list:
        """Return what ``find`` returned, as JSON has it, when the button was pressed."""
        if not self.chosen.startswith("["):
            self.chosen = json.dumps(find())
        return json.loads(self.chosen)

    def span(self, context: Context, action: bpy.types.Action, what: str) -> tuple[float, float]:
        """Return the seconds of the range that was chosen when the button was pressed."""
        if self.about[0] < 0 or self.chosen != what:
            self.about = gesture_edits.RANGES[what](action, context.scene, require_character(context).s2ag)
            self.chosen = what
        return round(self.about[0], 4), round(self.about[1], 4)

    def edit(self, context: Context, action: bpy.types.Action, gesture: Any) -> dict[str, Any]:
        """Return the new edit; ``gesture`` is the one at the playhead, None if the edit is about no gesture."""
        raise NotImplementedError


class Formed(Directing):
    """Base of operators that ask for a kind, a hand and a size of a gesture."""

    hand: bpy.props.EnumProperty(name="Hand", description="Which hand makes it", items=(AS_IT_IS, *HANDS), options=RESET)
    size: bpy.props.FloatProperty(
        name="Size", description="How large it is, in sizes that it has", default=1.0, min=LEAST, max=LARGEST,
        subtype="FACTOR", options=RESET,
    )

    def draw(self, context: Context) -> None:
        self.layout.use_property_split = True
        for name in ("kind", "hand", "size"):
            self.layout.prop(self, name)

    def form(self) -> dict[str, Any]:
        """Return what was chosen, without what is to be left as it is."""
        options: dict[str, Any] = {name: value for name in ("kind", "hand") if (value := getattr(self, name)) != "keep"}
        return options | ({"size": round(self.size, 3)} if abs(self.size - 1) > 1e-3 else {})


class S2AG_OT_apply_markers(Directing, bpy.types.Operator):
    """Move gestures to where their pose markers are now, and delete those whose markers are gone"""

    bl_label = "Apply Markers"

    def edits(self, context: Context, action: bpy.types.Action) -> tuple[list, list]:
        new = self.selection(lambda: gesture_edits.edits_from_markers(action, context.scene))
        if not new:
            raise UsageError("All markers are where they were.", "Move or delete pose markers of the action first.")
        return gesture_edits.edits_of(action), new


class S2AG_OT_delete_gesture(Directing, bpy.types.Operator):
    """Make phrases anew without their gestures: the one at the playhead, or all that are selected"""

    bl_label = "Delete Gesture"

    what: bpy.props.EnumProperty(
        name="Gestures",
        description="Which gestures are deleted",
        items=(
            ("PLAYHEAD", "At the Playhead", "The gesture that is nearest to the current frame"),
            ("SELECTED", "Selected Gestures", "All gestures whose pose markers are selected, in one step"),
        ),
        options=RESET,
    )

    def edits(self, context: Context, action: bpy.types.Action) -> tuple[list, list]:
        if self.what == "PLAYHEAD":
            return super().edits(context, action)
        scene = context.scene
        new = self.selection(lambda: gesture_edits.deletion(gesture_edits.chosen_gestures(action, scene)))
        return gesture_edits.edits_of(action), new

    def edit(self, context: Context, action: bpy.types.Action, gesture: Any) -> dict[str, Any]:
        return {"do": "delete", "at": gesture.at}


class S2AG_OT_change_gesture(Formed, bpy.types.Operator):
    """Give the gesture at the playhead another kind, hand or size"""

    bl_label = "Change Gesture"

    kind: bpy.props.EnumProperty(name="Kind", description="What it shows", items=kinds_or_same, options=RESET)

    def edit(self, context: Context, action: bpy.types.Action, gesture: Any) -> dict[str, Any]:
        changes = self.form()
        if not changes:
            raise UsageError("Nothing is to be changed.", "Choose another kind, hand or size.")
        return {"do": "change", "at": gesture.at, **changes}


class S2AG_OT_add_gesture(Formed, bpy.types.Operator):
    """Add a gesture whose stroke is at the playhead"""

    bl_label = "Add Gesture"
    at_gesture = False

    kind: bpy.props.EnumProperty(name="Kind", description="What it shows", items=kinds, options=RESET)
    word: bpy.props.IntProperty(default=-1, options={"HIDDEN", "SKIP_SAVE"})  # number of a word to add it at

    def edit(self, context: Context, action: bpy.types.Action, gesture: Any) -> dict[str, Any]:
        if self.word >= 0:
            word, nth = gesture_edits.word_occurrence(action, self.word)
            return {"do": "add", "word": word, "nth": nth, **self.form()}
        return {"do": "add", "at": self.moment(context, action), **self.form()}


def _word_items(operator: Any, context: Any) -> list[tuple[str, str, str]]:
    """Return enum items for the words of the selected take, labelled with their start in seconds."""
    take = selected(context)[1]
    words = gesture_edits.stored_words(take.action) if take is not None else []
    _SEARCH_ITEMS[:] = [(str(number), f"{word}  {start:.1f} s", "") for number, (word, start, _) in enumerate(words)]
    _SEARCH_ITEMS[:] = _SEARCH_ITEMS or [("0", "", "")]  # Blender complains of a menu without items
    return _SEARCH_ITEMS


class S2AG_OT_add_at_word(OnTake, bpy.types.Operator):
    """Search the words of the take, and add a gesture at the one that is chosen"""

    bl_label = "Add Gesture at Word"
    bl_options = {"REGISTER"}  # the operator that it calls adds the undo step
    bl_property = "word"

    word: bpy.props.EnumProperty(name="Word", description="Where its stroke is", items=_word_items, options={"SKIP_SAVE"})
    kind: bpy.props.EnumProperty(name="Kind", description="What it shows", items=kinds)

    @classmethod
    def why_not(cls, context: Context) -> str:
        if reason := super().why_not(context):
            return reason
        known = gesture_edits.stored_words(take_list.active(require_character(context)).action)
        return "" if known else translate("The words of this take are not known")

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        context.window_manager.invoke_search_popup(self)
        return {"RUNNING_MODAL"}

    def work(self, context: Context) -> None:
        action, operators = take_list.active(require_character(context)).action, cast(Any, bpy.ops)
        start = gesture_edits.stored_words(action)[int(self.word)][1]
        context.scene.frame_set(gesture_edits.frame_at(action, context.scene, start))  # where it will be seen
        operators.s2ag.add_gesture("INVOKE_DEFAULT", True, kind=self.kind, word=int(self.word))


RESTS = (
    ("none", "No Gestures", "Both hands go home together and stay there"),
    ("fewer", "Fewer Gestures", "The larger half of the gestures stays"),
    ("calmer", "Calmer Gestures", "All gestures stay, smaller and lower"),
)
"""Items of what a rest leaves."""
_RANGES = (
    ("PREVIEW", "Preview Range", "From the first to the last frame of the preview range"),
    ("GESTURES", "Selected Gestures", "From the first to the last gesture whose pose marker is selected"),
    ("WORDS", "Selected Words", "From the first to the last word whose timeline marker is selected"),
    ("MARKERS", "Selected Markers", "From the first to the last selected marker of the timeline"),
)


class S2AG_OT_reroll_range(Directing, bpy.types.Operator):
    """Make a range of the take anew, each time with another seed; flip through what came"""

    bl_label = "Re-Roll Range"

    what: bpy.props.EnumProperty(name="Range", description="What is made anew", items=_RANGES)

    def edits(self, context: Context, action: bpy.types.Action) -> tuple[list, list]:
        span = self.span(context, action, self.what)
        return gesture_edits.reroll_edits(take_list.active(require_character(context)), span)


class S2AG_OT_rest_range(Directing, bpy.types.Operator):
    """Let a passage rest: the hands go home and stay there, or gestures become fewer or calmer"""

    bl_label = "Rest, Fewer, Calmer"

    what: bpy.props.EnumProperty(name="Range", description="Which passage rests", items=_RANGES)
    how: bpy.props.EnumProperty(name="How", description="How much the passage rests", items=RESTS)

    def edits(self, context: Context, action: bpy.types.Action) -> tuple[list, list]:
        first, last = self.span(context, action, self.what)
        how = {} if self.how == "none" else {"how": self.how}
        return gesture_edits.edits_of(action), [{"do": "rest", "from": first, "to": last, **how}]


class S2AG_OT_keep_pose(Directing, bpy.types.Operator):
    """Keep what is keyed now: gestures flow into these poses and out of them, and later edits leave them"""

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
        if self.what == "KEYS":
            frames = self.selection(lambda: constraints.keyed_frames(action, bones))
        else:
            frames = [self.frames((scene.frame_current, scene.frame_current))[0]]
        new, self.pins = constraints.pose_edits(armature, action, scene, frames, bones or None)
        return gesture_edits.edits_of(action), new


class S2AG_OT_keep_place(Directing, bpy.types.Operator):
    """Keep the wrist of a hand at the chosen object, over the preview range or at the playhead"""

    bl_label = "Keep Hand at Object"

    hand: bpy.props.EnumProperty(name="Hand", description="Which hand is kept", items=HANDS[:2])
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
        first, last = self.frames(span)
        span = round(first), round(last)
        target = armature.s2ag.target
        new, self.pins = constraints.place_edit(armature, action, scene, span, self.hand, target, self.pointing)
        return gesture_edits.edits_of(action), new
