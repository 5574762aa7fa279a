"""Options of a format, described for menus and the command line."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

Value = bool | int | float | str
_TRUTH = {"true": True, "false": False}


@dataclass(frozen=True, slots=True)
class Option:
    """An option. The type is that of ``default``: bool, int, float, or str with ``choices``. ``minimum`` and ``maximum`` bound numbers."""

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
            return self.checked(_TRUTH[text.lower()] if isinstance(self.default, bool) else type(self.default)(text))
        except (KeyError, ValueError):
            raise ValueError(f"{self.name}: must be {self._range()}, not {text!r}") from None

    def checked(self, value: Value) -> Value:
        """Return ``value`` if it is allowed. Raises ValueError that names the option."""
        if isinstance(self.default, bool):
            good = isinstance(value, bool)
        elif isinstance(self.default, str):
            good = value in self.choices
        else:
            good = isinstance(value, int | float) and not isinstance(value, bool) and self.minimum <= value <= self.maximum
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


def complete(options: Sequence[Option], chosen: Mapping[str, Value]) -> dict[str, Any]:
    """The value of every option: the chosen one, checked, or the default. Raises ValueError for an unknown option."""
    known = {option.name: option for option in options}
    for name in chosen:
        if name not in known:
            raise ValueError(f"{name}: unknown option" + (f"; known are {', '.join(known)}" if known else "; there are none"))
    return {name: option.checked(chosen.get(name, option.default)) for name, option in known.items()}
