"""Tables of rules for pairs of objects: of the rows that fit a pair, the most specific one counts."""

from __future__ import annotations

from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import lru_cache
from typing import Generic, TypeVar

Does = TypeVar("Does", covariant=True)

MOST_ROWS = 1000
"""Number of rows that are read of a table."""


@dataclass(frozen=True, slots=True)
class Side:
    """What one of two objects must be: of that name, or made of the material of that name; without both, anything. In names ``*`` stands
    for any characters and ``?`` for one."""

    object: str = ""
    material: str = ""

    def __post_init__(self) -> None:
        if self.object and self.material:
            raise ValueError("material: a side names an object or a material, not both")

    @property
    def rank(self) -> int:
        """How specific it is: an object 4, objects of a pattern 3, a material 2, materials of a pattern 1, anything 0."""
        pattern = self.object or self.material
        return (2 if self.object else 0) + (2 if pattern and not {"*", "?"} & set(pattern) else 1) if pattern else 0

    def fits(self, name: str, material: str) -> bool:
        """Whether an object of that name and material is meant."""
        if not (self.object or self.material):
            return True
        return _fits(self.object, name) if self.object else bool(material) and _fits(self.material, material)


@lru_cache(maxsize=2**16)
def _fits(pattern: str, name: str) -> bool:
    return fnmatchcase(name, pattern.replace("[", "[[]"))


@dataclass(frozen=True, slots=True)
class Rule(Generic[Does]):
    """A row: what ``does`` count for pairs of objects that fit ``between``, whichever of them comes first."""

    between: tuple[Side, Side]
    does: Does

    @property
    def rank(self) -> tuple[int, int]:
        """How specific it is: first the rank of its more specific side, then that of the other."""
        first, second = (side.rank for side in self.between)
        return max(first, second), min(first, second)

    def fits(self, first: tuple[str, str], second: tuple[str, str]) -> bool:
        """Whether it counts for two objects, each given by name and material."""
        a, b = self.between
        return (a.fits(*first) and b.fits(*second)) or (a.fits(*second) and b.fits(*first))


@dataclass(frozen=True, slots=True)
class RuleTable(Generic[Does]):
    """The ``rows`` in the order in which an author sees them."""

    rows: tuple[Rule[Does], ...] = ()

    def of(self, first: tuple[str, str], second: tuple[str, str]) -> Does | None:
        """What counts for two objects, each given by name and material: that of the most specific row that fits, of equally specific ones
        that of the upper one; None where no row fits."""
        fitting = [row for row in self.rows if row.fits(first, second)]
        return max(fitting, key=lambda row: row.rank).does if fitting else None
