"""What makes a level one that a designer can compare by a decibel, as checks of a haptic scene by
the default strategy."""

from __future__ import annotations

import dataclasses
import itertools
import math

import networkx
import numpy as np
from explicit_graph import explicit_graph
from haptic_tracing.core.contacts.scene_contacts import contacts_of_scene
from haptic_tracing.core.contacts.shapes import Box, pose_matrix
from haptic_tracing.core.graph.haptic_graph import HapticGraph, graph_of_scene
from haptic_tracing.core.propagation import Propagation, propagate
from haptic_tracing.core.scene.measured import physical
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Pose,
    Settings,
    Source,
)

MOVED = 0.002
"""Metres."""
STILL = 0.1
"""Allowed change of a level [dB] where nothing changes that matters."""
QUIET = 1e-5
"""Gains below this, -100 dB, are not compared in decibels."""


def traced(scene: HapticScene) -> Propagation:
    """The scene by the default strategy."""
    return propagate(graph_of_scene(scene), Settings(epsilon=scene.settings.epsilon))


def decibels(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Differences of levels (n,) of all pairs that are above `QUIET` in either."""
    chosen = np.maximum(one, other) > QUIET
    return np.abs(
        20 * np.log10(np.maximum(one[chosen], 1e-300) / np.maximum(other[chosen], 1e-300))
    )


def check_bounded(scene: HapticScene) -> None:
    """No listener feels more than the source gives."""
    gain = traced(scene).gain
    assert ((gain >= 0) & (gain <= 1)).all()


def slope(item: HapticObject, epsilon: float, extent: float) -> float:
    """Most that the gain of an object changes with distance [dB/m], within ``extent`` metres and
    but for what is silent."""
    along = np.linspace(0.0, max(extent, 0.01), 200)
    gains = item.propagation.gain(along, item.kappa, item.rho, epsilon)
    levels = 20 * np.log10(np.maximum(gains, QUIET))
    return float(np.abs(np.diff(levels) / np.diff(along)).max())


def check_steady(scene: HapticScene, seed: int) -> None:
    """Contacts, sources and listeners that move by 2 mm change a level by no more than the
    functions along its way do, and 0.1 dB."""
    random = np.random.default_rng(seed)

    def moved(place: tuple[float, ...]) -> tuple[float, ...]:
        step = random.normal(size=3)
        return tuple(
            (np.array(place) + MOVED * random.uniform() * step / np.linalg.norm(step)).tolist()
        )

    contacts = []
    for contact in scene.contacts:
        place = moved(contact.positions[0])
        shift = np.array(place) - contact.positions[0]
        contacts.append(
            dataclasses.replace(
                contact, positions=(place, tuple((np.array(contact.positions[1]) + shift).tolist()))
            )
        )
    other = dataclasses.replace(
        scene,
        contacts=tuple(contacts),
        sources=tuple(
            item
            if item.position is None
            else dataclasses.replace(item, position=moved(item.position))
            for item in scene.sources
        ),
        listeners=tuple(
            item
            if item.position is None
            else dataclasses.replace(item, position=moved(item.position))
            for item in scene.listeners
        ),
    )
    before, after = (traced(item) for item in (scene, other))
    graph = graph_of_scene(scene)
    slopes = slopes_of(graph)
    for pair in itertools.product(range(len(scene.sources)), range(len(scene.listeners))):
        ways = [result.best_path[pair] for result in (before, after) if pair in result.best_path]
        if not ways:
            continue
        inside = [
            sum(
                slopes[graph.node_object[a]]
                for a, b in itertools.pairwise(way)
                if graph.partner[a] != b
            )
            for way in ways
        ]
        change = decibels(before.gain[pair].reshape(1), after.gain[pair].reshape(1))
        assert (change <= 2 * MOVED * max(inside) + STILL).all(), (
            pair,
            change,
            2 * MOVED * max(inside),
        )


def slopes_of(graph: HapticGraph) -> list[float]:
    """`slope` of each object, within the extent of its nodes."""
    found = []
    for index, item in enumerate(graph.table.objects):
        places = graph.node_position[graph.nodes_of(index)]
        found.append(
            slope(
                item,
                graph.table.epsilon,
                float(np.linalg.norm(np.ptp(places, axis=0))) if len(places) else 0.0,
            )
        )
    return found


def check_local(scene: HapticScene, far: str, place: tuple[float, float, float]) -> None:
    """A pebble of stone that touches only the object ``far``, at a ``place`` away from all ways,
    changes nothing."""
    pebble = HapticObject("a pebble", 0.1, 0.9, physical("stone", (0.1, 0.1, 0.1)))
    touching = Contact((far, pebble.name), (place, place))
    other = dataclasses.replace(
        scene, objects=(*scene.objects, pebble), contacts=(*scene.contacts, touching)
    )
    before, after = (traced(item).gain for item in (scene, other))
    assert before.tobytes() == after.tobytes()


def bodies_moved(
    scene: HapticScene, random: np.random.Generator, still: frozenset[str]
) -> HapticScene:
    """The scene with each of its bodies but those ``still`` moved by up to 1 mm and turned by up to
    1e-3 rad, with its sources and listeners."""
    poses = {item.name: (pose_matrix(item.pose), pose_matrix(item.pose)) for item in scene.objects}
    objects = []
    for item in scene.objects:
        if item.name not in still:
            way, axis = random.normal(size=(2, 3))
            way *= 1e-3 * random.uniform() / np.linalg.norm(way)
            half = 5e-4 * random.uniform() * axis / np.linalg.norm(axis)
            w, x, y, z = item.pose.rotation
            turned = (
                w - half @ [x, y, z],
                *(np.array([x, y, z]) + w * half + np.cross(half, [x, y, z])),
            )
            pose = Pose(tuple((np.array(item.pose.position) + way).tolist()), turned)
            item = dataclasses.replace(item, pose=pose)
            poses[item.name] = poses[item.name][0], pose_matrix(pose)
        objects.append(item)

    def carried(end):
        before, after = poses[end.object]
        if end.position is None:
            return end
        local = before[:3, :3].T @ (np.array(end.position) - before[:3, 3])
        return dataclasses.replace(end, position=tuple(after[:3, :3] @ local + after[:3, 3]))

    return dataclasses.replace(
        scene,
        objects=tuple(objects),
        sources=tuple(map(carried, scene.sources)),
        listeners=tuple(map(carried, scene.listeners)),
    )


def of_measured_materials(scene: HapticScene) -> HapticScene:
    """The scene with what *Make Haptic* gives to things of plastic on soil."""
    return dataclasses.replace(
        scene,
        objects=tuple(
            dataclasses.replace(
                item,
                propagation=physical(
                    "soil" if item.name == "ground" else "plastic",
                    tuple(np.ptp(item.shape.local_bounds, axis=0).tolist()),
                ),
            )
            for item in scene.objects
        ),
    )


def changes_of_moved_bodies(scene: HapticScene, still: frozenset[str], seed: int) -> np.ndarray:
    """Changes [dB] of all levels of the default strategy, 20 times, as the bodies move by 1 mm; by
    the contacts that are there before and after."""
    random, found = np.random.default_rng(seed), []
    for _ in range(20):
        pair = scene, bodies_moved(scene, random, still)
        contacts = [
            {
                contact.objects: contact
                for contact in contacts_of_scene(
                    dataclasses.replace(item, contacts=())
                ).to_contacts(sorted(body.name for body in item.objects))
            }
            for item in pair
        ]
        both = contacts[0].keys() & contacts[1].keys()
        gains = [
            traced(dataclasses.replace(item, contacts=tuple(own[key] for key in sorted(both)))).gain
            for item, own in zip(pair, contacts, strict=True)
        ]
        found.append(decibels(*gains))
    return np.concatenate(found)


def check_shown(graph: HapticGraph, result: Propagation, threshold: float) -> None:
    """The way that is shown makes the number: the product of its connections, and none is stronger
    by NetworkX's own search. Below the ``threshold`` it may be the way of another band."""
    for row, source in enumerate(graph.sources):
        explicit = explicit_graph(graph.in_band(source.band)).to_directed()
        # A listener's extent shortens the way to it, not that past it.
        explicit.remove_edges_from([*explicit.out_edges(graph.listener_nodes.tolist())])
        for edge in explicit.edges.values():
            edge["cost"] = -math.log(edge["gain"]) if edge["gain"] > 0 else math.inf
        explicit.remove_edges_from(
            [ends for ends, edge in explicit.edges.items() if edge["cost"] == math.inf]
        )
        costs = networkx.multi_source_dijkstra_path_length(
            explicit, set(source.nodes), weight="cost"
        )
        for column, target in enumerate(graph.listener_nodes.tolist()):
            gain = float(
                result.gain[row, column]
                if result.band_gain is None
                else result.band_gain[row, column, source.band]
            )
            nodes = result.best_path.get((row, column), ())
            best = math.exp(-costs[target]) if target in costs else 0.0
            assert (gain > 0) == bool(nodes)
            if nodes:
                assert nodes[0] in source.nodes and nodes[-1] == target
                product = math.prod(
                    explicit.edges[edge]["gain"] for edge in itertools.pairwise(nodes)
                )
                assert abs(product / gain - 1) < 1e-9
            assert abs(best / gain - 1) < 1e-9 if gain > threshold else best < threshold


def pile_scene(seed: int, count: int = 24) -> HapticScene:
    """Boxes of half a metre on a ground of 20 m, each touching the ground and most of its
    neighbours; three sources, ten listeners."""
    random = np.random.default_rng(seed)
    side = math.ceil(math.sqrt(count))
    middles = [np.array([k % side * 0.5, k // side * 0.5, 0.25]) for k in range(count)]
    names = [f"box {k:03d}" for k in range(count)]
    boxes = [
        HapticObject(
            name,
            *random.uniform([0.0, 0.4], [0.6, 1.0]).tolist(),
            shape=Box((0.5, 0.5, 0.5)),
            pose=Pose(tuple(middle.tolist())),
        )
        for name, middle in zip(names, middles, strict=True)
    ]
    ground = HapticObject("ground", 0.1, 0.9, shape=Box((40, 40, 1)), pose=Pose((0, 0, -0.5)))
    touching = [
        ("ground", name, middle * [1, 1, 0]) for name, middle in zip(names, middles, strict=True)
    ]
    for (a, one), (b, two) in itertools.combinations(zip(names, middles, strict=True), 2):
        if np.abs(one - two).sum() < 0.6 and random.uniform() < 0.8:
            touching.append((a, b, (one + two) / 2 + random.uniform(-0.1, 0.1, 3)))
    contacts = [
        Contact((a, b), (tuple(place.tolist()), tuple(place.tolist()))) for a, b, place in touching
    ]
    chosen = random.permutation(count).tolist()
    inside = [tuple((middle + random.uniform(-0.2, 0.2, 3)).tolist()) for middle in middles]
    return HapticScene(
        (*boxes, ground),
        tuple(contacts),
        tuple(Source(f"s{k}", names[k], inside[k]) for k in chosen[:3]),
        tuple(Listener(f"l{k}", names[k], inside[k], radius=0.0) for k in chosen[3:13]),
    )
