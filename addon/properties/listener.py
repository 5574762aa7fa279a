"""Properties of haptic listeners."""

from __future__ import annotations

from bpy.types import Context, PropertyGroup

from ...core.scene.body import BODY_PARTS
from ...core.scene.choices import MOST_DUCKING, Extent
from .callbacks import Imported, changed, edited, updating
from .kinds import choice, limited, number, switch, text

MIXING_ITEMS = (
    ("cumulative", "Cumulative", "Sums all signals and limits the sum to the ceiling"),
    ("weighted", "Weighted", "Averages the signals by the priorities of their sources"),
    ("strongest", "Strongest", "Only the strongest signal is felt"),
    ("power", "Power", "Adds up energies: the root of the sum of squares"),
    ("custom", "Custom", "Your own formula from the results of the other methods"),
)
EXTENT_ITEMS = (
    (Extent.NONE.value, "Point", "Feels what arrives at its origin, whatever the radius"),
    (Extent.STRONGEST.value, "Strongest", "Contacts within the radius count as if they were at the origin"),
    (Extent.MEAN_POWER.value, "Mean Power", "Feels the mean of the power over its volume"),
)
BODY_PART_ITEMS = (
    ("NONE", "None", "Not a part of the body"),
    *((part.name, part.name.replace("_", " ").title(), f"Stands for the {part.name.replace('_', ' ')}") for part in BODY_PARTS),
)


def _enabled_edited(self: HapticListenerProperties, context: Context) -> None:
    """Give a new listener a limiter and an extent; listeners of files in which these were off by default are not affected."""
    if self.enabled and (context.scene is None or context.scene.haptics.strategy != "as_in_the_paper"):
        if not self.is_property_set("limiter"):
            self.limiter = True
        if not self.is_property_set("extent"):
            self.extent = Extent.STRONGEST.value
    changed(self, context)


def _radius_edited(self: HapticListenerProperties, context: Context) -> None:
    """Set the size of an empty that is displayed as a sphere to the listener's radius."""
    empty = self.id_data
    if empty.type == "EMPTY" and empty.empty_display_type == "SPHERE":
        empty.empty_display_size = self.radius
    edited("radius")(self, context)


@updating()
class HapticListenerProperties(Imported, PropertyGroup):
    """A haptic listener, which receives signals at a point of the body."""

    enabled: switch("Haptic Listener", "Signals are received at this object's origin", update=_enabled_edited)
    muted: switch("Mute", "Keep the listener but let it feel nothing", options=set())
    solo: switch("Solo", "Let only listeners that are solo feel something", options=set())
    body_part: choice("Body Part", "The place on the body that this listener stands for", BODY_PART_ITEMS, default="NONE")
    radius: number("Radius", "Radius of the listener's bounding volume", 0.05, (0.0, 0.5), unit="LENGTH", update=_radius_edited)
    extent: choice(
        "Extent",
        "What the listener feels of its bounding volume. New listeners feel the strongest; those of earlier files are points",
        EXTENT_ITEMS,
        default=Extent.NONE.value,
    )
    use_wish: switch("Wish", "Fulfil Wishes brings this listener to the wished level", options=set(), update=None)
    wish: limited(
        "Level (dB)", "The level that this listener shall have, in decibels of full scale", -20.0, (-90.0, 0.0), options=set(), update=None
    )
    gain: limited("Gain", "Factor of this listener's mixed signal; can be animated", 1.0, (0.0, 10.0), soft_max=2.0)
    mixing: choice("Mixing", "How signals that arrive together are combined", MIXING_ITEMS)
    mixing_expression: text(
        "Formula",
        "The mix, sample by sample, of sum, weighted, strongest and power (what the other methods give) and s_max (the ceiling)",
        "s_max * tanh(sum / s_max)",
        maxlen=500,
    )
    s_max: limited("Ceiling", "No sample of the mixed signal is stronger than this", 1.0, (0.01, 1.0), subtype="FACTOR")
    ducking: limited(
        "Ducking (dB)",
        "Sources are turned down by so many decibels while one of higher priority arrives here",
        0.0,
        (0.0, MOST_DUCKING),
        soft_max=24.0,
    )
    limiter: switch(
        "Limiter",
        "Turns a mix that would exceed the ceiling down, ahead of its peaks, instead of cutting it off, which distorts. "
        "All listeners then feel 5 ms later",
    )

    @property
    def part(self) -> str:
        """The body part that it stands for, "" for none."""
        return "" if self.body_part == "NONE" else self.body_part
