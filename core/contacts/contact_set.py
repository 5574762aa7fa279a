"""The contacts of one frame as arrays, from which the haptic graph is built."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..arrays import FloatArray, IntArray
from ..scene.functions import Identity, ModulationFunction
from ..scene.values import Contact


@dataclass(frozen=True, slots=True)
class ContactSet:
    """``n`` contacts between objects given by index.

    ``pairs`` (n, 2), ``positions`` (n, 2, 3) of the contact node on either object [m, world], ``normal`` (n, 3) from first to second,
    ``depth`` (n,) penetration [m, >= 0], ``distance`` (n,) signed [m], ``area`` (n,) of the patch [m^2], ``share`` (n,) of its patch
    (adds up to 1 over the contacts of a pair), ``weight`` (n,) in [0, 1] that multiplies what it passes on, ``transmission`` (n,) index
    into ``transmissions``.
    """

    pairs: IntArray
    positions: FloatArray
    normal: FloatArray
    depth: FloatArray
    distance: FloatArray
    area: FloatArray
    share: FloatArray
    weight: FloatArray
    transmission: IntArray
    transmissions: tuple[ModulationFunction, ...] = field(default_factory=lambda: (Identity(),))

    def __len__(self) -> int:
        return len(self.pairs)

    @classmethod
    def empty(cls) -> ContactSet:
        """No contacts."""
        return cls.from_contacts((), {})

    @classmethod
    def from_contacts(cls, contacts: Sequence[Contact], index: Mapping[str, int]) -> ContactSet:
        """From authored contacts; ``index`` gives the number of each object by name."""
        count = len(contacts)
        functions: dict[ModulationFunction, int] = {}
        return cls(
            pairs=np.array([[index[name] for name in c.objects] for c in contacts], dtype=np.int64).reshape(count, 2),
            positions=np.array([c.positions for c in contacts], dtype=np.float64).reshape(count, 2, 3),
            normal=np.array([c.normal for c in contacts], dtype=np.float64).reshape(count, 3),
            depth=np.array([max(c.depth, 0.0) for c in contacts], dtype=np.float64),
            distance=np.array([-c.depth for c in contacts], dtype=np.float64),
            **{key: np.array([getattr(c, key) for c in contacts], dtype=np.float64) for key in ("area", "share", "weight")},
            transmission=np.array([functions.setdefault(c.transmission, len(functions)) for c in contacts], dtype=np.int64),
            transmissions=tuple(functions) or (Identity(),),
        )

    def to_contacts(self, names: Sequence[str]) -> tuple[Contact, ...]:
        """As authored contacts; ``names`` gives the name of each object by number."""
        return tuple(
            Contact(
                objects=(names[a], names[b]),
                positions=(tuple(self.positions[i, 0].tolist()), tuple(self.positions[i, 1].tolist())),
                transmission=self.transmissions[self.transmission[i]],
                area=float(self.area[i]),
                normal=tuple(self.normal[i].tolist()),
                depth=float(-self.distance[i]),
                share=float(self.share[i]),
                weight=float(self.weight[i]),
            )
            for i, (a, b) in enumerate(self.pairs.tolist())
        )
