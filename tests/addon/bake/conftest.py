"""A scene to bake: a box slides over the ground, a source on it, two listeners."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from haptic_tracing.addon.bake import playback
from haptic_tracing.addon.registration import handlers


@pytest.fixture
def shaken(scene: Any, add_box: Callable[..., Any], add_empty: Callable[..., Any]) -> Any:
    """A sine of 60 Hz at full strength on the ground, felt on the ground and on a crate that leaves
    it after frame 12; 24 frames."""
    ground = add_box("ground", (0, 0, -0.1), (4, 4, 0.2))
    crate = add_box("crate", (1, 0, 0.25), (0.5, 0.5, 0.5))
    source = add_empty("shaker", (-0.25, 0, 0), ground)
    source.haptics.source.enabled = True
    for name, parent, part in (("foot", ground, "foot.L"), ("hand", crate, "hand.R")):
        listener = add_empty(name, (0, 0, 0), parent)
        listener.haptics.listener.enabled = True
        listener.haptics.listener.body_part = part
        listener.haptics.listener.limiter = False
    crate.keyframe_insert("location", frame=12)
    crate.location.z = 2.0
    crate.keyframe_insert("location", frame=14)
    scene.frame_start, scene.frame_end = 1, 24
    scene.frame_set(1)
    return scene


@pytest.fixture
def playing(monkeypatch: Any) -> None:
    """The timeline plays, as it can't without a window."""
    for module in (playback, handlers):
        monkeypatch.setattr(module, "is_playing", lambda: True)
