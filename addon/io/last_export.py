"""The files of the last export of tracks, with their measured losses, for the panel."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..changes.events import file_changed

if TYPE_CHECKING:
    from ...core.formats.registry import Written

written: Written | None = None


def _forget() -> None:
    global written
    written = None


file_changed.subscribe(_forget)
