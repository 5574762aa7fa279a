"""Made-up devices in place of hidapi's module, and a scene that is felt."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from typing import Any

import bpy
import pytest
from fake_hid import FakeHid, FakePad, until
from guard_in_thread import GuardInThread
from haptic_tracing.addon.live_output import handlers, outputs
from haptic_tracing.core.devices import guard


@pytest.fixture
def hid(monkeypatch) -> FakeHid:
    """hidapi's module, with nothing plugged in."""
    module = FakeHid()
    monkeypatch.setitem(
        sys.modules, "hidraw" if sys.platform.startswith("linux") else "hid", module
    )
    monkeypatch.setattr(guard._state, "start", GuardInThread)
    # This guard waits for the same lock of Python as the scene's trace: that is not hanging.
    monkeypatch.setattr(guard, "_ANSWERS_WITHIN", 60.0)
    return module


@pytest.fixture
def plug(hid, tmp_path) -> Iterator[Callable[..., FakePad]]:
    """Plugs in a DualSense, or what is said instead. It has a node that this user may open."""

    def plug(**what: Any) -> FakePad:
        node = tmp_path / f"hidraw{len(hid.pads)}"
        node.write_bytes(b"")
        pad = FakePad(str(node).encode(), **what)
        hid.pads.append(pad)
        return pad

    yield plug
    for pad in hid.pads:
        pad.gate.set()


@pytest.fixture
def connect(hid) -> Callable[[], list[str]]:
    """Finds and connects every device that is plugged in; returns their keys once they are open."""

    def connect() -> list[str]:
        bpy.ops.haptic.find_devices()
        outputs.wait_until_found()
        keys = [found.key for found in outputs.inventory().devices]
        for key in keys:
            if key not in outputs.running():
                bpy.ops.haptic.connect_device(device=key)
        until(lambda: all(outputs.running()[key].status.state == "open" for key in keys))
        return keys

    return connect


@pytest.fixture
def felt(scene, add_box, add_empty) -> Any:
    """A humming box with a listener for either hand."""
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    box.haptics.kappa, box.haptics.rho = 0.0, 1.0
    box.haptics.source.enabled = True
    box.haptics.source.frequency = 150.0
    for name, part in (("left", "hand.L"), ("right", "hand.R")):
        listener = add_empty(name, parent=box)
        listener.haptics.listener.enabled = True
        listener.haptics.listener.body_part = part
        listener.haptics.listener.limiter = False
    scene.frame_set(1)
    return scene


@pytest.fixture
def playing(felt) -> Iterator[Callable[[int], None]]:
    """Playback: called with a number, as many frames go by, as fast as they can."""
    handlers.animation_playback_pre(felt)

    def advance(count: int = 1) -> None:
        for _ in range(count):
            felt.frame_set(felt.frame_current + 1)

    return advance
