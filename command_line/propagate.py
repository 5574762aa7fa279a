"""``haptic-tracing propagate``: the gains of a haptic scene file as one JSON object."""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import time
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..core.graph.haptic_graph import HapticGraph, NoGain
    from ..core.modalities.propagation import Felt
    from ..core.propagation import Propagation
    from ..core.scene.values import HapticScene, Strategy

_UNSET = object()


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Describe the subcommand."""
    parser = subparsers.add_parser("propagate", help="gains of a haptic scene file")
    parser.add_argument("scene", metavar="SCENE.json", help="haptic scene; without contacts they are found from shapes and poses")
    strategies = ("auto", "as_in_the_paper", "best_path", "all_paths", "energy_balance")
    parser.add_argument("--strategy", choices=strategies, help="how gains are computed (the scene's)")
    parser.add_argument("--mode", choices=("HT", "SD", "MD", "MN"), help="rendering: haptic graph, nearest listener, direct (the scene's)")
    parser.add_argument("--max-connections", type=_connections, default=_UNSET, metavar="N|none", help="most connections on a path")
    parser.add_argument("--threshold", type=_threshold, metavar="X", help="a path stops where its gain falls below; 0: nowhere")
    parser.add_argument("--tolerance", type=_tolerance, metavar="X", help="relative error wanted of a sum that is out of reach (0.01)")
    parser.set_defaults(run=run)


def _connections(text: str) -> int | None:
    if text == "none":
        return None
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"must be a whole number, 0 or more, or none, got {text}")
    return int(text)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be a number, got {text}") from None


def _threshold(text: str) -> float:
    value = _number(text)
    if not 0 <= value <= 1:
        raise argparse.ArgumentTypeError(f"must lie in [0, 1], got {text}")
    return value


def _tolerance(text: str) -> float:
    value = _number(text)
    if not 0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"must be finite and >= 0, got {text}")
    return value


def run(args: argparse.Namespace) -> int:
    """Read, propagate, print."""
    from ..core.formats.io.strict_json import read_json
    from ..core.formats.scene.modalities_json import modalities_from_dict
    from ..core.formats.scene.scene_json import current_document, scene_of
    from ..core.graph.haptic_graph import NoGain, graph_of_scene
    from ..core.propagation import propagate
    from . import warn_of_unknown

    document, unknown = current_document(read_json(args.scene), args.scene)
    warn_of_unknown(args.scene, unknown)
    scene = scene_of(document, args.scene)
    modalities = modalities_from_dict(document, scene, args.scene)
    chosen = {key: value for key in ("strategy", "mode", "threshold", "tolerance") if (value := getattr(args, key)) is not None}
    if args.max_connections is not _UNSET:
        chosen["max_connections"] = args.max_connections
    settings = dataclasses.replace(scene.settings, **chosen)
    try:
        scene = _with_contacts(dataclasses.replace(scene, settings=settings))
        started = time.perf_counter()
        graph = graph_of_scene(scene)
        built = time.perf_counter()
        result = propagate(graph, settings)
        finished = time.perf_counter()
        felt = [part.felt_in(scene) for part in modalities if part.enabled]
    except NoGain as error:
        raise ValueError(f"{args.scene}: {_pointer(scene, error)}: {error}") from None
    except ValueError as error:
        raise ValueError(f"{args.scene}: {error}") from None
    seconds = {"graph_seconds": built - started, "propagate_seconds": finished - built}
    printed = report(graph, result, settings.strategy, seconds)
    if felt:
        printed["modalities"] = {item.modality.name: felt_report(item) for item in felt}
    print(json.dumps(printed, indent=1, ensure_ascii=False, allow_nan=False))
    return 0


def felt_report(felt: Felt) -> dict[str, Any]:
    """What the listeners feel of a modality beside vibration, in its unit."""
    values = [{"listener": name, "value": float(value)} for name, value in zip(felt.listeners, felt.values, strict=True)]
    return {"unit": felt.modality.source_value.unit, "felt": values}


def _with_contacts(scene: HapticScene) -> HapticScene:
    """The scene, with contacts from shapes and poses where it lists none itself."""
    if scene.contacts or sum(item.shape is not None for item in scene.objects) < 2:
        return scene
    from ..core.contacts.scene_contacts import contacts_of_scene

    return dataclasses.replace(scene, contacts=contacts_of_scene(scene).to_contacts([item.name for item in scene.objects]))


def _pointer(scene: HapticScene, error: NoGain) -> str:
    """Where the function stands that gives no gain."""
    if len(error.objects) == 1:
        return f"/objects/{[item.name for item in scene.objects].index(error.objects[0])}/propagation"
    pairs = [frozenset(contact.objects) for contact in scene.contacts]
    return f"/contacts/{pairs.index(frozenset(error.objects))}/transmission"


def report(graph: HapticGraph, result: Propagation, strategy: Strategy, seconds: dict[str, float]) -> dict[str, Any]:
    """The printed object: every pair present, gains with the source's amplitude; band gains (relative to the source, in the order of
    `core.bands`), the delay of the best path [s] and (delay, gain) of the strongest paths where the scene uses them."""
    from ..core.diagnosis.sentences import sentence
    from ..core.propagation import objects_on

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
            if result.band_gain is not None:
                pair["band_gains"] = (source.amplitude * result.band_gain[row, column]).tolist()
            if result.delay is not None:
                pair["delay"] = float(result.delay[row, column])
                pair["taps"] = [[delay, source.amplitude * gain] for delay, gain in result.taps.get((row, column), ())]
            pairs.append(pair)
    statistics: dict[str, Any] = {**seconds, **result.statistics}
    if result.warnings:
        statistics["warnings"] = [sentence(warning) for warning in result.warnings]
    return {"gains": pairs, "strategy": strategy.value, "statistics": statistics}
