"""Tracing that looks for contacts only where signals get to, against tracing that resolves all: the same gains, impacts and samples."""

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


def field(generator, special=False):
    """Stacks of two boxes on a ground, some of which hop; balls roll between them."""
    objects = [HapticObject("ground", 0.3, 0.7)]
    bodies = [Body("ground", Box((60, 60, 1)), motion="static")]
    start = [(0.0, 0.0, -0.5)]
    for k in range(ROWS * ROWS * 2):
        column, row, level = k // 2 % ROWS, k // 2 // ROWS, k % 2
        name = f"body {k:03d}"
        kappa, rho = generator.uniform(0.0, 0.6), generator.uniform(0.5, 1.0)
        item = HapticObject(name, kappa, rho)
        if special and k % 5 == 0:
            item = replace(item, propagation=(Linear(range=5.0), Expression(expression="0.9 * exp(-0.3 * d)"))[k % 2])
        objects.append(item)
        ball = level == 1 and column % 3 == 0
        bodies.append(Body(name, Sphere(0.25) if ball else Box((0.5, 0.5, 0.5)), float(10 ** generator.uniform(0, 2.5))))
        start.append((1.1 * column, 1.1 * row, 0.25 + 0.5 * level))
    return tuple(objects), tuple(bodies), np.array(start)


def frames(seed, count, settings, special=False):
    generator = np.random.default_rng(seed)
    objects, bodies, start = field(generator, special)
    kicked = generator.choice(np.arange(2, len(bodies), 2), 8, replace=False)
    when, up = generator.integers(2, count - 14, 8) / RATE, generator.uniform(1.0, 2.5, 8)
    on = generator.integers(0, len(bodies), 3)
    sources = tuple(Source(f"s{k}", objects[b].name, tuple(start[b]), amplitude=float(k > 0)) for k, b in enumerate(on.tolist()))
    ears = generator.integers(0, len(bodies), 4).tolist()
    for number in range(count):
        place = start.copy()
        for body, begin, speed in zip(kicked, when, up, strict=True):
            since = max(number / RATE - begin, 0.0)
            place[body, 2] += max(0.0, speed * since - 9.81 / 2 * since**2)
        transforms = np.tile(np.eye(4), (len(bodies), 1, 1))
        transforms[:, :3, 3] = place.astype(np.float32)
        listeners = tuple(Listener(f"l{k}", objects[b].name, tuple(place[b])) for k, b in enumerate(ears))
        yield Frame(number, number / RATE, objects, sources, listeners, settings, bodies, transforms, continuous=number > 0)


CASES = [
    (Settings(strategy="best_path"), False),
    (Settings(strategy="best_path", threshold=0.1), True),
    (Settings(threshold=0.05), False),
    (Settings(threshold=0.0, strategy="best_path"), False),
    (Settings(strategy="energy_balance"), False),
    (Settings(mode="SD", strategy="best_path", threshold=0.1), False),
    (Settings(mode="MD"), False),
]


@pytest.mark.parametrize(("settings", "special"), CASES)
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_lazy_tracing_gives_the_same(settings, special, seed):
    lazy, eager = Tracer(lazy=True), Tracer()
    impacts, fewer = 0, 0
    for frame in frames(seed, 30, settings, special):
        some, every = lazy.step(frame), eager.step(frame)
        assert some.impacts == every.impacts
        assert [source.name for source in some.sources] == [source.name for source in every.sources]
        audible = np.array([source.amplitude > 0 for source in some.sources], dtype=bool)
        np.testing.assert_allclose(some.amplitudes[audible], every.amplitudes[audible], rtol=1e-9, atol=1e-12)
        if every.block is not None:
            np.testing.assert_allclose(some.block, every.block, rtol=1e-9, atol=1e-12)
        impacts += len(every.impacts)
        fewer += len(every.contacts) - len(some.contacts)
        assert len(some.contacts) <= len(every.contacts)
    assert impacts > 3
    assert fewer > 0 or settings.threshold < 0.05 or settings.mode == "SD"
