"""Paths relative to the file that are stored with objects and scenes. Blender keeps those of its
own properties right where a file is saved in another folder or appended, but not these."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import bpy
from bpy.types import ID, Object, Scene

_STATE = ("is_edited", "fault")
"""What the edit of a sound's path sets, and another way to the same file does not change."""


def follow(blocks: Iterable[ID], before: str, after: str) -> None:
    """Let the relative paths of objects and scenes lead to the same files from the file ``after``
    as they did from ``before``; "" stands for one that was never saved."""
    start, end = str(Path(before).parent), str(Path(after).parent)
    if not before or start == end:
        return
    for block in blocks:
        if not isinstance(block, Object | Scene) or not block.is_editable:
            continue
        for owner, name in _paths(block.haptics):
            stored = getattr(owner, name)
            if not stored.startswith("//"):
                continue
            full = bpy.path.abspath(stored, start=start)
            state = {key: getattr(owner, key) for key in _STATE if hasattr(owner, key)}
            setattr(owner, name, bpy.path.relpath(full, start=end) if after else full)
            for key, value in state.items():
                setattr(owner, key, value)


def _paths(haptics: Any) -> Iterator[tuple[Any, str]]:
    """The groups and properties that hold a path."""
    if isinstance(haptics.id_data, Object):
        yield haptics.source, "filepath"
        yield haptics.source.sound, "filepath"
        return
    for row in haptics.impact_table.items:
        yield row, "filepath"
