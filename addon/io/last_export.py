"""The files of the last export of tracks, with their measured losses, for the panel."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ...core.formats.registry import Written

written: Written | None = None
