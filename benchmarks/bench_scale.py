"""What bakes and sweeps cost, on one worker and on two, and how well a model of few numbers tells
it.

    python -m benchmarks.bench_scale

The model: a process costs `start` seconds of a processor before its first frame and `frame` for
each that it traces. Both are fitted to two bakes, of 2 and of `FRAMES` frames; they then predict
parts of a bake, and sweeps, given what a sweep of one variant costs beside that variant. Processor
time is that of all processes and threads: what else the machine does counts little there, unlike in
`passed`.
"""

from __future__ import annotations

import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

FRAMES, PARTS, VARIANTS, SHORT = 128, 4, 6, 24
SAMPLES: tuple[tuple[str, list[str]], ...] = (("jackhammer_bench", []), ("pile", ["--count", "40"]))


def _cost(*arguments: object) -> tuple[float, float, str]:
    """Seconds that passed, seconds of processors, and what the command printed."""
    before, clock = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    command = [sys.executable, "-m", "haptic_tracing", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    passed, after = time.perf_counter() - clock, resource.getrusage(resource.RUSAGE_CHILDREN)
    return passed, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done.stdout


def _measure(name: str, more: list[str], folder: Path) -> None:
    blend = folder / f"{name}.blend"
    _cost("sample", name, *more, "--output", blend)
    bake = ("export", blend, "--out", folder, "--frames")
    few, many = (_cost(*bake, f"1:{last}")[1] for last in (2, FRAMES))
    frame = (many - few) / (FRAMES - 2)
    start = few - 2 * frame
    print(f"\n{name}: start {start:.2f} s, frame {1000 * frame:.1f} ms of a processor")
    print(f"{'':<34}{'measured':>10}{'model':>8}{'passed':>8}")

    for number in range(1, PARTS + 1):
        passed, used, said = _cost(*bake, f"1:{FRAMES}", "--part", f"{number}/{PARTS}")
        found = re.search(r"frames \d+ to (\d+)\), traced from frame (\d+)", said)
        assert found is not None
        traced = int(found[1]) - int(found[2]) + 1
        heading = f"part {number} of {PARTS}, {traced} frames traced"
        print(f"{heading:<34}{used:>10.2f}{start + traced * frame:>8.2f}{passed:>8.2f}")
    parts = [folder / f"{name}.{number}-of-{PARTS}.npz" for number in range(1, PARTS + 1)]
    passed, used, _ = _cost("export", *parts, "--out", folder)
    print(f"{f'merge of {FRAMES} frames':<34}{used:>10.2f}{'':>8}{passed:>8.2f}")

    def sweep(variants: int, workers: int) -> tuple[float, float, str]:
        study = folder / f"{name}{variants}.toml"
        energies = [number / 1000 for number in range(variants)]
        study.write_text(
            f"scenes = ['{blend.name}']\nframes = [1, "
            f"{SHORT}]\n[settings]\n'scene.haptics.minimum_energy' = {energies}\n"
        )
        return _cost("sweep", study, "--workers", workers, "--out", folder / str(workers))

    variant = start + SHORT * frame
    fixed = sweep(1, 1)[1] - variant
    print(f"{'sweep: check, scheduler, table':<34}{fixed:>10.2f}")
    for workers in (1, 2):
        passed, used, _ = sweep(VARIANTS, workers)
        title = f"sweep of {VARIANTS} × {SHORT} frames, {workers} worker{'s' * (workers > 1)}"
        print(f"{title:<34}{used:>10.2f}{fixed + VARIANTS * variant:>8.2f}{passed:>8.2f}")


def main() -> None:
    """Print a table for each sample."""
    for name, more in SAMPLES:
        with tempfile.TemporaryDirectory() as folder:
            _measure(name, more, Path(folder))


if __name__ == "__main__":
    main()
