"""Settings of the F-curves that gestures become: speed, smoothing, and which frames are keyed."""
# pyright: reportInvalidTypeForm=false

import math
from typing import Any

import bpy

EDITABLE: Any = {"LIBRARY_OVERRIDABLE"}
"""Option of properties that can be changed on library overrides."""


def update_preview(settings: Any, context: bpy.types.Context) -> None:
    """Update the live preview after a change of a setting."""
    from ..takes import preview

    preview.request_draft(settings.id_data)


class CurveSettings:
    """The settings of F-curves, a part of a character's settings."""

    speed: bpy.props.FloatProperty(
        name="Speed",
        description="How fast strokes are; they meet the words all the same",
        default=1.0,
        min=0.6,
        max=2.0,
        subtype="FACTOR",
        override=EDITABLE,
        update=update_preview,
    )
    smoothing: bpy.props.FloatProperty(
        name="Smoothing",
        description="Seconds over which movements are evened out",
        default=0.0,
        min=0.0,
        max=1.0,
        subtype="TIME_ABSOLUTE",
        override=EDITABLE,
        update=update_preview,
    )
    curves: bpy.props.EnumProperty(
        name="Keys",
        description="Which frames are keyed",
        items=[
            ("POSES", "Poses", "Where strokes, holds and rests begin and end, with curves between that can be edited"),
            ("FRAMES", "Frames", "Every frame, or every few of them"),
        ],
        override=EDITABLE,
    )
    tolerance: bpy.props.FloatProperty(
        name="Tolerance",
        description="How far curves may depart from the gestures; more leaves fewer keys",
        default=math.radians(1.0),
        min=math.radians(0.05),
        max=math.radians(10.0),
        subtype="ANGLE",
        override=EDITABLE,
    )
    key_step: bpy.props.IntProperty(
        name="Key Every",
        description="Frames between keys; more are easier to edit",
        default=1,
        min=1,
        max=12,
        subtype="TIME",
        override=EDITABLE,
        update=update_preview,
    )
