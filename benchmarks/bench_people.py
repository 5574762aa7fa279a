"""How far touch and film are apart in a study with people: two pads that umockdev makes up, pages
in Chromium.

    python -m benchmarks.bench_people

The first report of each beat is compared with the time at which the page shows its picture, less
the latency of its pad. The goal is 15 ms.
"""

from __future__ import annotations

import os
import sys
import tempfile
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from .report import publish, table

PARTICIPANTS = ("P01", "P02", "P03")


def main() -> None:
    """Print the distances, with the load of the machine."""
    sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "study"))
    sitting: Any = import_module("test_sitting_of_a_participant")
    distances: dict[str, list[Any]] = {}
    load = os.getloadavg()[0]
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary, "study")
        folder.mkdir()
        sitting.prepare(folder)
        for name in PARTICIPANTS:
            own = Path(temporary, name)
            own.mkdir()
            pictures, felt = sitting.felt_onsets(folder, own, name)
            zero = np.median(pictures[:, 1] - pictures[:, 0])
            for pad, times in felt:
                apart = 1e3 * np.abs(times[:, None] - zero - np.array(pad.beats)).min(axis=0)
                distances.setdefault(pad.name, []).append(apart)
    rows = [
        [name, f"{np.size(apart)}", *(f"{one:.1f}" for one in np.percentile(apart, [50, 95, 100]))]
        for name, apart in distances.items()
    ]
    publish(
        "people",
        "people",
        f"Touch and picture apart, in milliseconds; the goal is 15. Load of {os.cpu_count()} "
        f"cores: {load:.1f} before, {os.getloadavg()[0]:.1f} after.\n\n"
        + table(("pad", "beats", "median", "95 %", "largest"), rows),
        {name: np.concatenate(apart).tolist() for name, apart in distances.items()},
    )


if __name__ == "__main__":
    main()
