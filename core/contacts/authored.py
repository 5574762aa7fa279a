"""Contacts given by an author, which override those found."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import BoolArray, IntArray
from ..frozen import frozen
from ..scene.functions import ModulationFunction
from ..scene.values import Contact
from .contact_set import ContactSet

ARRAYS = ("pairs", "positions", "normal", "depth", "distance", "area", "weight", "transmission")
"""The arrays of a `ContactSet`, a row per contact."""


@frozen(eq=False)
class AuthoredContacts:
    """Authored ``contacts`` replace those found between two objects that are both ``settled`` (n,),
    which means placed by their author. ``transmissions``: by pair of objects, the smaller number
    first, the transmission of their contacts wherever they are found. Objects are numbered by their
    sorted names."""

    settled: BoolArray
    contacts: ContactSet
    transmissions: Mapping[tuple[int, int], ModulationFunction]

    @classmethod
    def of(
        cls,
        names: Collection[str],
        settled: Collection[str],
        contacts: Sequence[Contact],
        transmissions: Mapping[tuple[str, str], ModulationFunction],
    ) -> AuthoredContacts:
        """The contacts in a scene of the objects ``names``; those of other objects are left out."""
        index = {name: number for number, name in enumerate(sorted(names))}
        return cls(
            settled=np.array([name in settled for name in index], dtype=np.bool_),
            contacts=ContactSet.from_contacts(
                [item for item in contacts if index.keys() >= set(item.objects)], index
            ),
            transmissions={
                (min(index[a], index[b]), max(index[a], index[b])): function
                for (a, b), function in transmissions.items()
                if a in index and b in index
            },
        )

    def over(self, found: ContactSet) -> ContactSet:
        """The valid contacts, given those that detection ``found``."""
        left = rows_of(found, np.logical_not(self.settled[found.pairs].all(axis=1)))
        functions = list(left.transmissions)
        transmission = left.transmission.copy()
        for row, (a, b) in enumerate(left.pairs.tolist() if self.transmissions else ()):
            function = self.transmissions.get((min(a, b), max(a, b)))
            if function is not None:
                transmission[row] = len(functions)
                functions.append(function)
        arrays = {
            key: np.concatenate([getattr(left, key), getattr(self.contacts, key)])
            for key in ARRAYS[:-1]
        }
        return ContactSet(
            **arrays,
            transmission=np.concatenate(
                [transmission, self.contacts.transmission + len(functions)]
            ),
            transmissions=(*functions, *self.contacts.transmissions),
        )


def rows_of(contacts: ContactSet, chosen: BoolArray | IntArray) -> ContactSet:
    """The contacts that are ``chosen``, (n,) or by their numbers."""
    return replace(contacts, **{key: getattr(contacts, key)[chosen] for key in ARRAYS})
