"""The formats by name, with their options, described for menus and command lines. Does not import
the modules that write and read them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import field
from pathlib import Path
from types import MappingProxyType

from ...declaration import Choice, Declaration, Number, Switch
from ...forms import JsonObject
from ...frozen import frozen
from ...scene import references

MAX_SAMPLE_RATE = 192_000
"""Largest sample rate of tracks [Hz]."""


Value = bool | int | float | str


def value_of(option: Declaration, text: str) -> Value:
    """The value of an option in a text. Raises ValueError with the reason."""
    value: Value = text
    if isinstance(option, Switch):
        value = {"true": True, "false": False}.get(text.lower(), text)
    elif isinstance(option, Number):
        try:
            value = int(text) if option.whole else float(text)
        except ValueError:
            kind = "whole number" if option.whole else "number"
            raise ValueError(f"must be a {kind}, got {text!r}") from None
    checked: Value = option.checked(value)
    return checked


def complete(options: Mapping[str, Declaration], chosen: Mapping[str, Value]) -> JsonObject:
    """The value of every option: the chosen one, checked, or the default. Raises ValueError for an
    unknown option."""
    values = {name: option.shown for name, option in options.items()}
    for name, value in chosen.items():
        if name not in options:
            raise ValueError(
                f"{name}: unknown option"
                + (f"; known are {', '.join(options)}" if options else "; there are none")
            )
        try:
            values[name] = options[name].checked(value)
        except (TypeError, ValueError) as error:
            raise ValueError(f"{name}: {error}") from None
    return values


@frozen
class Format:
    """``label``: its name in menus. ``suffix``: of its files. ``module``: the module in
    `core.formats` that writes and, if it ``is_read``, reads it. ``files``: patterns of the names of
    its files. ``carries``: what they hold. ``options``: by their names."""

    name: str
    label: str
    suffix: str
    module: str
    files: str
    carries: str
    is_read: bool = False
    options: Mapping[str, Declaration] = field(default_factory=dict)


def _format(form: JsonObject) -> Format:
    options = {item.pop("name"): _option(item) for item in form.pop("options", ())}
    return Format(**form, options=options)


def _option(form: JsonObject) -> Declaration:
    """The declaration of an option: of the kind of its default."""
    match form["shown"]:
        case bool():
            return Switch(**form)
        case str():
            return Choice(**form | {"items": {value: (value, "") for value in form["items"]}})
        case int():
            return Number(whole=True, **form)
        case _:
            return Number(digits=3, **form)


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
