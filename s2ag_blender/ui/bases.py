"""Typed bases of operators and panels, and the character that they act on."""

from typing import TYPE_CHECKING, Any

import bpy

from ..datablocks import ArmatureObject, Context
from ..takes.operator_base import character

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import IconItems as Icon

    class OperatorMixin(bpy.types.Operator):
        layout: bpy.types.UILayout
        filepath: str

    class LayoutMixin(bpy.types.Panel):
        layout: bpy.types.UILayout

else:
    Icon = str

    class OperatorMixin:
        """Base of our mixins for operators; type checkers see an operator, with the path of a file dialog."""

    class LayoutMixin:
        """Base of our panels, menus and preferences; type checkers see that there is a layout to draw in."""


OperatorResult = Any
"""What ``execute``, ``invoke`` and ``modal`` of an operator return: a set with one of Blender's status names."""


def require_character(context: Context) -> ArmatureObject:
    """Return the chosen character, where a poll has made sure that there is one."""
    armature = character(context)
    assert armature is not None
    return armature


def may_run(cls: Any, reason: str) -> bool:
    """Return whether an operator class may run, there being no ``reason`` why not, which its greyed button tells."""
    if reason:
        cls.poll_message_set(reason)
    return not reason
