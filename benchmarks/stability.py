"""Numerical stability: scenes at the ends of what numbers can hold, against closed forms in mpmath.

    python -m benchmarks.stability

Each case is computed by both strategies. The error is relative to the exact gain, of the worst
scene of the case. Best paths below -120 dB have a gain of exactly 0; sums below 1e-300 are compared
with that number.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import mpmath
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.functions import Constant, Exponential, ModulationFunction
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Settings,
    Source,
    Strategy,
)

from .report import publish, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Place = tuple[float, float, float]
BEST, SUM = Strategy.BEST_PATH, Strategy.AS_IN_THE_PAPER
HERE: Place = (0.0, 0.0, 0.0)
LEAST = mpmath.mpf("1e-6")
"""Gain of a path at which the search for the best one ends."""
ROUNDING = 1e-12
"""Relative error that rounding may make."""


@dataclass(frozen=True, slots=True)
class Instance:
    """A scene with one source and one listener, and its exact gain by strategy."""

    scene: HapticScene
    exact: Mapping[Strategy, Any]


@dataclass(frozen=True, slots=True)
class Worst:
    """The worst relative error of a case by one strategy."""

    case: str
    strategy: str
    error: float


def scene_of(
    edges: Sequence[tuple[int, int]], functions: Sequence[ModulationFunction], listener: int
) -> HapticScene:
    """Objects by number, all nodes at one place; the source is on the first one."""
    objects = tuple(
        HapticObject(f"{number:06d}", 0.0, 1.0, function)
        for number, function in enumerate(functions)
    )
    contacts = tuple(Contact((f"{a:06d}", f"{b:06d}"), (HERE, HERE)) for a, b in edges)
    return HapticScene(
        objects, contacts, (Source("s", "000000"),), (Listener("l", f"{listener:06d}", radius=0.0),)
    )


def chain(gains: Sequence[float], *strategies: Strategy) -> Instance:
    """Objects in a row with a gain each: one path."""
    edges = list(itertools.pairwise(range(len(gains))))
    product = mpmath.fprod(mpmath.mpf(gain) for gain in gains)
    scene = scene_of(edges, [Constant(gain_value=gain) for gain in gains], len(gains) - 1)
    return Instance(scene, dict.fromkeys(strategies or (BEST, SUM), product))


def hub(spokes: int, gain: float, own: float) -> Instance:
    """A ground with a gain of ``gain`` and so many bodies on it, one of which has the listener: one
    path."""
    functions = [Constant(gain_value=gain), *[Constant(gain_value=own)] * spokes]
    scene = scene_of([(0, k) for k in range(1, spokes + 1)], functions, spokes)
    return Instance(scene, dict.fromkeys((BEST, SUM), mpmath.mpf(gain) * mpmath.mpf(own)))


def ring(count: int, gain: float) -> Instance:
    """Objects in a ring, the listener a third of the way round: two paths."""
    edges = [(k, (k + 1) % count) for k in range(count)]
    near, g = count // 3, mpmath.mpf(gain)
    scene = scene_of(edges, [Constant(gain_value=gain)] * count, near)
    return Instance(scene, {BEST: g ** (near + 1), SUM: g ** (near + 1) + g ** (count - near + 1)})


def lossless_ladder(columns: int) -> Instance:
    """Two rows of lossless blocks: 2 ** (columns - 1) shortest paths, each of the gain 1."""
    edges = [(2 * k, 2 * k + 1) for k in range(columns)] + [
        (2 * k + i, 2 * k + 2 + i) for k in range(columns - 1) for i in range(2)
    ]
    blocks = [Constant(gain_value=1.0)] * (2 * columns)
    return Instance(scene_of(edges, blocks, 2 * columns - 1), {BEST: mpmath.mpf(1)})


def zigzag(size: float, offset: float = 0.0) -> Instance:
    """Five bodies of a size [m] in a zigzag, damped over their size."""
    alpha = 0.4 / size
    places = [(offset + size * k, size * (k % 2) * 0.7, size * 0.3 * k * k) for k in range(6)]
    objects = tuple(HapticObject(f"o{k}", 0.0, 1.0, Exponential(alpha=alpha)) for k in range(5))
    contacts = tuple(
        Contact((f"o{k}", f"o{k + 1}"), (places[k + 1], places[k + 1])) for k in range(4)
    )
    scene = HapticScene(
        objects,
        contacts,
        (Source("s", "o0", places[0]),),
        (Listener("l", "o4", places[5], radius=0.0),),
    )
    exact = [[mpmath.mpf(x) for x in place] for place in places]
    length = mpmath.fsum(
        mpmath.sqrt(mpmath.fsum((x - y) ** 2 for x, y in zip(a, b, strict=True)))
        for a, b in itertools.pairwise(exact)
    )
    return Instance(scene, dict.fromkeys((BEST, SUM), mpmath.exp(-mpmath.mpf(alpha) * length)))


def coincident(count: int, gain: float) -> Instance:
    """Bodies at one place, the first touching all others and each of these the last."""
    middle = range(1, count - 1)
    edges = [(0, k) for k in middle] + [(k, count - 1) for k in middle]
    g, n = mpmath.mpf(gain), len(middle)
    # Through an odd number of the bodies between: there, back and there again.
    total = mpmath.fsum(math.perm(n, k) * g ** (2 * k + 1) for k in range(1, n + 1, 2))
    scene = scene_of(edges, [Constant(gain_value=gain)] * count, count - 1)
    return Instance(scene, {BEST: g**3, SUM: total})


def cases(scale: float = 1.0) -> Iterator[tuple[str, list[Instance]]]:
    """All cases; ``scale`` below 1 makes the large ones smaller."""

    def sized(count: int) -> int:
        return max(3, round(scale * count))

    long, middle, wide = sized(100_000), sized(10_000), sized(50_000)
    yield (
        "gains of 1e-300",
        [chain([1e-300]), chain([1e-150, 1e-150]), chain([1e-300, 0.5]), chain([1e-300] * 3)],
    )
    yield f"chain of {long:,}, gains of 1 - 1e-5", [chain([1 - 1e-5] * long, BEST)]
    yield f"chain of {middle:,}, gains of 1 - 1e-5", [chain([1 - 1e-5] * middle)]
    yield f"chain of {long:,}, lossless", [chain([1.0] * long, BEST), chain([1.0] * 20)]
    yield f"hub of {wide:,}", [hub(wide, 0.9, 0.5), hub(wide, 1.0, 1.0), hub(wide, 1e-6, 1.0)]
    yield (
        "rings of 30, gains next to 1",
        [ring(30, gain) for gain in (1 - 1e-6, 1 - 1e-12, math.nextafter(1, 0), 1.0)],
    )
    yield "2^899 paths of one gain", [lossless_ladder(900)]
    yield "coincident bodies", [coincident(9, gain) for gain in (0.05, 0.6, 1.0)]
    yield "sizes of 1e-6 to 1e6 m", [zigzag(10.0**power) for power in range(-6, 7)]
    yield "the same, 1e6 m from the origin", [zigzag(10.0**power, 1e6) for power in range(-6, 7)]
    yield "sizes of 1e-9 and 1e200 m", [zigzag(1e-9), zigzag(1e200)]


def worst_errors(case: str, instances: Sequence[Instance]) -> list[Worst]:
    """One row for each strategy with exact gains."""
    found = []
    for strategy in (BEST, SUM):
        errors = []
        for instance in instances:
            if strategy not in instance.exact:
                continue
            settings = Settings(strategy=strategy, max_connections=None, threshold=0.0)
            result = propagate(graph_of_scene(instance.scene), settings)
            exact, least = instance.exact[strategy], mpmath.mpf("1e-300")
            if strategy is BEST:
                exact, least = exact if exact >= LEAST * (1 - ROUNDING) else mpmath.mpf(0), LEAST
            gain = mpmath.mpf(float(result.gain[0, 0]))
            errors.append(float(abs(gain - exact) / max(exact, least)))
        if errors:
            found.append(Worst(case, str(strategy), max(errors)))
    return found


def draw(found: Sequence[Worst]) -> Figure:
    """Errors by case."""
    from matplotlib.figure import Figure

    names = list(dict.fromkeys(row.case for row in found))
    figure = Figure(figsize=(9, 5), layout="constrained")
    axis = figure.subplots()
    for strategy, marker in ((BEST, "o"), (SUM, "s")):
        own = [row for row in found if row.strategy == strategy]
        errors = [max(row.error, 1e-17) for row in own]
        at = [names.index(row.case) for row in own]
        axis.plot(errors, at, marker, label=str(strategy), alpha=0.7)
    axis.axvline(ROUNDING, color="#999999", linewidth=0.7, linestyle=":")
    axis.set(
        xscale="log",
        xlabel="worst relative error (1e-17: none)",
        yticks=range(len(names)),
        yticklabels=names,
    )
    axis.invert_yaxis()
    axis.grid(alpha=0.25)
    axis.legend(frameon=False)
    return figure


def main() -> None:
    """Compute, print, write."""
    with mpmath.workdps(60):
        found = [row for case, instances in cases() for row in worst_errors(case, instances)]
    errors = {(row.case, row.strategy): f"{row.error:.1e}" for row in found}
    rows = [
        (case, *(errors.get((case, str(strategy)), "-") for strategy in (BEST, SUM)))
        for case in dict.fromkeys(row.case for row in found)
    ]
    text = "Worst relative errors.\n\n" + table(("case", "best path", "as in the paper"), rows)
    publish("stability", "Numerical stability", text, [asdict(row) for row in found], draw(found))


if __name__ == "__main__":
    main()
