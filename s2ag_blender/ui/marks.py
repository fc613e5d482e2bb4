"""A menu of every mark that a transcript can have, which writes the chosen one where the words are."""
# pyright: reportInvalidTypeForm=false

import functools
from typing import Any

import bpy

from ..datablocks import Context
from ..takes import gesture_kinds
from ..translations import translate
from .bases import NeedsCharacter, require_character

_STRETCHES = (
    ("*", "Stress", "Before and after a word: it bears the accent of its phrase"),
    ("[pause]", "Pause", "Hands go to rest between two words"),
    ("{none}", "Rest", "Hands rest until the end of the phrase"),
    ("{big}", "Larger", "Larger gestures until the end of the phrase"),
    ("{small}", "Smaller", "Smaller gestures until the end of the phrase"),
    ("{left}", "Left Hand", "The left hand shows it until the end of the phrase"),
    ("{right}", "Right Hand", "The right hand shows it until the end of the phrase"),
    ("{as usual}", "Usual Style", "The take's own style again"),
)


@functools.cache  # Blender keeps no reference to the texts of a menu
def mark_items() -> list[tuple[str, str, str]]:
    """Return the items of all marks, for a stretch of words, and for a gesture, with what it shows."""
    from ...core.meaning import vocabulary
    from ...core.words import hints

    kinds = vocabulary.load_vocabulary().marks
    shown = {name: gesture_kinds.SHOWN.get(kinds.get(name, name), "") for name in hints.HINTS}
    asked = [(f"{{{name}}}", name.capitalize(), told or "A stroke with this meaning") for name, told in shown.items()]
    return [*_STRETCHES, *asked]


class S2AG_OT_insert_mark(NeedsCharacter, bpy.types.Operator):
    """Write a mark into the words: at the cursor of the text, or at the end of what is typed"""

    bl_label = "Insert Mark"

    mark: bpy.props.EnumProperty(
        name="Mark", description="What the mark asks for", items=lambda operator, context: mark_items(), options={"SKIP_SAVE"}
    )

    @classmethod
    def why_not(cls, context: Context) -> str:
        if reason := super().why_not(context):
            return reason
        settings: Any = require_character(context).s2ag
        if settings.transcript_source == "TYPED" or (settings.transcript_source == "BLOCK" and settings.transcript_block):
            return ""
        return translate("Words of a file get their marks there; choose a text or type them")

    def work(self, context: Context) -> None:
        settings: Any = require_character(context).s2ag
        if settings.transcript_source == "BLOCK":
            settings.transcript_block.write(self.mark if self.mark == "*" else f"{self.mark} ")
        else:
            settings.typed = f"{settings.typed.rstrip()} {self.mark}".lstrip()
