"""Cost of baking the mine ride with tracing, relative to stepping the same frames without.

    python -m benchmarks.bench_study [--frames 3600]

The runs go through all frames in order, in a process of their own each. `ratio` compares the
seconds that passed, `CPU` those of the processor, of all threads: what else the machine does counts
little there. `four modes` renders each traced frame in HT, SD, MD and MN as the study does. Memory
is the peak of the process beyond that of stepping alone.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import time

GOAL_RATIO, GOAL_MEGABYTES = 1.15, 1000.0
RUNS = ("stepping", "tracing", "four modes")


def _measure(run: str, frames: int) -> dict[str, float]:
    """One run, in this process."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    import bpy
    import haptic_tracing
    from haptic_tracing.addon.changes.suspension import suspended
    from haptic_tracing.addon.session import timeline
    from haptic_tracing.sample_scenes import build_sample

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    haptic_tracing.register()
    with suspended():
        scene = build_sample("mine_ride")
        scene.frame_set(scene.frame_start)
    stages: dict[str, float] = {}
    begun, clock = time.process_time(), time.perf_counter()
    if run == "stepping":
        with suspended():
            for frame in range(1, frames + 1):
                scene.frame_set(frame)
    elif run == "tracing":
        for result in timeline.results(scene, 1, frames):
            for stage, milliseconds in result.milliseconds.items():
                stages[stage] = stages.get(stage, 0.0) + milliseconds / frames
    else:
        from haptic_tracing.study.baking import bake_ride

        bake_ride(scene, 1, frames)
    seconds, passed = time.process_time() - begun, time.perf_counter() - clock
    haptic_tracing.unregister()
    return {
        "seconds": seconds,
        "passed": passed,
        "megabytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        **stages,
    }


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--frames", type=int, default=3600)
    parser.add_argument("--run", choices=RUNS, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.run:
        print("measured " + json.dumps(_measure(options.run, options.frames)))
        return
    measured = {}
    for run in RUNS:
        command = [
            sys.executable,
            "-m",
            "benchmarks.bench_study",
            "--run",
            run,
            "--frames",
            str(options.frames),
        ]
        answer = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
        (line,) = [line for line in answer.stdout.splitlines() if line.startswith("measured ")]
        measured[run] = json.loads(line.removeprefix("measured "))
    alone = measured["stepping"]
    print(f"{options.frames} frames of the mine ride")
    print(f"{'run':12} {'seconds':>9} {'ms a frame':>11} {'ratio':>7} {'CPU':>7} {'MB more':>8}")
    for run, row in measured.items():
        ratio, processor, more = (
            row["passed"] / alone["passed"],
            row["seconds"] / alone["seconds"],
            row["megabytes"] - alone["megabytes"],
        )
        print(
            f"{run:12} {row['passed']:9.1f} {1000 * row['passed'] / options.frames:11.2f} "
            f"{ratio:7.2f} {processor:7.2f} {more:8.0f}"
        )
    stages = {
        key: value
        for key, value in measured["tracing"].items()
        if key not in ("seconds", "passed", "megabytes")
    }
    print(
        "tracing by stage, milliseconds passed a frame: "
        + ", ".join(f"{stage} {value:.2f}" for stage, value in stages.items())
    )
    print(f"goal: ratio at most {GOAL_RATIO:g}, at most {GOAL_MEGABYTES:g} MB more")


if __name__ == "__main__":
    main()
