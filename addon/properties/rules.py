"""Tables of a scene: rules for pairs of objects.

A table is a property group with `TableRows` and ``items``, whose class has `RuleScope` and the values of a row; `TABLES` lists it for the
operators that edit tables.
"""

from __future__ import annotations

from typing import Any

from bpy.props import CollectionProperty, FloatProperty, FloatVectorProperty, IntProperty
from bpy.types import PropertyGroup

from .callbacks import Imported, updating
from .drawing import drawing_property
from .function import TRANSMISSIONS, ContactParameters, function_property
from .kinds import choice, limited, number, share, switch, text

TABLES = (
    ("impact_table", "Impacts", "What impacts between some objects need and play"),
    ("transmission_table", "Contacts", "What contacts between some objects pass on"),
    ("textures", "Sliding and Rolling", "What some objects play that slide or roll on each other"),
)
"""The tables by their names in the properties of a scene."""

SIDE_ITEMS = (
    ("ANY", "Anything", "Any object", "WORLD", 0),
    ("MATERIAL", "Material", "Objects of a material of the library; * stands for any characters, ? for one", "MATERIAL", 1),
    ("OBJECT", "Object", "An object; * stands for any characters, ? for one", "OBJECT_DATA", 2),
)


def _curve(name: str, description: str, weak: float, low: float, high: float, **more: Any) -> FloatVectorProperty:
    """A value for the weakest impacts and for those of full energy."""
    return FloatVectorProperty(name=name, description=description, size=2, default=(weak, 1.0), min=low, max=high, **more)


def least_energy() -> FloatProperty:
    """The least energy E_min of an impact [J]."""
    words = "Collisions weaker than this, in joules, make no source; 5 J is a light contact"
    return number("Least Energy (J)", words, 5.0, (0.0, 100.0))


def full_energy() -> FloatProperty:
    """The energy E_max of an impact that plays its signal at full strength [J]."""
    words = "A collision of this energy, in joules, plays the impact signal at full strength"
    return number("Full Energy (J)", words, 100.0, (0.001, 1000.0))


def refractory() -> FloatProperty:
    """The refractory time [s]."""
    words = "Time in seconds after an impact in which the same two objects make no further impact"
    return number("Refractory (s)", words, 0.1, (0, 2), precision=3)


SIGNAL_ITEMS = (
    ("MATERIALS", "By Material", "By the two materials: metal on stone rings, wood on soil thuds; plain if unknown"),
    ("PLAIN", "Plain", "A short knock of 150 Hz, the same for all objects"),
)
"""Choices of the signal of impacts."""


class RuleScope:
    """Mixin: the pairs of objects that a row applies to."""

    first_kind: choice("Between", "What this rule is for", SIDE_ITEMS, options=set())
    first: text("Name", "Name of the object or material, or a pattern", options=set())
    second_kind: choice("And", "What this rule is for", SIDE_ITEMS, options=set())
    second: text("Name", "Name of the object or material, or a pattern", options=set())


class TableRows:
    """Mixin: the properties of every table besides its items."""

    active: IntProperty(name="Active Rule", default=0, min=0, options=set())


@updating(animated=False)
class HapticImpactRule(RuleScope, Imported, PropertyGroup):
    """The rule for impacts between some objects."""

    template: choice(
        "Signal",
        "What impacts feel like",
        (
            *SIGNAL_ITEMS,
            ("FILE", "File", "The first vibration in a file: .wav, .hjif, .haptic, .ahap, .haps or .tact"),
            ("KEPT", "Imported", "The signal of an imported file, kept in this one"),
            ("DRAWN", "Drawn", "A signal that was drawn for a source, once"),
        ),
    )
    filepath: text("File", "The file with the vibration that impacts play", subtype="FILE_PATH")
    drawing: drawing_property()
    use_limits: switch("Own Energies", "These collisions need other energies than others of the scene")
    least_energy: least_energy()
    full_energy: full_energy()
    refractory: refractory()
    gain: _curve("Gain", "Amplitude of the weakest collisions, and of those of full energy", 0.0, 0.0, 1.0)
    pitch: _curve(
        "Pitch",
        "How many times as fast the signal plays in the weakest collisions, and in those of full energy",
        1.0,
        0.25,
        4.0,
        translation_context="Haptics",
    )
    decay: _curve(
        "Decay", "Part of its decay time that the signal has in the weakest collisions, and in those of full energy", 1.0, 0.01, 1.0
    )
    brightness: _curve("Brightness", "Gain above 100 Hz in the weakest collisions, and in those of full energy", 1.0, 0.0, 1.0)
    bend: limited(
        "Bend",
        "How these values change from weak to full: 1 with the energy, 0.5 with the speed of the impact",
        1.0,
        (0.1, 10.0),
    )
    variation: share("Variation", "Largest relative variation of impacts: higher or lower, shorter and weaker", 0.0, soft_max=0.3)
    seed: IntProperty(name="Seed", description="Another number gives other variations", default=0, min=0, max=10**9)


class HapticImpactTable(TableRows, PropertyGroup):
    """The rules of a scene for impacts."""

    items: CollectionProperty(type=HapticImpactRule)  # type: ignore[assignment]  # in place of items() of bpy_struct


@updating(animated=False)
class HapticTexture(RuleScope, Imported, PropertyGroup):
    """The texture of some objects that slide or roll on each other."""

    period: limited(
        "Period",
        "From one ridge or grain of the surface to the next: at 1 m/s, 5 mm give 200 Hz",
        0.005,
        (1e-5, 10.0),
        subtype="DISTANCE",
        precision=4,
    )
    sliding: limited("Sliding", "Amplitude of sliding at full force and speed", 0.5, (0.0, 1.0))
    rolling: limited("Rolling", "Amplitude of rolling at full force and speed", 0.2, (0.0, 1.0))
    noise: limited("Noise", "Fraction of the power that is noise around the tone; higher for irregular surfaces", 0.5, (0.0, 1.0))
    bandwidth: limited("Bandwidth", "How wide the noise is, relative to the frequency of the tone", 0.5, (0.05, 4.0))
    stick_speed: limited(
        "Stick Below",
        "Below this speed the surfaces stick and slip, the slower the more; 0: they do not",
        0.0,
        (0.0, 100.0),
        unit="VELOCITY",
        precision=3,
    )
    full_force: limited(
        "Full Force (N)",
        "Force in newtons at which the amplitude reaches its full value; it grows with the square root of the force",
        100.0,
        (1e-3, 1e9),
        soft_max=1e4,
    )
    full_speed: limited(
        "Full Speed",
        "Speed at which the amplitude reaches its full value; it grows with the speed to the power 3/4 for sliding, 3/2 for rolling",
        1.0,
        (1e-3, 1e3),
        unit="VELOCITY",
    )


class HapticTextureTable(TableRows, PropertyGroup):
    """The rules of a scene for sliding and rolling."""

    items: CollectionProperty(type=HapticTexture)  # type: ignore[assignment]  # in place of items() of bpy_struct


@updating()
class HapticTransmissionRule(RuleScope, ContactParameters, Imported, PropertyGroup):
    """The transmission function of contacts between some objects."""

    function: function_property(TRANSMISSIONS, "impedance")


class HapticTransmissionTable(TableRows, PropertyGroup):
    """The rules of a scene for contacts."""

    items: CollectionProperty(type=HapticTransmissionRule)  # type: ignore[assignment]  # in place of items() of bpy_struct
