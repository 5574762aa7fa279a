"""Tables of rules for pairs of objects: of the rows that match a pair, the most specific one
applies."""

from __future__ import annotations

from fnmatch import fnmatchcase
from functools import lru_cache
from typing import Generic, TypeVar

from ..frozen import frozen

Value = TypeVar("Value", covariant=True)

MOST_ROWS = 1000
"""Largest number of rows of a table."""


@frozen
class Side:
    """Condition on one of two objects: its name, its material, or neither (any object). In names
    ``*`` stands for any characters and ``?`` for one."""

    object: str = ""
    material: str = ""

    def __post_init__(self) -> None:
        if self.object and self.material:
            raise ValueError("material: a side names an object or a material, not both")

    @property
    def rank(self) -> int:
        """Specificity: an object 4, a pattern of objects 3, a material 2, a pattern of materials 1,
        anything 0."""
        pattern = self.object or self.material
        return (
            (2 if self.object else 0) + (2 if pattern and not {"*", "?"} & set(pattern) else 1)
            if pattern
            else 0
        )

    def fits(self, name: str, material: str) -> bool:
        """Whether an object of that name and material matches."""
        if not (self.object or self.material):
            return True
        return (
            _fits(self.object, name)
            if self.object
            else bool(material) and _fits(self.material, material)
        )


@lru_cache(maxsize=2**16)
def _fits(pattern: str, name: str) -> bool:
    return fnmatchcase(name, pattern.replace("[", "[[]"))


@frozen
class Rule(Generic[Value]):
    """A row: the ``value`` for pairs of objects that match ``between`` in either order."""

    between: tuple[Side, Side]
    value: Value

    @property
    def rank(self) -> tuple[int, int]:
        """Specificity: the rank of the more specific side, then that of the other."""
        first, second = (side.rank for side in self.between)
        return max(first, second), min(first, second)

    def fits(self, first: tuple[str, str], second: tuple[str, str]) -> bool:
        """Whether the row matches two objects, each given by name and material."""
        a, b = self.between
        return (a.fits(*first) and b.fits(*second)) or (a.fits(*second) and b.fits(*first))


@frozen
class RuleTable(Generic[Value]):
    """A table of ``rows`` in the author's order."""

    rows: tuple[Rule[Value], ...] = ()

    def of(self, first: tuple[str, str], second: tuple[str, str]) -> Value | None:
        """The value for two objects, each given by name and material: that of the most specific
        matching row, the upper one of equally specific rows; None without a match."""
        fitting = [row for row in self.rows if row.fits(first, second)]
        return max(fitting, key=lambda row: row.rank).value if fitting else None
