"""Writing JSON: compact text, and small indented documents."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import FloatArray
from .atomic import write_text


def compact(value: Any) -> str:
    """JSON without spaces. Raises ValueError for NaN and infinity."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def json_rows(keys: Sequence[str], *columns: FloatArray) -> list[dict[str, Any]]:
    """Objects with the same keys, from a column (n,) of numbers per key."""
    return [dict(zip(keys, row, strict=True)) for row in np.column_stack(columns).tolist()]


def write_json(path: Path, value: Any) -> Path:
    """Write an indented document in one step."""
    return write_text(path, [json.dumps(value, ensure_ascii=False, allow_nan=False, indent=1), "\n"])
