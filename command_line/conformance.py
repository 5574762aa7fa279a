"""``haptic-tracing conformance``: plays conversations against a run-time server and compares its
answers."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from websockets.exceptions import InvalidHandshake, InvalidURI, WebSocketException
from websockets.sync.client import ClientConnection, connect

from ..core.formats.io.strict_json import read_json
from . import answer

FOLDER = Path(__file__).parents[1] / "conformance"
DECIBELS = 0.01
"""Tolerance of levels [dB]; gains have the same."""
TOLERANCES = {"seconds": 1e-3, "energy": 0.01}
"""Tolerances of an impact's time [s], and of its energy relative to what is expected, where a file
has none of its own."""
_PATIENCE = 60.0


def run(args: argparse.Namespace) -> int:
    """Play the files, one connection each; exit code 1 if any answer differs."""
    files = sorted(FOLDER.glob("*.json*")) if args.file == [] else args.file
    found: dict[str, list[str]] = {}
    for file in files:
        try:
            with connect(args.url, open_timeout=_PATIENCE) as client:
                faults = list(differences(read_json(file), client, args.token))
        except (OSError, TimeoutError, InvalidURI, InvalidHandshake, WebSocketException) as error:
            raise ValueError(f"{args.url}: {error}") from None
        name = file.name.partition(".")[0]
        found[name] = faults
        print(f"{name}: {'as expected' if not faults else ''}")
        for fault in faults[: args.most]:
            print(f"  {fault}")
    failed = sum(map(bool, found.values()))
    print(f"{len(files) - failed} passed, {failed} failed")
    answer(args, {"differences": found})
    return 1 if failed else 0


def differences(
    document: Mapping[str, Any], client: ClientConnection, token: str | None
) -> Iterator[str]:
    """Where the answers of a server to a conversation are not as expected, one sentence each."""
    tolerances = TOLERANCES | document.get("tolerances", {})
    for number, one in enumerate(document["exchange"]):
        sent, expected = dict(one["send"]), one.get("expect", {})
        if token is not None and sent["type"] == "hello":
            sent["token"] = token
        client.send(json.dumps(sent))
        if sent["type"] == "play":  # has no answer
            continue
        answer = json.loads(client.recv(timeout=_PATIENCE))
        for where, what in _differences(answer, expected, tolerances):
            yield f"message {number} ({sent['type']}): {where}: {what}"


def _differences(
    answer: Mapping[str, Any], expected: Mapping[str, Any], tolerances: Mapping[str, float]
) -> Iterator[tuple[str, str]]:
    for key, value in expected.items():
        got = answer.get(key)
        if key == "levels":
            for listener, felt in value.items():
                yield from _levels(f"levels of {listener}", (got or {}).get(listener, {}), felt)
        elif key == "impacts":
            yield from _impacts(got or [], value, tolerances)
        elif got != value:
            yield key, f"expected {value!r}, got {got!r}"


def _levels(
    where: str, got: Mapping[str, Any], expected: Mapping[str, Any]
) -> Iterator[tuple[str, str]]:
    level = got.get("level")
    if expected.get("felt") and level is None:
        yield where, "expected a level, got silence"
    if "level" in expected and not _alike(level, expected["level"], DECIBELS):
        yield where, f"expected {expected['level']} dB, got {level}"
    for source, gain in expected.get("gains", {}).items():
        yield from _gain(f"{where}, gain of {source}", got.get("gains", {}).get(source), gain)


def _gain(where: str, got: float | None, expected: float) -> Iterator[tuple[str, str]]:
    """Compare gains in decibels."""
    if not (
        got == expected == 0
        or (got and expected and abs(20 * math.log10(got / expected)) <= DECIBELS)
    ):
        yield where, f"expected {expected:.6g}, got {got}"


def _impacts(
    got: Sequence[Mapping[str, Any]],
    expected: Sequence[Mapping[str, Any]],
    tolerances: Mapping[str, float],
) -> Iterator[tuple[str, str]]:
    if len(got) != len(expected):
        yield "impacts", f"expected {len(expected)}, got {len(got)}"
        return
    for one, wanted in zip(got, expected, strict=True):
        if "objects" in wanted and sorted(one["objects"]) != sorted(wanted["objects"]):
            yield "objects of an impact", f"expected {wanted['objects']}, got {one['objects']}"
        if "time" in wanted and not _alike(one["time"], wanted["time"], tolerances["seconds"]):
            yield "time of an impact", f"expected {wanted['time']:.5f} s, got {one['time']}"
        if not _alike(one["energy"], wanted["energy"], tolerances["energy"] * wanted["energy"]):
            yield "energy of an impact", f"expected {wanted['energy']:.2f} J, got {one['energy']}"
        if "amplitude" in wanted:
            yield from _gain("amplitude of an impact", one.get("amplitude"), wanted["amplitude"])
        for listener, gain in wanted.get("gains", {}).items():
            yield from _gain(f"gain of an impact at {listener}", one["gains"].get(listener), gain)


def _alike(got: Any, expected: float | None, tolerance: float) -> bool:
    return bool(
        got == expected if got is None or expected is None else abs(got - expected) <= tolerance
    )
