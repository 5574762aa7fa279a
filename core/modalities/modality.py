"""What a modality is, as data: its functions, what materials have for it, its signal and its unit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ..scene.choices import Strategy


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number that an author sets. ``name`` as code and files say it, ``title`` as panels do; ``low`` <= value <= ``high``."""

    name: str
    title: str
    description: str
    unit: str
    default: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Modality:
    """One way to feel: vibrotactile, thermal, ...

    functions: the names of those that objects can have, the default first. object_values: what an object has, by the names that its
    functions' parameters and `core.scene.materials.Material` give them; ``source_value``: how strong a source is. ``sampled``: a signal
    has samples (a vibration); else it is one value per frame (a temperature). ``strategy`` computes the gains. ``transmission``: the gain
    of a contact from the values of the object that is entered. ``sensations``: from which value at a listener on it is felt as what,
    rising.
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
        """The objects' values before anything is known of them."""
        return {quantity.name: quantity.default for quantity in self.object_values}

    def sensation(self, value: float) -> str:
        """What a value at a listener feels like, in words; "" below all that is felt."""
        return next((words for least, words in reversed(self.sensations) if value >= least), "")


def lossless(values: Mapping[str, float]) -> float:
    """A contact that passes everything on."""
    return 1.0
