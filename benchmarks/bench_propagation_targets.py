"""Targets of propagation, as ratios within one run where a peer exists.

    python -m benchmarks.bench_propagation_targets [--demo]

``--demo`` measures and prints the first row alone, without a peer. The rows of the certified 1 %
are taken from what ``bench_propagation_error`` measured last.
"""

from __future__ import annotations

import argparse
import os
import statistics
import time
from dataclasses import asdict, dataclass, replace

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
from haptic_tracing.core.graph.haptic_graph import ObjectTable
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.propagation.energy_balance import energy_gains
from haptic_tracing.core.scene.measured import physical
from haptic_tracing.core.scene.values import Settings, Strategy
from haptic_tracing.core.signals import Sine

from .bench_propagation_error import BY_CONNECTIONS, ENUMERATION, WANTED, Measured, measured_before
from .families import Family, ladder, pile, traced, wall
from .frames import demo_family
from .peers import by_networkx, by_rustworkx, by_scipy
from .report import milliseconds, publish, table
from .timing import best_time, peak

DEFAULT = Settings()
LIMITED = Settings(strategy=Strategy.BEST_PATH)
BEST = Settings(strategy=Strategy.BEST_PATH, max_connections=None, threshold=0.0)
EXACT = Settings(strategy=Strategy.ALL_PATHS, max_connections=None, threshold=0.0, tolerance=0.0)
ENOUGH = 0.05
"""Seconds of enumeration below which a scene is left out."""


@dataclass(frozen=True, slots=True)
class Target:
    """One row: the target, the measurement, and whether it is met."""

    what: str
    wanted: str
    measured: str
    reached: bool


def best_path(family: Family) -> np.ndarray:
    return propagate(family.graph(), BEST).gain


def against_peers() -> list[Target]:
    """Piles on a ground: graph and best paths, against explicit graphs; no limits on either side,
    and gains checked to be equal."""
    targets = []
    for family, others in (
        (
            pile(1000),
            (
                (by_networkx, "NetworkX", 100, 1),
                (by_scipy, "SciPy", 10, 5),
                (by_rustworkx, "rustworkx", 0, 2),
            ),
        ),
        (pile(5000), ((by_scipy, "SciPy", 50, 2),)),
    ):
        ours = best_time(best_path, family, runs=9)
        gains = best_path(family)
        for other, name, wanted, runs in others:
            seconds = best_time(other, family, runs=runs)
            if not np.allclose(other(family), gains, rtol=1e-9, atol=0):
                raise AssertionError(f"{name} finds other gains")
            implied = family.graph().intra_connection_count()
            targets.append(
                Target(
                    f"pile of {len(family.table.names) - 1:,} ({implied:,} implied "
                    "intra-connections), 4 sources, 10 listeners, "
                    f"graph + best_path, against {name}",
                    f"{wanted} times faster" if wanted else "-",
                    f"{seconds / ours:.0f} times ({milliseconds(ours)} ms, "
                    f"{milliseconds(seconds)} ms)",
                    seconds / ours >= wanted,
                )
            )
    return [*targets, memory()]


def memory() -> Target:
    """What graph and best paths take at most, by contacts."""
    sizes = (1000, 5000, 20_000)
    families = [pile(size) for size in sizes]
    each = [peak(best_path, family) / len(family.contacts) for family in families]
    return Target(
        f"memory for piles of {', '.join(f'{size:,}' for size in sizes)}",
        "proportional to contacts",
        ", ".join(f"{value:.0f}" for value in each) + " bytes a contact",
        each[-1] < 1.2 * each[0],
    )


def exact_sums() -> list[Target]:
    """Sums over more paths than can be enumerated; the ladder against its transfer matrix."""
    family = ladder(60)
    seconds = best_time(traced, family, EXACT)
    result = propagate(family.graph(), EXACT)
    error = abs(result.gain[0, 0] / float(_ladder_by_transfer(family)) - 1)
    block = wall(25)
    wide = best_time(traced, block, EXACT)
    proven = float(propagate(block.graph(), EXACT).error_bound.max())
    return [
        Target(
            "ladder 2 x 60 (2^59 paths), exact",
            "relative error 1e-9, under 20 ms",
            f"{error:.1g}, {milliseconds(seconds)} ms",
            bool(error < 1e-9 and seconds < 0.02 and result.error_bound.max() == 0),
        ),
        Target(
            "wall 4 x 25, exact",
            "under 500 ms",
            f"{milliseconds(wide)} ms",
            bool(wide < 0.5 and proven == 0),
        ),
    ]


def _ladder_by_transfer(family: Family) -> float:
    """The sum over all paths of a ladder of two rows: column by column a path crosses the rung or
    not, and never goes back."""
    graph = family.graph()

    def gain(a: int, b: int) -> float:
        return float(
            graph.table.gain(
                int(graph.node_object[a]), graph.node_distances(np.array([a]), np.array([b]))
            )[0]
        )

    columns = len(graph.table.names) // 2
    across: dict[tuple[int, int], int] = {}
    for node, other in enumerate(graph.partner.tolist()):
        if other >= 0:
            across[int(graph.node_object[node]), int(graph.node_object[other])] = node
    source, listener = graph.sources[0].nodes[0], int(graph.listener_nodes[0])
    # Entries of this column's objects, and what arrives there.
    here: list[tuple[int, float]] = [(source, 1.0)]
    for column in range(columns):
        pair = 2 * column, 2 * column + 1
        through = {index: across[index, other] for index, other in (pair, pair[::-1])}
        inside: dict[int, list[tuple[int, float]]] = {index: [] for index in pair}
        for entry, value in here:
            index = int(graph.node_object[entry])
            other = sum(pair) - index
            inside[index].append((entry, value))
            inside[other].append((through[other], value * gain(entry, through[index])))
        if column == columns - 1:
            return sum(
                value * gain(entry, listener)
                for entry, value in inside[int(graph.node_object[listener])]
            )
        here = []
        for index, arrived in inside.items():
            way = across[index, index + 2]
            here.append(
                (int(graph.partner[way]), sum(value * gain(entry, way) for entry, value in arrived))
            )
    raise AssertionError("a ladder ends at its last column")


def certified(measured: list[Measured]) -> list[Target]:
    """Time to a certified 1 % of the sum over all paths, against enumeration to the same true
    error, with its best setting."""
    targets = []
    for item in measured:
        ours = item.certified()
        plain = item.fastest((ENUMERATION, BY_CONNECTIONS), max(ours.error, 1e-9))
        one = item.fastest((ENUMERATION, BY_CONNECTIONS), WANTED)
        seconds = max(point.seconds for point in item.points if point.curve == ENUMERATION)
        least = seconds if plain is None else plain.seconds
        said = (
            f"over {milliseconds(seconds)} ms"
            if plain is None
            else f"{milliseconds(plain.seconds)} ms"
        )
        to_one = "" if one is None else f", to a true 1 % {milliseconds(one.seconds)} ms"
        proven = ours.bound is not None and ours.bound <= WANTED * (1 + 1e-9)
        ratio = least / ours.seconds
        if plain is not None and plain.seconds < ENOUGH:
            wanted, reached = "-", bool(proven)
        else:
            wanted, reached = "10 times faster", bool(proven and ratio >= 10)
        faster = f"{'over ' if plain is None else ''}{ratio:.0f} times"
        targets.append(
            Target(
                f"certified 1 % in {item.family}, {item.objects} objects, against breadth-first "
                "enumeration to the same true error",
                wanted,
                f"{faster} ({milliseconds(ours.seconds)} ms with error {ours.error:.1g}; "
                f"{said}{to_one})",
                reached,
            )
        )
    return targets


def demo_frame() -> list[Target]:
    """The demo's persistent source and its 10 listeners, as a frame does it: graph, then
    propagation by the default settings."""
    family = demo_family()
    times = []
    for _ in range(500):
        begun = time.process_time()
        propagate(family.graph(), DEFAULT)
        times.append(1000 * (time.process_time() - begun))
    median = statistics.median(times)
    count = f"{len(family.table.names)} objects, {len(family.contacts)} contacts"
    what = f"one persistent source, {len(family.listeners)} listeners, demo scene ({count})"
    return [
        Target(
            what, "under 0.6 ms a frame", f"{median:.2f} ms (best {min(times):.2f})", median < 0.6
        )
    ]


def default_strategy() -> Target:
    """The default, which has no limit of connections, against best paths with the scene's
    limits."""
    graph = pile(1000).graph()
    default, limited = (
        best_time(propagate, graph, chosen, runs=20) for chosen in (DEFAULT, LIMITED)
    )
    return Target(
        "pile of 1,000, 4 sources, 10 listeners, default strategy, against best_path",
        "at most 2 times its time",
        f"{default / limited:.2f} times ({milliseconds(default)} ms, {milliseconds(limited)} ms)",
        default <= 2 * limited,
    )


def energy_balances() -> list[Target]:
    """Piles of one material, κ 0.1 and ρ 0.9; the graph is not included."""
    targets = []
    for count, wanted in ((100, 1), (300, 3), (1000, 10)):
        graph = pile(count, low=0.81, high=0.81).graph()
        pairs = np.ones((len(graph.sources), len(graph.listeners)), dtype=np.bool_)
        seconds = best_time(energy_gains, graph, pairs, runs=30)
        first = best_time(energy_gains, graph, pairs & (np.arange(4) == 0)[:, None], runs=30)
        targets.append(
            Target(
                f"energy balance, pile of {count:,}, 4 sources, 10 listeners (one source)",
                f"{wanted} ms",
                f"{milliseconds(seconds)} ms ({milliseconds(first)} ms)",
                seconds <= wanted / 1000,
            )
        )
    return targets


def physical_materials() -> list[Target]:
    """Piles of stone on soil as they were measured, in bands, against their plain gain, and against
    the paper's function, by which less arrives; graph and propagation by default settings. Sources
    of one frequency band, and of four, whose paths are found for each."""
    targets = []
    for count in (100, 1000):
        paper = pile(count)
        measured = [physical("soil", (20, 20, 1)), *[physical("stone", (0.3, 0.3, 0.3))] * count]
        objects = [
            replace(item, propagation=function)
            for item, function in zip(paper.table.objects, measured, strict=True)
        ]
        bands = replace(paper, table=ObjectTable.of(objects, paper.table.epsilon))
        plain = replace(bands, table=replace(bands.table, band_decays=None))
        four = [
            replace(item, signal=Sine(frequency))
            for item, frequency in zip(bands.sources, (30, 60, 120, 250), strict=True)
        ]
        several = replace(bands, sources=tuple(four))
        chosen = (paper, plain, bands, several)
        times = [best_time(traced, family, DEFAULT, runs=100) for family in chosen]
        arrived = [int((propagate(family.graph(), DEFAULT).gain > 0).sum()) for family in chosen]
        for what, time_, pairs, base, other in (
            (
                "sources of one band, against the plain gain",
                times[2],
                arrived[2],
                times[1],
                arrived[1],
            ),
            (
                "sources of four bands, against the plain gain",
                times[3],
                arrived[3],
                times[1],
                arrived[1],
            ),
            (
                "sources of one band, against the paper's function",
                times[2],
                arrived[2],
                times[0],
                arrived[0],
            ),
        ):
            targets.append(
                Target(
                    f"pile of {count:,}, 4 sources, 10 listeners, physical materials in bands, "
                    f"{what}",
                    "at most 1.5 times its time",
                    f"{time_ / base:.2f} times ({milliseconds(time_)} ms, {pairs} of 40 pairs "
                    f"arrive; {milliseconds(base)} ms, {other})",
                    time_ <= 1.5 * base,
                )
            )
    return targets


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--demo", action="store_true")
    if parser.parse_args().demo:
        print(*(f"{target.what}: {target.measured}" for target in demo_frame()), sep="\n")
        return
    targets = [
        *demo_frame(),
        default_strategy(),
        *energy_balances(),
        *physical_materials(),
        *exact_sums(),
        *against_peers(),
        *certified(measured_before()),
    ]
    rows = [(t.what, t.wanted, t.measured, "yes" if t.reached else "**no**") for t in targets]
    note = (
        "Seconds are those of the processor, one thread; the graph is built in each of them. The "
        "rows of the certified 1 % are those of\n"
        "[propagation_error](propagation_error.md), where enumeration is given the setting that "
        "is quickest to the error."
    )
    text = f"{note}\n\n" + table(("what", "at least", "measured", "reached"), rows)
    publish(
        "propagation_targets",
        "What propagation reaches",
        text,
        [asdict(target) for target in targets],
    )


if __name__ == "__main__":
    main()
