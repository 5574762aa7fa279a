"""Time that tracing adds to Blender's own frame while rigid bodies fall and settle, or lie still.

    python -m benchmarks.bench_frame [--bodies 100 300 1000 3000] [--settled 10000] [--frames 200]
    [--passes 3]
                                     [--shape BOX] [--strategy auto] [--no-impacts]

Every frame is simulated by Blender and traced by the add-on, on a thread beside it. Three Blenders
play the same frames, a few at a time in turns, so that whatever else the machine does meets them
all: one without tracing, one with it, and one more without. Of several passes the quickest of each
frame's times counts; the first frame of each turn, which has no tracing beside it, does not. `off`
is the median of Blender's own frame without, `on` that of the frame with tracing, `cost` the median
of their ratio frame by frame, less one. `noise` is the same of the two Blenders without tracing: no
cost below it is known. `CPU` is the cost in CPU time, of all threads: what tracing costs where
there is no second core. `handler` is what the add-on's frame handler takes of it: reading, and
waiting where the last frame is still being traced. 4 sources are on bodies, 10 listeners on others;
all contacts that signals reach are wanted. As in new scenes, impacts are found, and each makes one
more source; not with `--no-impacts`. The samples of every frame are rendered, as for the meters
that a new scene shows. Settled bodies lie asleep on the ground with one source at the edge; beyond
reading the transforms, Blender waits for the rest of the handler, and all other stages pass beside
it.
"""

from __future__ import annotations

import argparse
import multiprocessing
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

GOALS = {100: 0.12, 300: 0.08, 1000: 0.04, 3000: 0.03}
SETTLED_GOAL = 1.0
PASSES = 3
FRAMES_OF_BODIES = 20_000  # in a turn: of 1,000 bodies 20 frames


@dataclass(frozen=True, slots=True)
class Traced:
    """Medians over the frames that were traced: milliseconds of the handler, and of each stage;
    narrow-phase queries made and avoided per frame, all told; bytes that the tracer holds."""

    handler: float
    stages: dict[str, float]
    beyond: float
    contacts: float
    queries: int
    avoided: int
    memory: int


@dataclass(frozen=True, slots=True)
class Row:
    """Medians over the frames of one scene: milliseconds of the frame without and with tracing, by
    how much one is above the other, and by how much the frame without is above itself; the same of
    CPU time; and what was traced."""

    bodies: int
    off: float
    on: float
    cost: float
    noise: float
    off_cpu: float
    on_cpu: float
    cost_cpu: float
    traced: Traced


def turn_of(bodies: int) -> int:
    """Frames that a Blender plays at a time."""
    return int(np.clip(FRAMES_OF_BODIES // bodies, 10, 100))


class Blender:
    """A Blender in its own process that plays ``frames`` of a scene in turns. ``scene``: the
    arguments of `falling_bodies.build` after the frames."""

    def __init__(self, tracing: bool, frames: int, *scene: object) -> None:
        context = multiprocessing.get_context("spawn")
        self._connection, other = context.Pipe()
        self._process = context.Process(
            target=_in_blender, args=("play_in_turns", other, tracing, frames, *scene), daemon=True
        )
        self._process.start()

    def play(self, numbers: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
        """Seconds of each of these frames, of the clock and of CPU time."""
        self._connection.send(numbers)
        times: tuple[np.ndarray, np.ndarray] = self._connection.recv()
        return times

    def end(self) -> Traced | None:
        """End the process and return what it traced."""
        self._connection.send(())
        traced = self._connection.recv()
        self._process.join()
        return None if traced is None else Traced(**traced)


def _in_blender(function: str, *arguments: Any) -> Any:
    """A function of `falling_bodies`, in a process that knows nothing of Blender yet."""
    from . import falling_bodies

    return getattr(falling_bodies, function)(*arguments)


def measure(
    bodies: int, shape: str, frames: int, passes: int, settled: bool, strategy: str, impacts: bool
) -> Row:
    """Play the scene without tracing, with it, and without once more, in turns."""
    turn = turn_of(bodies)
    seconds, worked = np.full((2, 3, frames), np.inf)
    for _ in range(passes):
        blenders = [
            Blender(tracing, frames, bodies, shape, settled, strategy, impacts)
            for tracing in (False, True, False)
        ]
        for begin in range(0, frames, turn):
            numbers = range(begin + 1, min(begin + turn, frames) + 1)
            for times, cpu, blender in zip(seconds, worked, blenders, strict=True):
                of_clock, of_cpu = blender.play(numbers)
                times[begin:][: len(numbers)] = np.minimum(times[begin:][: len(numbers)], of_clock)
                cpu[begin:][: len(numbers)] = np.minimum(cpu[begin:][: len(numbers)], of_cpu)
        _, traced, _ = (blender.end() for blender in blenders)
    assert traced is not None
    beside = np.arange(frames) % turn > 0
    (off, on, again), (off_cpu, on_cpu, _) = 1000 * seconds[:, beside], 1000 * worked[:, beside]
    return Row(
        bodies=bodies,
        off=float(np.median(off)),
        on=float(np.median(on)),
        cost=float(np.median(on / off)) - 1,
        noise=float(np.median(again / off)) - 1,
        off_cpu=float(np.median(off_cpu)),
        on_cpu=float(np.median(on_cpu)),
        cost_cpu=float(np.median(on_cpu / off_cpu)) - 1,
        traced=traced,
    )


def run(
    bodies: tuple[int, ...] = (100, 300, 1000, 3000),
    settled: int = 10_000,
    frames: int = 200,
    passes: int = PASSES,
    shape: str = "BOX",
    strategy: str = "best_path",
    impacts: bool = True,
) -> list[Row]:
    """Print the table; its rows."""
    print(
        f"{frames} frames, {shape.lower()}, strategy {strategy}, "
        f"{'with' if impacts else 'without'} impacts; milliseconds a frame"
    )
    columns = (
        "bodies      off       on    cost  noise   goal | CPU: off       on    cost | "
        "handler | contacts  queries  avoided     MB"
    )
    print(f" {columns}  stages")
    rows = []
    for count in bodies:
        row = measure(count, shape, frames, passes, False, strategy, impacts)
        rows.append(row)
        goal = f"{GOALS[count]:.0%}" if count in GOALS else ""
        _show(row, goal)
    if settled:
        row = measure(settled, shape, frames, passes, True, strategy, impacts)
        rows.append(row)
        _show(row, "")
        waits, beside = row.traced.handler - row.traced.stages["read"], row.traced.beyond
        words = (
            f"Blender waits {waits:.2f} ms a frame beyond reading (goal {SETTLED_GOAL:g} "
            f"ms), {beside:.2f} ms pass beside it"
        )
        print(f"{settled} settled, one local source: {words}", flush=True)
    with multiprocessing.get_context("spawn").Pool(1) as blender:
        off, untagged = blender.apply(_in_blender, ("idle",))
        print(
            f"the handler where tracing is off: {off:.1f} us, where nothing is tagged: "
            f"{untagged:.1f} us (goal 20 us)"
        )
    return rows


def _show(row: Row, goal: str) -> None:
    traced = row.traced
    stages = ", ".join(
        f"{stage} {milliseconds:.2f}" for stage, milliseconds in traced.stages.items()
    )
    print(
        f"{row.bodies:7} {row.off:8.2f} {row.on:8.2f} {row.cost:7.1%} {row.noise:6.1%} {goal:>6} |"
        f" {row.off_cpu:8.2f} {row.on_cpu:8.2f} {row.cost_cpu:7.1%} | {traced.handler:7.2f} |"
        f" {traced.contacts:8.0f} {traced.queries:8} {traced.avoided:8} "
        f"{traced.memory / 1e6:6.1f}  {stages}",
        flush=True,
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--bodies", type=int, nargs="*", default=[100, 300, 1000, 3000])
    parser.add_argument("--settled", type=int, default=10_000)
    parser.add_argument("--frames", type=int, default=200)
    parser.add_argument("--passes", type=int, default=PASSES)
    parser.add_argument("--shape", default="BOX")
    parser.add_argument(
        "--strategy",
        choices=("best_path", "as_in_the_paper"),
        default="best_path",
    )
    parser.add_argument("--impacts", action=argparse.BooleanOptionalAction, default=True)
    options = parser.parse_args()
    run(
        tuple(options.bodies),
        options.settled,
        options.frames,
        options.passes,
        options.shape,
        options.strategy,
        options.impacts,
    )


if __name__ == "__main__":
    main()
