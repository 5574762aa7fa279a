"""Families of haptic scenes that the propagation benchmarks share. All are deterministic and given
as arrays, as detection would."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.graph.haptic_graph import HapticGraph, ObjectTable, build_graph
from haptic_tracing.core.propagation import Propagation, propagate
from haptic_tracing.core.scene.values import HapticObject, Listener, Settings, Source


@dataclass(frozen=True, slots=True)
class Family:
    """Objects (their table), contacts, sources and listeners: what one frame hands to the graph."""

    name: str
    table: ObjectTable
    contacts: ContactSet
    sources: tuple[Source, ...]
    listeners: tuple[Listener, ...]

    def graph(self) -> HapticGraph:
        """The haptic graph."""
        return build_graph(self.table, self.contacts, self.sources, self.listeners)


def traced(family: Family, settings: Settings) -> Propagation:
    """Graph and propagation of a frame."""
    return propagate(family.graph(), settings)


def _name(number: int) -> str:
    return f"object {number:06d}"


def _family(
    name: str,
    count: int,
    edges: np.ndarray,
    points: np.ndarray,
    kappa: np.ndarray,
    rho: np.ndarray,
    sources: list[int],
    listeners: list[int],
    places: np.ndarray,
) -> Family:
    """``edges`` (c, 2) objects, ``points`` (c, 3) contact points [m], ``places`` (count, 3) where
    an object's source or listener sits."""
    objects = [HapticObject(_name(i), float(kappa[i]), float(rho[i])) for i in range(count)]
    contacts = len(edges)
    contact_set = ContactSet(
        pairs=np.asarray(edges, dtype=np.int64).reshape(contacts, 2),
        positions=np.repeat(
            np.asarray(points, dtype=np.float64).reshape(contacts, 1, 3), 2, axis=1
        ),
        normal=np.tile([0.0, 0.0, 1.0], (contacts, 1)),
        depth=np.zeros(contacts),
        distance=np.zeros(contacts),
        area=np.zeros(contacts),
        weight=np.ones(contacts),
        transmission=np.zeros(contacts, dtype=np.int64),
    )
    return Family(
        name,
        ObjectTable.of(objects, 0.1),
        contact_set,
        tuple(
            Source(f"source {k:03d}", _name(o), tuple(places[o].tolist()))
            for k, o in enumerate(sources)
        ),
        tuple(
            Listener(f"listener {k:03d}", _name(o), tuple(places[o].tolist()), radius=0.0)
            for k, o in enumerate(listeners)
        ),
    )


def _material(
    generator: np.random.Generator, count: int, low: float, high: float
) -> tuple[np.ndarray, np.ndarray]:
    """kappa and rho such that K = (1 - kappa) rho is spread over [low, high]."""
    k = generator.uniform(low, high, count)
    rho = np.sqrt(k)
    return 1 - k / rho, rho


def tree(count: int, sources: int = 1, listeners: int = 10) -> Family:
    """Every object touches three smaller ones, 0.5 m apart; listeners at leaves."""
    generator = np.random.default_rng(1)
    child = np.arange(1, count)
    edges = np.column_stack([(child - 1) // 3, child])
    places = generator.uniform(0, 1, (count, 3)) * 0.5
    points = (places[edges[:, 0]] + places[edges[:, 1]]) / 2 + generator.uniform(
        0, 0.1, (count - 1, 3)
    )
    leaves = np.linspace(max(1, count - 1 - count // 3), count - 1, listeners).astype(int).tolist()
    return _family(
        "tree",
        count,
        edges,
        points,
        *_material(generator, count, 0.5, 0.9),
        [0] * sources,
        leaves,
        places,
    )


def grid(
    name: str, rows: int, columns: int, low: float = 0.3, high: float = 0.6, listeners: int = 1
) -> Family:
    """Blocks of 0.5 m in rows and columns, each touching its four neighbours; source in the first
    corner, listener in the last."""
    generator = np.random.default_rng(2)
    number = np.arange(rows * columns).reshape(columns, rows).T
    edges = np.concatenate(
        [
            np.column_stack([number[:-1].ravel(), number[1:].ravel()]),
            np.column_stack([number[:, :-1].ravel(), number[:, 1:].ravel()]),
        ]
    )
    places = np.zeros((rows * columns, 3))
    places[number.ravel()] = 0.5 * np.stack(
        np.meshgrid(np.arange(rows), np.arange(columns), [0], indexing="ij"), -1
    ).reshape(-1, 3)
    places += generator.uniform(0, 0.05, places.shape)
    points = (places[edges[:, 0]] + places[edges[:, 1]]) / 2
    ends = [int(number.ravel()[-1 - k]) for k in range(listeners)]
    return _family(
        name,
        rows * columns,
        edges,
        points,
        *_material(generator, rows * columns, low, high),
        [0],
        ends,
        places,
    )


def ladder(columns: int) -> Family:
    """Two rows of blocks."""
    return grid("ladder", 2, columns)


def wall(columns: int, rows: int = 4) -> Family:
    """Four rows of blocks."""
    return grid("wall", rows, columns)


def random_contacts(count: int, degree: float = 3.0, low: float = 0.2, high: float = 0.5) -> Family:
    """Objects of 1 m with contacts between random pairs."""
    generator = np.random.default_rng(3)
    contacts = int(count * degree / 2)
    first = generator.integers(0, count, contacts)
    second = (first + generator.integers(1, count, contacts)) % count
    edges = np.unique(np.sort(np.column_stack([first, second]), axis=1), axis=0)
    places = generator.uniform(0, 1, (count, 3))
    points = generator.uniform(0, 1, (len(edges), 3))
    listeners = generator.choice(np.arange(1, count), min(10, count - 1), replace=False).tolist()
    return _family(
        "random contacts",
        count,
        edges,
        points,
        *_material(generator, count, low, high),
        [0],
        listeners,
        places,
    )


def hub(arches: int, low: float = 0.3, high: float = 0.6) -> Family:
    """A ground with arches, each standing on two feet: every path may leave and enter the ground
    again and again."""
    generator = np.random.default_rng(4)
    count = arches + 1
    arch = np.repeat(np.arange(1, count), 2)
    edges = np.column_stack([np.zeros_like(arch), arch])
    side = int(np.ceil(np.sqrt(arches)))
    centre = np.stack(
        [(np.arange(arches) % side) * 1.5, np.arange(arches) // side * 1.5, np.zeros(arches)],
        axis=1,
    )
    feet = np.tile([[0.0, 0.0, 0.0], [0.8, 0.0, 0.0]], (arches, 1))
    points = np.repeat(centre, 2, axis=0) + feet + generator.uniform(0, 0.1, (2 * arches, 3))
    places = np.concatenate([[[0.0, 0.0, 0.0]], centre + np.array([0.4, 0.0, 0.8])])
    listeners = np.unique(np.linspace(1, arches, min(10, arches)).astype(int)).tolist()
    return _family(
        "hub with arches",
        count,
        edges,
        points,
        *_material(generator, count, low, high),
        [0],
        listeners,
        places,
    )


def pile(
    count: int,
    sources: int = 4,
    listeners: int = 10,
    neighbours: float = 1.0,
    low: float = 0.4,
    high: float = 0.8,
) -> Family:
    """Boxes on a ground, 0.6 m apart, each touching the ground and about ``neighbours`` of its next
    ones in its row."""
    generator = np.random.default_rng(5)
    side = int(np.ceil(np.sqrt(count)))
    box = np.arange(1, count + 1)
    place = np.stack(
        [(box - 1) % side * 0.6, (box - 1) // side * 0.6, np.full(count, 0.3)], axis=1
    ) + generator.uniform(0, 0.1, (count, 3))
    touching = np.flatnonzero(
        ((box[:-1] - 1) % side != side - 1) & (generator.uniform(size=count - 1) < neighbours)
    )
    edges = np.concatenate(
        [
            np.column_stack([np.zeros_like(box), box]),
            np.column_stack([box[touching], box[touching + 1]]),
        ]
    )
    ground = place * [1, 1, 0]
    points = np.concatenate([ground, (place[touching] + place[touching + 1]) / 2])
    places = np.concatenate([[[0.0, 0.0, 0.0]], place])
    starts = generator.choice(box, sources, replace=False).tolist()
    ends = generator.choice(box, min(listeners, count), replace=False).tolist()
    return _family(
        "pile on a ground",
        count + 1,
        edges,
        points,
        *_material(generator, count + 1, low, high),
        starts,
        ends,
        places,
    )


FAMILIES: dict[str, Callable[[int], Family]] = {
    "tree": tree,
    "ladder": lambda count: ladder(max(2, count // 2)),
    "wall": lambda count: wall(max(2, count // 4)),
    "random contacts": random_contacts,
    "hub with arches": lambda count: hub(max(2, count - 1)),
    "pile on a ground": lambda count: pile(max(10, count - 1), sources=1),
}
"""By name: the family at about a number of objects."""
