"""Contacts given by an author, which override those found."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import BoolArray, IntArray
from ..frozen import frozen
from ..scene.values import Contact
from .contact_set import ContactSet

ARRAYS = ("pairs", "positions", "normal", "depth", "distance", "area", "weight", "transmission")
"""The arrays of a `ContactSet`, a row per contact."""


@frozen(eq=False)
class AuthoredContacts:
    """Authored ``contacts`` replace those found between two objects that are both ``settled`` (n,),
    which means placed by their author. Objects are numbered by their sorted names."""

    settled: BoolArray
    contacts: ContactSet

    @classmethod
    def of(
        cls,
        names: Collection[str],
        settled: Collection[str],
        contacts: Sequence[Contact],
    ) -> AuthoredContacts:
        """The contacts in a scene of the objects ``names``; those of other objects are left out."""
        index = {name: number for number, name in enumerate(sorted(names))}
        return cls(
            settled=np.array([name in settled for name in index], dtype=np.bool_),
            contacts=ContactSet.from_contacts(
                [item for item in contacts if index.keys() >= set(item.objects)], index
            ),
        )

    def over(self, found: ContactSet) -> ContactSet:
        """The valid contacts, given those that detection ``found``."""
        left = rows_of(found, np.logical_not(self.settled[found.pairs].all(axis=1)))
        arrays = {
            key: np.concatenate([getattr(left, key), getattr(self.contacts, key)])
            for key in ARRAYS[:-1]
        }
        return ContactSet(
            **arrays,
            transmission=np.concatenate(
                [left.transmission, self.contacts.transmission + len(left.transmissions)]
            ),
            transmissions=(*left.transmissions, *self.contacts.transmissions),
        )


def rows_of(contacts: ContactSet, chosen: BoolArray | IntArray) -> ContactSet:
    """The contacts that are ``chosen``, (n,) or by their numbers."""
    return replace(contacts, **{key: getattr(contacts, key)[chosen] for key in ARRAYS})
