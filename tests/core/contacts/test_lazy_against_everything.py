"""Tracing that looks for contacts only where signals get to, against tracing that resolves all: the
same gains, impacts and samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from haptic_tracing.core.contacts.settings import Body
from haptic_tracing.core.contacts.shapes import Box, Sphere
from haptic_tracing.core.scene.functions import Expression, Linear
from haptic_tracing.core.scene.values import HapticObject, Listener, Settings, Source
from haptic_tracing.core.tracer import Frame, Tracer

RATE = 24.0
ROWS = 7


def field(generator, rows, special=False):
    """Stacks of two boxes on a strip of ground per row, some of which hop; balls roll between
    them."""
    objects = [HapticObject(f"ground {row}", 0.3, 0.7) for row in range(rows)]
    bodies = [Body(item.name, Box((60, 1, 1)), motion="static") for item in objects]
    start = [(0.0, 1.5 * row, -0.5) for row in range(rows)]
    for k in range(rows * rows * 2):
        column, row, level = k // 2 % rows, k // 2 // rows, k % 2
        name = f"body {k:03d}"
        kappa, rho = generator.uniform(0.0, 0.6), generator.uniform(0.5, 1.0)
        item = HapticObject(name, kappa, rho)
        if special and k % 5 == 0:
            item = replace(
                item,
                propagation=(Linear(range=5.0), Expression(expression="0.9 * exp(-0.3 * d)"))[
                    k % 2
                ],
            )
        objects.append(item)
        ball = level == 1 and column % 3 == 0
        bodies.append(
            Body(
                name,
                Sphere(0.25) if ball else Box((0.5, 0.5, 0.5)),
                float(10 ** generator.uniform(0, 2.5)),
            )
        )
        start.append((1.1 * column, 1.5 * row, 0.25 + 0.5 * level))
    return tuple(objects), tuple(bodies), np.array(start)


def frames(seed, count, settings, special=False, rows=ROWS):
    """Kicked bodies hop, and one slides over to the next row; sources and listeners come and go."""
    generator = np.random.default_rng(seed)
    objects, bodies, start = field(generator, rows, special)
    kicked = generator.choice(np.arange(rows, len(bodies), 2), 8, replace=False)
    when, up = generator.integers(2, count - 14, 8) / RATE, generator.uniform(1.0, 2.5, 8)
    on = generator.integers(0, len(bodies), 3)
    sources = tuple(
        Source(f"s{k}", objects[b].name, tuple(start[b]), amplitude=float(k > 0))
        for k, b in enumerate(on.tolist())
    )
    ears = generator.integers(0, len(bodies), 2).tolist()
    slider, silent = int(generator.integers(rows, len(bodies))), int(generator.integers(0, count))
    for number in range(count):
        place = start.copy()
        for body, begin, speed in zip(kicked, when, up, strict=True):
            since = max(number / RATE - begin, 0.0)
            place[body, 2] += max(0.0, speed * since - 9.81 / 2 * since**2)
        place[slider, 1] += 1.5 * number / count
        transforms = np.tile(np.eye(4), (len(bodies), 1, 1))
        transforms[:, :3, 3] = place.astype(np.float32)
        listeners = tuple(
            Listener(f"l{k}", objects[b].name, tuple(place[b]), radius=0.0)
            for k, b in enumerate(ears)
        )
        active = sources[:1] if silent <= number < silent + 8 else sources
        yield Frame(
            number,
            number / RATE,
            objects,
            active,
            listeners,
            settings,
            bodies,
            transforms,
            continuous=number > 0,
        )


CASES = [
    (Settings(strategy="best_path"), False),
    (Settings(strategy="as_in_the_paper", threshold=0.1), True),
    (Settings(mode="SD"), False),
    (Settings(mode="MD"), False),
]


def compared(sequence, *paths):
    """Trace lazily, with each of these values of ``paths``, and everything; how many impacts there
    were, and how many contacts fewer each lazy tracer found."""
    lazy, eager = [Tracer(lazy=True, paths=each) for each in paths], Tracer()
    impacts, fewer = 0, [0] * len(paths)
    for frame in sequence:
        every = eager.step(frame)
        impacts += len(every.impacts)
        for k, tracer in enumerate(lazy):
            some = tracer.step(frame)
            assert_same(some, every)
            fewer[k] += len(every.contacts) - len(some.contacts)
    return impacts, *fewer


def assert_same(some, every):
    """What is felt in a frame is the same, from no more contacts."""
    assert some.impacts == every.impacts
    assert [source.name for source in some.sources] == [source.name for source in every.sources]
    audible = np.array([source.amplitude > 0 for source in some.sources], dtype=bool)
    np.testing.assert_allclose(
        some.amplitudes[audible], every.amplitudes[audible], rtol=1e-9, atol=1e-12
    )
    if every.block is not None:
        np.testing.assert_allclose(some.block, every.block, rtol=1e-9, atol=1e-12)
    assert len(some.contacts) <= len(every.contacts)


@pytest.mark.parametrize(("settings", "special"), CASES)
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_lazy_tracing_gives_the_same(settings, special, seed):
    impacts, *fewer = compared(frames(seed, 30, settings, special), False, True)
    assert impacts > 3 and min(fewer) > 0


@pytest.mark.slow
@pytest.mark.parametrize(
    "first", [0, *(pytest.param(k, marks=pytest.mark.more) for k in range(25, 200, 25))]
)
def test_lazy_tracing_gives_the_same_in_200_scenes(first):
    found = [
        compared(frames(seed, 24, Settings(), rows=4), seed % 2 == 1)
        for seed in range(first, first + 25)
    ]
    assert all(np.sum(found, axis=0) > 0)


def test_contacts_on_dead_ends_are_left_out_where_only_paths_count():
    """The hammer on a floor with other things on it: a path needs no contact but its own."""
    names = ["floor", "drill", "table", "cup", "crate"]
    sizes = [(9, 9, 1), (1, 1, 1), (1, 1, 1), (1, 1, 1), (1, 1, 1)]
    places = [(0, 0, -0.5), (-3, 0, 0.5), (0, 0, 0.5), (0, 0, 1.5), (3, 0, 0.5)]
    transforms = np.tile(np.eye(4), (5, 1, 1))
    transforms[:, :3, 3] = places
    frame = Frame(
        1,
        0.0,
        tuple(HapticObject(name, 0.3, 0.7) for name in names),
        (Source("hammer", "drill", places[1]),),
        (Listener("hand", "cup", places[3], radius=0.0),),
        bodies=tuple(
            Body(name, Box(size), motion="static") for name, size in zip(names, sizes, strict=True)
        ),
        transforms=transforms,
    )
    lean, heaps = Tracer(lazy=True, paths=True).step(frame), Tracer(lazy=True).step(frame)
    assert (len(lean.contacts), len(heaps.contacts)) == (3, 4)  # not that of the crate
    assert lean.gains.tolist() == heaps.gains.tolist()
    summed = replace(frame, settings=Settings(strategy="as_in_the_paper"))
    assert len(Tracer(lazy=True, paths=True).step(summed).contacts) == 4
