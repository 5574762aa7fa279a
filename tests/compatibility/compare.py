"""Says what files of earlier versions give now, beside what they gave: see README.md.

    python tests/compatibility/compare.py [NAME ...]     all, or those whose names contain one of
    these texts

One line for each file that differs: the largest difference of a level or a gain in decibels, and
where it is.
"""

from __future__ import annotations

import json
import math
import sys
import tarfile
import tempfile
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import levels

FILES = HERE / "0.1.tar.xz"
"""The files: ``samples`` and ``blends`` are Blender's, ``scenes`` haptic scenes, ``signals``
vibrations in other formats."""
STORED = HERE / "levels.json"
"""What they gave, by name."""
MEANT = HERE / "meant.json"
"""Changes that are meant, by name: ``decibels`` at most, a ``reason``, and the settings that
``restore`` the levels (null: none does)."""
TYPICAL = (
    "blends/0",
    "scenes/good-",
    "scenes/made",
    "imports/made",
    "commands/sound",
    "commands/scripting",
)
"""How the names of those begin that also run where there is little time."""


def stored() -> dict[str, Any]:
    """All measurements by name."""
    return json.loads(STORED.read_text(encoding="utf-8"))


def meant() -> dict[str, Any]:
    """All changes that are meant, by name."""
    return json.loads(MEANT.read_text(encoding="utf-8"))


def unpack(folder: Path) -> None:
    """Unpack the files."""
    with tarfile.open(FILES) as tar:
        tar.extractall(folder, filter="data")


def measure(
    name: str,
    frames: list[int] | None,
    files: Path,
    folder: Path,
    settings: dict[str, str] | None = None,
) -> levels.Measured:
    """Measure the file or the command of a name with the version that is installed; the add-on must
    be registered. ``folder``: empty."""
    kind, _, file = name.partition("/")
    if frames:
        return levels.of_blend(
            files / f"{name}.blend", *frames, ways=kind == "samples", settings=settings
        )
    if kind == "scenes":
        return levels.of_scene_file(files / name, folder)
    if kind == "imports":
        return levels.of_import(files / "scenes" / file)
    if kind == "signals":
        levels.run("convert", files / name, folder / "converted.wav")
        return levels.of_wave_files(folder)
    if file == "scripting":
        return levels.of_script(files / "scripting.py", folder)
    if file == "sound":
        levels.run("sound", files / "signals" / "good.wav", "--output", folder / "signal.json")
        return {"signal": levels.numbers(json.loads((folder / "signal.json").read_bytes()))}
    return levels.of_blender_command(
        folder, *(str(files / part) if part.endswith(".blend") else part for part in file.split())
    )


def names_in(files: Path) -> dict[str, list[int] | None]:
    """The names of everything that is measured; with the frames, of a Blender file."""
    frames = json.loads((files / "frames.json").read_bytes())
    scenes = sorted(path.name for path in (files / "scenes").iterdir())
    signals = sorted(path.name for path in (files / "signals").iterdir())
    commands = (
        "bake samples/hammer_nail.blend --to wav --frames 1:24 --modes HT,SD,MD,MN",
        "bake samples/jackhammer_bench.blend --to wav --frames 10:30 --set "
        "scene.haptics.epsilon=0.3",
        "trace samples/jackhammer_bench.blend --start 1 --end 14 --whole --no-picture",
        "sound",
        "scripting",
    )
    rest = [
        *(f"scenes/{name}" for name in scenes),
        *(f"imports/{name}" for name in scenes),
        *(f"signals/{name}" for name in signals),
        *(f"commands/{command}" for command in commands),
    ]
    return {**frames, **dict.fromkeys(rest)}


def outcome(name: str, files: Path, before: dict[str, Any]) -> tuple[bool, float, str]:
    """Whether a file gives the same bits; the largest difference [dB]; and where."""
    with tempfile.TemporaryDirectory() as folder:
        found = measure(name, before["frames"], files, Path(folder))
    found = json.loads(json.dumps(found))
    decibels, place = levels.difference(before["measured"], found)
    return found == before["measured"], decibels, place


def main() -> None:
    import haptic_tracing

    wanted = sys.argv[1:] or [""]
    changes = meant()
    haptic_tracing.register()
    same = compared = 0
    with tempfile.TemporaryDirectory() as files:
        unpack(Path(files))
        for name, before in stored().items():
            if not any(text in name for text in wanted):
                continue
            try:
                equal, decibels, place = outcome(name, Path(files), before)
            except Exception as error:
                equal, decibels, place = False, math.inf, repr(error)
            compared, same = compared + 1, same + equal
            if not equal:
                note = f" (meant: {changes[name]['reason']})" if name in changes else ""
                print(f"{decibels:8.3f} dB  {name}{note}  {place}", file=sys.stderr)
    print(f"{same} of {compared} give the same bits", file=sys.stderr)
    haptic_tracing.unregister()


if __name__ == "__main__":
    main()
