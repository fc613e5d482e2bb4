"""Typed bases of operators and panels, and the character that they act on."""

from typing import TYPE_CHECKING, Any

import bpy

from ...core.errors import S2agError
from ..datablocks import ArmatureObject, Context
from ..takes.operator_base import character
from ..translations import translate, translate_error

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
        """Base of all our operators, which are called as their classes are: ``S2AG_OT_keep_take`` is ``s2ag.keep_take``.

        Type checkers see an operator, with the path of a file dialog."""

        def __init_subclass__(cls) -> None:
            cls.bl_idname = f"s2ag.{cls.__name__.removeprefix('S2AG_OT_')}"

    class LayoutMixin:
        """Base of our panels, menus and preferences; type checkers see that there is a layout to draw in."""


OperatorResult = Any
"""What ``execute``, ``invoke`` and ``modal`` of an operator return: a set with one of Blender's status names."""


def require_character(context: Context) -> ArmatureObject:
    """Return the chosen character, where a poll has made sure that there is one."""
    armature = character(context)
    assert armature is not None
    return armature


class Button(OperatorMixin):
    """Base of operators: their buttons are greyed with the reason, and errors are told in the user's language."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def why_not(cls, context: Context) -> str:
        """Return why the operator cannot run now, in the user's language; empty if it can."""
        return ""

    @classmethod
    def poll(cls, context: Context) -> bool:
        reason = cls.why_not(context)
        if reason:
            cls.poll_message_set(reason)
        return not reason

    def execute(self, context: Context) -> OperatorResult:
        try:
            news = self.work(context)
        except S2agError as error:
            self.report({"ERROR"}, translate_error(error))
            return {"CANCELLED"}
        if news:
            self.report({"INFO"}, news)
        return {"FINISHED"}

    def work(self, context: Context) -> str | None:
        """Do it, and return news for the user, if any; may raise :class:`S2agError`."""
        raise NotImplementedError


class NeedsCharacter(Button):
    """Base of operators that need a character and nothing else."""

    @classmethod
    def why_not(cls, context: Context) -> str:
        return "" if character(context) is not None else translate("Select a character's armature")


class OfCharacter(Button):
    """Base of operators that change the active character; it must exist, be no linked data, and not be in edit mode."""

    @classmethod
    def why_not(cls, context: Context) -> str:
        return why_unchangeable(character(context))


def why_unchangeable(armature: ArmatureObject | None) -> str:
    """Return why a character cannot be changed now; empty if it can."""
    if armature is None:
        return translate("Select a character's armature")
    if armature.library is not None:
        return translate("The character is linked: make a library override of it first")
    return translate("Leave edit mode first") if armature.mode == "EDIT" else ""
