"""Definition of a modality: its functions, material values, signal and unit."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ..declaration import Number, Numbers, default_of, shown
from ..frozen import frozen
from ..scene.choices import Strategy


@frozen
class Modality:
    """One kind of sensation that has one value per frame, such as warmth.

    functions: names of the objects' functions, the default first. values: a class that declares the
    numbers of an object, named like the parameters of its functions and the fields of
    `core.scene.materials.Material`; ``source``: one whose first number is that of a source.
    ``strategy`` computes the gains. ``transmission``: gain of a contact from the values of the
    object that the signal enters. ``sensations``: ascending pairs of the least value at a listener
    and the sensation.
    """

    name: str
    title: str
    description: str
    functions: tuple[str, ...]
    values: type
    source: type
    strategy: Strategy
    sensations: tuple[tuple[float, str], ...]
    transmission: Callable[[Mapping[str, float]], float]

    @property
    def default_function(self) -> str:
        """The name of the function that objects have unless their author chooses another."""
        return self.functions[0]

    @property
    def quantities(self) -> dict[str, Number]:
        """The declared numbers of objects."""
        return {
            key: item
            for key, item in shown(self.values).items()
            if isinstance(item, Number) and not isinstance(item, Numbers)
        }

    @property
    def source_value(self) -> Number:
        """The declared number of a source."""
        return next(item for item in shown(self.source).values() if isinstance(item, Number))

    def defaults(self) -> dict[str, float]:
        """The default values of objects."""
        return {
            key: default_of(self.values, key) if item.shown is None else item.shown
            for key, item in self.quantities.items()
        }

    def sensation(self, value: float) -> str:
        """The sensation of a value at a listener; "" below the first."""
        return next((words for least, words in reversed(self.sensations) if value >= least), "")


def lossless(values: Mapping[str, float]) -> float:
    """Gain 1 for every contact."""
    return 1.0
