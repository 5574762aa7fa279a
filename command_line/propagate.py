"""``haptic-tracing propagate``: the gains of a haptic scene file as one JSON object."""

from __future__ import annotations

import argparse
import math
import time

import numpy as np

from ..core.arrays import FloatArray
from ..core.forms import JsonObject
from ..core.graph.haptic_graph import HapticGraph
from ..core.message import sentence
from ..core.propagation import Propagation, objects_on
from ..core.render.arrival import arriving, signal_gains
from ..core.render.frame_result import Sounding
from ..core.render.levels import vibration_rms
from ..core.render.masking import felt_sources
from ..core.render.renderer import SAMPLE_RATE
from ..core.run_time import Result, Scene, load
from ..core.scene.values import HapticScene
from . import print_json, say


def run(args: argparse.Namespace) -> int:
    """Read, propagate, print."""
    scene = load(args.scene)
    chosen = {
        key: value
        for key in ("strategy", "mode", "threshold")
        if (value := getattr(args, key)) is not None
    }
    if "max_connections" in args:  # none is a value
        chosen["max_connections"] = args.max_connections
    scene = scene.with_settings(**chosen)
    started = time.perf_counter()
    graph = scene.graph()
    built = time.perf_counter()
    result = scene.propagate(graph)
    finished = time.perf_counter()
    seconds = {"graph_seconds": built - started, "propagate_seconds": finished - built}
    printed = report(scene.content, graph, result, seconds)
    if args.felt:
        sounding = Sounding(0.0, scene.content.sources, scene.content.listeners, result)
        printed["felt"] = [
            part
            for column in range(len(scene.content.listeners))
            for part in who_is_felt(sounding, column)
        ]
    if args.contacts:
        printed["contacts"] = contacts_of(scene)
    print_json(printed, args.stdout)
    found = Result(scene.with_contacts(), graph, result)
    say(f"{args.scene}: {words}" for words in found.warnings)
    return 0


def contacts_of(scene: Scene) -> list[JsonObject]:
    """The contacts that shapes and poses give, in the form of the scene file, each with its signed
    ``distance`` [m]."""
    contacts = scene.contacts_found()
    names = [item.name for item in scene.content.objects]
    return [
        {
            "objects": [names[a], names[b]],
            "positions": contacts.positions[i].tolist(),
            "transmission": {"function": "identity"},
            "area": float(contacts.area[i]),
            "normal": contacts.normal[i].tolist(),
            "depth": float(contacts.depth[i]),
            "distance": float(contacts.distance[i]),
            "weight": float(contacts.weight[i]),
        }
        for i, (a, b) in enumerate(contacts.pairs.tolist())
    ]


def who_is_felt(sounding: Sounding, listener: int, sample_rate: float = 8000.0) -> list[JsonObject]:
    """The sources that reach a listener: margin [dB] of each alone above the threshold of feeling,
    whether that is assumed because the device isn't calibrated, and its masker."""
    found = felt_sources(sounding, listener, sample_rate)
    return [
        {
            "listener": found.listener,
            "source": item.source.name,
            "state": item.state,
            "margin": item.margin,
            "assumed": sounding.listeners[listener].device is None,
            "masked_by": item.masker or None,
        }
        for item in found.sources
    ]


def report(
    scene: HapticScene, graph: HapticGraph, result: Propagation, seconds: dict[str, float]
) -> JsonObject:
    """The printed object, with all pairs. ``gain`` includes the source's amplitude, ``path_gain``
    does not; ``level`` [dB of full scale] is the RMS of the first second that the listener would be
    played of this source alone, None for silence. Band gains (in the order of `core.scene.bands`),
    and the delay of the best path [s] if the scene uses them; these gains include the amplitude."""
    pairs = []
    played = _levels_alone(scene, result)
    gains = signal_gains(scene.sources, result).tolist()
    for row, source in enumerate(graph.sources):
        for column, listener in enumerate(scene.listeners):
            pair: JsonObject = {
                "source": source.name,
                "listener": listener.name,
                "gain": source.amplitude * gains[row][column],
                "path_gain": gains[row][column],
                "level": level if (level := float(played[row, column])) > -math.inf else None,
                "limited": bool(result.limited[row, column]),
                "silenced": bool(result.silenced[row, column])
                or source.amplitude == 0
                or listener.gain == 0,
                "paths": int(result.paths[row, column]),
                "path": list(objects_on(graph, result.best_path.get((row, column), ()))),
            }
            if result.band_gain is not None:
                pair["band_gains"] = (source.amplitude * result.band_gain[row, column]).tolist()
            if result.delay is not None:
                pair["delay"] = float(result.delay[row, column])
            pairs.append(pair)
    statistics: JsonObject = {**seconds, **result.statistics}
    if result.warnings:
        statistics["warnings"] = [sentence(warning) for warning in result.warnings]
    return {"gains": pairs, "strategy": scene.settings.strategy.value, "statistics": statistics}


def _levels_alone(scene: HapticScene, result: Propagation) -> FloatArray:
    """Level (s, l) at each listener of the first second of each source by itself [dB of full
    scale]: without other sources, limiter and ceiling. Minus infinity for silence."""
    rate = round(SAMPLE_RATE)
    own = [float(vibration_rms(s.emitted.sample(0, rate, rate), rate)) for s in scene.sources]
    factor = np.array([listener.gain for listener in scene.listeners])
    with np.errstate(divide="ignore"):
        played = arriving(scene.sources, result) * np.reshape(own, (-1, 1)) * factor
        return np.asarray(20.0 * np.log10(played))
