"""Strict JSON: bounded in size, depth and number of values; NaN, duplicate keys and unpaired
surrogates are errors.

The parser of the standard library accepts some of these. They are replaced by a marker while
parsing; only if there is a marker, the document is searched for it, so that the error gives its
JSON pointer.
"""

from __future__ import annotations

import codecs
import gzip
import json
import re
import zlib
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from ...frozen import frozen
from ...regular_file import open_regular
from .error import FormatError, json_pointer

MAX_BYTES = 256 * 2**20
MAX_DEPTH = 100
MAX_VALUES = 32_000_000
_CHUNK = 2**22
_MARKS = b'"[]{},'
_PLAIN = bytes(set(range(256)) - set(_MARKS))
_NO_NEST = bytes(set(range(256)) - set(b'"[]{}'))
_STEPS = np.zeros(256, dtype=np.int8)
"""By byte: the change of the nesting depth, 1 at an opening and -1 at a closing bracket."""
_STEPS[list(b"[{")], _STEPS[list(b"]}")] = 1, -1

_SURROGATE_ESCAPE = re.compile(rb"\\u[dD][89a-fA-F]")

_BLENDER_FILES = b"BLENDER", b"\x28\xb5\x2f\xfd"
"""How Blender's files begin, plain and compressed (by Zstandard)."""


@frozen
class _Misplaced:
    """Marker of a value that JSON does not allow."""

    reason: str


def read_bytes(path: Path, max_bytes: int = MAX_BYTES) -> bytes:
    """The content of a file, decompressed if its name ends in ``.gz``.

    Raises FormatError if it is larger than ``max_bytes`` after decompression, and OSError.
    """
    with open_regular(path) as file:
        try:
            with gzip.open(file) if path.suffix.lower() == ".gz" else nullcontext(file) as unpacked:
                data = _read_up_to(unpacked, max_bytes + 1)
        except (gzip.BadGzipFile, EOFError, zlib.error) as error:
            raise FormatError(path, "/", f"not a whole gzip file: {error}") from None
    if len(data) > max_bytes:
        raise FormatError(path, "/", f"larger than {max_bytes / 2**20:.6g} MiB")
    return data


def _read_up_to(file: BinaryIO | gzip.GzipFile, most: int) -> bytes:
    """Read at most ``most`` bytes in chunks, since a single read would allocate ``most`` bytes."""
    pieces = []
    while most > 0 and (piece := file.read(min(_CHUNK, most))):
        pieces.append(piece)
        most -= len(piece)
    return b"".join(pieces)


def _without_escapes(data: bytes) -> bytes:
    """The text with escaped backslashes and quotes replaced, of the same length: every quote in it
    delimits a string."""
    return data.replace(b"\\\\", b"__").replace(b'\\"', b"__") if b"\\" in data else data


def parse_json(data: bytes, file: str | Path) -> Any:
    """The document in ``data``, UTF-8 with or without byte order mark. Raises FormatError."""
    if not data.strip():
        raise FormatError(file, "/", "the file is empty")
    if data.startswith(_BLENDER_FILES):
        raise FormatError(
            file, "/", "a Blender file, no JSON: export its haptic scene, or use trace or bake"
        )
    try:
        text = data.removeprefix(codecs.BOM_UTF8).decode()
    except UnicodeDecodeError as error:
        raise FormatError(
            file, "/", f"not UTF-8: byte {error.start} is 0x{data[error.start]:02x}"
        ) from None
    _check_extent(data, file)
    misplaced = False

    def mark(reason: str) -> _Misplaced:
        nonlocal misplaced
        misplaced = True
        return _Misplaced(reason)

    def members(pairs: list[tuple[str, Any]]) -> Any:
        result = dict(pairs)
        if len(result) == len(pairs):
            return result
        keys = [key for key, _ in pairs]
        first = {key: place for place, key in reversed([*enumerate(keys)])}
        return mark(
            f"the key {next(key for place, key in enumerate(keys) if place > first[key])!r} "
            "occurs twice"
        )

    try:
        document = json.loads(
            text,
            object_pairs_hook=members,
            parse_constant=lambda name: mark(f"{name} is not a JSON number"),
        )
    except json.JSONDecodeError as error:
        raise FormatError(
            file, "/", f"not JSON: {error.msg} (line {error.lineno} column {error.colno})"
        ) from None
    except RecursionError:
        raise FormatError(file, "/", "nested too deeply") from None
    except ValueError:
        raise FormatError(file, "/", "a number has too many digits") from None
    if misplaced or _SURROGATE_ESCAPE.search(data):
        _find_misplaced(document, file)
    return document


def read_json(path: str | Path) -> Any:
    """The document in a ``.json`` or ``.json.gz`` file. Raises FormatError or OSError."""
    path = Path(path)
    return parse_json(read_bytes(path), path)


def _check_extent(data: bytes, file: str | Path) -> None:
    """Check depth and number of values before parsing, in chunks to save memory."""
    data = _without_escapes(data)
    may_exceed = len(data) > MAX_VALUES  # each value begins with a byte of its own
    # Without strings and the innermost lists, mostly few brackets are left.
    left = data.translate(None, _NO_NEST).replace(b'""', b"").replace(b"[]", b"")
    if not may_exceed and len(left) < MAX_DEPTH and b'"' not in left:
        return
    depth = values = 0
    is_inside = False
    for start in range(0, len(data), _CHUNK):
        part = data[start : start + _CHUNK]
        codes = np.frombuffer(part.translate(None, _PLAIN), dtype=np.uint8)
        if len(codes) == 0:
            continue
        inside = np.logical_xor.accumulate(codes == ord('"')) ^ is_inside  # a string
        is_inside = bool(inside[-1])
        steps = _STEPS[codes] * ~inside
        if may_exceed:
            values += int(np.count_nonzero((steps > 0) | ((codes == ord(",")) & ~inside)))
            if values > MAX_VALUES:
                raise FormatError(file, "/", f"more than {MAX_VALUES} values")
        depths = depth + steps.cumsum(dtype=np.int64)
        if depths.max() > MAX_DEPTH:
            marked = np.isin(np.frombuffer(part, dtype=np.uint8), list(_MARKS)).nonzero()[0]
            place = start + int(marked[np.argmax(depths > MAX_DEPTH)])
            raise FormatError(file, "/", f"nested deeper than {MAX_DEPTH} levels at byte {place}")
        depth = int(depths[-1])


def _find_misplaced(document: Any, file: str | Path) -> None:
    for parts, value in _walk(document):
        if isinstance(value, _Misplaced):
            raise FormatError(file, json_pointer(parts), value.reason)
        strings = (
            [value] if isinstance(value, str) else list(value) if isinstance(value, dict) else []
        )
        for text in strings:
            if any("\ud800" <= c <= "\udfff" for c in text):
                raise FormatError(file, json_pointer(parts), f"{text!r} has an unpaired surrogate")


def _walk(document: Any) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    """Every value with its keys and indices, in document order."""
    stack: list[tuple[tuple[str | int, ...], Any]] = [((), document)]
    while stack:
        parts, value = stack.pop()
        yield parts, value
        if isinstance(value, dict):
            stack.extend(((*parts, key), member) for key, member in reversed(value.items()))
        elif isinstance(value, list):
            stack.extend(((*parts, i), value[i]) for i in range(len(value) - 1, -1, -1))
