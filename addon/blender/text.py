"""Texts in panels."""

from __future__ import annotations

import textwrap


def wrapped(text: str, width: int = 40) -> list[str]:
    """A sentence as lines that fit into the sidebar."""
    return textwrap.wrap(text[:1].upper() + text[1:], width)
