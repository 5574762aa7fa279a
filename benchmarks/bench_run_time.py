"""How long a run-time server takes from a message to its answer, over its WebSocket on this
machine.

    python -m benchmarks.bench_run_time [--seconds 10] [--only 100/100]

A grid of crates on a ground, of which some move up and down by a few centimetres and to the side,
with ten listeners; steps come at a fixed rate. Goals: 5 ms (median) with 100 moving of 100; 15 ms
(99 %) at 60 steps a second with 100 moving of 1,000; 40 ms (99 %) at 25 with 1,000 moving.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import resource
import subprocess
import sys
import time
from typing import Any

import numpy as np
from websockets.sync.client import ClientConnection, connect

from .report import publish, table

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


def measured(url: str, count: int, moving: int, rate: int, seconds: float) -> dict[str, Any]:
    """Times from message to answer [ms], and how late the steps are at the end."""
    side = math.isqrt(count) + 1
    with connect(url, max_size=None, open_timeout=60) as client:
        said(client, {"type": "hello", "version": 1, "scene": scene_of(count)})
        waits, bytes_ = [], 0
        begun = time.perf_counter()
        for k in range(max(round(seconds * rate), 5)):
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
            client.recv(timeout=60)
            waits.append(1000 * (time.perf_counter() - asked))
    return {
        "crates": count,
        "moving": moving,
        "rate": rate,
        "median": float(np.median(waits[2:])),
        "late": float(np.quantile(waits[2:], 0.99)),
        "kilobytes": bytes_ / 1000,
        "behind": max(time.perf_counter() - begun - len(waits) / rate, 0.0),
    }


def said(client: ClientConnection, message: dict[str, Any]) -> Any:
    """The answer to a message."""
    client.send(json.dumps(message))
    return json.loads(client.recv(timeout=120))


def main() -> None:
    """Print and store the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    command = [sys.executable, "-m", "haptic_tracing", "serve", "--listen", "127.0.0.1:0"]
    server = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    assert server.stderr is not None
    found = re.search(r"ws://\S+(?=,)", server.stderr.readline())
    assert found is not None
    cases = [case for case in CASES if options.only in ("", f"{case[0]}/{case[1]}")]
    results = [measured(found[0], *case, options.seconds) for case in cases]
    server.terminate()
    server.wait()
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    rows = [
        [
            *(f"{r[key]:,}" for key in ("crates", "moving", "rate")),
            *(f"{r[key]:.1f}" for key in ("median", "late")),
            f"{r['kilobytes']:.0f}",
        ]
        for r in results
    ]
    text = table(
        ("objects", "moving", "steps a second", "median [ms]", "99 % [ms]", "message [kB]"), rows
    )
    text += (
        f"\n\nThe server's largest memory: {used.ru_maxrss / 1000:.0f} MB; its processor "
        f"time: {used.ru_utime + used.ru_stime:.0f} s.\n"
    )
    if options.only:
        print(text)
    else:
        publish("run_time", "From a message to its answer", text, results)


if __name__ == "__main__":
    main()
