"""Sample scenes, each built by a script from an empty scene.

A sample is a module with ``build(scene)``, which fills an empty scene deterministically.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING

from ..core.frozen import frozen

if TYPE_CHECKING:
    from bpy.types import Scene


@frozen
class Sample:
    """A sample scene: its name in commands, its title in menus, one sentence on what it shows.

    ``objects``: approximate number of objects. ``count``: default number of repeated items if that
    can be chosen, else None. ``variation``: relative variation of its impacts. ``about``: the body
    parts that should feel it, of both sides unless one is named. ``body``: how its people feel, as
    in *Bodies*; "" in a scene with the paper's function.
    """

    name: str
    title: str
    objects: int
    description: str
    count: int | None = None
    variation: float = 0.1
    about: tuple[str, ...] = ("ear", "hand", "middle_back", "upper_back", "upper_leg")
    body: str = "MEASURED"

    def build(self, scene: Scene, count: int | None = None) -> None:
        """Fill the empty ``scene``; ``count``: number of repeated items instead of the default.
        Raises ValueError if it cannot be chosen."""
        module, materials = (
            import_module(f".{name}", __name__) for name in (self.name, "materials")
        )
        if count is None:
            module.build(scene)
        elif self.count is None:
            raise ValueError(f"sample {self.name!r} is of one size: give no count")
        elif count < 4:
            raise ValueError(f"count: must be at least 4, got {count}")
        else:
            module.build(scene, count)
        if self.body:
            materials.measure(scene, self.body)
        scene.haptics.materials.active = 0
        if self.variation:
            materials.vary_impacts(scene, self.variation)


SAMPLES: Mapping[str, Sample] = MappingProxyType(
    {
        sample.name: sample
        for sample in (
            Sample(
                "jackhammer_bench",
                "Jackhammer and Bench",
                50,
                "A jackhammer is felt on a bench, through the ground, four feet and a seat",
                about=("hand", "middle_back", "upper_leg"),
                body="",
            ),
            Sample(
                "hammer_nail",
                "Hammer and Nail",
                46,
                "A blow makes a temporary source, which the hammer passes on to the hand",
                about=("hand",),
            ),
            Sample(
                "fireplace",
                "Fireplace",
                58,
                "A fire is felt in an armchair through the air: it crackles, and warms",
                body="FELT_ALL_OVER",
            ),
            Sample(
                "dishwasher_kitchen",
                "Dishwasher in the Kitchen",
                63,
                "A dishwasher is felt at the table: cupboard, floor, chair",
                about=("hand", "middle_back", "upper_leg"),
            ),
            Sample(
                "rails",
                "Rails",
                104,
                "A far locomotive is felt through rails rather than soil; the path leaves the "
                "ground and comes back",
                about=("hand", "middle_back", "upper_leg"),
                body="FELT_ALL_OVER",
            ),
            Sample(
                "domino_wall",
                "Wall of Dominoes",
                1039,
                "A thousand impacts, one after the other",
                1000,
                about=("hand", "upper_leg"),
            ),
            Sample(
                "pile",
                "Pile",
                243,
                "Hundreds of things in a tray on a shaking table",
                200,
                about=("hand", "upper_leg"),
                body="FELT_ALL_OVER",
            ),
            Sample(
                "air_blast",
                "Air Blast",
                56,
                "An explosion is felt through a medium, the air: its pressure arrives as a front",
                body="FELT_ALL_OVER",
            ),
            Sample(
                "sliding_and_rolling",
                "Sliding and Rolling",
                52,
                "A file, a ball, a shoe, a crate and a wheel sound at their contacts, at the "
                "period of what they pass over",
                about=("hand", "upper_leg"),
                body="FELT_ALL_OVER",
            ),
            Sample(
                "kart",
                "Kart and Driver",
                80,
                "A driver feels engine, kerb and setts through seat and steering wheel",
                about=("hand", "middle_back", "upper_leg"),
            ),
            Sample(
                "kitchen",
                "Cook at a Worktop",
                91,
                "A hand on the worktop feels the mixer, and the fridge through floor and cupboards",
                about=("hand.L",),
            ),
            Sample(
                "boardwalk",
                "Walk along a Boardwalk",
                80,
                "Steps are felt in the feet that make them, and less by one who sits nearby",
                about=("foot",),
            ),
            Sample(
                "robot_cell",
                "Robot at a Table",
                61,
                "The hand of one who works there feels a robot set castings down",
                about=("hand.R",),
            ),
            Sample(
                "mine_ride",
                "Mine Ride",
                461,
                "The ride of the paper's study: two and a half minutes in six sections",
                variation=0.0,
                body="",
            ),
        )
    }
)
"""The samples by name."""


def build_sample(name: str, count: int | None = None) -> Scene:
    """Build a sample in a new scene, which the window then shows. Raises ValueError, which lists
    the known names, for any other."""
    import bpy

    if name not in SAMPLES:
        raise ValueError(f"sample {name!r} is unknown: use one of {', '.join(SAMPLES)}")
    scene = bpy.data.scenes.new(SAMPLES[name].title)
    with import_module(".staging", __name__).progress(SAMPLES[name].objects):
        SAMPLES[name].build(scene, count)
    if bpy.context.window is not None:
        bpy.context.window.scene = scene
    return scene
