"""Every family of the benchmarks, judged by mpmath: best path, sum over all paths, energies and
bounds of walks, to 1e-12."""

from __future__ import annotations

import importlib.util
import math
import sys
from pathlib import Path

import mpmath
import numpy as np
import pytest
from energy_reference import energy_gain
from haptic_tracing.core.graph.haptic_graph import HapticGraph, graph_of_scene
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.propagation.exact.step_graph import build_step_graph, walk_sums
from haptic_tracing.core.scene.functions import Constant, Exponential
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Settings,
    Source,
    Strategy,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from path_reference import connected_scene, recursive_paths

spec = importlib.util.spec_from_file_location(
    "benchmark_families", Path(__file__).parents[3] / "benchmarks" / "families.py"
)
assert spec is not None
assert spec.loader is not None
families = importlib.util.module_from_spec(spec)
sys.modules[spec.name] = families
spec.loader.exec_module(families)

FREE = {"max_connections": None, "threshold": 0.0, "tolerance": 0.0}
SMALL = {
    "tree": families.tree(60),
    "ladder": families.ladder(6),
    "wall": families.wall(3),
    "random contacts": families.random_contacts(9),
    "hub with arches": families.hub(4),
    "pile on a ground": families.pile(7, sources=1, listeners=4),
}
LARGER = {
    "tree": families.tree(60),
    "ladder": families.ladder(30),
    "wall": families.wall(15),
    "random contacts": families.random_contacts(60),
    "hub with arches": families.hub(30),
    "pile on a ground": families.pile(60, sources=2),
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
    best = propagate(graph, Settings(strategy=Strategy.BEST_PATH, **FREE))
    total = propagate(graph, Settings(strategy=Strategy.ALL_PATHS, **FREE))
    limited = propagate(
        graph,
        Settings(strategy=Strategy.ALL_PATHS, max_connections=13, threshold=0.0, tolerance=0.0),
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
            assert close(best.gain[0, column], max(gains, default=mpmath.mpf(0)))
            assert close(total.gain[0, column], mpmath.fsum(gains))
            assert close(limited.gain[0, column], mpmath.fsum(few))
    assert total.error_bound.max() == 0


@pytest.mark.parametrize("name", LARGER)
def test_energies(name):
    """Within the certified bound of the documented equations, written down a second time; and well
    within a hundredth of a decibel."""
    graph = LARGER[name].graph()
    result = propagate(graph, Settings(strategy=Strategy.ENERGY_BALANCE))
    with mpmath.workdps(30):
        for row, column in list(np.ndindex(result.gain.shape))[:4]:
            exact = energy_gain(graph, row, column)
            assert abs(result.gain[row, column] - exact) <= result.error_bound[row, column]
            assert result.error_bound[row, column] <= max(0.002 * exact, 1e-6)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 10**6), st.integers(3, 9))
def test_energies_from_authored_numbers(seed, count):
    """The documented equations once more, for objects small enough to be one subsystem each."""
    random = np.random.default_rng(seed)
    functions = [
        Exponential(alpha=float(random.uniform(0, 0.05))),
        Constant(gain_value=float(random.uniform(0.01, 1))),
    ]
    objects = tuple(
        HapticObject(f"o{i}", 0.0, 1.0, functions[random.integers(2)]) for i in range(count)
    )
    edges = [(i, int(random.integers(i))) for i in range(1, count)] + [(0, count - 1)]
    contacts = tuple(
        Contact(
            (f"o{a}", f"o{b}"),
            (p := tuple(random.uniform(0, 1, 3).tolist()), p),
            Constant(gain_value=float(random.uniform(0.1, 1))),
        )
        for a, b in edges
    )
    ends = [(float(random.uniform()), float(random.uniform()), 0.5) for _ in range(2)]
    scene = HapticScene(
        objects, contacts, (Source("s", "o0", ends[0]),), (Listener("l", f"o{count - 1}", ends[1]),)
    )
    graph = graph_of_scene(scene)
    with mpmath.workdps(40):

        def squared(index: int, distance: mpmath.mpf) -> mpmath.mpf:
            function = objects[index].propagation
            if isinstance(function, Exponential):
                return mpmath.exp(-2 * mpmath.mpf(function.alpha) * distance)
            return mpmath.mpf(function.gain_value) ** 2

        def apart(a, b) -> mpmath.mpf:
            return mpmath.sqrt(
                sum((mpmath.mpf(x) - mpmath.mpf(y)) ** 2 for x, y in zip(a, b, strict=True))
            )

        places = [
            [c.positions[0] for c, edge in zip(contacts, edges, strict=True) if index in edge]
            for index in range(count)
        ]
        damping, middles, least = [], [], mpmath.mpf(1) / 200
        for index, here in enumerate(places):
            number = len(here)
            middles.append([sum(mpmath.mpf(p[k]) for p in here) / number for k in range(3)])
            ratio = mpmath.sqrt(mpmath.mpf(2 * number) / max(number - 1, 1))
            through = [squared(index, ratio * apart(p, middles[-1])) for p in here]
            damping.append(number / sum(through) - 1 + least)
        matrix = mpmath.diag(damping)
        for (a, b), contact in zip(edges, contacts, strict=True):
            coupling = mpmath.mpf(contact.transmission.gain_value) ** 2
            for i, j in ((a, b), (b, a)):
                matrix[i, i] += coupling
                matrix[i, j] -= coupling
        last = count - 1
        energy, takes = matrix**-1, (1 - least) / 3
        own = (1 + takes * energy[0, 0]) * (1 + takes * energy[last, last])
        arrives = 1 / (own / energy[0, last] - takes**2 * energy[0, last])
        put_in, heard = (
            squared(index, apart(end, middles[index])) / squared(index, mpmath.mpf(0))
            for index, end in zip((0, last), ends, strict=True)
        )
        exact = mpmath.sqrt(put_in * heard / (1 / arrives + takes))
        result = propagate(graph, Settings(strategy=Strategy.ENERGY_BALANCE))
        assert abs(result.gain[0, 0] - exact) <= result.error_bound[0, 0] <= 0.002 * exact


@pytest.mark.slow
@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 10**6))
def test_walks(seed):
    """The bound of all walks is none too small, and not larger than rounding and its own remainder
    make it."""
    graph = graph_of_scene(
        connected_scene(
            seed,
            (Exponential(alpha=0.4), Constant(gain_value=0.3), Constant(gain_value=0.1)),
            extra=3,
        )
    )
    entries = np.flatnonzero(graph.partner >= 0)
    paths = build_step_graph(
        graph, entries, list(graph.sources[0].nodes), graph.listener_nodes.tolist()
    )
    count = len(paths.nodes)
    with mpmath.workdps(40):
        step = mpmath.zeros(count, count)
        ends = mpmath.zeros(count, paths.listeners)
        for rows, matrix in ((paths.steps, step), (paths.ends, ends)):
            for entry in range(count):
                for place in range(
                    int(rows.start[entry]), int(rows.start[entry] + rows.size[entry])
                ):
                    matrix[entry, int(rows.to[place])] += mpmath.mpf(float(rows.gain[place, 0]))
        term = total = ends
        for k in range(1, 6):
            term = step * term
            total = total + term
            got, _ = walk_sums(paths, k)
            assert all(
                close(got[i, j], total[i, j]) for i in range(count) for j in range(paths.listeners)
            )
        largest = np.abs(
            np.linalg.eigvals(np.array(step.tolist(), dtype=np.float64).reshape(count, count))
        ).max(initial=0.0)
        bound, _ = walk_sums(paths, 1000)
        if largest < 0.9:
            exact = (mpmath.eye(count) - step) ** -1 * ends
            for i in range(count):
                for j in range(paths.listeners):
                    assert exact[i, j] * (1 - mpmath.mpf(1e-12)) <= bound[i, j]
                    assert math.isfinite(bound[i, j])
        else:
            assert np.isfinite(bound).all()
