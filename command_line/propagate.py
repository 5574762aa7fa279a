"""``haptic-tracing propagate SCENE.json``: the gains of a haptic scene file as one JSON object."""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
import time
from typing import Any

from ..core.graph import HapticGraph, graph_of_scene
from ..core.propagation import Propagation, objects_on, propagate
from ..core.scene import Mode, Strategy

_UNSET = object()


def add_parser(subparsers: Any) -> None:
    """Add the command to the program's."""
    parser = subparsers.add_parser("propagate", help="gains of a haptic scene file", description=__doc__)
    parser.add_argument("scene", help="haptic scene, .json or .json.gz")
    parser.add_argument("--strategy", choices=[s.value for s in Strategy], help="how gains are computed")
    parser.add_argument("--mode", choices=[m.value for m in Mode], help="rendering of the study: haptic graph, nearest listener, direct")
    parser.add_argument("--max-connections", type=_connections, default=_UNSET, metavar="N|none", help="most connections on a path")
    parser.add_argument("--threshold", type=float, help="a path stops where its gain falls below", metavar="X")
    parser.add_argument("--tolerance", type=float, help="relative error wanted of a sum that is out of reach", metavar="X")
    parser.set_defaults(run=run)


def _connections(text: str) -> int | None:
    return None if text.lower() == "none" else int(text)


def run(args: argparse.Namespace) -> int:
    """Read, propagate, print. Exit code 0, or 2 with one line on stderr."""
    from ..core.formats.scene_json import read_scene

    try:
        scene = read_scene(args.scene)
        chosen = {
            key: value
            for key in ("strategy", "mode", "threshold", "tolerance")
            if (value := getattr(args, key, None)) is not None
        }
        if args.max_connections is not _UNSET:
            chosen["max_connections"] = args.max_connections
        settings = dataclasses.replace(scene.settings, **chosen)
        started = time.perf_counter()
        graph = graph_of_scene(dataclasses.replace(scene, settings=settings))
        built = time.perf_counter()
        result = propagate(graph, settings)
        finished = time.perf_counter()
    except (ValueError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    seconds = {"graph_seconds": built - started, "propagate_seconds": finished - built}
    print(json.dumps(report(graph, result, settings.strategy, seconds), indent=1, ensure_ascii=False, allow_nan=False))
    return 0


def report(graph: HapticGraph, result: Propagation, strategy: Strategy, seconds: dict[str, float]) -> dict[str, Any]:
    """The printed object: every pair present, gains and error bounds with the source's amplitude."""
    pairs = []
    for row, source in enumerate(graph.sources):
        for column, listener in enumerate(graph.listeners):
            paths = int(result.paths[row, column])
            pair: dict[str, Any] = {
                "source": source.name,
                "listener": listener,
                "gain": source.amplitude * float(result.gain[row, column]),
                "error_bound": source.amplitude * float(result.error_bound[row, column]),
                "paths": None if paths < 0 else paths,
                "path": list(objects_on(graph, result.best_path.get((row, column), ()))),
            }
            pairs.append(pair)
    return {
        "gains": pairs,
        "strategy": strategy.value,
        "statistics": {**seconds, **result.statistics},
        "warnings": list(result.warnings),
    }

