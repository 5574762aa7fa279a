"""What a file gives, as plain numbers: gains, levels and impacts of a .blend or a haptic scene.

Levels are in decibels of full scale, gains in decibels with the source's amplitude, both rounded to
thousandths and None below `FLOOR`; ``bits`` is a checksum of all numbers that they were rounded
from. Only what `docs/scripting.md` and the command line offer is used, so that these lines also run
on versions long gone or not yet written.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import wavfile

FLOOR = -100.0
"""What is quieter [dB] counts as silence: it is below a step of 16 bits."""
TOLERANCE = 0.1
"""Levels of old files stay within this [dB]."""
MOMENT = 1e-3
"""Impacts stay within this [s]."""

Measured = dict[str, Any]
"""Of one file: names, and numbers in nested lists and dictionaries, see `of_frames` and
`of_command`; and ``bits``."""


def decibels(values: Any) -> Any:
    """Numbers as rounded decibels, in lists like theirs; None for silence."""
    if isinstance(values, np.ndarray):
        return decibels(values.tolist())
    if isinstance(values, list):
        return [decibels(value) for value in values]
    level = 20 * math.log10(abs(values)) if values else -math.inf
    return round(level, 3) if level > FLOOR else None


def of_frames(results: list[Any]) -> Measured:
    """Of traced frames: amplitudes that arrive in those that begin, end, or have impacts; the level
    of each listener in each frame; all impacts."""
    struck = [result for result in results if result.impacts]
    shown = {result.number: result for result in (results[0], *struck[:3], results[-1])}
    numbers = hashlib.sha256()
    for result in results:
        numbers.update(_amplitudes(result).tobytes())
        numbers.update(b"" if result.block is None else result.block.tobytes())
    return {
        "listeners": [item.name for item in results[-1].listeners],
        "gains": {str(n): _by_source(result) for n, result in shown.items()},
        "levels": {
            str(r.number): decibels(np.sqrt((r.block**2).mean(axis=1)))
            for r in results
            if r.block is not None and r.block.shape[1]
        },
        "impacts": [
            [
                result.number,
                *sorted(result.objects[k] for k in impact.objects),
                round(impact.time, 6),
                float(f"{impact.energy:.4g}"),
            ]
            for result in results
            for impact in result.impacts
        ],
        "bits": numbers.hexdigest()[:16],
    }


def _amplitudes(result: Any) -> Any:
    """The amplitudes (s, l) that arrive, which version 0.1 called gains."""
    return result.amplitudes if hasattr(result, "amplitudes") else result.gains


def _by_source(result: Any) -> list[list[Any]]:
    """Name of each source, or the objects of a temporary one, and the amplitudes that arrive at the
    listeners. Impacts at one moment may change places."""
    rows = []
    for source, amplitudes in zip(result.sources, _amplitudes(result), strict=True):
        name = (
            source.name
            if source.kind.value == "persistent"
            else f"{source.object} {source.second_object or ''}"
        )
        rows.append([name, *decibels(amplitudes)])
    return sorted(rows, key=json.dumps)


def of_blend(
    path: Path, first: int, last: int, ways: bool = False, settings: dict[str, str] | None = None
) -> Measured:
    """Of the frames of a .blend as it plays them. ``ways``: also the gains of the last frame in
    every mode and strategy. ``settings``: properties by their paths, as of ``haptic-tracing bake
    --set``, that are changed first."""
    import bpy
    from haptic_tracing.addon.session import session

    bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    scene = bpy.context.scene
    if settings:
        from haptic_tracing.command_line.setting import assign

        for name, value in settings.items():
            assign(scene, f"{name}={value}")

    def traced(number: int) -> Any:
        scene.frame_set(number)
        result = session.result_of(scene)
        assert result is not None and result.number == number, session.problems_of(scene)
        return result

    opened = traced(scene.frame_current)
    found = {
        "opened": _by_source(opened),
        **of_frames([traced(number) for number in range(first, last + 1)]),
    }
    if ways:
        found["ways"] = {}
        for name, values in (
            ("mode", ("SD", "MD", "MN")),
            ("strategy", ("as_in_the_paper", "best_path", "all_paths", "energy_balance")),
        ):
            before = getattr(scene.haptics, name)
            for value in values:
                setattr(scene.haptics, name, value)
                found["ways"][value] = _by_source(traced(last))
            setattr(scene.haptics, name, before)
    return found


def of_import(path: Path) -> Measured:
    """Of the frames of a haptic scene file as Blender plays it after an import."""
    import bpy
    from haptic_tracing.addon.session import session

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert bpy.ops.import_scene.haptic_scene(filepath=str(path)) == {"FINISHED"}
    scene, results = bpy.context.scene, []
    for number in range(scene.frame_start, min(scene.frame_end, scene.frame_start + 5) + 1):
        scene.frame_set(number)
        results.append(session.result_of(scene))
    return of_frames(results) if all(results) else {"problems": len(session.problems_of(scene))}


def of_scene_file(path: Path, folder: Path) -> Measured:
    """Of a haptic scene file: what the commands ``propagate``, ``contacts`` (positions in cm) and
    ``export`` give; ``folder`` is empty."""
    propagated = run("propagate", path, "--felt")
    try:
        exported = of_command(folder, "export", path, "--to", "wav", "--seconds", 0.5)
    except ValueError:
        exported = {"tracks": "refused"}  # nobody listens
    return {
        "propagate": [
            [pair["source"], pair["listener"], decibels(pair["gain"])]
            for pair in propagated["gains"]
        ],
        "felt": [
            [item["source"], item["listener"], item["state"], round(item["margin"], 3)]
            for item in propagated["felt"]
        ],
        "modalities": {
            name: [[item["listener"], round(item["value"], 4)] for item in part["felt"]]
            for name, part in propagated.get("modalities", {}).items()
        },
        "contacts": sorted(
            [
                *sorted(item["objects"]),
                *(round(100 * x, 3) for x in np.mean(item["positions"], axis=0).tolist()),
            ]
            for item in run("contacts", path)["contacts"]
        ),
        **exported,
    }


def of_command(folder: Path, *arguments: Any) -> Measured:
    """Of a command that writes WAV files into ``folder``: the level of each channel of each; and
    their bytes."""
    run(*arguments, "--out", folder)
    return of_wave_files(folder)


def of_wave_files(folder: Path) -> Measured:
    """Of the WAV files (16 bits) of a folder: the level of each channel."""
    found, written = {}, hashlib.sha256()
    for path in sorted(folder.rglob("*.wav")):
        samples = np.atleast_2d(wavfile.read(path)[1].T).T / 32768
        found[path.name] = decibels(np.sqrt((samples**2).mean(axis=0)))
        written.update(samples.tobytes())
    return {"tracks": found, "bits": written.hexdigest()[:16]}


def of_blender_command(folder: Path, *arguments: Any) -> Measured:
    """The same of a command that enables the add-on itself and leaves it so."""
    import atexit

    import haptic_tracing
    from haptic_tracing.command_line import trace

    haptic_tracing.unregister()
    try:
        return of_command(folder, *arguments)
    finally:
        atexit.unregister(trace.unregister)


def of_script(path: Path, folder: Path) -> Measured:
    """Of a script that makes, traces, bakes and exports a scene and names what it computes."""
    import bpy

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with contextlib.chdir(folder), contextlib.redirect_stdout(io.StringIO()):
        names: dict[str, Any] = {}
        exec(compile(path.read_text(encoding="utf-8"), str(path), "exec"), names)
        track = json.loads(Path("table.hjif").read_bytes())
    return {
        **of_frames([names["result"]]),
        "core": decibels(names["found"].gain),
        "track": numbers(track),
    }


def numbers(value: Any) -> list[Any]:
    """All numbers in a JSON document, as decibels: their relative difference."""
    if isinstance(value, dict | list):
        return [
            number
            for part in (value.values() if isinstance(value, dict) else value)
            for number in numbers(part)
        ]
    return (
        [decibels(value)] if isinstance(value, int | float) and not isinstance(value, bool) else []
    )


def run(*arguments: Any) -> Any:
    """Run a command in this process, and give what it prints as JSON."""
    from haptic_tracing.command_line import main

    printed, warned = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(warned):
        code = main([str(argument) for argument in arguments])
    if code:
        raise ValueError(f"{' '.join(map(str, arguments))}: {warned.getvalue().strip()}")
    try:
        return json.loads(printed.getvalue())
    except json.JSONDecodeError:
        return None


def difference(before: Any, now: Any, at: str = "") -> tuple[float, str]:
    """The largest difference between two measurements [dB], and where it is. It is infinite where
    one has what the other lacks."""
    if at.endswith("/bits"):
        return 0.0, ""
    if "/impacts/" in at and isinstance(before, list) and isinstance(now, list):
        return _between_impacts(before, now, at)
    if isinstance(before, dict) and isinstance(now, dict) and before.keys() == now.keys():
        return max(
            (difference(before[key], now[key], f"{at}/{key}") for key in before), default=(0.0, "")
        )
    if isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        return max(
            (
                difference(a, b, f"{at}/{k}")
                for k, (a, b) in enumerate(zip(before, now, strict=True))
            ),
            default=(0.0, ""),
        )
    if all(value is None or isinstance(value, float) for value in (before, now)):
        return abs((FLOOR if before is None else before) - (FLOOR if now is None else now)), at
    return (
        (0.0, "") if before == now else (math.inf, f"{at}: {_short(before)} became {_short(now)}")
    )


def _between_impacts(before: list[Any], now: list[Any], at: str) -> tuple[float, str]:
    """Frame, objects, time [s], energy [J]: infinite if one of the first three differs; otherwise
    by the amplitude, the root of energy."""
    if before[:3] != now[:3] or abs(before[3] - now[3]) > MOMENT:
        return math.inf, f"{at}: {before} became {now}"
    return abs(10 * math.log10(before[4] / now[4])), f"{at}: {before} became {now}"


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) < 100 else f"{text[:100]}... ({len(value)})"
