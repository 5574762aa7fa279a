"""Tracing suspended while the add-on itself steps frames, so that a bake or an export is not traced twice."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

_depth = 0


def is_suspended() -> bool:
    """True inside `suspended`."""
    return _depth > 0


@contextmanager
def suspended() -> Iterator[None]:
    """Handlers do nothing inside; may be nested."""
    global _depth
    _depth += 1
    try:
        yield
    finally:
        _depth -= 1
