"""``haptic-tracing conformance``: plays conversations against a run-time server and compares its
answers."""

from __future__ import annotations

import argparse
import json
import math
import time
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

from websockets.exceptions import InvalidHandshake, InvalidURI, WebSocketException
from websockets.sync.client import ClientConnection, connect

from ..core.formats.io.error import FormatError
from ..core.formats.io.strict_json import read_json
from ..core.forms import Form, JsonObject
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
    conversations = {file: conversation(file) for file in files}
    found: dict[str, list[str]] = {}
    for file, document in conversations.items():
        try:
            with connect(args.url, open_timeout=_PATIENCE) as client:
                faults = list(differences(document, client, args.token))
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


def conversation(file: Path) -> Form:
    """The conversation in a file. Raises FormatError or OSError."""
    document: Form = read_json(file)
    exchange = document.get("exchange") if isinstance(document, dict) else None
    if not isinstance(exchange, list):
        raise FormatError(file, "/exchange", "is required: a list of messages and answers")
    for number, one in enumerate(exchange):
        sent = one.get("send") if isinstance(one, dict) else None
        messages = sent if isinstance(sent, list) and sent else [sent]
        if not all(isinstance(message, dict) and "type" in message for message in messages):
            raise FormatError(
                file, f"/exchange/{number}/send", "is required: a message with its type"
            )
    return dict(document)


def differences(document: Form, client: ClientConnection, token: str | None) -> Iterator[str]:
    """Where the answers of a server to a conversation are not as expected, one sentence each."""
    tolerances = TOLERANCES | document.get("tolerances", {})
    for number, one in enumerate(document["exchange"]):
        expected = one.get("expect", {})
        if isinstance(one["send"], list):
            for where, what in _differences(_flooded(client, one), expected, tolerances):
                yield f"messages {number}: {where}: {what}"
            continue
        sent = dict(one["send"])
        if token is not None and sent["type"] == "hello":
            sent["token"] = token
        client.send(json.dumps(sent))
        if sent["type"] == "play":  # has no answer
            continue
        answer = json.loads(client.recv(timeout=_PATIENCE))
        for where, what in _differences(answer, expected, tolerances):
            yield f"message {number} ({sent['type']}): {where}: {what}"


def _flooded(client: ClientConnection, one: Form) -> Form:
    """The last of the frames that answer steps which are sent without waiting, and read after a
    ``pause`` [s]: with the impacts and samples of all, and the ids that are answered, dropped ones
    among them."""
    for message in one["send"]:
        client.send(json.dumps(message))
    time.sleep(one.get("pause", 0.0))
    frame: JsonObject = {"answers": []}
    impacts: list[Form] = []
    samples: list[tuple[int, int]] = []
    answered: list[Any] = []
    while one["send"][-1]["id"] not in frame["answers"]:
        frame = json.loads(client.recv(timeout=_PATIENCE))
        if frame["type"] != "frame":
            return frame
        for part in (*frame.get("dropped", ()), frame):
            answered += part["answers"]
            samples.append((part["first_sample"], part["n"]))
        impacts += frame["impacts"]
    follow = all(a + n == b for (a, n), (b, _) in pairwise(samples))
    n = sum(count for _, count in samples) if follow else "samples with gaps"
    return {**frame, "answers": answered, "impacts": impacts, "n": n}


def _differences(
    answer: Form, expected: Form, tolerances: Mapping[str, float]
) -> Iterator[tuple[str, str]]:
    """Places of an answer, and what is there instead of what is expected."""
    if "impacts" in answer and "impacts" in expected:
        impacts = _arranged(answer["impacts"], expected["impacts"], tolerances["seconds"])
        answer = {**answer, "impacts": impacts}
    given, wanted = dict(_values(answer)), dict(_values(expected))
    for place, value in wanted.items():
        *within, key = place
        got = given.get((*within, "level" if key == "felt" else key))
        if key == "felt":
            alike = got is not None or not value
        else:
            alike = _alike(place, got, value, tolerances)
        if not alike:
            yield " ".join(place), f"expected {value!r}, got {got!r}"
    more = len(answer.get("impacts", ())) - len(expected.get("impacts", ()))
    if "impacts" in expected and more > 0:
        yield "impacts", f"{more} more than expected"


def _arranged(impacts: list[Form], expected: list[Form], seconds: float) -> list[Form]:
    """The impacts in the order of those expected: which of two is the first means nothing within
    the tolerance of their times."""
    left, arranged = list(impacts), []
    for one in expected[: len(left)]:
        alike = (
            number
            for number, other in enumerate(left)
            if set(other["objects"]) == set(one.get("objects", ()))
            and abs(other["time"] - one.get("time", math.inf)) <= seconds
        )
        arranged.append(left.pop(next(alike, 0)))
    return arranged + left


def _values(value: Any, place: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """The values in a message with the keys that lead to each; impacts are numbered."""
    if isinstance(value, list) and place == ("impacts",):
        value = {str(number): one for number, one in enumerate(value)}
    if not isinstance(value, dict):
        yield place, sorted(value) if "impacts" in place and place[-1] == "objects" else value
        return
    for key, inside in value.items():
        yield from _values(inside, (*place, key))


def _alike(
    place: tuple[str, ...], got: Any, expected: Any, tolerances: Mapping[str, float]
) -> bool:
    """Whether a value is as expected: gains, amplitudes and levels in decibels, times in seconds,
    energies relative to what is expected."""
    if got == expected or None in (got, expected) or isinstance(expected, str | list):
        return bool(got == expected)
    if "gains" in place or place[-1] == "amplitude":
        return got * expected > 0 and abs(20 * math.log10(got / expected)) <= DECIBELS
    limits = {
        "level": DECIBELS,
        "time": tolerances["seconds"],
        "energy": tolerances["energy"] * expected,
    }
    return bool(abs(got - expected) <= limits.get(place[-1], 0.0))
