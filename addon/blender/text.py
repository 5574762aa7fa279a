"""Texts in panels and over viewports: their widths, lines and shortened forms."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from functools import lru_cache

import blf

Measure = Callable[[str, float], float]
"""Width in pixels of a text at a size in pixels."""
ELLIPSIS = "…"


def wrapped(text: str, width: int = 40) -> list[str]:
    """A sentence as lines that fit into the sidebar."""
    return textwrap.wrap(text[:1].upper() + text[1:], width)


@lru_cache(maxsize=4096)
def text_width(words: str, size: float) -> float:
    """Width of a text in Blender's own font [pixels]."""
    blf.size(0, size)
    return float(blf.dimensions(0, words)[0])


def shortened(words: str, width: float, size: float, measure: Measure) -> str:
    """A text of at most ``width`` pixels, shortened in the middle if it is longer; "" if not even its ends fit."""
    if measure(words, size) <= width:
        return words
    for count in range(len(words) - 1, 1, -1):
        cut = f"{words[: (count + 1) // 2]}{ELLIPSIS}{words[-(count // 2) :]}"
        if measure(cut, size) <= width:
            return cut
    return ""
