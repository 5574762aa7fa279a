"""How long a run-time server takes from a message to its answer, over its WebSocket on this
machine, what many servers beside each other take, and whether one drifts in ten minutes.

    python -m benchmarks.bench_run_time [--seconds 10] [--part answers|sessions|drift]

A grid of crates on a ground, of which some move up and down by a few centimetres and to the side,
with ten listeners; steps come at a fixed rate. Goals: 5 ms (median) with 100 moving of 100; 15 ms
(99 %) at 60 steps a second with 100 moving of 1,000; 40 ms (99 %) at 25 with 1,000 moving. The
processor's time is that of the server alone, which other load does not change much; the times to
the answer are of a machine with the stated load.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from itertools import repeat
from pathlib import Path
from threading import Barrier
from typing import Any

import numpy as np
from websockets.sync.client import ClientConnection, connect

from .report import RESULTS, publish, table

CASES = (
    (10, 10, 60),
    (100, 100, 60),
    (1000, 100, 60),
    (1000, 1000, 25),
    (10_000, 100, 25),
    (9_999, 9_999, 2),
)
"""Crates, moving crates, steps a second."""
LISTENERS = 10


def scene_of(count: int) -> dict[str, Any]:
    """A ground with ``count`` crates that don't touch each other."""
    side = math.isqrt(count) + 1
    ground = {"name": "ground", "kappa": 0.1, "rho": 0.9, "motion": "static"}
    size = 2.0 * side + 10
    objects = [
        {
            **ground,
            "shape": {"type": "box", "size": [size, size, 1]},
            "pose": {"position": [size / 2, size / 2, -0.5]},
        }
    ]
    for k in range(count - 1):
        shape = {"type": "box", "size": [1, 1, 1]}
        objects.append(
            {
                "name": f"crate {k}",
                "kappa": 0.1,
                "rho": 0.9,
                "mass": 5,
                "shape": shape,
                "pose": {"position": place(k, side)},
            }
        )
    listeners = [
        {"name": f"hand {k}", "object": f"crate {k}", "position": place(k, side)}
        for k in range(min(LISTENERS, count - 1))
    ]
    return {
        "objects": objects,
        "sources": [{"name": "drill", "object": "ground", "position": [0, 0, 0]}],
        "listeners": listeners,
    }


def place(number: int, side: int, time_: float | None = None) -> list[float]:
    """Where a crate is; at rest without a time."""
    x, y = 1.3 * (number % side), 1.3 * (number // side)
    if time_ is None:
        return [x, y, 0.5]
    return [
        x + 0.05 * math.sin(7 * time_ + number),
        y,
        0.5 + 0.04 * abs(math.sin(5 * time_ + number)),
    ]


class Served:
    """A running server: its ``url``, and what it takes."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        assert process.stderr is not None
        found = re.search(r"ws://\S+(?=,)", process.stderr.readline())
        assert found is not None
        self.url, self._folder = found[0], Path("/proc") / str(process.pid)

    def processor(self) -> float:
        """Seconds of the processor so far."""
        fields = (self._folder / "stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / float(os.sysconf("SC_CLK_TCK"))

    def memory(self) -> float:
        """Resident megabytes."""
        found = re.search(r"VmRSS:\s+(\d+)", (self._folder / "status").read_text())
        assert found is not None
        return int(found[1]) / 1000


@contextmanager
def served() -> Iterator[Served]:
    """A server without a scene."""
    command = [sys.executable, "-m", "haptic_tracing", "serve", "--listen", "127.0.0.1:0"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        try:
            yield Served(process)
        finally:
            process.terminate()


def measured(
    server: Served, case: tuple[int, int, int], seconds: float, others: Barrier | None = None
) -> dict[str, Any]:
    """Times from message to answer [ms] and the server's processor per step [ms], over all steps;
    and the server's memory [MB], the median and the processor of the second and the last tenth.
    Begins once the ``others`` are ready."""
    count, moving, rate = case
    side = math.isqrt(count) + 1
    with connect(server.url, max_size=None, open_timeout=300, ping_interval=None) as client:
        said(client, {"type": "hello", "version": 1, "scene": scene_of(count)})
        said(client, {"type": "step", "time": -1.0})  # imports what steps need
        if others is not None:
            others.wait()
        waits, used, memory, bytes_ = [], [server.processor()], [server.memory()], 0
        steps = max(round(seconds * rate), 10)
        part = steps // 10
        begun = time.perf_counter()
        for k in range(part * 10):
            now = k / rate
            poses = {
                f"crate {n}": [*place(n, side, now), 1, 0, 0, 0]
                for n in range(min(moving, count - 1))
            }
            message = json.dumps({"type": "step", "time": now, "poses": poses})
            bytes_ = len(message)
            time.sleep(max(begun + now - time.perf_counter(), 0.0))
            asked = time.perf_counter()
            client.send(message)
            client.recv(timeout=300)
            waits.append(1000 * (time.perf_counter() - asked))
            if (k + 1) % part == 0:
                used.append(server.processor())
                memory.append(server.memory())
    each = 1000 * np.diff(used) / part
    return {
        "crates": count,
        "moving": moving,
        "rate": rate,
        "median": float(np.median(waits[2:])),
        "late": float(np.quantile(waits[2:], 0.99)),
        "processor": float(np.median(each)),
        "kilobytes": bytes_ / 1000,
        "medians": [float(np.median(waits[k : k + part])) for k in (part, 9 * part)],
        "processors": each[[1, -1]].tolist(),
        "memory": [memory[2], memory[-1]],
    }


def said(client: ClientConnection, message: dict[str, Any]) -> Any:
    """The answer to a message."""
    client.send(json.dumps(message))
    return json.loads(client.recv(timeout=300))


def answers(seconds: float) -> tuple[str, Any]:
    """The table of the cases, with 10 to 10,000 objects."""
    results = []
    for case in CASES:
        with served() as server:
            results.append(measured(server, case, seconds))
    rows = [
        [
            *(f"{r[key]:,}" for key in ("crates", "moving", "rate")),
            *(f"{r[key]:.1f}" for key in ("processor", "median", "late")),
            f"{r['memory'][1]:.0f}",
            f"{r['kilobytes']:.0f}",
        ]
        for r in results
    ]
    heads = ("objects", "moving", "steps a second", "processor a step [ms]", "median [ms]")
    return table((*heads, "99 % [ms]", "memory [MB]", "message [kB]"), rows), results


SESSIONS = (1, 10, 50)
SESSION = (100, 10, 30)
"""Crates, moving crates and steps a second of each of many sessions."""


def sessions(seconds: float) -> tuple[str, Any]:
    """The table of many sessions at once, with a server for each."""
    results = []
    for count in SESSIONS:
        with ExitStack() as stack, ThreadPoolExecutor(count) as pool:
            servers = [stack.enter_context(served()) for _ in range(count)]
            begun = Barrier(count)
            found = list(
                pool.map(measured, servers, repeat(SESSION), repeat(seconds), repeat(begun))
            )
        results.append(
            {
                "sessions": count,
                "processor": float(np.mean([one["processor"] for one in found])),
                "median": float(np.median([one["median"] for one in found])),
                "late": float(np.median([one["late"] for one in found])),
                "memory": float(np.sum([one["memory"][1] for one in found])),
            }
        )
    rows = [
        [
            f"{r['sessions']}",
            f"{r['processor']:.2f}",
            f"{r['processor'] * SESSION[2] / 10 * r['sessions']:.0f}",
            f"{r['median']:.1f}",
            f"{r['late']:.1f}",
            f"{r['memory']:.0f}",
        ]
        for r in results
    ]
    heads = ("sessions", "processor a step [ms]", "of one core [%]", "median [ms]", "99 % [ms]")
    return table((*heads, "memory of all [MB]"), rows), results


def drift(seconds: float) -> tuple[str, Any]:
    """The table of the second and the last tenth of 60 times ``seconds``."""
    with served() as server:
        found = measured(server, (100, 100, 60), 60 * seconds)
    rows = [
        [
            f"{seconds * minute:.0f}",
            *(f"{found[key][k]:.1f}" for key in ("memory", "processors", "medians")),
        ]
        for k, minute in enumerate((12, 60))
    ]
    heads = ("after [s]", "memory [MB]", "processor a step [ms]", "median [ms]")
    return table(heads, rows), found


PARTS = {
    "answers": ("One server", answers),
    "sessions": (f"Sessions of {SESSION[0]} objects, {SESSION[2]} steps a second", sessions),
    "drift": ("Drift of one server: 100 moving objects, 60 steps a second", drift),
}


def main() -> None:
    """Print and store the tables; those of parts that are not measured now stay stored."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--part", choices=PARTS)
    options = parser.parse_args()
    results = json.loads((RESULTS / "run_time.json").read_text(encoding="utf-8"))["results"]
    for name, (title, measure) in PARTS.items():
        if options.part in (None, name):
            text, found = measure(options.seconds)
            load = os.getloadavg()[0]
            shown = f"## {title}\n\nLoad of the machine: {load:.1f}.\n\n{text}\n"
            results[name] = {"shown": shown, "found": found}
    shown = "\n".join(results[name]["shown"] for name in PARTS)
    publish("run_time", "From a message to its answer", shown, results)


if __name__ == "__main__":
    main()
