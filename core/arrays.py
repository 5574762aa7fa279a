"""Array types of all stages, operations on runs, groups and graphs of numbers, and on records.
Docstrings give shapes, as in ``(n, 3)``.

A record is a dataclass whose fields are arrays with the same last axis, along which its rows lie,
or None.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields, replace
from functools import cache
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
_Record = TypeVar("_Record")


def runs(numbers: IntArray) -> tuple[IntArray, IntArray]:
    """Start indices and lengths of the runs of equal ``numbers`` (n,)."""
    begins = np.ones(len(numbers), dtype=np.bool_)
    np.not_equal(numbers[1:], numbers[:-1], out=begins[1:])
    begin = begins.nonzero()[0]
    size = np.empty_like(begin)
    np.subtract(begin[1:], begin[:-1], out=size[:-1])
    size[-1:] = len(numbers) - begin[-1:]
    return begin, size


def ranges(first: IntArray, size: IntArray) -> IntArray:
    """The numbers ``first[k], first[k] + 1, ...``, ``size[k]`` of them for each k, concatenated."""
    return np.asarray(np.arange(size.sum()) + (first - size.cumsum() + size).repeat(size))


def portions(ends: IntArray, most: int) -> list[slice]:
    """Items in order, divided into groups whose sizes add up to about ``most``; the sizes of the
    first to the k-th item add up to ``ends[k]``."""
    total = int(ends[-1]) if len(ends) else 0
    if total <= most:
        return [slice(0, len(ends))]
    cuts = ends.searchsorted(np.arange(most, total, most), side="right")
    return [slice(*cut) for cut in pairwise([0, *sorted({*cuts.tolist()} - {0}), len(ends)])]


def among(numbers: IntArray, ordered: IntArray) -> BoolArray:
    """Which ``numbers`` (k,) are contained in ``ordered``, which ascend."""
    if len(ordered) == 0:
        return np.zeros(len(numbers), dtype=np.bool_)
    if np.array_equal(numbers, ordered):
        return np.ones(len(numbers), dtype=np.bool_)
    return np.asarray(ordered.take(np.searchsorted(ordered, numbers), mode="clip") == numbers)


def differing(one: Any, other: Any, names: Sequence[str]) -> BoolArray:
    """In which rows (n,) some of the arrays ``names`` of two values differ; NaN is like NaN."""
    found = np.zeros(len(getattr(one, names[0])), dtype=np.bool_)
    for name in names:
        a, b = getattr(one, name).reshape(-1), getattr(other, name).reshape(-1)
        unlike = np.flatnonzero(a != b)
        unlike = unlike[~(np.isnan(a[unlike]) & np.isnan(b[unlike]))]
        found[unlike // max(1, len(a) // max(1, len(found)))] = True
    return found


def with_rows(value: _Record, names: Sequence[str], rows: IntArray | slice, found: Any) -> _Record:
    """A value whose arrays ``names`` have in some ``rows``, along their first axis, what was
    ``found``. None, and arrays without a change, stay."""
    changed = {}
    for name in names:
        known, new = getattr(value, name), getattr(found, name)
        if known is not None and not np.array_equal(known[rows], new):
            changed[name] = known.copy()
            changed[name][rows] = new
    record: Any = value
    result: _Record = replace(record, **changed)
    return result


def added_by(number: IntArray, values: FloatArray, count: int) -> FloatArray:
    """Sums (..., count) of values (..., n) by their ``number`` (n,)."""
    rows = values.reshape(math.prod(values.shape[:-1]), values.shape[-1])
    sums = np.array(
        [np.bincount(number, weights=row, minlength=count) for row in rows],
        dtype=np.float64,
    )
    return sums.reshape(*values.shape[:-1], count)


def connected(pairs: IntArray, count: int) -> IntArray:
    """For each of ``count`` vertices the lowest number in its connected component; ``pairs`` (k, 2)
    are the edges."""
    label = np.arange(count)
    one, other = pairs.T
    while ((a := label.take(one)) != (b := label.take(other))).any():
        lower = np.minimum(a, b)
        np.minimum.at(label, a, lower)
        np.minimum.at(label, b, lower)
        while ((further := label.take(label)) != label).any():
            label = further
    return label


@cache
def _names(record: type) -> tuple[str, ...]:
    """The names of the fields of a kind of record."""
    return tuple(f.name for f in fields(record))


def _values(record: Any) -> list[Any]:
    kind: Any = type(record)
    return [getattr(record, name) for name in _names(kind)]


def chosen_of(record: _Record, rows: IntArray | BoolArray) -> _Record:
    """Some of the rows of a record."""
    if rows.dtype == np.bool_:
        rows = rows.nonzero()[0]
    return type(record)(
        *(None if value is None else value.take(rows, axis=-1) for value in _values(record))
    )


def some_of(record: _Record, rows: BoolArray) -> _Record:
    """Some of the rows of a record; the record itself if that is all of them."""
    return record if rows.all() else chosen_of(record, rows)


def part_of(record: _Record, rows: slice) -> _Record:
    """A run of the rows of a record, not copied."""
    return type(record)(*(None if value is None else value[..., rows] for value in _values(record)))


def taken(values: Any, rows: IntArray | BoolArray) -> Any:
    """``values[..., rows]``, one row beside the next in memory: indexing would put the rows first,
    and what is computed of them would take several times as long."""
    return values.take(rows.nonzero()[0] if rows.dtype == np.bool_ else rows, axis=-1)


def carried(values: Any, before: IntArray, fresh: Any) -> Any:
    """``values[..., before]``, and ``fresh`` where ``before`` is -1."""
    found = np.full((*values.shape[:-1], len(before)), fresh, dtype=values.dtype)
    known = before >= 0
    found[..., known] = values[..., before[known]]
    return found


def joined(records: Sequence[_Record]) -> _Record:
    """The rows of several records, one after the other."""
    if len(records) == 1:
        return records[0]
    return type(records[0])(
        *(
            None if parts[0] is None else np.concatenate(parts, axis=-1)
            for parts in zip(*map(_values, records), strict=True)
        )
    )


def replace_rows(record: _Record, rows: IntArray, by: _Record) -> None:
    """Replace some of the rows of a record."""
    for values, others in zip(_values(record), _values(by), strict=False):  # ``by`` may know more
        values[..., rows] = others
