"""Best CPU time and peak memory of a function."""

from __future__ import annotations

import math
import time
import tracemalloc
from collections.abc import Callable
from typing import Any, TypeVar

Result = TypeVar("Result")


def best_time(run: Callable[..., object], *arguments: Any, runs: int = 5) -> float:
    """Seconds of the best of ``runs``."""
    return best_run(run, *arguments, runs=runs)[0]


def best_run(
    run: Callable[..., Result], *arguments: Any, runs: int = 5, patience: float = math.inf
) -> tuple[float, Result]:
    """Seconds of the best of up to ``runs``, or of as many as fit into ``patience`` seconds, and
    what the last one gave."""
    best, spent = math.inf, 0.0
    for _ in range(runs):
        begun = time.process_time()
        result = run(*arguments)
        used = time.process_time() - begun
        best, spent = min(best, used), spent + used
        if spent > patience:
            break
    return best, result


def peak(run: Callable[..., object], *arguments: Any) -> int:
    """Peak of allocated bytes."""
    tracemalloc.start()
    run(*arguments)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return most
