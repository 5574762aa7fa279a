"""The formats by name, with the descriptions for menus and command lines. Does not import the modules that write and read them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ...scene import references
from .options import Option

MAX_SAMPLE_RATE = 192_000
"""Largest sample rate of tracks [Hz]."""


@dataclass(frozen=True, slots=True)
class Format:
    """``label``: its name in menus. ``suffix``: of its files. ``module``: the module in `core.formats` that writes and reads it."""

    name: str
    label: str
    suffix: str
    module: str
    options: tuple[Option, ...] = ()


def _format(form: dict[str, Any]) -> Format:
    options = [Option(**{**item, "choices": tuple(item.get("choices", ()))}) for item in form.pop("options", ())]
    return Format(**form, options=tuple(options))


FORMATS: Mapping[str, Format] = MappingProxyType(
    {form["name"]: _format(form) for form in json.loads(Path(__file__).with_name("formats.json").read_text("utf-8"))}
)
"""The formats by name."""

READERS: Mapping[str, str] = MappingProxyType(
    {".wav": "wav", ".hjif": "hjif", ".haptic": "haptic", ".ahap": "ahap", ".haps": "wyvrn", ".tact": "tact"}
)
"""The format of each file suffix that can be imported."""


def named(name: str) -> Format:
    """A format by its name. Raises ValueError, which lists the names, for any other."""
    return references.named(name, FORMATS, "format")
