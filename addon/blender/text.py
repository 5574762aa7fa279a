"""Texts in panels and over viewports: their widths, lines and shortened forms."""

from __future__ import annotations

import re
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


_SIDE = re.compile(r"[._ -](l|r|left|right)([._ -]\d+)*$", re.IGNORECASE)
"""The side of the body at the end of a name, and the number that Blender adds to it: ".L.001"."""


def shortened(words: str, width: float, size: float, measure: Measure) -> str:
    """A text of at most ``width`` pixels, shortened in the middle if it is longer, and before the
    side of the body at its end if that has room; "" if not even its ends fit."""
    if measure(words, size) <= width:
        return words
    side = _SIDE.search(words)
    least = len(side.group()) if side is not None else 0
    for count in range(len(words) - 1, 1, -1):
        end = max(count // 2, least if count > least else 0)
        cut = f"{words[: count - end]}{ELLIPSIS}{words[-end:]}"
        if measure(cut, size) <= width:
            return cut
    return ""
