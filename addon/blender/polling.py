"""Base classes of operators, and what these need to run."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, ClassVar, NamedTuple

import bpy
from bpy.types import Collection, Context, Object, Operator

from .words import TranslatedError, report_text

UNDO = {"REGISTER", "UNDO"}
SOLID_TYPES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}


LINKED = (
    "The object is linked from a library: use Object > Library Override > Make, or make it local"
)


def is_editable(obj: Any) -> bool:
    """Whether Blender lets the user edit the haptics of an object: it is of this file, or an
    override that is editable."""
    return not obj.haptics.is_property_readonly("enabled")


def editable(objects: Iterable[Object]) -> list[Object]:
    """The objects that the user may edit."""
    return [obj for obj in objects if is_editable(obj)]


def receiving(collection: Collection) -> Collection:
    """The collection if Blender adds objects to it, else the scene's own, because it is linked or
    overridden."""
    own = bpy.context.scene.collection
    return collection if collection.is_editable and not collection.override_library else own


def linked_message(objects: Sequence[Object]) -> str:
    """The message if all objects are linked from a library, by themselves or as the instance of a
    collection; "" if any is editable."""
    if not objects or any(
        is_editable(obj)
        and (obj.instance_collection is None or obj.instance_collection.library is None)
        for obj in objects
    ):
        return ""
    return (
        "These objects are linked from a library: use Object > Library Override > Make, or make "
        "them local"
    )


class Need(NamedTuple):
    """What an operator needs to run; Blender shows the ``words`` where it is missing."""

    is_met: Callable[[Context], object]
    words: str


Needs = tuple[Need, ...]

OBJECT_MODE = Need(lambda context: context.mode == "OBJECT", "Switch to Object Mode first")
SELECTED = Need(lambda context: context.selected_objects, "Select one or more objects first")
ACTIVE = (
    Need(lambda context: context.object, "Select an object first"),
    Need(lambda context: is_editable(context.object), LINKED),
)


class Refused(TranslatedError):
    """The reason for which an operator does nothing, reported as a warning, not as an error."""


class Action(Operator):
    """An operator. Its name in Blender is that of its class, haptic.add_rule for
    HAPTIC_OT_add_rule, and ``apply`` does its work: ValueError and OSError are reported; a return
    value is passed to Blender."""

    bl_idname = ""
    needs: ClassVar[Needs] = ()

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        prefix, _, name = cls.__name__.partition("_OT_")
        if name and "bl_idname" not in vars(cls):
            cls.bl_idname = f"{prefix.lower()}.{name}"

    @classmethod
    def poll(cls: Any, context: Context) -> bool:
        """Whether everything is there that it needs."""
        for need in cls.needs:
            if not need.is_met(context):
                cls.poll_message_set(need.words)
                return False
        return True

    def execute(self: Any, context: Context) -> set[str]:
        """Call ``apply`` and report its errors."""
        try:
            return self.apply(context) or {"FINISHED"}
        except (ValueError, OSError) as error:
            self.report({"WARNING" if isinstance(error, Refused) else "ERROR"}, str(error))
            return {"CANCELLED"}

    def tell(self, words: str, *values: object) -> None:
        """Report what was done."""
        self.report({"INFO"}, report_text(words, *values))

    def warn(self, words: str, *values: object) -> None:
        """Report what was not done."""
        self.report({"WARNING"}, report_text(words, *values))


class Edit(Action):
    """An operator that edits the file, in Object Mode."""

    bl_options = UNDO
    needs: ClassVar[Needs] = (OBJECT_MODE,)

    def execute(self: Any, context: Context) -> set[str]:
        """Evaluate the scene first: while its settings are adjusted (F9), Blender undoes and calls
        it again with world matrices that are not set yet."""
        context.view_layer.update()
        return super().execute(context)


class OnSelected(Edit):
    """Such an operator on the selected objects."""

    needs: ClassVar[Needs] = (OBJECT_MODE, SELECTED)


class OnActive(Edit):
    """Such an operator on the active object."""

    needs: ClassVar[Needs] = (OBJECT_MODE, *ACTIVE)
