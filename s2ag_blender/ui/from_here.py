"""Operators that change who performs, and how it feels, from the playhead on."""
# pyright: reportInvalidTypeForm=false

from typing import Any

import bpy

from ..datablocks import Context
from ..takes import menu_items
from ..translations import translate
from .bases import NeedsCharacter
from .directing import RESET, Directing
from .take_ops import selected


def _style_items(operator: Any, context: Any) -> list[tuple]:
    """Return the items of the styles of the gesture model."""
    armature = selected(context)[0]
    return [one for one in menu_items.style_items(armature and armature.s2ag, context) if one[0] != menu_items.WRITTEN]


class S2AG_OT_style_from(Directing, bpy.types.Operator):
    """Perform in another style from the playhead on, up to the next change of style"""

    bl_label = "Style from Here"
    at_gesture = False

    style: bpy.props.EnumProperty(name="Style", description="Who performs from here on", items=_style_items, options=RESET)

    def edit(self, context: Context, action: bpy.types.Action, gesture: Any) -> dict[str, Any]:
        return {"do": "style", "at": self.moment(context, action), "style": self.style}


class S2AG_OT_feeling_from(Directing, bpy.types.Operator):
    """Feel otherwise from the playhead on, body and face, up to the next change of feeling"""

    bl_label = "Feeling from Here"
    at_gesture = False

    mood: bpy.props.EnumProperty(
        name="Feeling", description="How it feels from here on", items=[one[:3] for one in menu_items.MOODS], options=RESET
    )
    strength: bpy.props.FloatProperty(
        name="Strength", description="How much of it", default=0.8, min=0.1, max=1.0, subtype="FACTOR", options=RESET
    )

    def edit(self, context: Context, action: bpy.types.Action, gesture: Any) -> dict[str, Any]:
        affects = next(one[3] for one in menu_items.MOODS if one[0] == self.mood)
        felt = {name: round(value * self.strength, 3) for name, value in affects.items()}
        return {"do": "feel", "at": self.moment(context, action), **felt}


class S2AG_OT_mark_style(NeedsCharacter, bpy.types.Operator):
    """Put a timeline marker at the playhead at which this style begins, in all takes that are generated from now on"""

    bl_label = "Style Marker"

    style: bpy.props.EnumProperty(name="Style", description="Who performs from here on", items=_style_items, options=RESET)

    def work(self, context: Context) -> str:
        marker = context.scene.timeline_markers.new(f"as {self.style}", frame=context.scene.frame_current)
        return translate("{name} begins at frame {frame}", name=translate(self.style), frame=marker.frame)
