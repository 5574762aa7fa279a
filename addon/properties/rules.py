"""Tables of a scene: rules for pairs of objects.

A table is a property group with `TableRows` and ``items``, whose class has `RuleScope` and the
values of a row; `TABLES` lists it for the operators that edit tables.
"""

from __future__ import annotations

from bpy.props import CollectionProperty, IntProperty
from bpy.types import PropertyGroup

from ...core.scene.impact_rule import TEMPLATES, ImpactLimits, ImpactRule
from ...core.scene.texture import Texture
from .callbacks import scene_changed, updating
from .declared import holding, items_of
from .drawing import drawing_property
from .function import TRANSMISSIONS, ContactParameters, function_property
from .kinds import choice, file_path, text

TABLES = (
    ("impact_table", "Impacts", "What impacts between some objects need and play"),
    ("transmission_table", "Contacts", "What contacts between some objects pass on"),
    ("textures", "Sliding and Rolling", "What some objects play that slide or roll on each other"),
)
"""The tables by their names in the properties of a scene."""

SIDE_ITEMS = (
    ("ANY", "Anything", "Any object", "WORLD", 0),
    (
        "MATERIAL",
        "Material",
        "Objects of a material of the library; * stands for any characters, ? for one",
        "MATERIAL",
        1,
    ),
    ("OBJECT", "Object", "An object; * stands for any characters, ? for one", "OBJECT_DATA", 2),
)

_SIDE = "Whether this side of the rule is one object, a material or anything"
_NAME = "Name of the object or material, or a pattern"
_FULL = (
    "A collision of this energy, in joules, plays the signal at full strength; 0: that of the scene"
)


class RuleScope:
    """Mixin: the pairs of objects that a row applies to."""

    first_kind: choice("Between", _SIDE, SIDE_ITEMS, options=set())
    first: text("Name", _NAME, options=set())
    second_kind: choice("And", _SIDE, SIDE_ITEMS, options=set())
    second: text("Name", _NAME, options=set())


class TableRows:
    """Mixin: the properties of every table besides its items."""

    reasons = {"active": "view"}

    active: IntProperty(name="Active Rule", default=0, min=0, options=set())


@updating(scene_changed, animated=False)
@holding(ImpactRule)
@holding(ImpactLimits, "full_energy", more={"full_energy": {"description": _FULL}})
class HapticImpactRule(RuleScope, PropertyGroup):
    """The rule for impacts between some objects."""

    reasons = {
        "template": "file",
        "filepath": "file",
        "drawing": "file",
        "full_energy": "steps of characters, see Add Footsteps",
        "gain": "pairs that make no sound, see Add Footsteps",
    }

    template: choice(
        "Signal",
        "What impacts feel like",
        (
            *items_of(TEMPLATES),
            ("FILE", "File", "The first vibration in a file"),
            ("DRAWN", "Drawn", "A signal that was drawn for a source, once"),
        ),
    )
    filepath: file_path("File", "The file with the vibration that impacts play")
    drawing: drawing_property()


class HapticImpactTable(TableRows, PropertyGroup):
    """The rules of a scene for impacts."""

    items: CollectionProperty(type=HapticImpactRule)  # type: ignore[assignment]  # in place of items() of bpy_struct


@updating(scene_changed, animated=False)
@holding(Texture)
class HapticTexture(RuleScope, PropertyGroup):
    """The texture of some objects that slide or roll on each other."""


class HapticTextureTable(TableRows, PropertyGroup):
    """The rules of a scene for sliding and rolling."""

    items: CollectionProperty(type=HapticTexture)  # type: ignore[assignment]  # in place of items() of bpy_struct


@updating(scene_changed, animated=False)
class HapticTransmissionRule(RuleScope, ContactParameters, PropertyGroup):
    """The transmission function of contacts between some objects."""

    function: function_property(TRANSMISSIONS, "impedance")


class HapticTransmissionTable(TableRows, PropertyGroup):
    """The rules of a scene for contacts."""

    items: CollectionProperty(type=HapticTransmissionRule)  # type: ignore[assignment]  # in place of items() of bpy_struct
