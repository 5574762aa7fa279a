"""Writing JSON: compact text, and small indented documents."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from .atomic import write_text


def compact(value: Any) -> str:
    """JSON without spaces. Raises ValueError for NaN and infinity."""
    return _ENCODER.encode(value)


_ENCODER = json.JSONEncoder(ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def write_compact(path: Path, value: Any) -> Path:
    """Write a document without spaces in one step."""
    return write_text(path, [compact(value), "\n"])


def write_json(path: Path, value: Any) -> Path:
    """Write an indented document in one step."""
    return write_text(
        path, [json.dumps(value, ensure_ascii=False, allow_nan=False, indent=1), "\n"]
    )
