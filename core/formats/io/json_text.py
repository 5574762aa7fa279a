"""Writing JSON: compact text, and small indented documents."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .atomic import write_text


def compact(value: Any) -> str:
    """JSON without spaces. Raises ValueError for NaN and infinity."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def json_rows(keys: Sequence[str], *columns: Sequence[float]) -> str:
    """JSON of a list of objects with the same keys, from a column of finite numbers per key."""
    form = "{" + ",".join(f'"{key}":%r' for key in keys) + "}"
    return "[" + ",".join([form % row for row in zip(*columns, strict=True)]) + "]"


def write_json(path: Path, value: Any) -> Path:
    """Write an indented document in one step."""
    return write_text(path, [json.dumps(value, ensure_ascii=False, allow_nan=False, indent=1), "\n"])
