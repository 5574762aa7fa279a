"""Certified error of the sum over all paths within the default budget, without limits and with a
tolerance of 1 %.

    python -m benchmarks.bench_propagation_budget

The certified error is the largest of any listener, relative to what was summed. Beside it, the same
scene with the default limits, where it includes all that they leave out; and the energies.
"""

from __future__ import annotations

import os
import time
from dataclasses import asdict, dataclass

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.propagation.connections import LARGEST
from haptic_tracing.core.scene.values import Settings, Strategy

from .families import FAMILIES, Family
from .report import milliseconds, publish, table

SIZES = {
    "tree": (100, 10_000, 100_000),
    "ladder": (120, 1000, 10_000),
    "wall": (24, 100, 1000),
    "random contacts": (10, 20, 30, 40, 60, 100),
    "hub with arches": (6, 9, 12, 15, 20, 50),
    "pile on a ground": (11, 13, 16, 21, 51, 1001),
}


@dataclass(frozen=True, slots=True)
class Row:
    """Seconds of the sum without limits, of the limited sum and of the energies; the certified
    relative errors of both sums."""

    family: str
    objects: int
    seconds: float
    error: float
    seconds_limited: float
    error_limited: float
    seconds_energy: float


def timed(family: Family, settings: Settings) -> tuple[float, float]:
    """Seconds, and the largest certified error relative to the gain (where something is heard)."""
    begun = time.process_time()
    result = propagate(family.graph(), settings)
    used = time.process_time() - begun
    heard = result.gain[0] > 0
    bounds = np.where(result.error_bound[0] >= LARGEST, np.inf, result.error_bound[0])
    silent = float(np.max(bounds[~heard], initial=0.0))
    return used, float("inf") if silent > 0 else float(
        np.max(bounds[heard] / result.gain[0][heard], initial=0.0)
    )


def measure(family: Family) -> Row:
    free, error = timed(
        family, Settings(strategy=Strategy.ALL_PATHS, max_connections=None, threshold=0.0)
    )
    limited, limited_error = timed(family, Settings(strategy=Strategy.ALL_PATHS))
    energy, _ = timed(family, Settings(strategy=Strategy.ENERGY_BALANCE))
    return Row(family.name, len(family.table.names), free, error, limited, limited_error, energy)


def said(error: float) -> str:
    """The certified error as text."""
    if error == 0:
        return "exact"
    return f"{100 * error:.2g} %" if error < 10 else "no useful bound"


def main() -> None:
    """Measure, print, write."""
    rows = [measure(FAMILIES[name](size)) for name, sizes in SIZES.items() for size in sizes]
    text = "Processor time with building the graph, one source, one run each.\n\n" + table(
        (
            "family",
            "objects",
            "all paths [ms]",
            "certified",
            "default limits [ms]",
            "certified",
            "energy_balance [ms]",
        ),
        [
            (
                row.family,
                f"{row.objects:,}",
                milliseconds(row.seconds),
                said(row.error),
                milliseconds(row.seconds_limited),
                said(row.error_limited),
                milliseconds(row.seconds_energy),
            )
            for row in rows
        ],
    )
    data = [
        {key: value if value != float("inf") else None for key, value in asdict(row).items()}
        for row in rows
    ]
    publish("propagation_budget", "What the default budget certifies", text, data)


if __name__ == "__main__":
    main()
