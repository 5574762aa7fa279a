"""What in a scene is valid but probably not meant."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ..contacts.shapes import pose_matrix
from ..render.renderer import SAMPLE_RATE
from ..scene.body import BODY_PART
from ..scene.references import meant
from ..scene.values import HapticObject, HapticScene, Listener, Pose, Source


def doubts(scene: HapticScene) -> Iterator[str]:
    """A sentence for each listener whose body part no device and no format knows, for each source
    and listener that is farther from its object than that is large, and for each tone that samples
    at 8 kHz don't hold."""
    shapes = {item.name: item for item in scene.objects if item.shape is not None}
    items: list[Source | Listener] = [*scene.sources, *scene.listeners]
    for one in items:
        item = shapes.get(one.object)
        if item is not None and (away := _away(item, one.position)) > 0:
            yield f"'{one.name}' is {away:.3g} m away from '{item.name}', which it is on"
    for source in scene.sources:
        frequency = getattr(source.emitted, "frequency", 0.0)
        if isinstance(frequency, float | int) and frequency >= SAMPLE_RATE / 2:
            yield (
                f"'{source.name}' has a tone of {frequency:.5g} Hz, which samples at "
                f"{SAMPLE_RATE:.0f} Hz do not hold"
            )
    for listener in scene.listeners:
        part = listener.body_part
        if part and part not in BODY_PART:
            yield (
                f"'{listener.name}': the body part {part!r} is unknown to devices and formats"
                f"{meant(part, BODY_PART)}"
            )


def _away(item: HapticObject, position: Sequence[float]) -> float:
    """Metres from a position to the box about an object, 0 where that is not more than the box
    measures across."""
    assert item.shape is not None
    pose = pose_matrix(item.pose or Pose())
    local = pose[:3, :3].T @ (np.array(position) - pose[:3, 3])
    low, high = item.shape.local_bounds
    outside = float(np.linalg.norm(local - local.clip(low, high)))
    return outside if outside > np.linalg.norm(high - low) else 0.0
