"""What a script says to the front door, for checkers of types (`make lint`): arrays are poses and
positions, and nothing is `Any`."""

from __future__ import annotations

from typing import assert_type

import haptic_tracing as ht
import numpy as np


def answers(scene: ht.Scene, places: dict[str, np.ndarray]) -> ht.Step:
    """Poses as lists, tuples and arrays."""
    run = assert_type(ht.open(scene), ht.Run)
    run.step(0.0, {"crate": [0.0, 0, 0, 1, 0, 0, 0]}, source_positions={"drill": (0, 0, 1)})
    run.step(0.1, {"crate": np.zeros(7), "ball": np.arange(7, dtype=np.float32)})
    run.follow(0.2, places, listener_positions={"hand": np.array([0, 0, 1])})
    step = assert_type(run.answer(), ht.Step)
    assert_type(step.levels["hand"].level, float | None)
    assert_type(step.impacts[0].objects, tuple[str, str])
    assert_type(scene.content.objects[0].name, str)
    return step
