"""What in a scene is valid but probably not meant."""

from __future__ import annotations

from collections.abc import Iterator

from ..scene.body import BODY_PART
from ..scene.references import meant
from ..scene.values import HapticScene


def doubts(scene: HapticScene) -> Iterator[str]:
    """A sentence for each listener whose body part no device and no format knows."""
    for listener in scene.listeners:
        part = listener.body_part
        if part and part not in BODY_PART:
            yield (
                f"'{listener.name}': the body part {part!r} is unknown to devices and formats"
                f"{meant(part, BODY_PART)}"
            )
