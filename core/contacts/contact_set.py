"""The contacts of one frame as arrays, from which the haptic graph is built."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray, IntArray
from ..frozen import frozen
from ..scene.functions import Identity, Impedance, ModulationFunction
from ..scene.values import Contact


@frozen(eq=False)
class ContactSet:
    """``n`` contacts between objects given by index.

    ``pairs`` (n, 2), ``positions`` (n, 2, 3) of the contact node on either object [m, world],
    ``normal`` (n, 3) from first to second, ``depth`` (n,) penetration [m, >= 0], ``distance`` (n,)
    signed [m], ``area`` (n,) of the patch [m^2], ``weight`` (n,) in [0, 1] that multiplies what it
    passes on, ``transmission`` (n,) index into ``transmissions``.
    """

    pairs: IntArray
    positions: FloatArray
    normal: FloatArray
    depth: FloatArray
    distance: FloatArray
    area: FloatArray
    weight: FloatArray
    transmission: IntArray
    transmissions: tuple[ModulationFunction, ...] = (Impedance(),)

    def __len__(self) -> int:
        return len(self.pairs)

    @classmethod
    def empty(cls) -> ContactSet:
        """No contacts."""
        return cls.from_contacts((), {})

    @classmethod
    def from_contacts(cls, contacts: Sequence[Contact], index: Mapping[str, int]) -> ContactSet:
        """From authored contacts, each patch as one; ``index`` gives the number of each object by
        name."""
        contacts = _one_per_patch(contacts)
        count = len(contacts)
        functions: dict[ModulationFunction, int] = {}
        return cls(
            pairs=np.array(
                [[index[name] for name in c.objects] for c in contacts], dtype=np.int64
            ).reshape(count, 2),
            positions=np.array([c.positions for c in contacts], dtype=np.float64).reshape(
                count, 2, 3
            ),
            normal=np.array([c.normal for c in contacts], dtype=np.float64).reshape(count, 3),
            depth=np.array([max(c.depth, 0.0) for c in contacts], dtype=np.float64),
            distance=np.array([-c.depth for c in contacts], dtype=np.float64),
            **{
                key: np.array([getattr(c, key) for c in contacts], dtype=np.float64)
                for key in ("area", "weight")
            },
            transmission=np.array(
                [functions.setdefault(c.transmission, len(functions)) for c in contacts],
                dtype=np.int64,
            ),
            transmissions=tuple(functions) or (Identity(),),
        )

    def to_contacts(self, names: Sequence[str]) -> tuple[Contact, ...]:
        """As authored contacts; ``names`` gives the name of each object by number."""
        return tuple(
            Contact(
                objects=(names[a], names[b]),
                positions=(
                    tuple(self.positions[i, 0].tolist()),
                    tuple(self.positions[i, 1].tolist()),
                ),
                transmission=self.transmissions[self.transmission[i]],
                area=float(self.area[i]),
                normal=tuple(self.normal[i].tolist()),
                depth=float(-self.distance[i]),
                weight=float(self.weight[i]),
            )
            for i, (a, b) in enumerate(self.pairs.tolist())
        )


def _one_per_patch(contacts: Sequence[Contact]) -> list[Contact]:
    """The contacts, with one in place of those of a pair of objects that have shares below 1: the
    points of its patch."""
    patches: dict[object, list[Contact]] = {}
    for number, contact in enumerate(contacts):
        patches.setdefault(frozenset(contact.objects) if contact.share < 1 else number, []).append(
            contact
        )
    return [points[0] if len(points) == 1 else _centre(points) for points in patches.values()]


def _centre(points: Sequence[Contact]) -> Contact:
    """The contact at the share-weighted centre of the points of a patch: their means, the sum of
    their areas, and the function of the point with the largest share. Refining a patch does not
    change it."""
    points = sorted(
        points, key=lambda point: (-point.share, repr(point.transmission), point.positions)
    )
    share = np.array([point.share for point in points])
    share = share / share.sum() if share.any() else np.full(len(points), 1 / len(points))
    flipped = np.array([point.objects != points[0].objects for point in points])
    positions = np.array([point.positions for point in points])
    positions[flipped] = positions[flipped, ::-1]
    normal = share @ (
        np.array([point.normal for point in points]) * np.where(flipped, -1.0, 1.0)[:, None]
    )
    length = float(np.linalg.norm(normal))
    return replace(
        points[0],
        positions=np.einsum("p,pij->ij", share, positions).tolist(),
        normal=tuple((normal / length).tolist()) if length > 0 else points[0].normal,
        area=math.fsum(point.area for point in points),
        depth=float(share @ [point.depth for point in points]),
        weight=min(float(share @ [point.weight for point in points]), 1.0),
        share=1.0,
    )
