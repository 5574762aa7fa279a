"""The results of a study as one Parquet table: a row per variant and listener."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from ...core.formats.io.atomic import atomic_file
from ...core.forms import JsonObject
from .study import Value, Variant

_ROWS = 10_000
"""Number of variants in memory at once."""

_RESULT = {
    "frames": pa.int64(),
    "listener": pa.string(),
    "body_part": pa.string(),
    "level": pa.float64(),
    "peak": pa.float64(),
    "impacts": pa.int64(),
    "gains": pa.map_(pa.string(), pa.float64()),
    "silenced": pa.bool_(),
    "threshold": pa.float64(),
    "milliseconds": pa.float64(),
}


def write_table(path: Path, folder: Path, keyed: Sequence[tuple[str, Variant]]) -> None:
    """Write the results of variants in ``folder``, in the given order.

    Columns: ``key``, the varied parameters, ``level`` in dB of the RMS (0 dB: a constant 1; null if
    nothing is felt), ``peak``, ``gains`` (mean over the frames, by persistent source, including the
    amplitude), ``silenced``, ``threshold`` of feeling in dB of the listener's calibrated device
    (null without a calibration), and ``milliseconds`` of tracing a frame.
    """
    varied: dict[str, pa.DataType] = {}
    for _, variant in keyed:
        for name, value in variant.parameters().items():
            varied[name] = _wider(varied.get(name), value)
    schema = pa.schema([("key", pa.string()), *varied.items(), *_RESULT.items()])
    with atomic_file(path) as file, pq.ParquetWriter(file, schema) as writer:
        for first in range(0, len(keyed), _ROWS):
            rows = list(_rows(folder, keyed[first : first + _ROWS], varied))
            writer.write_table(pa.Table.from_pylist(rows, schema))


def read_table(path: Path) -> pa.Table:
    """Read a table. Raises ValueError if it is not the table of a sweep, and OSError."""
    if not path.is_file():
        raise ValueError(f"{path}: there is no such file")
    try:
        table = pq.read_table(path)
    except pa.ArrowInvalid as error:
        raise ValueError(f"{path}: not Parquet: {error}") from None
    missing = [name for name in _RESULT if name not in (*table.column_names, "threshold")]
    if missing:
        raise ValueError(f"{path}: not the table of a sweep: there is no column {missing[0]}")
    return table


def varied_columns(table: pa.Table) -> list[str]:
    """The names of the varied parameters."""
    return [name for name in table.column_names if name != "key" and name not in _RESULT]


def _wider(known: pa.DataType | None, value: Value) -> pa.DataType:
    """The type of a column that holds ``value`` as well."""
    own = {bool: pa.bool_(), int: pa.int64(), float: pa.float64(), str: pa.string()}[type(value)]
    if known is None or known == own:
        return own
    return pa.float64() if {known, own} == {pa.int64(), pa.float64()} else pa.string()


def _rows(
    folder: Path, keyed: Iterable[tuple[str, Variant]], varied: dict[str, pa.DataType]
) -> Iterator[JsonObject]:
    for key, variant in keyed:
        path = folder / "results" / f"{key}.json"
        if not path.exists():
            continue  # it failed
        result = json.loads(path.read_bytes())
        known = variant.parameters()
        parameters = {
            name: str(known[name]) if kind == pa.string() else known[name]
            for name, kind in varied.items()
            if name in known
        }
        for listener in result["listeners"]:
            rms = listener.pop("rms")
            level = 20 * math.log10(rms) if rms > 0 else None
            times = {name: result[name] for name in ("frames", "milliseconds")}
            yield {"key": key, **parameters, **times, **listener, "level": level}
