"""Declarations of the fields of scene values and of signals: what a field may be, and how it is
presented.

A dataclass declares a field by its default and its meaning:

    gain: float = number(1.0, "Gain", "Factor of this listener's mixed signal", 0.0, 1e9,
        soft=(0.0, 2.0))

From the declaration follow the check of its values, its JSON Schema, and in Blender its property,
its tooltip, and its place in a panel. A field with a label has a property in Blender; one without a
label stands in files only.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import MISSING, field, fields
from enum import StrEnum
from functools import cache
from typing import Any

from .forms import JsonObject
from .frozen import frozen

MOST = 1e9
"""Largest magnitude of a number without a limit of its own."""
_MOST_IN_CURVE = 1e6
_KEY = "declaration"
_RANGE = {True: "exclusiveMinimum", False: "minimum"}


@frozen(kw_only=True)
class Declaration:
    """What all kinds of fields have.

    ``key``: the field's name in files, "" for its own. ``label``: its name in panels, "" for a
    field without a property; ``context``: that of the label's translation, if it has another
    meaning elsewhere. ``about``: its meaning, as tooltip and in the schema. ``shown``: the value of
    a new property, None for the default. ``optional``: None, or no numbers, is a value, too.
    ``required``: files always have it. ``animated``: the property can have keyframes.
    """

    key: str = ""
    label: str = ""
    context: str = ""
    about: str = ""
    shown: Any = None
    optional: bool = False
    required: bool = False
    animated: bool = True

    def checked(self, value: Any) -> Any:
        """The value in its own type. Raises ValueError with the reason if it is not allowed."""
        return value

    def schema(self) -> JsonObject:
        """The JSON Schema of a value other than None."""
        raise NotImplementedError


@frozen(kw_only=True)
class Number(Declaration):
    """A number from ``low``, or ``above`` it, to ``high``; ``whole``: an integer. ``soft``: range
    of sliders. ``digits``: decimal places shown. ``unit``: its unit."""

    low: float
    high: float
    soft: tuple[float, float] | None = None
    unit: str = ""
    above: bool = False
    whole: bool = False
    digits: int | None = None

    def checked(self, value: Any) -> Any:
        if not (self.low < value if self.above else self.low <= value) or not value <= self.high:
            span = (
                f"above {self.low:g} and at most {self.high:g}"
                if self.above
                else f"from {self.low:g} to {self.high:g}"
            )
            raise ValueError(f"must be {span}{self.unit and ' '}{self.unit}, got {value!r:.40}")
        if self.whole and value % 1 != 0:
            raise ValueError(f"must be a whole number, not {value:g}")
        return int(value) if self.whole else value

    def schema(self) -> JsonObject:
        return {
            "type": "integer" if self.whole else "number",
            _RANGE[self.above]: self.low,
            "maximum": self.high,
        }


@frozen(kw_only=True)
class Numbers(Number):
    """A fixed ``count`` of numbers, such as a position."""

    count: int

    def checked(self, value: Any) -> Any:
        numbers = tuple(map(float, value))
        if len(numbers) != self.count or not all(map(math.isfinite, numbers)):
            raise ValueError(f"expected {self.count} finite numbers, got {numbers!r}")
        if self.high < MOST:  # what is further away than in any file is found and heard as well
            for value in numbers:
                Number.checked(self, value)
        return numbers

    def schema(self) -> JsonObject:
        return {
            "type": "array",
            "minItems": self.count,
            "maxItems": self.count,
            "items": Number.schema(self),
        }


@frozen(kw_only=True)
class Curve(Declaration):
    """Numbers above 0 by rising frequency: pairs ``((hertz, number), ...)``, as a text such as "40
    3.2, 160 14"."""

    most: int = 100

    def checked(self, value: Any) -> Any:
        points = tuple((float(hertz), float(number)) for hertz, number in value)
        hertz = [place for place, _ in points]
        if len(points) > self.most or hertz != sorted(set(hertz)):
            raise ValueError(f"expected up to {self.most} points by rising frequency")
        if not all(0 < number <= _MOST_IN_CURVE for point in points for number in point):
            raise ValueError(f"numbers must be above 0 and at most {_MOST_IN_CURVE:g}")
        return points

    def schema(self) -> JsonObject:
        number = {"type": "number", "exclusiveMinimum": 0, "maximum": _MOST_IN_CURVE}
        point = {"type": "array", "minItems": 2, "maxItems": 2, "items": number}
        return {"type": "array", "maxItems": self.most, "items": point}

    @staticmethod
    def text(value: Any) -> str:
        """The points as text."""
        return ", ".join(f"{hertz:.6g} {number:.6g}" for hertz, number in value)

    def read(self, text: str) -> Any:
        """The points of a text. Raises ValueError with the reason."""
        try:
            points = [tuple(map(float, part.split())) for part in text.split(",") if part.strip()]
            return self.checked(points)
        except ValueError as error:
            raise ValueError(
                f"{self.label}: {text!r} is not pairs of hertz and number, "
                f'such as "40 3.2, 160 14" ({error})'
            ) from None


@frozen(kw_only=True)
class Switch(Declaration):
    """True or false."""

    def checked(self, value: Any) -> Any:
        if not isinstance(value, bool):
            raise ValueError(f"must be true or false, got {value!r}")
        return value

    def schema(self) -> JsonObject:
        return {"type": "boolean"}


@frozen(kw_only=True)
class Choice(Declaration):
    """One of ``items``: the label and the meaning of each value. ``kind``: the enumeration that the
    values are converted to. ``open``: other texts are values, too."""

    items: Mapping[str, tuple[str, str]]
    kind: type[StrEnum] | None = None
    open: bool = False

    def checked(self, value: Any) -> Any:
        if not self.open and value not in self.items:
            raise ValueError(f"must be one of {', '.join(map(str, self.items))}, got {value!r}")
        return value if self.kind is None else self.kind(value)

    def schema(self) -> JsonObject:
        return (
            {"type": "string", "maxLength": 255}
            if self.open
            else {"enum": list(map(str, self.items))}
        )


@frozen(kw_only=True)
class Text(Declaration):
    """A text of ``least`` to ``most`` characters."""

    least: int = 0
    most: int = 255

    def checked(self, value: Any) -> Any:
        if not isinstance(value, str) or len(value) < self.least:
            raise ValueError(f"expected a {'name' if self.least else 'text'}, got {value!r}")
        return value

    def schema(self) -> JsonObject:
        return {
            "type": "string",
            **({"minLength": self.least} if self.least else {}),
            "maxLength": self.most,
        }


@frozen(kw_only=True)
class Part(Declaration):
    """A value with its own definition ``ref`` in the schema, which also checks it; with ``most``, a
    list of up to ``most`` of them."""

    ref: str
    most: int = 0

    def schema(self) -> JsonObject:
        ref = {"$ref": f"#/$defs/{self.ref}"}
        return {"type": "array", "maxItems": self.most, "items": ref} if self.most else ref


def declare(default: Any, declaration: Declaration) -> Any:
    """A dataclass's field with its declaration; `MISSING`: without a default."""
    return field(default=default, metadata={_KEY: declaration})


def number(
    default: Any, label: str, about: str, low: float, high: float = MOST, **more: Any
) -> Any:
    """The field of a number.

    Args:
        default: the value of new items.
        label: name in panels, "" for a field without a property.
        about: meaning, as tooltip and in the schema.
        low: least value.
        high: largest value.
        more: further fields of the declaration.
    """
    return declare(default, Number(label=label, about=about, low=low, high=high, **more))


def share(default: Any, label: str, about: str, **more: Any) -> Any:
    """The field of a number from 0 to 1."""
    return number(default, label, about, 0.0, 1.0, **more)


def numbers(
    default: Any,
    label: str,
    about: str,
    count: int,
    low: float = -MOST,
    high: float = MOST,
    **more: Any,
) -> Any:
    """The field of ``count`` numbers, each from ``low`` to ``high``; the rest as in `number`."""
    more |= {"label": label, "about": about}
    return declare(default, Numbers(count=count, low=low, high=high, **more))


def curve(default: Any, label: str, about: str, **more: Any) -> Any:
    """The field of a `Curve`."""
    return declare(default, Curve(label=label, about=about, **more))


def switch(default: bool, label: str, about: str, **more: Any) -> Any:
    """The field of a `Switch`."""
    return declare(default, Switch(label=label, about=about, **more))


def choice(
    default: Any, label: str, about: str, items: Mapping[Any, tuple[str, str]], **more: Any
) -> Any:
    """The field of a `Choice`; ``items`` by members of an enumeration, or by texts. The rest as in
    `number`."""
    kinds = {type(value) for value in items} - {str}
    more |= {"label": label, "about": about}
    return declare(default, Choice(items=items, kind=next(iter(kinds), None), **more))


def text(default: Any, label: str, about: str, **more: Any) -> Any:
    """The field of a `Text`."""
    return declare(default, Text(label=label, about=about, **more))


def name_of(about: str, default: Any = MISSING, **more: Any) -> Any:
    """The field of a name: of the item, or of another one."""
    return text(default, "", about, least=1, **more)


def part(default: Any, ref: str, about: str, most: int = 0, **more: Any) -> Any:
    """The field of a `Part`."""
    return declare(default, Part(ref=ref, about=about, most=most, **more))


def extras() -> Any:
    """The field of any further data of an item."""
    about = part(MISSING, "extras", "Anything else: kept as it is").metadata
    return field(default_factory=dict, hash=False, metadata=about)


@cache
def declared(cls: type) -> Mapping[str, Declaration]:
    """The declarations of the fields of a class, in their order."""
    return {item.name: item.metadata[_KEY] for item in fields(cls) if _KEY in item.metadata}


def shown(cls: type) -> dict[str, Declaration]:
    """The declarations of the fields of a class that have a property in Blender."""
    return {key: declaration for key, declaration in declared(cls).items() if declaration.label}


@cache
def _checked(cls: type) -> list[tuple[str, Declaration]]:
    """The declared fields of a class whose values are checked."""
    return [
        (key, item)
        for key, item in declared(cls).items()
        if type(item).checked is not Declaration.checked
    ]


def check(item: Any) -> None:
    """Check all declared fields of a new item and convert their values to their types. Raises
    ValueError that names the field."""
    for key, declaration in _checked(item.__class__):
        value = getattr(item, key)
        if declaration.optional and (value is None or value == ()):
            continue
        try:
            checked = declaration.checked(value)
        except (TypeError, ValueError) as error:
            raise ValueError(f"{declaration.key or key}: {error}") from None
        if checked is not value:
            object.__setattr__(item, key, checked)


class Declared:
    """Base of dataclasses whose declared fields are checked by the constructor, see `check`."""

    __slots__ = ()

    def __post_init__(self) -> None:
        check(self)


@cache
def default_of(cls: type, key: str) -> Any:
    """The default of a field, `MISSING` without one."""
    entry = next(entry for entry in fields(cls) if entry.name == key)
    return entry.default if entry.default_factory is MISSING else entry.default_factory()


def schema_of(cls: type) -> JsonObject:
    """The JSON Schema of the items of a class: an object with its declared fields."""
    known = declared(cls)
    return {
        "type": "object",
        "properties": {
            item.key or name: _described(item, default_of(cls, name))
            for name, item in known.items()
        },
        "required": [
            item.key or name
            for name, item in known.items()
            if item.required or default_of(cls, name) is MISSING
        ],
        "additionalProperties": False,
    }


def _described(declaration: Declaration, default: Any) -> JsonObject:
    """The schema of a field with its description."""
    sentences = [declaration.about]
    if isinstance(declaration, Choice):
        sentences += [f'"{value}": {about}' for value, (_, about) in declaration.items.items()]
    if isinstance(declaration, Number) and declaration.unit:
        sentences.append(f"Unit: {declaration.unit}")
    is_nullable = declaration.optional and default not in (None, ())
    if is_nullable:
        sentences.append("null: none, which Blender shows as 0")
    if isinstance(default, bool | int | float | str | tuple) and default != ():
        sentences.append(f"Default: {_json(default)}")
    found = declaration.schema()
    if is_nullable:
        found["type"] = [found["type"], "null"]
    return {"description": ". ".join(sentences) + ".", **found}


def _json(value: Any) -> str:
    return json.dumps(list(value) if isinstance(value, tuple) else value)
