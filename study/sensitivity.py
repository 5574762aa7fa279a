"""Sensitivity of the measured checks to material values and to the strategy.

Contacts, impacts and sources are unchanged; only gains and levels of haptic tracing are recomputed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ..core.graph.haptic_graph import HapticGraph, ObjectTable
from ..core.scene.materials import MATERIALS, Material
from ..core.scene.values import HapticObject, Settings, Strategy

CHOSEN = tuple(
    MATERIALS[name]
    for name in ("stone", "steel", "hardwood", "softwood", "ribbon", "fabric", "flesh")
)
"""The materials of the ride. It has no value of its own: every object has kappa and rho of the
library, which are chosen by design, and the paper's function."""


@dataclass(frozen=True, slots=True)
class Variation:
    """A variant of the ride: a material with another loss, or another strategy. ``name``: the
    material's; ``label``: of the variant; ``power``: to which the material's transfer coefficient K
    is raised, a factor on its loss in decibels."""

    name: str
    label: str
    material: Material | None = None
    power: float = 1.0
    strategy: Strategy | None = None

    def settings(self, settings: Settings) -> Settings:
        """The settings of a frame."""
        if self.strategy is None:
            return settings
        threshold = _LEAST if self.strategy is Strategy.AS_IN_THE_PAPER else settings.threshold
        return replace(settings, strategy=self.strategy, threshold=threshold)

    def belongs(self, item: HapticObject) -> bool:
        """Whether an object is made of the material."""
        own = self.material
        return own is not None and (round(item.kappa, 4), round(item.rho, 4)) == (
            own.kappa,
            own.rho,
        )

    def objects(self, objects: Sequence[HapticObject]) -> tuple[HapticObject, ...]:
        """The objects of a frame."""
        if self.material is None:
            return tuple(objects)
        k = self.material.k**self.power
        return tuple(
            replace(item, kappa=0.0, rho=k) if self.belongs(item) else item for item in objects
        )


def variations() -> tuple[Variation, ...]:
    """Half and double the loss of each material; the paper's strategies and the energy balance."""
    values = [
        Variation(material.title, label, material, power)
        for material in CHOSEN
        for label, power in (("half the loss", 0.5), ("double the loss", 2.0))
    ]
    strategies = (
        ("as in the paper, paths above 1 %", Strategy.AS_IN_THE_PAPER),
        ("energy balance", Strategy.ENERGY_BALANCE),
    )
    return (
        *values,
        *(Variation("strategy", label, strategy=strategy) for label, strategy in strategies),
    )


_LEAST = 0.01
"""Threshold of a path's gain in a sum over all paths: the wind, the cart and the bridge have too
many paths below it."""


class VariedGraph:
    """Graphs of consecutive frames with varied objects; the table of propagation functions is made
    once for each table."""

    def __init__(self, variation: Variation) -> None:
        self._variation = variation
        self._tables: tuple[ObjectTable, ObjectTable] | None = None

    def of(self, graph: HapticGraph) -> HapticGraph:
        """``graph`` with the variation's propagation functions."""
        if self._tables is None or self._tables[0] is not graph.table:
            self._tables = (
                graph.table,
                ObjectTable.of(self._variation.objects(graph.table.objects), graph.table.epsilon),
            )
        return replace(graph, table=self._tables[1])
