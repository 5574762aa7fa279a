"""Properties of drawn signals, which are node groups, because Blender stores the curves of panels
in nodes.

A drawn signal therefore has a name and users, can be an asset, and can be appended and linked.
"""

from __future__ import annotations

from bpy.props import CollectionProperty, PointerProperty
from bpy.types import NodeTree, PropertyGroup

from .callbacks import changed, updating
from .kinds import limited, reference, share, switch
from .signal_kinds import HERTZ

AMPLITUDE, FREQUENCY = "Amplitude", "Frequency"
"""The nodes with the curves, from 0 to 1 in both directions."""
LONGEST = 3600.0
"""Longest drawn signal [s]."""


@updating(animated=False)
class HapticEmphasis(PropertyGroup):
    """A transient of a drawn signal: a short burst at a relative time, with strength and
    sharpness."""

    place: share("Place", "Where in the signal it begins: 0 is the beginning, 1 the end", 0.0)
    strength: share("Strength", "Amplitude of the burst, which is added to the envelope", 1.0)
    sharpness: share(
        "Sharpness", "From a dull thud of 65 Hz to a sharp click of 300 Hz, as phones play it", 0.5
    )


@updating(animated=False)
class HapticDrawing(PropertyGroup):
    """Properties of a node group that is a drawn signal."""

    is_signal: switch("Is Signal", "This node group is a drawn signal", options={"HIDDEN"})
    duration: limited(
        "Duration (s)", "How long the drawn signal lasts", 1.0, (0.02, LONGEST), soft_max=10.0
    )
    lowest: limited("Lowest (Hz)", "Frequency at the bottom of the curve", 40.0, HERTZ)
    highest: limited("Highest (Hz)", "Frequency at the top of the curve", 300.0, HERTZ)
    loops: switch("Loop", "Play it again and again")
    emphases: CollectionProperty(type=HapticEmphasis)


def drawing_property() -> PointerProperty[NodeTree]:
    """The choice of a drawn signal."""
    return reference(
        NodeTree,
        "Drawn Signal",
        "The signal that is drawn",
        poll=lambda self, tree: tree.haptics.is_signal,
        options=set(),
        update=changed,
    )
