"""Tasks on Dask: a few at a time, each in its own process on a worker, with results as files."""

from __future__ import annotations

import contextlib
import json
import logging
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from itertools import islice
from typing import Any

from distributed import Client, LocalCluster, as_completed
from distributed.scheduler import KilledWorker

from ...core.forms import Form
from ..part_file import programs

_AHEAD = 4
"""Tasks per worker that the scheduler holds, so that its memory does not grow with the study."""

_SECONDS = 5
"""Time-out of a scheduler [s]."""


@contextmanager
def connected(on: str, workers: int) -> Iterator[Client]:
    """A client of the scheduler at an address, or of ``workers`` processes on this machine. Raises
    ValueError if there is no answer or no worker, or if a worker has other versions."""
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    with contextlib.ExitStack() as stack:
        address: Any = on
        if on == "local":
            address = stack.enter_context(
                LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None)
            )
        try:
            client = stack.enter_context(Client(address, timeout=_SECONDS, set_as_default=False))
        except (OSError, ValueError) as error:
            raise ValueError(f"--on {on}: no scheduler answers: {error}") from None
        try:
            known = client.run(programs, on_error="return")
        except Exception as error:
            raise ValueError(f"--on {on}: the workers do not answer: {error}") from None
        if not known:
            raise ValueError(
                f"--on {on}: the scheduler has no worker: start some by: dask worker {on}"
            )
        for worker, versions in known.items():
            if versions != programs():
                raise ValueError(
                    f"--on {on}: worker {worker} has {versions}; this machine has {programs()}"
                )
        yield client


def run_all(on: str, workers: int, tasks: Sequence[Form]) -> Iterator[tuple[str, str]]:
    """Run all tasks; yields the key of each completed one with the reason of its failure, or "".
    The task of a worker that dies goes to another one. See `connected`."""
    rest = iter(tasks)
    with connected(on, min(workers, len(tasks))) as client:

        def submitted(count: int) -> list[Any]:
            return [
                client.submit(work, task, key=task["key"], pure=False)
                for task in islice(rest, count)
            ]

        waiting = as_completed(
            submitted(_AHEAD * len(client.scheduler_info(n_workers=-1)["workers"])),
            loop=client.loop,
        )
        for future in waiting:
            try:
                failure = future.result()
            except KilledWorker:
                failure = "every worker that tried it died"
            except OSError as error:
                failure = str(error)
            except CancelledError:
                raise ValueError(
                    f"--on {on}: the scheduler has gone; what is done is kept: run the same "
                    "command again"
                ) from None
            yield future.key, failure
            waiting.update(submitted(1))


def work(task: Form) -> str:
    """Run one task in its own process; called on a worker. Returns the reason of its failure, or
    ""."""
    command = [sys.executable, "-m", "haptic_tracing.command_line.sweep.task"]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None and process.stderr is not None
        process.stdin.write(json.dumps(task) + "\n")
        process.stdin.flush()
        said = process.stderr.read().strip().splitlines()
        code = process.wait()
    return "" if code == 0 else (said[-1] if said else f"ended with {code}")
