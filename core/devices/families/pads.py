"""Gamepads with two motors whose reports have a fixed layout, from a file `pads.json`.

A layout is the bytes of a report in hexadecimal, with ``sequence`` for the lower byte of the
report's number, and ``left`` and ``right`` with the format of their amplitudes: ``8``, ``5``: the
upper bits of the 16-bit value; ``16``: all of it, little-endian; ``%``: percent. Reports are padded
with zeros to their length. ``silent``: a separate layout for zero; ``crc``, ``feature``: see
`report`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from ...forms import Form
from ..report import Report, Tones, Transport, percent, unsigned8, unsigned16, with_crc
from .family import RESEND, RumbleFamily

_WRITTEN: Mapping[str, Callable[[float], bytes]] = {
    "5": lambda amplitude: bytes([unsigned16(amplitude) >> 11]),
    "8": lambda amplitude: bytes([unsigned8(amplitude)]),
    "16": lambda amplitude: unsigned16(amplitude).to_bytes(2, "little"),
    "%": lambda amplitude: bytes([percent(amplitude)]),
}


def _part(word: str, drive: Tones, sequence: int) -> bytes:
    """The bytes that a word of a layout represents."""
    for side, amplitude in zip(("left", "right"), drive.amplitudes, strict=True):
        if word.startswith(side):
            return _WRITTEN[word.removeprefix(side)](amplitude)
    return bytes([sequence & 0xFF]) if word == "sequence" else bytes.fromhex(word)


def _encode(
    reports: Mapping[str, Form], drive: Tones, transport: Transport, sequence: int
) -> Report:
    form = reports.get(transport) or reports["any"]
    layout = form["layout"] if any(drive.amplitudes) else form.get("silent", form["layout"])
    data = b"".join(_part(word, drive, sequence) for word in layout.split()).ljust(
        form.get("length", 0), b"\0"
    )
    return Report(with_crc(data) if form.get("crc") else data, feature=form.get("feature", False))


def pad(name: str, module: str = __file__, **functions: Any) -> RumbleFamily:
    """The family called ``name`` in the `pads.json` beside a module (its file); ``functions``: its
    further functions."""
    row = json.loads(Path(module).with_name("pads.json").read_text("utf-8"))[name]
    return RumbleFamily(
        name=name,
        title=row["title"],
        ids=frozenset((int(pair[:4], 16), int(pair[5:], 16)) for pair in row["ids"]),
        minimum_interval=row["minimum_interval"],
        refresh_interval=row.get("refresh_interval", RESEND),
        zero_repeats=row.get("zero_repeats", 1),
        encode=partial(_encode, row["reports"]),
        **functions,
    )
