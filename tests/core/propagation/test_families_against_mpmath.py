"""Every family of the benchmarks, judged by mpmath: best path and sums over paths, to 1e-12."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import mpmath
import pytest
from haptic_tracing.core.graph.haptic_graph import HapticGraph
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.values import HapticObject, Mode, Settings, Strategy
from path_reference import recursive_paths

spec = importlib.util.spec_from_file_location(
    "benchmark_families", Path(__file__).parents[3] / "benchmarks" / "families.py"
)
assert spec is not None
assert spec.loader is not None
families = importlib.util.module_from_spec(spec)
sys.modules[spec.name] = families
spec.loader.exec_module(families)

SMALL = {
    "tree": families.tree(60),
    "ladder": families.ladder(6),
    "wall": families.wall(3),
    "random contacts": families.random_contacts(9),
    "hub with arches": families.hub(4),
    "pile on a ground": families.pile(7, sources=1, listeners=4),
}


def close(got: float, exact: mpmath.mpf, tolerance: float = 1e-12) -> bool:
    return exact < 1e-300 or abs(mpmath.mpf(got) - exact) <= tolerance * exact


def length(graph: HapticGraph, a: int, b: int) -> mpmath.mpf:
    place = [[mpmath.mpf(x) for x in graph.node_position[node].tolist()] for node in (a, b)]
    return mpmath.sqrt(sum((x - y) ** 2 for x, y in zip(*place, strict=True)))


def exact_gain(item: HapticObject, distance: mpmath.mpf) -> mpmath.mpf:
    """The default function, from the authored numbers."""
    k = (1 - mpmath.mpf(item.kappa)) * mpmath.mpf(item.rho)
    return k * mpmath.exp(-max(k, mpmath.mpf(0.1)) * distance)


@pytest.mark.parametrize("name", SMALL)
def test_paths(name):
    graph = SMALL[name].graph()
    best = propagate(graph, Settings())
    total, limited = (
        propagate(graph, Settings(Mode.HT, Strategy.AS_IN_THE_PAPER, most, 0.0))
        for most in (None, 13)
    )
    with mpmath.workdps(40):
        cache: dict[tuple[int, int], mpmath.mpf] = {}
        for column in range(len(graph.listeners)):
            gains, few = [], []
            for path, _ in recursive_paths(graph, 0, column):
                product = mpmath.mpf(1)
                # The transmissions between are 1.
                for a, b in zip(path[::2], path[1::2], strict=True):
                    if (a, b) not in cache:
                        cache[a, b] = exact_gain(
                            graph.table.objects[graph.node_object[a]], length(graph, a, b)
                        )
                    product *= cache[a, b]
                gains.append(product)
                if len(path) <= 14:
                    few.append(product)
            largest = max(gains, default=mpmath.mpf(0))
            assert close(best.gain[0, column], largest if largest >= 1e-6 else mpmath.mpf(0))
            assert close(total.gain[0, column], mpmath.fsum(gains))
            assert close(limited.gain[0, column], mpmath.fsum(few))
    assert not total.limited.any()
