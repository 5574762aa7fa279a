"""The drawing of a traced frame as plain arrays: points, lines and labels in world space,
independent of the GPU."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import fields
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import BoolArray, FloatArray, IntArray
from ...core.diagnosis.connections import connections
from ...core.frozen import frozen
from ...core.graph.distance_only import distance_only
from ...core.graph.haptic_graph import HapticGraph, SourceNodes, distances
from ...core.propagation.spread import Spread, spread
from ...core.render.frame_result import FrameResult
from ...core.scene.values import Listener, Mode, Settings, Source, SourceKind
from .colour_map import AmplitudeScale, hex_colour
from .symbols import HALO_COLOUR, LOOKS, Symbol

Drawn = NDArray[np.float32]
Place = tuple[float, float]
"""Across and up."""
Size = tuple[float, float]
"""Width and height."""


SOURCE_COLOUR = hex_colour("#f2673c")
IMPACT_COLOUR = hex_colour("#ffab2e")
SILENT_COLOUR = hex_colour("#9a9a9a")
HIGHLIGHT_COLOUR = hex_colour("#f4f4f4")

THIN_LINE = (1.2, 2.6)  # pixels, from the floor of the scale to 0 dB
PATH_LINE = (3.0, 5.0)
HALO = 3.0  # pixels of a halo on either side of a path
HIGHLIGHT_LINE = 19.0  # pixels, wider than a path with its halo

DIMMED = 0.3
"""Opacity of contacts without a signal."""
SILENT = 0.8
"""Opacity of silent sources and listeners."""
UNSELECTED = 0.35
"""Opacity of elements unrelated to the selection."""
PARTED = 0.05
"""Distance of the two nodes from which on an impact is drawn on both objects [m]."""


@frozen
class Options:
    """Drawing options. ``labelled``: the name of what has a label, None for all. ``sources`` and
    ``listeners``: selected names; if both are empty, nothing is dimmed. ``highlight``: a listener,
    and the object whose part of the best paths to it is highlighted."""

    show_intra: bool = True
    show_best_paths: bool = True
    labelled: str | None = None
    sources: frozenset[str] = frozenset()
    listeners: frozenset[str] = frozenset()
    highlight: tuple[str, str] | None = None


@frozen
class Lines:
    """Lines, and points, which are lines without length in the form of a symbol.

    ``position`` (n, 2, 3) [m], ``colour`` (n, 2, 4) display values with opacity at either end,
    ``width`` (n,) of a line or diameter of a point [pixels], ``arc_length`` (n, 2) metres from the
    source along a best path at either end, -1 for what shows no flow, ``shape`` (n,). Later ones
    are drawn over earlier ones."""

    position: Drawn
    colour: Drawn
    width: Drawn
    arc_length: Drawn
    shape: Drawn


def joined(*parts: Lines) -> Lines:
    """Several parts as one, in their order."""
    return Lines(
        *(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(Lines))
    )


def points_of(
    position: FloatArray,
    colour: FloatArray,
    opacity: FloatArray,
    size: FloatArray | float,
    shape: IntArray | Symbol,
) -> Lines:
    """Points.

    Args:
        position: (n, 3) [m].
        colour: Display values without opacity (n, 3).
        opacity: 0 to 1 (n,).
        size: Diameter [pixels], of all or of each.
        shape: The symbol, of all or of each.
    """
    both = np.repeat(position[:, None], 2, axis=1)
    return lines_of(both, colour[:, None], opacity[:, None], size, shape=shape)


def lines_of(
    position: FloatArray | Drawn,
    colour: FloatArray | Drawn,
    opacity: FloatArray | Drawn | float,
    width: FloatArray | Drawn | float,
    arc_length: FloatArray | float = -1.0,
    shape: FloatArray | IntArray | Symbol = Symbol.LINE,
) -> Lines:
    """Lines; each value but the position is one for all lines or one for each.

    Args:
        position: Both ends (n, 2, 3) [m].
        colour: Display values without opacity, also of either end.
        opacity: 0 to 1, also of either end.
        width: [pixels].
        arc_length: Metres along a best path at either end, -1 for lines that show no flow.
        shape: A line, a plate between two corners, or a symbol.
    """
    count = len(position)
    places = np.asarray(position, dtype=np.float32)
    colours = np.empty((count, 2, 4), dtype=np.float32)
    colours[..., :3], colours[..., 3] = colour, opacity
    return Lines(
        places,
        colours,
        _filled(count, width),
        _filled((count, 2), arc_length),
        _filled(count, shape),
    )


_filled = partial(np.full, dtype=np.float32)


NO_LINES = lines_of(np.zeros((0, 2, 3)), HALO_COLOUR, 0.0, 0.0)


@frozen
class Label:
    """The name of a source or listener at its place. ``clearance`` [pixels] around the position is
    kept free. Labels of higher ``priority`` are placed first."""

    name: str
    position: tuple[float, float, float]
    colour: tuple[float, float, float]
    clearance: float
    priority: float


@frozen
class RenderData:
    """One frame as drawn, from the bottom up: ``tree``, the strongest arrival at every node;
    ``highlight``; ``paths``, the best ones; ``points``."""

    tree: Lines
    highlight: Lines
    paths: Lines
    points: Lines
    labels: tuple[Label, ...]
    scale: AmplitudeScale


def render_data(
    result: FrameResult, settings: Settings, options: Options, kept: FloatArray | None = None
) -> RenderData:
    """The drawing of ``result``, which was traced with ``settings``. ``kept``: the connections of
    the best paths (`Connections.rows`) of a frame that was not traced now."""
    graph = distance_only(result.graph) if settings.mode is Mode.SD else result.graph
    scale = AmplitudeScale()
    spreading = _spread(result, graph, settings, options)
    pairs = np.outer(
        _chosen(options.sources, result.sources), _chosen(options.listeners, result.listeners)
    )
    on_graph = settings.mode in (Mode.HT, Mode.SD)
    tree = _tree_lines(graph, spreading, scale, UNSELECTED if options.listeners else 1.0)
    if kept is None:
        kept = connections(result, settings.mode, pairs).rows(result.graph)
    paths = drawn_paths(kept, scale)
    return RenderData(
        tree=tree if options.show_intra and on_graph else NO_LINES,
        highlight=_highlight_lines(result, options)
        if options.show_best_paths and on_graph
        else NO_LINES,
        paths=paths if options.show_best_paths or not on_graph else NO_LINES,
        points=_points(result, spreading, scale, options, pairs),
        labels=_labels(result, scale, options),
        scale=scale,
    )


def _spread(
    result: FrameResult, graph: HapticGraph, settings: Settings, options: Options
) -> Spread:
    if settings.mode in (Mode.HT, Mode.SD):
        return spread(graph, options.sources or None)
    nothing = Spread(np.zeros(graph.node_count), np.full(graph.node_count, -1, dtype=np.int64))
    for source in graph.sources:
        nothing.amplitude[list(source.nodes)] = source.amplitude
    return nothing


def _chosen(
    names: frozenset[str], items: Sequence[Source] | Sequence[SourceNodes] | Sequence[Listener]
) -> BoolArray:
    """Whether each item (n,) is one of the selected ``names``; all are if none is selected."""
    return np.array([not names or item.name in names for item in items], dtype=np.bool_)


def _tree_lines(
    graph: HapticGraph, spreading: Spread, scale: AmplitudeScale, opacity: float
) -> Lines:
    """Lines from every node to the predecessor of its strongest arrival, weak ones first."""
    ends = np.flatnonzero(spreading.predecessor >= 0)
    # Lines without length need no drawing: the contact itself is drawn.
    ends = ends[
        (graph.node_position[ends] != graph.node_position[spreading.predecessor[ends]]).any(axis=1)
    ]
    ends = ends[np.argsort(spreading.amplitude[ends], kind="stable")]
    nodes = np.stack([spreading.predecessor[ends], ends], axis=1)
    amplitude = spreading.amplitude[nodes]
    place = scale.place(amplitude[:, 1])
    opacities = (opacity * (0.35 + 0.5 * place))[:, None]
    return lines_of(
        graph.node_position[nodes], scale.colour(amplitude), opacities, _between(THIN_LINE, place)
    )


def drawn_paths(paths: FloatArray, scale: AmplitudeScale) -> Lines:
    """The `Connections.rows` of paths as lines, each connection once, as strong as its strongest
    use; weak ones first."""
    amplitude = paths[:, 6:8]
    return lines_of(
        paths[:, :6].reshape(-1, 2, 3),
        scale.colour(amplitude),
        1.0,
        _between(PATH_LINE, scale.place(amplitude[:, 1])),
        paths[:, 8:],
    )


def _highlight_lines(result: FrameResult, options: Options) -> Lines:
    """A light rim under the part of the best paths to a listener in the chosen object, with its
    contact to the next one."""
    if options.highlight is None:
        return NO_LINES
    listener, name = options.highlight
    names, graph = result.graph.table.names, result.graph
    steps = [
        step
        for (row, column), nodes in result.propagation.best_path.items()
        if result.listeners[column].name == listener and result.sources[row].amplitude > 0
        for step in itertools.pairwise(nodes)
        if names[graph.node_object[step[0]]] == name
    ]
    if not steps:
        return NO_LINES
    return lines_of(graph.node_position[np.array(steps)], HIGHLIGHT_COLOUR, 1.0, HIGHLIGHT_LINE)


def halos(lines: Lines) -> Lines:
    """A dark rim around lines, to be drawn under them."""
    return lines_of(lines.position, HALO_COLOUR, 0.85, lines.width + 2 * HALO)


def _points(
    result: FrameResult,
    spreading: Spread,
    scale: AmplitudeScale,
    options: Options,
    pairs: BoolArray,
) -> Lines:
    """Points of contacts, listeners and sources, in this order. Contacts off the best paths of
    selected listeners are dimmed.

    Args:
        result: the frame.
        spreading: strongest arrival at each node, which colours contacts.
        scale: of the colours.
        options: what is shown and selected.
        pairs: whose paths are drawn (s, l).
    """
    shown = np.ones(result.graph.node_count, dtype=np.bool_)
    if options.listeners:
        shown[:] = False
        shown[
            [
                node
                for pair, nodes in result.propagation.best_path.items()
                if pairs[pair]
                for node in nodes
            ]
        ] = True
    contacts = _contact_points(result.graph, spreading, scale, shown)
    return joined(
        contacts, _listener_points(result, scale, options), _source_points(result, options)
    )


def _contact_points(
    graph: HapticGraph, spreading: Spread, scale: AmplitudeScale, shown: BoolArray
) -> Lines:
    """One point per contact, midway between its two nodes, the strongest on top, smaller if there
    are many. Contacts whose nodes are not ``shown`` (n,) are dimmed."""
    first = np.flatnonzero(graph.partner > np.arange(graph.node_count))
    second = graph.partner[first]
    amplitude = np.maximum(spreading.amplitude[first], spreading.amplitude[second])
    order = np.argsort(amplitude, kind="stable")
    first = first[order]
    second = second[order]
    amplitude = amplitude[order]
    reached = amplitude > 0
    opacity = np.where(reached, np.where(shown[first] & shown[second], 1.0, UNSELECTED), DIMMED)
    size = (
        LOOKS[Symbol.CONTACT].size
        * min(1.0, max(0.5, (400 / max(len(first), 1)) ** 0.25))
        * np.where(reached, 1.0, 0.7)
    )
    position = (graph.node_position[first] + graph.node_position[second]) / 2
    return points_of(position, _amplitude_colour(scale, amplitude), opacity, size, Symbol.CONTACT)


def _listener_points(result: FrameResult, scale: AmplitudeScale, options: Options) -> Lines:
    amplitude = listener_amplitudes(result, options)
    chosen = _chosen(options.listeners, result.listeners)
    opacity = np.where(chosen, np.where(amplitude > 0, 1.0, SILENT), UNSELECTED)
    position = result.graph.node_position[result.graph.listener_nodes]
    return points_of(
        position,
        _amplitude_colour(scale, amplitude),
        opacity,
        LOOKS[Symbol.LISTENER].size,
        Symbol.LISTENER,
    )


def _source_points(result: FrameResult, options: Options) -> Lines:
    """One point per source; for an impact one on each object if they have separated."""
    graph = result.graph
    places: list[tuple[SourceNodes, FloatArray]] = []
    for source in graph.sources:
        at = graph.node_position[list(source.nodes)]
        parted = len(at) > 1 and float(distances(at[0], at[1])) > PARTED
        places.extend((source, position) for position in (at if parted else at[:1]))
    impact = np.array([source.kind is SourceKind.TEMPORARY for source, _ in places], dtype=np.bool_)
    silent = np.array([source.amplitude <= 0 for source, _ in places], dtype=np.bool_)
    chosen = _chosen(options.sources, [source for source, _ in places])
    return points_of(
        np.array([position for _, position in places]).reshape(-1, 3),
        np.where(
            silent[:, None], SILENT_COLOUR, np.where(impact[:, None], IMPACT_COLOUR, SOURCE_COLOUR)
        ),
        np.where(chosen, np.where(silent, SILENT, 1.0), UNSELECTED),
        np.where(impact, LOOKS[Symbol.IMPACT].size, LOOKS[Symbol.SOURCE].size),
        np.where(impact, Symbol.IMPACT, Symbol.SOURCE),
    )


def listener_amplitudes(result: FrameResult, options: Options) -> FloatArray:
    """Largest amplitude (l,) that arrives at each listener from any shown source."""
    shown = _chosen(options.sources, result.sources)
    return np.asarray(result.amplitudes[shown].max(axis=0, initial=0.0))


def _amplitude_colour(scale: AmplitudeScale, amplitude: FloatArray) -> FloatArray:
    """Colours (n, 3) by amplitude, grey for 0."""
    return np.where((amplitude > 0)[:, None], scale.colour(amplitude), SILENT_COLOUR)


def _labels(result: FrameResult, scale: AmplitudeScale, options: Options) -> tuple[Label, ...]:
    """Of listeners, and of sources that are none."""
    labels = {}
    for source in result.sources:
        chosen = source.name in options.sources
        if chosen or source.kind is not SourceKind.TEMPORARY:
            colour = SOURCE_COLOUR if source.amplitude > 0 else SILENT_COLOUR
            labels[source.name] = _label(source, Symbol.SOURCE, colour, 20.0 + 4 * chosen)
    received = listener_amplitudes(result, options)
    for listener, amplitude, colour in zip(
        result.listeners, received, _amplitude_colour(scale, received), strict=True
    ):
        chosen = listener.name in options.listeners
        if chosen or not options.listeners:
            priority = 10.0 * chosen + float(scale.place(amplitude))
            labels[listener.name] = _label(listener, Symbol.LISTENER, colour, priority)
    wanted = options.labelled
    return tuple(label for label in labels.values() if wanted is None or label.name == wanted)


def _label(item: Source | Listener, shape: Symbol, colour: FloatArray, priority: float) -> Label:
    red, green, blue = colour.tolist()
    size = LOOKS[shape].size / 2
    return Label(item.name, item.position, (red, green, blue), size, priority)


def _between(ends: tuple[float, float], place: FloatArray) -> FloatArray:
    return ends[0] + (ends[1] - ends[0]) * place
