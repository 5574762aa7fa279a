"""Transmission functions of detected contacts, by a scene's table of rules."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..scene.functions import Impedance, ModulationFunction
from ..scene.rule_table import RuleTable
from .contact_set import ContactSet


class TransmissionRules:
    """Transmission functions of contacts between ``objects``, each given by name and material: from
    the ``table``, otherwise by impedance.

    Pairs are looked up once.
    """

    def __init__(
        self, table: RuleTable[ModulationFunction], objects: Sequence[tuple[str, str]]
    ) -> None:
        self.table = table
        self.objects = objects
        self.functions: tuple[ModulationFunction, ...] = (
            Impedance(),
            *(row.value for row in table.rows),
        )
        self._known: dict[tuple[int, int], int] = {}

    @property
    def uses_force(self) -> bool:
        """Whether any function depends on the force of a contact."""
        return any(function.uses_force for function in self.functions)

    def over(self, contacts: ContactSet) -> ContactSet:
        """``contacts``, which were found, with their functions; their pairs number the objects."""
        if len(self.functions) == 1:
            return contacts
        numbers = [self._number(a, b) for a, b in contacts.pairs.tolist()]
        return replace(
            contacts, transmission=np.array(numbers, dtype=np.int64), transmissions=self.functions
        )

    def _number(self, a: int, b: int) -> int:
        number = self._known.get((a, b))
        if number is None:
            function = self.table.of(self.objects[a], self.objects[b])
            number = self._known[a, b] = 0 if function is None else self.functions.index(function)
        return number
