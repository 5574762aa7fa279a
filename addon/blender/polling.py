"""Base classes and poll functions of operators."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bpy.types import Context, Object, Operator

UNDO = {"REGISTER", "UNDO"}
SOLID_TYPES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}


def editable(objects: Sequence[Object]) -> list[Object]:
    """The objects that are not linked from a library."""
    return [obj for obj in objects if obj.is_editable]


def linked_message(objects: Sequence[Object]) -> str:
    """The message if all objects are linked from a library; "" if any is editable."""
    if not objects or editable(objects):
        return ""
    return "These objects are linked from a library; make them local or override them first"


def poll_object_mode(cls: type[Operator], context: Context) -> bool:
    """Object Mode."""
    if context.mode != "OBJECT":
        cls.poll_message_set("Switch to Object Mode first")
        return False
    return True


def poll_selected(cls: type[Operator], context: Context) -> bool:
    """Object Mode, and at least one selected object."""
    if not poll_object_mode(cls, context):
        return False
    if not context.selected_objects:
        cls.poll_message_set("Select one or more objects first")
        return False
    return True


def poll_active(cls: type[Operator], context: Context) -> bool:
    """Object Mode, and an editable active object."""
    if not poll_object_mode(cls, context):
        return False
    if context.object is None:
        cls.poll_message_set("Select an object first")
        return False
    if not context.object.is_editable:
        cls.poll_message_set("The active object is linked from a library; make it local or override it first")
        return False
    return True


class Refused(ValueError):
    """The reason for which an operator does nothing, reported as a warning, not as an error."""


class Action:
    """Mixin: an operator. Its name in Blender is that of its class, haptic.add_rule for HAPTIC_OT_add_rule, and ``apply`` does its work:
    ValueError and OSError are reported; a return value is passed to Blender."""

    bl_idname = ""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        prefix, _, name = cls.__name__.partition("_OT_")
        if name and "bl_idname" not in vars(cls):
            cls.bl_idname = f"{prefix.lower()}.{name}"

    def execute(self: Any, context: Context) -> set[str]:
        """Call ``apply`` and report its errors."""
        try:
            return self.apply(context) or {"FINISHED"}
        except (ValueError, OSError) as error:
            self.report({"WARNING" if isinstance(error, Refused) else "ERROR"}, str(error))
            return {"CANCELLED"}


class Edit(Action):
    """Mixin: an operator that edits the file."""

    bl_options = UNDO
