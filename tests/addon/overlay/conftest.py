"""Traced frames to draw: a bridge by hand, and random scenes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.render.frame_result import FrameResult
from haptic_tracing.core.scene.functions import Exponential, Linear
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Settings,
    Source,
    SourceKind,
)
from haptic_tracing.core.tracer import Frame, Tracer


def traced(scene: HapticScene) -> FrameResult:
    """One frame of a scene with authored contacts."""
    names = sorted(item.name for item in scene.objects)
    contacts = ContactSet.from_contacts(scene.contacts, {name: k for k, name in enumerate(names)})
    frame = Frame(
        1, 0.0, scene.objects, scene.sources, scene.listeners, scene.settings, contacts=contacts
    )
    return Tracer().step(frame)


def random_scene(seed: int, settings: Settings | None = None) -> HapticScene:
    """Up to ten objects with contacts anywhere, persistent and temporary sources, listeners."""
    random = np.random.default_rng(seed)
    count = int(random.integers(2, 11))

    def place() -> tuple[float, ...]:
        return tuple(random.uniform(-2, 2, 3).tolist())

    objects = tuple(
        HapticObject(
            f"o{k}",
            0.1,
            0.9,
            (Exponential(alpha=float(random.uniform(0, 1))), Linear(range=8.0))[random.integers(2)],
        )
        for k in range(count)
    )
    pairs = [
        random.choice(count, 2, replace=False) for _ in range(int(random.integers(0, 2 * count)))
    ]
    contacts = tuple(Contact((f"o{a}", f"o{b}"), (place(), place())) for a, b in pairs)
    sources = tuple(
        Source(
            f"s{k}",
            f"o{random.integers(count)}",
            place(),
            float(random.uniform(0, 1)),
            list(SourceKind)[random.integers(2)],
        )
        for k in range(int(random.integers(0, 4)))
    )
    listeners = tuple(
        Listener(f"l{k}", f"o{random.integers(count)}", place(), radius=0.0)
        for k in range(int(random.integers(0, 5)))
    )
    return HapticScene(objects, contacts, sources, listeners, settings or Settings())


BRIDGE = HapticScene(
    objects=(
        HapticObject("deck", 0.0, 1.0, Exponential(alpha=0.4)),
        HapticObject("pier", 0.0, 1.0, Exponential(alpha=0.4)),
        HapticObject("ground", 0.0, 1.0, Exponential(alpha=0.4)),
        HapticObject("island", 0.0, 1.0),
        HapticObject("hut", 0.0, 1.0),
    ),
    contacts=(
        Contact(("deck", "pier"), ((1, 0, 1), (1, 0, 1))),
        Contact(("pier", "ground"), ((1, 0, -1), (1, 0, -1))),
        Contact(("island", "hut"), ((0, 0, -1.6), (0, 0, -1.6))),
    ),
    sources=(Source("truck", "deck", (-1.5, 0, 1)), Source("siren", "deck", (-0.5, 0, 1), 0.0)),
    listeners=(
        Listener("driver", "deck", (0.2, 0, 1), radius=0.0),
        Listener("walker", "ground", (-1, 0, -1), radius=0.0),
        Listener("hermit", "hut", (-1.2, 0, -1.6), radius=0.0),
    ),
)
"""The truck reaches the driver and, over pier and ground, the walker; nothing reaches the
hermit."""


@pytest.fixture
def bridge() -> FrameResult:
    return traced(BRIDGE)


@pytest.fixture
def camera(scene: Any) -> Iterator[Any]:
    """Looks at the bridge from the front, 8 m away."""
    import bpy

    data = bpy.data.cameras.new("camera")
    obj = bpy.data.objects.new("camera", data)
    scene.collection.objects.link(obj)
    obj.location, obj.rotation_euler = (0, -8, 0), (np.pi / 2, 0, 0)
    scene.camera = obj
    bpy.context.view_layer.update()
    yield obj


@pytest.fixture
def shown(scene: Any, bridge: FrameResult) -> Callable[[], FrameResult]:
    """Makes the bridge the scene's last traced frame."""
    from haptic_tracing.addon.session import session, sessions

    def show() -> FrameResult:
        own = session.of(scene)
        own.result = bridge
        own.shown = sessions.Traced(bridge, BRIDGE.settings, np.zeros((len(bridge.listeners), 0)))
        return bridge

    return show
