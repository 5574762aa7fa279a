"""Sensitivity of the measured checks to the values of materials, to what was arranged, and to the
strategy.

Contacts, impacts and sources are unchanged; only gains and levels of haptic tracing are recomputed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..core.frozen import frozen
from ..core.graph.haptic_graph import HapticGraph, ObjectTable
from ..core.render.frame_result import FrameResult
from ..core.scene.materials import MATERIALS, Material
from ..core.scene.values import HapticObject, Settings, Strategy
from ..sample_scenes.mine_ride import FULL_ENERGY

CHOSEN = tuple(
    MATERIALS[name]
    for name in ("stone", "steel", "hardwood", "softwood", "ribbon", "fabric", "flesh")
)
"""The materials of the ride. It has no value of its own: every object has kappa and rho of the
library, which are chosen by design, and the paper's function."""


@frozen
class Variation:
    """A variant of the ride. ``name`` of what varies, ``label`` of the variant.

    ``material``, ``power``: to which the material's transfer coefficient K is raised, a factor on
    its loss in decibels. ``within``, ``stretch``: distances within the objects whose names begin so
    are multiplied. ``full_energy``: that plays an impact at full strength [J]. ``strength``: a
    factor on the amplitudes of all other sources.
    """

    name: str
    label: str
    material: Material | None = None
    power: float = 1.0
    strategy: Strategy | None = None
    within: str = ""
    stretch: float = 1.0
    full_energy: float = FULL_ENERGY
    strength: float = 1.0

    @property
    def sources_vary(self) -> bool:
        """Whether sources have other amplitudes, in all modes."""
        return self.full_energy != FULL_ENERGY or self.strength != 1.0

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
    """Half and double the loss of each material, what was arranged, and the paper's strategy."""
    values = [
        Variation(material.title, label, material, power)
        for material in CHOSEN
        for label, power in (("half the loss", 0.5), ("double the loss", 2.0))
    ]
    arranged = [
        Variation(name, label, within=within, stretch=stretch)
        for name, within in (
            ("distances in the ground", "Ground"),
            ("loss of the wind's air", "Updraft"),
        )
        for label, stretch in (("half", 0.5), ("double", 2.0))
    ]
    arranged += [
        Variation("blow of full strength", f"{energy:g} J", full_energy=energy)
        for energy in (PAPER_ENERGY, FULL_ENERGY / 2)
    ]
    arranged += [
        Variation("strength of wind and wheels", label, strength=strength)
        for label, strength in (("half", 0.5), ("a quarter", 0.25))
    ]
    paper = "as in the paper, paths above 1 %"
    return *values, *arranged, Variation("strategy", paper, strategy=Strategy.AS_IN_THE_PAPER)


PAPER_ENERGY = 100.0
"""Energy of a blow of full strength in the paper [J]."""
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
        stretch = self._variation.stretch
        if stretch == 1.0:
            return replace(graph, table=self._tables[1])
        places = graph.node_position.copy()
        for number, name in enumerate(graph.table.names):
            nodes = slice(*graph.start[number : number + 2].tolist())
            if name.startswith(self._variation.within) and nodes.start < nodes.stop:
                middle = places[nodes].mean(axis=0)
                places[nodes] = middle + stretch * (places[nodes] - middle)
        return replace(graph, node_position=places, table=self._tables[1])


class VariedSources:
    """Frames with sources of the varied strength; impacts play on in later frames."""

    def __init__(self, variation: Variation) -> None:
        self._full, self._strength = variation.full_energy, variation.strength
        self._of_impact = dict[str, float]()

    def of(self, result: FrameResult) -> FrameResult:
        """A frame with other amplitudes of its sources."""
        begun = result.sources[len(result.sources) - len(result.impacts) :]
        for source, impact in zip(begun, result.impacts, strict=True):
            now, then = (min(impact.energy / full, 1.0) for full in (self._full, FULL_ENERGY))
            self._of_impact[source.name] = now / then
        sources = tuple(
            replace(item, amplitude=item.amplitude * self._of_impact.get(item.name, self._strength))
            for item in result.sources
        )
        return replace(result, sources=sources)
