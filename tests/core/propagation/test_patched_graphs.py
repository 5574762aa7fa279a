"""A graph that is made from that of the frame before is, bit by bit, the one that is made anew."""

from __future__ import annotations

import dataclasses

import numpy as np
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.contacts.shapes import Box
from haptic_tracing.core.graph.haptic_graph import HapticGraph, ObjectTable, build_graph
from haptic_tracing.core.graph.object_frames import ObjectFrames
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.functions import (
    Constant,
    Exponential,
    Expression,
    HapticTracing,
    Identity,
    Impedance,
    Resilient,
    Spectrum,
)
from haptic_tracing.core.scene.functions.physical import Physical, Wave
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    Listener,
    Settings,
    Source,
)
from hypothesis import given, settings
from hypothesis import strategies as st

BANDS = Spectrum(band_gains=(1.0, 0.9, 0.8, 0.7, 0.6, 0.5), wave_speed=340.0)
PLAIN = (HapticTracing(), Exponential(alpha=0.4), Expression(expression="x / (1 + d)"))
MEASURED = (
    *(
        Physical(
            density=density, phase_speed=speed, thickness=0.05, extent=0.4, reference_distance=0.02
        )
        for density, speed in ((7850.0, 5100.0), (700.0, 3000.0))
    ),
    Physical(wave=Wave.SURFACE, density=1700.0, phase_speed=200.0, reference_distance=0.5),
)
LINKS = (Identity(), Constant(gain_value=0.7), Expression(expression="area / (1 + depth)"))
SPECTRAL = (Impedance(), Exponential(alpha=0.2, spectrum=BANDS), Resilient())


class World:
    """Boxes in a row, the first of them on each of the others, of which things change at random."""

    def __init__(self, seed: int, measured: bool, spectral: bool) -> None:
        self.random = np.random.default_rng(seed)
        names = self.random.permutation([f"o{k}" for k in range(9)]).tolist()
        functions = MEASURED if measured else PLAIN
        self.objects = tuple(
            HapticObject(name, 0.1, 0.9, functions[k % 3], Box((0.8, 0.3, 0.1)))
            for k, name in enumerate(names)
        )
        self.table = ObjectTable.of(self.objects, 0.1)
        joined = [(names[0], name) for name in names[1:]]
        joined += [(names[k], names[k + 1]) for k in range(1, 8)]
        links = SPECTRAL if spectral else LINKS
        self.contacts = ContactSet.from_contacts(
            [
                Contact(
                    pair,
                    (self.place(), self.place()),
                    links[k % 3],
                    normal=self.place(),
                    area=0.01 * (k % 4),
                )
                for k, pair in enumerate(joined)
            ],
            self.table.index(),
        )
        self.transforms = np.tile(np.eye(4), (9, 1, 1))
        self.sources = tuple(Source(f"s{k}", names[k], self.place()) for k in range(3))
        self.listeners = tuple(
            Listener(f"l{k}", names[-1 - k], self.place(), radius=0.1 * k) for k in range(3)
        )

    def place(self) -> tuple[float, float, float]:
        x, y, z = self.random.uniform(-1, 1, 3).tolist()
        return x, y, z

    def change(self, kind: str) -> None:
        """Let something become different."""
        contacts = self.contacts
        if kind == "part" and len(contacts) > 2:
            gone = self.random.integers(len(contacts))
            self.contacts = dataclasses.replace(
                contacts,
                **{
                    field.name: np.delete(getattr(contacts, field.name), gone, axis=0)
                    for field in dataclasses.fields(contacts)
                    if field.name != "transmissions"
                },
            )
        elif kind == "turn":
            cos, sin = np.cos(self.random.uniform()), np.sin(self.random.uniform())
            self.transforms = self.transforms.copy()
            self.transforms[self.random.integers(9), :2, :2] = [[cos, -sin], [sin, cos]]
        elif kind == "sources":
            self.sources = tuple(
                dataclasses.replace(source, position=self.place()) for source in self.sources
            )
        elif kind in ("positions", "area", "normal", "weight", "depth", "transmission"):
            values = getattr(contacts, kind).copy()
            rows = self.random.integers(len(contacts), size=2)
            if kind == "transmission":
                values[rows] = self.random.integers(3, size=2)
            else:
                values[rows] = self.random.uniform(0, 1, values[rows].shape)
            self.contacts = dataclasses.replace(contacts, **{kind: values})

    def graph(self, before: HapticGraph | None) -> HapticGraph:
        frames = ObjectFrames.of_objects(self.objects, self.transforms)
        return build_graph(
            self.table,
            self.contacts,
            self.sources,
            self.listeners,
            frames,
            before=before,
        )


def assert_alike(one: object, other: object) -> None:
    """The same bits in all arrays."""
    for field in dataclasses.fields(one):
        a, b = getattr(one, field.name), getattr(other, field.name)
        if isinstance(a, np.ndarray):
            assert a.dtype == b.dtype, field.name
            assert a.shape == b.shape, field.name
            assert a.tobytes() == b.tobytes(), field.name
        elif dataclasses.is_dataclass(a) and not isinstance(a, ObjectTable):
            assert_alike(a, b)
        else:
            assert (a is b) or a == b, field.name


KINDS = st.sampled_from(
    [
        "nothing",
        "positions",
        "area",
        "normal",
        "weight",
        "depth",
        "transmission",
        "turn",
        "sources",
        "part",
    ]
)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.integers(0, 10**6), st.lists(KINDS, min_size=1, max_size=8), st.booleans(), st.booleans())
def test_what_has_not_changed_stays(seed, kinds, measured, spectral):
    world = World(seed, measured, spectral)
    known = world.graph(None)
    for kind in kinds:
        world.change(kind)
        known, fresh = world.graph(known), world.graph(None)
        assert_alike(known, fresh)
        found, expected = (propagate(graph, Settings()) for graph in (known, fresh))
        assert found.gain.tobytes() == expected.gain.tobytes()
        assert dict(found.best_path) == dict(expected.best_path)


def test_only_what_has_changed_is_examined():
    """Of a later graph with the same contacts nothing but ends and impedances is made again."""
    world = World(0, measured=True, spectral=True)
    known = world.graph(None)
    world.change("nothing")
    again = world.graph(known)
    for key in ("partner", "contact", "side", "start", "node_object"):
        assert getattr(again, key) is getattr(known, key)
    assert again.conducted.ordered.positions is known.conducted.ordered.positions
