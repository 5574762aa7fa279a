"""The formats by name, with their options, described for menus and command lines. Does not import
the modules that write and read them."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from ...forms import JsonObject
from ...frozen import frozen
from ...scene import references

MAX_SAMPLE_RATE = 192_000
"""Largest sample rate of tracks [Hz]."""


Value = bool | int | float | str
_TRUTH = {"true": True, "false": False}


@frozen
class Option:
    """An option. The type is that of ``default``: bool, int, float, or str with ``choices``.
    ``minimum`` and ``maximum`` bound numbers."""

    name: str
    default: Value
    label: str
    description: str
    choices: tuple[str, ...] = ()
    minimum: float = -math.inf
    maximum: float = math.inf

    def parse(self, text: str) -> Value:
        """Parse ``text``. Raises ValueError that names the option."""
        try:
            return self.checked(
                _TRUTH[text.lower()] if isinstance(self.default, bool) else type(self.default)(text)
            )
        except (KeyError, ValueError):
            raise ValueError(f"{self.name}: must be {self._range()}, not {text!r}") from None

    def checked(self, value: Value) -> Value:
        """Return ``value`` if it is allowed. Raises ValueError that names the option."""
        if isinstance(self.default, bool):
            good = isinstance(value, bool)
        elif isinstance(self.default, str):
            good = value in self.choices
        else:
            good = (
                isinstance(value, int | float)
                and not isinstance(value, bool)
                and self.minimum <= value <= self.maximum
            )
            good = good and (isinstance(self.default, float) or isinstance(value, int))
        if not good:
            raise ValueError(f"{self.name}: must be {self._range()}, not {value!r}")
        return value

    def _range(self) -> str:
        if isinstance(self.default, bool):
            return "true or false"
        if self.choices:
            return "one of " + ", ".join(self.choices)
        kind = "a whole number" if isinstance(self.default, int) else "a number"
        return f"{kind} from {self.minimum:g} to {self.maximum:g}"


def complete(options: Sequence[Option], chosen: Mapping[str, Value]) -> JsonObject:
    """The value of every option: the chosen one, checked, or the default. Raises ValueError for an
    unknown option."""
    known = {option.name: option for option in options}
    for name in chosen:
        if name not in known:
            raise ValueError(
                f"{name}: unknown option"
                + (f"; known are {', '.join(known)}" if known else "; there are none")
            )
    return {
        name: option.checked(chosen.get(name, option.default)) for name, option in known.items()
    }


@frozen
class Format:
    """``label``: its name in menus. ``suffix``: of its files. ``module``: the module in
    `core.formats` that writes and, if it ``is_read``, reads it. ``files``: patterns of the names of
    its files. ``carries``: what they hold."""

    name: str
    label: str
    suffix: str
    module: str
    files: str
    carries: str
    is_read: bool = False
    options: tuple[Option, ...] = ()


def _format(form: JsonObject) -> Format:
    options = [
        Option(**{**item, "choices": tuple(item.get("choices", ()))})
        for item in form.pop("options", ())
    ]
    return Format(**form, options=tuple(options))


FORMATS: Mapping[str, Format] = MappingProxyType(
    {
        form["name"]: _format(form)
        for form in json.loads(Path(__file__).with_name("formats.json").read_text("utf-8"))
    }
)
"""The formats by name."""

READERS: Mapping[str, str] = MappingProxyType(
    {form.suffix: form.name for form in FORMATS.values() if form.is_read and form.name != "scene"}
)
"""The format of each suffix of files from which a vibration can be read."""


def named(name: str) -> Format:
    """A format by its name. Raises ValueError, which lists the names, for any other."""
    return references.named(name, FORMATS, "format")
