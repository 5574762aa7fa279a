"""The error of all readers: file, place and reason in one line."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from ...scene.references import PlacedError


def json_pointer(parts: Iterable[str | int]) -> str:
    """The JSON pointer (RFC 6901) to the value reached by keys and indices; ``/`` for the document
    itself."""
    pointer = "".join("/" + str(part).replace("~", "~0").replace("/", "~1") for part in parts)
    return pointer or "/"


def _shortened(text: str, most: int) -> str:
    """Beginning and end of a text, which may contain names from the file, at most ``most``
    characters together."""
    return text if len(text) <= most else f"{text[: most // 2]} … {text[3 - most // 2 :]}"


class FormatError(ValueError):
    """``FILE: /json/pointer: reason``, without the pointer if it is the whole document; long names
    in either are shortened.

    ``pointer`` is a JSON pointer, or a place such as ``byte 12`` in a file that is not JSON.
    """

    def __init__(self, file: str | Path, pointer: str, reason: str) -> None:
        place = _shortened(pointer, 200)
        why = _shortened(reason, 300)
        text = f"{file}: {why}" if pointer == "/" else f"{file}: {place}: {why}"
        super().__init__("".join(c if c.isprintable() else repr(c)[1:-1] for c in text))
        self.file: str = str(file)
        self.pointer = pointer
        self.reason = reason


@contextmanager
def errors_in(file: str | Path) -> Iterator[None]:
    """Report a PlacedError raised in the block as FormatError of ``file``."""
    try:
        yield
    except PlacedError as error:
        raise FormatError(file, json_pointer(error.place), error.reason) from None
