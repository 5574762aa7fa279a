"""Tables of a scene: rules for pairs of objects.

A table is a property group with ``items``, whose class has `RuleScope` and what its rows say, and `TableRows`; `TABLES` names it for the
operators that edit any of them.
"""

from __future__ import annotations

from bpy.props import CollectionProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy.types import PropertyGroup

from .callbacks import changed, edited
from .imported import Imported

TABLES = (("impact_table", "Impacts", "What impacts between some objects need and play"),)
"""The tables by their names in the properties of a scene."""

SIDE_ITEMS = (
    ("ANY", "Anything", "Any object", "WORLD", 0),
    ("MATERIAL", "Material", "Objects of a material of the library; * stands for any characters, ? for one", "MATERIAL", 1),
    ("OBJECT", "Object", "An object; * stands for any characters, ? for one", "OBJECT_DATA", 2),
)


def _kind(name: str) -> EnumProperty:
    return EnumProperty(name=name, description="What this rule is for", items=SIDE_ITEMS, options=set(), update=changed)


def _name() -> StringProperty:
    return StringProperty(name="Name", description="Name of the object or material, or a pattern", options=set(), update=changed)


class RuleScope:
    """Mixin: between which objects a row counts."""

    first_kind: _kind("Between")
    first: _name()
    second_kind: _kind("And")
    second: _name()


class TableRows:
    """Mixin: what every table has beside its items."""

    active: IntProperty(name="Active Rule", default=0, min=0, options=set())


class HapticImpactRule(RuleScope, Imported, PropertyGroup):
    """What counts for impacts between some objects."""

    template: EnumProperty(
        name="Signal",
        description="What impacts feel like",
        items=(
            ("MATERIALS", "By Material", "As the materials that meet: metal on stone rings, wood on soil thuds; plain where unknown"),
            ("PLAIN", "Plain", "A short knock of 150 Hz, whatever meets"),
            ("FILE", "File", "The first vibration in a file: .wav, .hjif, .haptic, .ahap, .haps or .tact"),
            ("KEPT", "Imported", "The signal of an imported file, kept in this one"),
        ),
        options=set(),
        update=changed,
    )
    filepath: StringProperty(
        name="File", description="The file with the vibration that impacts play", subtype="FILE_PATH", options=set(), update=changed
    )
    least_energy: FloatProperty(
        name="Least Energy (J)",
        description="Collisions weaker than this, in joules, make no source; 5 J is a light contact",
        default=5.0,
        min=0.0,
        max=1e9,
        soft_max=100.0,
        options=set(),
        update=edited("least_energy"),
    )
    full_energy: FloatProperty(
        name="Full Energy (J)",
        description="A collision of this energy, in joules, plays the impact signal at full strength",
        default=100.0,
        min=0.001,
        max=1e9,
        soft_max=1000.0,
        options=set(),
        update=edited("full_energy"),
    )
    refractory: FloatProperty(
        name="Refractory (s)",
        description="After an impact the same two objects make no other for so many seconds, however they bounce",
        default=0.1,
        min=0.0,
        max=1e6,
        soft_max=2.0,
        precision=3,
        options=set(),
        update=edited("refractory"),
    )


class HapticImpactTable(TableRows, PropertyGroup):
    """The rules of a scene for impacts."""

    items: CollectionProperty(type=HapticImpactRule)


CLASSES = (HapticImpactRule, HapticImpactTable)
