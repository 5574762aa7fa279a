"""Numerical stability: scenes at the ends of what numbers can hold, against mpmath and closed
forms.

    python -m benchmarks.stability

Every case is computed by all three strategies. The error is relative to the exact gain, of the
worst instance of the case; gains below 1e-300 (1e-6 with the energy balance, which stops at -120
dB) are compared with that number. An error bound holds if the exact gain lies within it, or differs
by rounding.
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
BEST, SUM, ENERGY = Strategy.BEST_PATH, Strategy.ALL_PATHS, Strategy.ENERGY_BALANCE
HERE: Place = (0.0, 0.0, 0.0)
SMALLEST = {BEST: 1e-300, SUM: 1e-300, ENERGY: 1e-6}
"""Gains below this may be 0; the energy balance stops at -120 dB."""
UPTAKE = mpmath.mpf(1) / 200
"""What every object takes up of the power that it is given, beside its losses."""
ROUNDING = 1e-12
"""Relative error that rounding may make of a best path or a sum whose bound says that it is
exact."""


@dataclass(frozen=True, slots=True)
class Instance:
    """A scene with one source and one listener, and its exact gain by strategy."""

    scene: HapticScene
    exact: Mapping[Strategy, Any]


@dataclass(frozen=True, slots=True)
class Worst:
    """The worst relative error of a case by one strategy, and whether every exact gain lies within
    its error bound."""

    case: str
    strategy: str
    error: float
    bounded: bool


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


def balanced(own: Any, across: Any, other: Any) -> Any:
    """Gain of the energy balance between two objects that nothing makes large, by their energies
    under unit power: of the first one under its own, from one to the other, of the other under its
    own."""
    takes = (1 - UPTAKE) / 3
    both = (1 + takes * own) * (1 + takes * other) - (takes * across) ** 2 + takes * across
    return mpmath.sqrt(across / both)


def along_chain(gains: Sequence[Any]) -> Any:
    """Gain from the first to the last object of a chain by the energy balance: Gaussian elimination
    from either end."""
    damping = [gain**-2 - 1 + UPTAKE for gain in gains]

    def eliminated(damping: Sequence[Any]) -> tuple[Any, Any]:
        """Energies of the last object under power at the last, and at the first one."""
        last = len(damping) - 1
        pivot, power = damping[0] + min(last, 1), mpmath.mpf(1)
        for number in range(1, len(damping)):
            pivot, power = (
                damping[number] + (2 if number < last else 1) - 1 / pivot,
                power / pivot,
            )
        return 1 / pivot, power / pivot

    (own, across), (other, _) = eliminated(damping), eliminated(damping[::-1])
    return balanced(other, across, own)


def chain(gains: Sequence[float]) -> Instance:
    """Objects in a row with a gain each: one path."""
    edges = list(itertools.pairwise(range(len(gains))))
    product = mpmath.fprod(mpmath.mpf(gain) for gain in gains)
    scene = scene_of(edges, [Constant(gain_value=gain) for gain in gains], len(gains) - 1)
    energy = along_chain([mpmath.mpf(gain) for gain in gains])
    return Instance(scene, {BEST: product, SUM: product, ENERGY: energy})


def hub(spokes: int, gain: float, own: float) -> Instance:
    """A ground with a gain of ``gain`` and so many bodies on it, one of which has the listener: one
    path."""
    scene = scene_of(
        [(0, k) for k in range(1, spokes + 1)],
        [Constant(gain_value=gain), *[Constant(gain_value=own)] * spokes],
        spokes,
    )
    g, k = mpmath.mpf(gain), mpmath.mpf(own)
    ground, body = g**-2 - 1 + UPTAKE, k**-2 - 1 + UPTAKE
    others = ground + (spokes - 1) * body / (1 + body)
    middle = 1 / (others + body / (1 + body))
    energy = balanced(middle, middle / (1 + body), 1 / (body + others / (1 + others)))
    return Instance(scene, {BEST: g * k, SUM: g * k, ENERGY: energy})


def ring(count: int, gain: float) -> Instance:
    """Objects in a ring, whose walk operator has the radius ``gain``; the listener a third of the
    way round: two paths."""
    edges = [(k, (k + 1) % count) for k in range(count)]
    near, g = count // 3, mpmath.mpf(gain)
    scene = scene_of(edges, [Constant(gain_value=gain)] * count, near)
    return Instance(scene, {BEST: g ** (near + 1), SUM: g ** (near + 1) + g ** (count - near + 1)})


def lossless_ladder(columns: int) -> Instance:
    """Two rows of lossless blocks: 2 ** (columns - 1) paths, of which each has the gain 1."""
    edges = [(2 * k, 2 * k + 1) for k in range(columns)] + [
        (2 * k + i, 2 * k + 2 + i) for k in range(columns - 1) for i in range(2)
    ]
    return Instance(
        scene_of(edges, [Constant(gain_value=1.0)] * (2 * columns), 2 * columns - 1),
        {BEST: 1, SUM: mpmath.mpf(2) ** (columns - 1)},
    )


def zigzag(size: float, offset: float = 0.0) -> Instance:
    """Five bodies of a size [m] in a zigzag, damped over their size."""
    alpha, places = (
        0.4 / size,
        [(offset + size * k, size * (k % 2) * 0.7, size * 0.3 * k * k) for k in range(6)],
    )
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
    gain = mpmath.exp(-mpmath.mpf(alpha) * length)
    return Instance(scene, {BEST: gain, SUM: gain})


def coincident(count: int, gain: float) -> Instance:
    """Bodies at one place, the first touching all others and each of these the last."""
    middle = range(1, count - 1)
    edges = [(0, k) for k in middle] + [(k, count - 1) for k in middle]
    g, n = mpmath.mpf(gain), len(middle)
    # Through an odd number of the bodies between: there, back and there again.
    total = mpmath.fsum(math.perm(n, k) * g ** (2 * k + 1) for k in range(1, n + 1, 2))
    return Instance(
        scene_of(edges, [Constant(gain_value=gain)] * count, count - 1), {BEST: g**3, SUM: total}
    )


def cases(scale: float = 1.0) -> Iterator[tuple[str, list[Instance]]]:
    """All cases; ``scale`` below 1 makes the large ones smaller."""

    def sized(count: int) -> int:
        return max(3, round(scale * count))

    long, wide = sized(100_000), sized(50_000)
    yield (
        "gains of 1e-300",
        [chain([1e-300]), chain([1e-150, 1e-150]), chain([1e-300, 0.5]), chain([1e-300] * 3)],
    )
    yield f"chain of {long:,}, gains of 1 - 1e-5", [chain([1 - 1e-5] * long)]
    yield f"chain of {long:,}, gains of 0.001", [chain([0.001] * long)]
    yield f"chain of {long:,}, lossless", [chain([1.0] * long), chain([1.0] * 20)]
    yield f"hub of {wide:,}", [hub(wide, 0.9, 0.5), hub(wide, 1.0, 1.0), hub(wide, 1e-6, 1.0)]
    yield (
        "walk radius at 1",
        [ring(30, gain) for gain in (1 - 1e-6, 1 - 1e-12, math.nextafter(1, 0), 1.0)],
    )
    yield "2^899 paths, radius above 1", [lossless_ladder(900)]
    yield "coincident bodies", [coincident(9, gain) for gain in (0.05, 0.6, 1.0)]
    yield "sizes of 1e-6 to 1e6 m", [zigzag(10.0**power) for power in range(-6, 7)]
    yield "the same, 1e6 m from the origin", [zigzag(10.0**power, 1e6) for power in range(-6, 7)]


def worst_errors(case: str, instances: Sequence[Instance]) -> list[Worst]:
    """One row for each strategy with exact gains."""
    found = []
    for strategy in (BEST, SUM, ENERGY):
        errors, bounded = [], True
        for instance in instances:
            if strategy not in instance.exact:
                continue
            result = propagate(
                graph_of_scene(instance.scene),
                Settings(strategy=strategy, max_connections=None, threshold=0.0, tolerance=0.0),
            )
            gain, bound, exact = (
                mpmath.mpf(float(result.gain[0, 0])),
                float(result.error_bound[0, 0]),
                instance.exact[strategy],
            )
            beyond = abs(gain - exact)
            errors.append(float(beyond / max(exact, SMALLEST[strategy])))
            bounded &= bool(beyond <= bound + ROUNDING * exact + 1e-300)
        if errors:
            found.append(Worst(case, str(strategy), max(errors), bounded))
    return found


def draw(found: Sequence[Worst]) -> Figure:
    """Errors by case."""
    from matplotlib.figure import Figure

    names = list(dict.fromkeys(row.case for row in found))
    figure = Figure(figsize=(9, 5), layout="constrained")
    axis = figure.subplots()
    for strategy, marker in ((BEST, "o"), (SUM, "s"), (ENERGY, "^")):
        own = [row for row in found if row.strategy == strategy]
        axis.plot(
            [max(row.error, 1e-17) for row in own],
            [names.index(row.case) for row in own],
            marker,
            label=str(strategy),
            alpha=0.7,
        )
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
    by_case = {
        name: {row.strategy: row for row in found if row.case == name}
        for name in dict.fromkeys(row.case for row in found)
    }

    def cell(row: Worst | None) -> str:
        return (
            "-"
            if row is None
            else f"{row.error:.1e}" + ("" if row.bounded else " **outside its bound**")
        )

    rows = [
        (name, *(cell(own.get(str(strategy))) for strategy in (BEST, SUM, ENERGY)))
        for name, own in by_case.items()
    ]
    text = (
        "Worst relative errors; every exact gain lies within its error bound unless the table "
        "says otherwise.\n\n"
    )
    text += table(("case", "best path", "sum over all paths", "energy balance"), rows)
    publish("stability", "Numerical stability", text, [asdict(row) for row in found], draw(found))


if __name__ == "__main__":
    main()
