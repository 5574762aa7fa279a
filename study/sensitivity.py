"""What becomes of the checks by measurement when a value that was tuned for the ride is another one, or the strategy is.

Contacts, impacts and sources stay what they are; only gains and levels of haptic tracing are computed again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from ..core.graph.haptic_graph import HapticGraph, ObjectTable
from ..core.scene.functions import Exponential, HapticTracing, ModulationFunction
from ..core.scene.values import HapticObject, Settings, Strategy


@dataclass(frozen=True, slots=True)
class Tuned:
    """A decay [1/m] that was chosen for the ride: whose it is, why, and ``belongs``: whether an object of this name has it."""

    name: str
    decay: float
    reason: str
    belongs: Callable[[str], bool]


def _of_the_cart(name: str) -> bool:
    return name.startswith("Bridge") or ("Cart" in name and "Rail" not in name and "Wheelset" not in name)


TUNED = (
    Tuned("rider", 3.0, "so that what reaches a part of the body tells where it came from", lambda name: name.startswith("Avatar")),
    Tuned("rock", 0.12, "so that a stalactite is felt over some metres", lambda name: name.startswith("Ground")),
    Tuned("planks and carts", 0.2, "as distance alone in the other modes", _of_the_cart),
    Tuned("wheelsets", 0.05, "so that what comes from the rails reaches the cart", lambda name: "Wheelset" in name),
    Tuned("rails", 0.01, "so that rails carry further than rock", lambda name: "Rail" in name),
)
"""Every tuned decay of the ride. Walls, stalactites and projectiles have the paper's function with kappa and rho of their materials."""


@dataclass(frozen=True, slots=True)
class Variation:
    """Another value, or another strategy. ``name``: of what; ``label``: which one."""

    name: str
    label: str
    belongs: Callable[[str], bool] | None = None
    function: ModulationFunction | None = None
    strategy: Strategy | None = None

    def settings(self, settings: Settings) -> Settings:
        """The settings of a frame."""
        return settings if self.strategy is None else replace(settings, strategy=self.strategy)

    def objects(self, objects: Sequence[HapticObject]) -> tuple[HapticObject, ...]:
        """The objects of a frame."""
        if self.belongs is None or self.function is None:
            return tuple(objects)
        return tuple(replace(item, propagation=self.function) if self.belongs(item.name) else item for item in objects)


def variations() -> tuple[Variation, ...]:
    """Half, double, and the paper's own function for each tuned decay; the default strategy and the energy balance."""
    values = [
        Variation(tuned.name, label, tuned.belongs, function)
        for tuned in TUNED
        for label, function in (
            ("half", Exponential(alpha=tuned.decay / 2)),
            ("double", Exponential(alpha=tuned.decay * 2)),
            ("the paper's function", HapticTracing()),
        )
    ]
    strategies = (("best path, the default", Strategy.BEST_PATH), ("energy balance", Strategy.ENERGY_BALANCE))
    return (*values, *(Variation("strategy", label, strategy=strategy) for label, strategy in strategies))


class VariedGraph:
    """Graphs of consecutive frames with varied objects; the table of propagation functions is made once for each table."""

    def __init__(self, variation: Variation) -> None:
        self._variation = variation
        self._tables: tuple[ObjectTable, ObjectTable] | None = None

    def of(self, graph: HapticGraph) -> HapticGraph:
        """``graph`` with the variation's propagation functions."""
        if self._tables is None or self._tables[0] is not graph.table:
            self._tables = graph.table, ObjectTable.of(self._variation.objects(graph.table.objects), graph.table.epsilon)
        return replace(graph, table=self._tables[1])
