"""Frames as the loop meets them, handed to the graph: the demo scene, and boxes that fall and
settle as Blender simulates them."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.graph.haptic_graph import ObjectTable
from haptic_tracing.core.run_time import load
from haptic_tracing.core.scene.values import HapticScene, SourceKind

from .families import Family


def demo_scene() -> HapticScene:
    """The demo's scene as it is exported."""
    with tempfile.TemporaryDirectory() as folder:
        command = [
            sys.executable,
            "-m",
            "haptic_tracing",
            "demo",
            "--out",
            folder,
            "--no-picture",
            "--end",
            "10",
        ]
        subprocess.run(command, check=True, capture_output=True)
        return load(Path(folder) / "jackhammer_bench.json").content


def demo_family() -> Family:
    """One persistent source of the demo's scene and its 10 listeners."""
    scene = demo_scene()
    table = ObjectTable.of(scene.objects, scene.settings.epsilon)
    contacts = ContactSet.from_contacts(scene.contacts, table.index())
    sources = tuple(source for source in scene.sources if source.kind is SourceKind.PERSISTENT)[:1]
    return Family("demo scene", table, contacts, sources, scene.listeners)


def falling_boxes(bodies: int, frames: int) -> list[Family]:
    """What each frame of `falling_bodies` hands to the graph: so many boxes, 4 sources, 10
    listeners, all contacts that signals reach."""
    import haptic_tracing
    from haptic_tracing.addon.session import session

    from . import falling_bodies

    haptic_tracing.register()
    try:
        scene = falling_bodies.build(frames, bodies, "BOX", False, "best_path", False)
        scene.haptics.tracing = True
        played = []
        for frame in range(1, frames + 1):
            scene.frame_set(frame)
            result = session.result_of(scene)
            if result is not None:
                name = f"{bodies:,} falling boxes"
                played.append(
                    Family(
                        name, result.graph.table, result.contacts, result.sources, result.listeners
                    )
                )
        return played
    finally:
        haptic_tracing.unregister()
