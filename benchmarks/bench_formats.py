"""Cost of writing 150 s x 10 listeners in every format: seconds, memory, bytes, and similarity when
read back.

    python -m benchmarks.bench_formats [--seconds 150] [--listeners 10] [--formats wav hjif ...]

The listeners feel a jackhammer and falling crates, each as strongly as the way to it allows.
Samples lie on disk, as after tracing. Every format is written by a process of its own: `s` is the
time that writing takes, `CPU s` that of the processor, `MB more` by how much the most memory that
the process held exceeds what it held before, mapped samples included, `ST-SIM` the similarity
(vibromaf, 1 is the same) of the first 10 s of two listeners read back. AHAP and .tact carry
strengths, not waves, which ST-SIM compares; it does not apply to them. Needs vibromaf.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import argparse
import multiprocessing
import resource
import sys
import tempfile
import time
import warnings
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path

import numpy as np
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.io.catalogue import formats, named
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.scene.body import PAPER_LISTENERS
from haptic_tracing.core.scene.values import HapticObject, HapticScene, Listener
from haptic_tracing.core.signals import DEFAULT_IMPACT, Pulse

from .report import publish, table

RATE = 8000
TARGET = 10.0
HEARD = 10
"""Seconds that are compared."""
BLOCK = 512
WAVES = ("wav", "hjif", "haptic", "wyvrn")


@dataclass(frozen=True, slots=True)
class Row:
    """One format. ``similarity`` None where nothing is read back or no wave is carried."""

    name: str
    seconds: float
    processor_seconds: float
    megabytes_more: float
    files: int
    size: int
    similarity: float | None


def write_samples(seconds: float, listeners: int, path: Path) -> None:
    """What ``listeners`` feel for ``seconds``, as float32 in a file at ``path``."""
    count = round(seconds * RATE)
    blow = DEFAULT_IMPACT.sample(0, RATE // 4, RATE)
    felt = 0.5 * np.asarray(Pulse(25.0).sample(0, count, RATE))
    for begin in np.rint(impact_times(seconds) * RATE).astype(int):
        felt[begin : begin + len(blow)] += 0.8 * blow[: count - begin]
    samples = np.memmap(path, dtype="<f4", mode="w+", shape=(count, listeners))
    for first in range(0, count, RATE):
        samples[first : first + RATE] = felt[first : first + RATE, None] * gains_of(listeners)
    samples.flush()


def impact_times(seconds: float) -> np.ndarray:
    return np.arange(0.5, seconds, 1.7)


def gains_of(listeners: int) -> np.ndarray:
    return np.geomspace(0.03, 0.4, listeners)


def tracks(seconds: float, listeners: int, path: Path) -> Tracks:
    """The tracks whose samples are in a file."""
    times = impact_times(seconds)
    parts = [PAPER_LISTENERS[k % len(PAPER_LISTENERS)] for k in range(listeners)]
    felt = [
        ListenerTrack(
            f"{part} {k}", part, np.column_stack([times, np.full(len(times), 0.8 * gain)])
        )
        for k, (part, gain) in enumerate(zip(parts, gains_of(listeners), strict=True))
    ]
    return Tracks(
        tuple(felt),
        RATE,
        np.memmap(path, dtype="<f4", mode="r", shape=(round(seconds * RATE), listeners)).T,
    )


def measured(name: str, seconds: float, listeners: int, path: Path) -> Row:
    """Write one format, in this process, and read it back."""
    with tempfile.TemporaryDirectory(prefix="haptic-formats-") as folder:
        given = tracks(seconds, listeners, path)
        scene = HapticScene(
            (HapticObject("bench", 0.1, 0.9),),
            listeners=tuple(Listener(t.name, "bench") for t in given.listeners),
        )
        import_module(f"haptic_tracing.core.formats.{named(name).module}")
        options = {"tracks": "wav"} if name == "scene" else {}
        before = _most_memory()
        begun, used = time.perf_counter(), time.process_time()
        written = registry.write(name, Export("study", scene, given), folder, options)
        took, used = time.perf_counter() - begun, time.process_time() - used
        more = _most_memory() - before
        size = sum(path.stat().st_size for path in written.files)
        return Row(
            name,
            took,
            used,
            more,
            len(written.files),
            size,
            _similarity(name, given, written.files),
        )


def _most_memory() -> float:
    """Megabytes. Linux counts what the parent had, too, where it is asked by getrusage."""
    status = Path("/proc/self/status")
    if status.exists():
        return (
            next(
                float(line.split()[1])
                for line in status.read_text().splitlines()
                if line.startswith("VmHWM")
            )
            / 1e3
        )
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most / 1e6 if sys.platform == "darwin" else most / 1e3


def _similarity(name: str, given: Tracks, files: Sequence[Path]) -> float | None:
    if name not in WAVES:
        return None
    suffix = named(name).suffix
    paths = [path for path in files if path.name.endswith(suffix)]
    channels = [channel for path in paths[:2] for channel in registry.read(path).channels[:2]][:2]
    count = min(HEARD * RATE, given.count) // BLOCK * BLOCK
    scores = []
    for row, channel in zip(given.samples, channels, strict=False):
        again = np.pad(
            channel.at_rate(RATE)[:count], (0, max(count - len(channel.at_rate(RATE)), 0))
        )
        scores.append(similarity(np.array(row[:count], dtype=np.float64), again))
    return min(scores)


def similarity(source: np.ndarray, again: np.ndarray) -> float:
    """ST-SIM over the blocks in which the source sounds; it has no value where there is silence."""
    from vibromaf.metrics.stsim import st_sim

    sounds = np.abs(source.reshape(-1, BLOCK)).max(axis=1) > 2e-4
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        # Complex where the waves are in opposite phase: a root of a negative structure.
        return float(
            np.real(
                st_sim(
                    again.reshape(-1, BLOCK)[sounds].ravel(),
                    source.reshape(-1, BLOCK)[sounds].ravel(),
                )
            )
        )


def run(
    names: Sequence[str] = tuple(formats()), seconds: float = 150.0, listeners: int = 10
) -> list[Row]:
    """All formats, each in a process of its own."""
    context = multiprocessing.get_context("spawn")
    rows = []
    with tempfile.TemporaryDirectory(prefix="haptic-formats-") as folder:
        path = Path(folder) / "samples"
        write_samples(seconds, listeners, path)
        for name in names:
            with context.Pool(1) as pool:
                rows.append(pool.apply(measured, (name, seconds, listeners, path)))
    return rows


def main() -> None:
    """Print the table and keep it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=150.0)
    parser.add_argument("--listeners", type=int, default=10)
    parser.add_argument("--formats", nargs="+", default=list(formats()), choices=list(formats()))
    options = parser.parse_args()
    rows = run(options.formats, options.seconds, options.listeners)
    cells = [
        (
            row.name,
            f"{row.seconds:.2f}",
            f"{row.processor_seconds:.2f}",
            f"{row.megabytes_more:.0f}",
            f"{row.files}",
            f"{row.size:,}",
            "-" if row.similarity is None else f"{row.similarity:.3f}",
        )
        for row in rows
    ]
    total, used = (
        sum(getattr(row, key) for row in rows) for key in ("seconds", "processor_seconds")
    )
    text = table(("format", "s", "CPU s", "MB more", "files", "bytes", "ST-SIM"), cells)
    text += (
        f"\n\n{options.listeners} listeners for {options.seconds:g} s at {RATE} Hz: "
        f"{total:.1f} s in all, "
    )
    text += f"{used:.1f} s of the processor (target: {TARGET:g} s)"
    data = [asdict(row) for row in rows]
    publish(
        "formats",
        "What writing each format costs",
        text,
        {"seconds": options.seconds, "listeners": options.listeners, "rows": data},
    )


if __name__ == "__main__":
    main()
