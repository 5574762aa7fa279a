"""A device that accepts reports at once, and logs the times of the guard process's steps."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from haptic_tracing.core.devices.pacing import RumblePacing


@dataclass(frozen=True)
class TimedPad:
    """hidapi's module and its one device. It can be pickled.

    log: a file that gets a line of JSON for each event when the device is closed, as writing it at
    once would be measured too: the event's name, the seconds of `time.perf_counter`, and for
    ``accept``, which is the end of encoding a block, when that block was sent and when encoding
    began. ``written`` is a report, ``unchanged`` the decision that the device does already what a
    report would say.
    """

    vendor: int
    product: int
    number: int
    log: str

    def enumerate(self, *_: int) -> Iterable[Mapping[str, Any]]:
        names = {
            "path": b"/dev/null",
            "serial_number": "",
            "product_string": "Pad",
            "bus_type": 1,
            "interface_number": self.number,
        }
        return [
            {
                **names,
                "vendor_id": self.vendor,
                "product_id": self.product,
                "usage_page": 1,
                "usage": 5,
            }
        ]

    def device(self) -> Any:
        noted: list[tuple[str | float, ...]] = []

        def note(name: str, *more: float) -> None:
            noted.append((name, time.perf_counter(), *more))

        def close() -> None:
            with Path(self.log).open("a", encoding="utf-8") as lines:
                lines.writelines(json.dumps(event) + "\n" for event in noted)

        _note_decisions(note)

        def write(data: bytes) -> int:
            note("written")
            return len(data)

        return SimpleNamespace(
            open_path=lambda path: None,
            write=write,
            send_feature_report=write,
            get_feature_report=lambda report, length: [],
            read=lambda length, timeout: [],
            error=lambda: "",
            close=close,
        )


def _note_decisions(note: Callable[..., None]) -> None:
    """Log the decisions of the device's pace. Called once, inside the guard."""
    accept, unless_known = RumblePacing.accept, RumblePacing._unless_known

    def timed_accept(self: RumblePacing, block: Any, sent: float) -> None:
        begun = time.perf_counter()
        accept(self, block, sent)
        note("accept", sent, begun)

    def timed_unless_known(self: RumblePacing, drive: Any, now: float) -> Any:
        report = unless_known(self, drive, now)
        if report is None:
            note("unchanged")
        return report

    RumblePacing.accept, RumblePacing._unless_known = timed_accept, timed_unless_known  # type: ignore[method-assign]


def events(log: str) -> dict[str, list[list[float]]]:
    """The logged times by event: [seconds, ...]."""
    found: dict[str, list[list[float]]] = {"accept": [], "written": [], "unchanged": []}
    for line in Path(log).read_text(encoding="utf-8").splitlines():
        name, *values = json.loads(line)
        found[name].append(values)
    return found
