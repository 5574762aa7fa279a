"""Definition of a modality: its functions, material values, signal and unit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ..scene.choices import Strategy


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number that an author sets. ``name`` in code and files, ``title`` in panels; ``low`` <= value <= ``high``."""

    name: str
    title: str
    description: str
    unit: str
    default: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Modality:
    """One kind of sensation: vibrotactile, thermal, ...

    functions: names of the objects' functions, the default first. object_values: quantities of an object, named like the parameters of its
    functions and the fields of `core.scene.materials.Material`; ``source_value``: quantity of a source. ``sampled``: a signal has samples
    (vibration), otherwise one value per frame (temperature). ``strategy`` computes the gains. ``transmission``: gain of a contact from the
    values of the object that the signal enters. ``sensations``: ascending pairs of the least value at a listener and the sensation.
    """

    name: str
    title: str
    description: str
    functions: tuple[str, ...]
    object_values: tuple[Quantity, ...]
    source_value: Quantity
    sampled: bool
    strategy: Strategy
    sensations: tuple[tuple[float, str], ...]
    transmission: Callable[[Mapping[str, float]], float]

    @property
    def default_function(self) -> str:
        """The name of the function that objects have unless their author chooses another."""
        return self.functions[0]

    def defaults(self) -> dict[str, float]:
        """The default values of objects."""
        return {quantity.name: quantity.default for quantity in self.object_values}

    def sensation(self, value: float) -> str:
        """The sensation of a value at a listener; "" below the first."""
        return next((words for least, words in reversed(self.sensations) if value >= least), "")


def lossless(values: Mapping[str, float]) -> float:
    """Gain 1 for every contact."""
    return 1.0
