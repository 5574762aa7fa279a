"""Random scenes, and two references that share nothing with the product's propagation: NetworkX's
simple paths, and plain recursion."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from random import Random

import networkx
from explicit_graph import explicit_graph
from haptic_tracing.core.graph.haptic_graph import HapticGraph
from haptic_tracing.core.scene.functions import (
    Constant,
    Exponential,
    Expression,
    HapticTracing,
    Identity,
    Linear,
    ModulationFunction,
)
from haptic_tracing.core.scene.functions.physical import Physical, Wave
from haptic_tracing.core.scene.values import Contact, HapticObject, HapticScene, Listener, Source
from haptic_tracing.core.signals import Sine
from hypothesis import strategies as st

METRIC: tuple[ModulationFunction, ...] = (
    HapticTracing(),
    Exponential(alpha=0.4),
    Constant(gain_value=0.6),
    Constant(gain_value=1.0),
    Identity(),
    Constant(gain_value=0.0),
    Physical(
        wave=Wave.SURFACE, loss_factor=0.2, phase_speed=200.0, reference_distance=0.3, extent=1.0
    ),
    Physical(
        wave=Wave.BOUNDED,
        thickness=0.5,
        extent=2.0,
        reference_distance=0.3,
    ),
)
LOW = Sine(25.0)
"""A signal in the lowest band, for which the path of the largest plain gain is the best one."""
OTHER: tuple[ModulationFunction, ...] = (
    Linear(range=3.0),
    Expression(expression="x / (1 + d)"),
    Expression(expression="0.9 * exp(-d**2)"),
)


@st.composite
def scenes(
    draw: st.DrawFn,
    functions: tuple[ModulationFunction, ...] = METRIC,
    transmissions: tuple[ModulationFunction, ...] = (
        Identity(),
        Constant(gain_value=0.7),
        Exponential(alpha=1.0),
    ),
    most_contacts: int = 6,
    listeners: int = 2,
    refined: bool = False,
) -> HapticScene:
    """Few objects, contacts between any two of them (also several between the same two), a source
    that may have two sides."""
    count = draw(st.integers(1, 5))
    names = [f"o{i}" for i in range(count)]
    place = st.tuples(*[st.integers(-6, 6).map(lambda v: v / 4)] * 3)
    objects = tuple(
        HapticObject(
            name,
            draw(st.sampled_from([0.0, 0.1, 0.5, 1.0])),
            draw(st.sampled_from([0.3, 0.8, 1.0])),
            draw(st.sampled_from(functions)),
        )
        for name in names
    )
    contacts = []
    for _ in range(draw(st.integers(0, most_contacts)) if count > 1 else 0):
        first, second = draw(st.permutations(names))[:2]
        share = draw(st.sampled_from([1.0, 0.5])) if refined else 1.0
        at = draw(place)
        contacts.append(
            Contact(
                (first, second),
                (at, draw(st.sampled_from([at, draw(place)]))),
                draw(st.sampled_from(transmissions)),
                area=draw(st.sampled_from([0.0, 0.3, 5.0])),
                share=share,
            )
        )
    second_object = draw(st.sampled_from([None, *names]))
    source = Source(
        "s", draw(st.sampled_from(names)), draw(place), signal=LOW, second_object=second_object
    )
    heard = tuple(
        Listener(f"l{k}", draw(st.sampled_from(names)), draw(place), radius=0.0)
        for k in range(draw(st.integers(1, listeners)))
    )
    return HapticScene(objects, tuple(contacts), (source,), heard)


def networkx_paths(
    graph: HapticGraph, row: int, column: int
) -> Iterator[tuple[tuple[int, ...], list[float]]]:
    """Nodes and gains of all paths: NetworkX's simple paths without two intra-connections in a
    row."""
    explicit = explicit_graph(graph)
    target = int(graph.listener_nodes[column])
    for root in graph.sources[row].nodes:
        for path in networkx.all_simple_paths(explicit, root, target):
            edges = [explicit.edges[a, b] for a, b in itertools.pairwise(path)]
            kinds = [edge["connection"] for edge in edges]
            if ("intra", "intra") not in set(itertools.pairwise(kinds)):
                yield tuple(path), [edge["gain"] for edge in edges]


def recursive_paths(
    graph: HapticGraph, row: int, column: int, explicit: networkx.DiGraph | None = None
) -> Iterator[tuple[tuple[int, ...], list[float]]]:
    """The same by recursion over contacts, from the definition; ``explicit``: with other gains."""
    inside: dict[int, list[tuple[int, float]]] = {}
    across: dict[tuple[int, int], float] = {}
    known = explicit_graph(graph) if explicit is None else explicit
    for a, others in known.adjacency():
        for b, edge in others.items():
            if edge["connection"] == "intra":
                inside.setdefault(a, []).append((b, edge["gain"]))
            else:
                across[a, b] = edge["gain"]
    partners = graph.partner.tolist()
    target = int(graph.listener_nodes[column])

    def onwards(
        path: tuple[int, ...], gains: list[float]
    ) -> Iterator[tuple[tuple[int, ...], list[float]]]:
        for other, gain in inside.get(path[-1], ()):
            if other in path:
                continue
            if other == target:
                yield (*path, other), [*gains, gain]
            partner = partners[other]
            if partner >= 0 and partner not in path:
                yield from onwards((*path, other, partner), [*gains, gain, across[other, partner]])

    for root in graph.sources[row].nodes:
        yield from onwards((root,), [])


def meets(gains: list[float], max_connections: int | None, threshold: float) -> bool:
    """A path within both limits: it stops where the product of its gains falls below the threshold,
    exactly met goes on."""
    if max_connections is not None and len(gains) > max_connections:
        return False
    least = threshold * (1 - 1e-12)
    return all(product >= least for product in itertools.accumulate(gains, lambda a, b: a * b))


def least_cost(graph: HapticGraph, row: int, column: int) -> float:
    """The least cost of a walk, by NetworkX's Dijkstra on a graph with two states of each node: its
    object has just been entered through it, or it has been arrived at inside."""
    states = networkx.DiGraph()
    for a, b, edge in explicit_graph(graph).edges(data=True):
        if edge["gain"] > 0:
            ends = ((a, 0), (b, 1)) if edge["connection"] == "intra" else ((a, 1), (b, 0))
            states.add_edge(*ends, cost=-math.log(edge["gain"]))
    target = int(graph.listener_nodes[column]), 1
    roots = {(node, 0) for node in graph.sources[row].nodes} & set(states)
    if not roots or target not in states:
        return math.inf
    costs = networkx.multi_source_dijkstra_path_length(states, roots, weight="cost")
    return float(costs.get(target, math.inf))


REFERENCES: dict[str, Callable[..., Iterator[tuple[tuple[int, ...], list[float]]]]] = {
    "networkx": networkx_paths,
    "recursion": recursive_paths,
}


def connected_scene(
    seed: int,
    functions: tuple[ModulationFunction, ...] = METRIC,
    transmissions: tuple[ModulationFunction, ...] = (Identity(), Constant(gain_value=0.9)),
    most_objects: int = 7,
    extra: int = 3,
    listeners: int = 2,
    size: float = 1.0,
    refined: bool = False,
) -> HapticScene:
    """A scene in one component with up to ``extra`` contacts more than a tree needs: longer paths
    than `scenes` draws."""
    random = Random(seed)
    count = random.randint(2, most_objects)
    names = [f"o{i}" for i in range(count)]

    def place() -> tuple[float, float, float]:
        return (random.uniform(0, size), random.uniform(0, size), random.uniform(0, size))

    objects = tuple(
        HapticObject(
            name, random.uniform(0, 0.5), random.uniform(0.5, 1.0), random.choice(functions)
        )
        for name in names
    )
    ends = [(names[i], names[random.choice([i - 1, random.randrange(i)])]) for i in range(1, count)]
    ends += [tuple(random.sample(names, 2)) for _ in range(random.randint(0, extra))]
    contacts = []
    for pair in ends:
        at = place()
        points = random.randint(1, 2) if refined else 1
        contacts += [
            Contact(
                pair,
                (at if k == 0 else place(), at),
                random.choice(transmissions),
                area=(0.0, 0.3, 5.0)[len(contacts) % 3],
                share=1 / points,
            )
            for k in range(points)
        ]
    random.shuffle(contacts)
    source = Source(
        "s",
        names[0],
        place(),
        signal=LOW,
        second_object=names[1] if random.random() < 0.2 else None,
    )
    heard = tuple(
        Listener(f"l{k}", random.choice([names[-1], random.choice(names)]), place(), radius=0.0)
        for k in range(random.randint(1, listeners))
    )
    return HapticScene(objects, tuple(contacts), (source,), heard)
