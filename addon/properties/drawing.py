"""Properties of drawn signals, which are node groups: Blender keeps the curves that it shows in panels in nodes.

So a drawn signal has a name and users, may be an asset, and is appended and linked like everything else in a file.
"""

from __future__ import annotations

from typing import Any

from bpy.props import BoolProperty, CollectionProperty, FloatProperty, PointerProperty
from bpy.types import NodeTree, PropertyGroup

from .callbacks import changed

AMPLITUDE, FREQUENCY = "Amplitude", "Frequency"
"""The nodes with the curves, from 0 to 1 in both directions."""
HERTZ = (0.1, 1000.0)
"""Frequencies that sources take."""
LONGEST = 3600.0
"""Seconds that a drawn signal may last."""


def _hertz(name: str, description: str, default: float) -> FloatProperty:
    return FloatProperty(name=name, description=description, default=default, min=HERTZ[0], max=HERTZ[1], update=changed)


def _share(name: str, description: str, default: float) -> FloatProperty:
    return FloatProperty(name=name, description=description, default=default, min=0.0, max=1.0, subtype="FACTOR", update=changed)


class HapticEmphasis(PropertyGroup):
    """A transient of a drawn signal: a short burst at a place, with strength and sharpness."""

    place: _share("Place", "Where in the signal it begins: 0 is the beginning, 1 the end", 0.0)
    strength: _share("Strength", "Amplitude of the burst, which is added to the envelope", 1.0)
    sharpness: _share("Sharpness", "From a dull thud of 65 Hz to a sharp click of 300 Hz, as phones play it", 0.5)


class HapticDrawing(PropertyGroup):
    """What a node group says as a drawn signal."""

    is_signal: BoolProperty(name="Is Signal", description="This node group is a drawn signal", options={"HIDDEN"})
    duration: FloatProperty(
        name="Duration (s)",
        description="How long the drawn signal lasts",
        default=1.0,
        min=0.02,
        max=LONGEST,
        soft_max=10.0,
        update=changed,
    )
    lowest: _hertz("Lowest (Hz)", "Frequency at the bottom of the curve", 40.0)
    highest: _hertz("Highest (Hz)", "Frequency at the top of the curve", 300.0)
    loops: BoolProperty(name="Loop", description="Play it again and again", default=False, update=changed)
    emphases: CollectionProperty(type=HapticEmphasis)


def _is_drawing(_: Any, tree: NodeTree) -> bool:
    """Whether a node group is a drawn signal."""
    return tree.haptics.is_signal


def drawing_property() -> PointerProperty[NodeTree]:
    """The choice of a drawn signal."""
    words = "The signal that is drawn"
    return PointerProperty(name="Drawn Signal", description=words, type=NodeTree, poll=_is_drawing, options=set(), update=changed)
