"""The error of all readers: file, place and reason in one line."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from ...scene.references import PlacedError


def json_pointer(parts: Iterable[str | int]) -> str:
    """The JSON pointer (RFC 6901) to the value reached by keys and indices; ``/`` for the document itself."""
    pointer = "".join("/" + str(part).replace("~", "~0").replace("/", "~1") for part in parts)
    return pointer or "/"


class FormatError(ValueError):
    """``FILE: /json/pointer: reason``, without the pointer where it is the whole document.

    ``pointer`` is a JSON pointer, or a place such as ``byte 12`` in a file that is not JSON.
    """

    def __init__(self, file: str | Path, pointer: str, reason: str) -> None:
        text = f"{file}: {reason}" if pointer == "/" else f"{file}: {pointer}: {reason}"
        super().__init__("".join(c if c.isprintable() else repr(c)[1:-1] for c in text))
        self.file = str(file)
        self.pointer = pointer
        self.reason = reason


@contextmanager
def errors_in(file: str | Path) -> Iterator[None]:
    """Report a PlacedError raised in the block as FormatError of ``file``."""
    try:
        yield
    except PlacedError as error:
        raise FormatError(file, json_pointer(error.place), error.reason) from None
