"""What is drawn of a traced frame, as plain arrays: points, lines and labels in world space. No GPU, no Blender."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from ...core.frame_result import FrameResult
from ...core.graph import HapticGraph, distances
from ...core.propagation.modes import distance_only
from ...core.propagation.spread import Spread, spread
from ...core.scene import Mode, Settings, SourceKind
from .colour_map import FloatArray, GainScale, decibel_text, hex_colour

Drawn = NDArray[np.float32]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


class Shape(IntEnum):
    """How a point or line is drawn, see `shader`."""

    LINE = 0
    CONTACT = 1
    SOURCE = 2
    LISTENER = 3
    IMPACT = 4
    PLATE = 5


SOURCE_COLOUR = hex_colour("#f2673c")
IMPACT_COLOUR = hex_colour("#ffab2e")
SILENT_COLOUR = hex_colour("#9a9a9a")
HALO_COLOUR = hex_colour("#101012")

POINT_SIZE = {Shape.CONTACT: 9.0, Shape.SOURCE: 26.0, Shape.LISTENER: 21.0, Shape.IMPACT: 22.0}
"""Diameters in pixels at a user interface scale of 1."""
THIN_LINE = (1.2, 2.6)  # pixels, from the floor of the scale to 0 dB
PATH_LINE = (3.0, 5.0)
HALO = 3.0  # pixels that a halo shows on either side of a path

DIMMED = 0.28
"""Opacity of what no signal reaches, and of what has nothing to do with the selection."""


@dataclass(frozen=True, slots=True)
class Options:
    """What to draw. ``sources`` and ``listeners``: selected names; where both are empty nothing is dimmed for not being selected."""

    show_intra: bool = True
    show_best_paths: bool = True
    show_labels: bool = True
    sources: frozenset[str] = frozenset()
    listeners: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class Points:
    """``position`` (n, 3) [m], ``colour`` (n, 4) display values with opacity, ``size`` (n,) diameter [pixels], ``shape`` (n,)."""

    position: Drawn
    colour: Drawn
    size: Drawn
    shape: Drawn


@dataclass(frozen=True, slots=True)
class Lines:
    """``position`` (n, 2, 3) [m], ``colour`` (n, 2, 4) at either end, ``width`` (n,) [pixels], ``way`` (n, 2) metres from the source
    along a best path at either end, -1 for lines that show no flow, ``shape`` (n,). Later lines are drawn over earlier ones."""

    position: Drawn
    colour: Drawn
    width: Drawn
    way: Drawn
    shape: Drawn


@dataclass(frozen=True, slots=True)
class Label:
    """Words at a place: ``name``, then ``value`` in ``colour`` (3,). ``clearance`` [pixels] around the place is kept free. Labels of
    higher ``priority`` are placed first."""

    name: str
    value: str
    position: tuple[float, float, float]
    colour: tuple[float, float, float]
    clearance: float
    priority: float


@dataclass(frozen=True, slots=True)
class RenderData:
    """One frame as drawn."""

    points: Points
    lines: Lines
    labels: tuple[Label, ...]
    scale: GainScale


def render_data(result: FrameResult, settings: Settings, options: Options) -> RenderData:
    """What to draw of ``result``, which was traced with ``settings``."""
    graph = distance_only(result.graph) if settings.mode is Mode.SD else result.graph
    scale = GainScale.of_threshold(settings.threshold)
    spreading = _spread(result, graph, settings, options)
    pairs = _shown_pairs(result, options)
    lines = []
    if options.show_intra and settings.mode in (Mode.HT, Mode.SD):
        lines.append(_tree_lines(graph, spreading, scale))
    if options.show_best_paths or settings.mode in (Mode.MD, Mode.MN):
        lines.extend(_path_lines(result, graph, settings.mode, pairs, scale))
    return RenderData(
        points=_points(result, spreading, scale, options),
        lines=_joined_lines(lines),
        labels=_labels(result, scale, options) if options.show_labels else (),
        scale=scale,
    )


def _spread(result: FrameResult, graph: HapticGraph, settings: Settings, options: Options) -> Spread:
    if settings.mode in (Mode.HT, Mode.SD):
        return spread(graph, settings, options.sources or None)
    nothing = Spread(np.zeros(graph.node_count), np.full(graph.node_count, -1, dtype=np.int64))
    for source in graph.sources:
        nothing.gain[list(source.nodes)] = source.amplitude
    return nothing


def _shown_pairs(result: FrameResult, options: Options) -> BoolArray:
    """(s, l) True for the pairs whose paths are drawn: all, or those of the selected sources and listeners."""
    wanted_sources = np.array([not options.sources or s.name in options.sources for s in result.sources], dtype=np.bool_)
    wanted_listeners = np.array([not options.listeners or li.name in options.listeners for li in result.listeners], dtype=np.bool_)
    return np.outer(wanted_sources, wanted_listeners)


def _tree_lines(graph: HapticGraph, spreading: Spread, scale: GainScale) -> Lines:
    """How the signal spreads: every node joined to the one that its strongest arrival came from, weak ones first."""
    ends = np.flatnonzero(spreading.predecessor >= 0)
    ends = ends[np.argsort(spreading.gain[ends], kind="stable")]
    nodes = np.stack([spreading.predecessor[ends], ends], axis=1)
    gain = spreading.gain[nodes]
    place = scale.place(gain[:, 1])
    colour = np.concatenate([scale.colour(gain), np.broadcast_to((0.35 + 0.5 * place)[:, None, None], (len(ends), 2, 1))], axis=2)
    return _lines(graph.node_position[nodes], colour, _between(THIN_LINE, place), None)


def _path_lines(result: FrameResult, graph: HapticGraph, mode: Mode, pairs: BoolArray, scale: GainScale) -> Iterable[Lines]:
    """The best paths of the shown pairs, each connection once as strong as its strongest use: first their halos, then their cores."""
    paths = {pair: nodes for pair, nodes in result.propagation.best_path.items() if pairs[pair] and result.sources[pair[0]].amplitude > 0}
    if not paths:
        return ()
    steps, gain, way = path_steps(result, graph, mode, paths)
    strongest = np.argsort(-gain[:, 1], kind="stable")
    undirected = np.sort(steps[strongest], axis=1)
    _, first = np.unique(undirected, axis=0, return_index=True)
    kept = strongest[np.sort(first)[::-1]]
    steps, gain, way = steps[kept], gain[kept], way[kept]
    position = graph.node_position[steps]
    width = _between(PATH_LINE, scale.place(gain[:, 1]))
    halo = np.broadcast_to(np.array([*HALO_COLOUR, 0.85]), (len(steps), 2, 4))
    core = np.concatenate([scale.colour(gain), np.ones((len(steps), 2, 1))], axis=2)
    return _lines(position, halo, width + 2 * HALO, None), _lines(position, core, width, way)


def path_steps(
    result: FrameResult, graph: HapticGraph, mode: Mode, paths: Mapping[tuple[int, int], Sequence[int]]
) -> tuple[IntArray, FloatArray, FloatArray]:
    """The connections of paths: their nodes (m, 2), the signal at either end (m, 2), amplitude included, and the metres from the source
    at either end (m, 2)."""
    steps = np.array([step for nodes in paths.values() for step in itertools.pairwise(nodes)], dtype=np.int64).reshape(-1, 2)
    counts = np.array([len(nodes) - 1 for nodes in paths.values()], dtype=np.int64)
    length = distances(graph.node_position[steps[:, 0]], graph.node_position[steps[:, 1]])
    if mode in (Mode.MD, Mode.MN):
        factor = np.array([result.propagation.gain[pair] for pair in paths], dtype=np.float64)
    else:
        factor = _connection_gains(graph, steps, length)
    amplitude = np.array([result.sources[source].amplitude for source, _ in paths])
    with np.errstate(divide="ignore"):
        cost = -np.log(factor)
    after = _running_sums(cost, counts)
    before = np.concatenate([[0.0], after])[:-1]
    before[_starts(counts)] = 0.0
    gain = np.repeat(amplitude, counts)[:, None] * np.exp(-np.stack([before, after], axis=1))
    end = _running_sums(length, counts)
    return steps, gain, np.stack([end - length, end], axis=1)


def _connection_gains(graph: HapticGraph, steps: IntArray, length: FloatArray) -> FloatArray:
    """Gain of each connection (m,) between nodes (m, 2) that are ``length`` (m,) apart."""
    inter = (graph.partner[steps[:, 0]] == steps[:, 1]) & (graph.contact[steps[:, 0]] >= 0)
    index = graph.node_object[steps[:, 0]]
    with np.errstate(invalid="ignore"):
        gain = graph.table.factor[index] * np.exp(-graph.table.decay[index] * length)
    gain[inter] = graph.transmission[graph.contact[steps[inter, 0]]]
    for special in set(index[~inter].tolist()) & graph.table.special:
        chosen = ~inter & (index == special)
        gain[chosen] = graph.table.gain(special, length[chosen])
    return gain


def _starts(counts: IntArray) -> IntArray:
    return np.cumsum(counts) - counts


def _running_sums(values: FloatArray, counts: IntArray) -> FloatArray:
    """Cumulative sums that start anew with every run of ``counts``."""
    runs = np.split(values, np.cumsum(counts)[:-1])
    return np.concatenate([np.cumsum(run) for run in runs])


def _points(result: FrameResult, spreading: Spread, scale: GainScale, options: Options) -> Points:
    """Contacts, then listeners, then sources, each contact once, in the middle between its two nodes."""
    graph = result.graph
    first = np.flatnonzero((graph.partner >= 0) & (graph.partner > np.arange(graph.node_count)))
    second = graph.partner[first]
    contact_gain = np.maximum(spreading.gain[first], spreading.gain[second])
    order = np.argsort(contact_gain, kind="stable")
    contacts = (graph.node_position[first] + graph.node_position[second])[order] / 2
    contact_gain = contact_gain[order]
    smaller = min(1.0, max(0.5, (400 / max(len(first), 1)) ** 0.25))

    received = listener_gains(result, options)
    in_selection = np.array([not options.listeners or li.name in options.listeners for li in result.listeners], dtype=np.bool_)
    listeners = graph.node_position[graph.listener_nodes]

    nodes = [(source, node) for source in graph.sources for node in source.nodes[:1]]
    sources = graph.node_position[[node for _, node in nodes]] if nodes else np.zeros((0, 3))
    impact = np.array([source.kind is SourceKind.TEMPORARY for source, _ in nodes], dtype=np.bool_)
    sounding = np.array(
        [source.amplitude > 0 and (not options.sources or source.name in options.sources) for source, _ in nodes], dtype=np.bool_
    )
    source_colour = np.where(impact[:, None], IMPACT_COLOUR, SOURCE_COLOUR)
    source_shape = np.where(impact, Shape.IMPACT, Shape.SOURCE)

    colour = np.concatenate(
        [
            _gain_colour(scale, contact_gain, np.ones(len(contacts), dtype=np.bool_)),
            _gain_colour(scale, received, in_selection),
            np.column_stack([source_colour, np.where(sounding, 1.0, DIMMED)]).reshape(-1, 4),
        ]
    )
    shape = np.concatenate(
        [np.full(len(contacts), Shape.CONTACT), np.full(len(listeners), Shape.LISTENER), source_shape.reshape(-1)]
    ).astype(np.float32)
    size = np.array([POINT_SIZE.get(Shape(k), 0.0) for k in range(len(Shape))])[shape.astype(np.int64)]
    size[: len(contacts)] *= smaller * np.where(contact_gain > 0, 1.0, 0.7)
    return Points(
        np.concatenate([contacts, listeners, sources]).astype(np.float32), colour.astype(np.float32), size.astype(np.float32), shape
    )


def listener_gains(result: FrameResult, options: Options) -> FloatArray:
    """(l,) the strongest gain at each listener from any shown source, amplitude included."""
    wanted = [k for k, source in enumerate(result.sources) if not options.sources or source.name in options.sources]
    return np.asarray(result.gains[wanted].max(axis=0, initial=0.0))


def _gain_colour(scale: GainScale, gain: FloatArray, emphasised: BoolArray) -> FloatArray:
    """(n, 4): by gain; grey and faint where nothing arrives."""
    reached = gain > 0
    colour = np.where(reached[:, None], scale.colour(gain), SILENT_COLOUR)
    return np.column_stack([colour, np.where(reached & emphasised, 1.0, np.where(reached, 0.5, DIMMED))])


def _labels(result: FrameResult, scale: GainScale, options: Options) -> tuple[Label, ...]:
    selected = bool(options.sources or options.listeners)
    received = listener_gains(result, options)
    colours = np.where(received[:, None] > 0, scale.colour(received), SILENT_COLOUR)
    labels = []
    for source in result.sources:
        chosen = source.name in options.sources
        if source.kind is SourceKind.TEMPORARY and not chosen:
            continue
        colour = SOURCE_COLOUR if source.amplitude > 0 else SILENT_COLOUR
        labels.append(
            Label(
                source.name,
                decibel_text(source.amplitude),
                source.position,
                tuple(colour.tolist()),
                POINT_SIZE[Shape.SOURCE] / 2,
                20.0 + 4 * chosen,
            )
        )
    for k, listener in enumerate(result.listeners):
        chosen = listener.name in options.listeners
        if selected and options.listeners and not chosen:
            continue
        gain = float(received[k])
        labels.append(
            Label(
                listener.name,
                decibel_text(gain),
                listener.position,
                tuple(colours[k].tolist()),
                POINT_SIZE[Shape.LISTENER] / 2,
                10.0 * chosen + float(scale.place(np.array(gain))),
            )
        )
    return tuple(labels)


def _between(ends: tuple[float, float], place: FloatArray) -> FloatArray:
    return ends[0] + (ends[1] - ends[0]) * place


def _lines(position: FloatArray, colour: FloatArray, width: FloatArray, way: FloatArray | None) -> Lines:
    way = np.full((len(position), 2), -1.0) if way is None else way
    shape = np.full(len(position), Shape.LINE)
    return Lines(*(values.astype(np.float32) for values in (position, colour, width, way, shape)))


def _joined_lines(parts: Sequence[Lines]) -> Lines:
    if not parts:
        return _lines(np.zeros((0, 2, 3)), np.zeros((0, 2, 4)), np.zeros(0), None)
    return Lines(*(np.concatenate([getattr(part, key) for part in parts]) for key in ("position", "colour", "width", "way", "shape")))
