"""File names made from object names: valid on every system, without path separators."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable

LONGEST = 80
"""Maximum number of characters of a file name without its suffix."""

_FORBIDDEN = re.compile(
    r'[<>:"/\\|?*\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069\ufeff\ud800-\udfff]+'
)
_RESERVED = re.compile(
    r"(CON|PRN|AUX|NUL|CONIN\$|CONOUT\$|(COM|LPT)[0-9¹²³])(\..*)?", re.IGNORECASE
)


def file_stem(name: str) -> str:
    """``name`` as a file name without suffix: forbidden characters become ``_``, names reserved by
    Windows get a leading ``_``."""
    stem = _FORBIDDEN.sub("_", unicodedata.normalize("NFC", name))[:LONGEST].strip(" .")
    if not stem or stem.startswith("-") or _RESERVED.fullmatch(stem):
        stem = f"_{stem}"
    return stem


def file_stems(names: Iterable[str]) -> list[str]:
    """File stems that are unique on case-insensitive file systems; equal ones are numbered."""
    stems: list[str] = []
    taken: set[str] = set()
    for name in names:
        stem = first = file_stem(name)
        number = 2
        while stem.casefold() in taken:
            stem = f"{first}_{number}"
            number += 1
        taken.add(stem.casefold())
        stems.append(stem)
    return stems
