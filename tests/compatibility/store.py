"""Makes the old files and the levels that they gave, from the version of the product that is
installed: see README.md.

python tests/compatibility/store.py COLLECTED      with a folder of Blender files that `collect`
saved
"""

from __future__ import annotations

import json
import re
import shutil
import sys
import tarfile
import tempfile
from collections.abc import Hashable, Iterator
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import bpy
import compare
import haptic_tracing
import levels
import made
from haptic_tracing.addon.changes.suspension import suspended
from haptic_tracing.sample_scenes import build_sample

CORPUS = HERE.parent / "core" / "formats" / "corpus"
SAMPLES = {
    "jackhammer_bench": (1, 30, None),
    "hammer_nail": (1, 24, None),
    "fireplace": (1, 6, None),
    "dishwasher_kitchen": (1, 6, None),
    "rails": (1, 6, None),
    "domino_wall": (1, 45, 60),
    "pile": (1, 24, 40),
    "air_blast": (28, 31, None),
    "sliding_and_rolling": (1, 14, None),
    "mine_ride": (62, 72, None),
}
"""First and last frame that are played, and how many things where that can be chosen: two of the
samples are smaller than by default."""
MOST_FRAMES = 12
NAMED = {
    "poses",
    "properties",
    "functions",
    "amplitudes",
    "gains",
    "source_positions",
    "listener_positions",
    "extras",
}
"""Keys of a scene file below which the keys are names of the scene's own."""
KINDS = {
    "function",
    "signal",
    "type",
    "strategy",
    "mode",
    "mixing",
    "extent",
    "motion",
    "kind",
    "encoding",
    "energy",
    "waveform",
}
"""Keys whose values are choices."""


def save_samples(folder: Path) -> None:
    """Save all samples with their rigid bodies baked up to the last frame that is played."""
    for name, (_, last, count) in SAMPLES.items():
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        with suspended():
            scene = build_sample(name, count)
            if scene.rigidbody_world is not None:
                cache = scene.rigidbody_world.point_cache
                cache.frame_end = last
                for frame in range(cache.frame_start, last + 1):
                    scene.frame_set(frame)
                with bpy.context.temp_override(scene=scene, point_cache=cache):
                    bpy.ops.ptcache.bake_from_cache()
                scene.frame_set(scene.frame_start)
            bpy.ops.wm.save_as_mainfile(filepath=str(folder / f"{name}.blend"), compress=False)


def properties_set(group: Any) -> Iterator[Hashable]:
    """Every property of a group, and of those in it, that has a value of its own: its class, its
    name and what was chosen."""
    for described in group.bl_rna.properties:
        name = described.identifier
        if name in ("rna_type", "name"):
            continue
        value = getattr(group, name)
        if described.type == "COLLECTION":
            for item in value:
                yield from properties_set(item)
        elif described.type == "POINTER":
            if isinstance(value, bpy.types.PropertyGroup):
                yield from properties_set(value)
        elif group.is_property_set(name):
            yield (
                type(group).__name__,
                name,
                str(value) if described.type in ("ENUM", "BOOLEAN") else "",
            )


def keys_of(value: Any, at: tuple[str, ...] = ()) -> Iterator[Hashable]:
    """Every key of a scene file by its path, without numbers and names, and every choice."""
    for key, part in value.items() if isinstance(value, dict) else ():
        path = (*at, "*" if at and at[-1] in NAMED else key)
        yield path
        if key in KINDS and isinstance(part, str):
            yield (*path, part)
        yield from keys_of(part, path)
    for part in value if isinstance(value, list) else ():
        yield from keys_of(part, at)


def fewest(covered: dict[Path, set[Hashable]]) -> list[Path]:
    """A few files that together cover what all cover: each time the one that adds most, of equal
    ones the smallest."""
    chosen, left = [], set().union(*covered.values())
    while left:
        best = max(covered, key=lambda path: (len(covered[path] & left), -path.stat().st_size))
        chosen.append(best)
        left -= covered[best]
    return chosen


def collected(
    folder: Path, exported: Path
) -> tuple[dict[Path, set[Hashable]], dict[Path, set[Hashable]]]:
    """What the Blender files of a folder cover that can be traced and heard, and what the scene
    files do that are exported from them."""
    blends, scenes = {}, {}
    for path in sorted(folder.glob("*.blend")):
        try:
            bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
            scene = bpy.context.scene
            first, last = frames_of(scene)
            found = levels.of_blend(path, first, last)
        except (AssertionError, RuntimeError, ValueError) as error:
            print(f"{path.stem}: {str(error)[:200]}", file=sys.stderr)
            continue
        scene = bpy.context.scene
        if not any(
            gain is not None for rows in found["gains"].values() for row in rows for gain in row[1:]
        ):
            continue
        holders = [scene, *scene.objects, *bpy.data.node_groups]
        blends[path] = {feature for holder in holders for feature in properties_set(holder.haptics)}
        written = exported / f"{path.stem}.json"
        options = {
            "frames": "RANGE",
            "frame_start": first,
            "frame_end": min(last, first + 4),
            "tracks": "none",
        }
        if bpy.ops.export_scene.haptic_scene(filepath=str(written), **options) == {"FINISHED"}:
            scenes[written] = set(keys_of(json.loads(written.read_bytes())))
    return blends, scenes


def frames_of(scene: Any) -> tuple[int, int]:
    return scene.frame_start, min(scene.frame_end, scene.frame_start + MOST_FRAMES - 1)


def as_version_1_0(path: Path, target: Path) -> None:
    """Write a scene file as an earlier version would have, whose default strategy had another
    meaning."""
    document = json.loads(path.read_bytes())
    document["version"] = "1.0"
    document.get("settings", {}).pop("strategy", None)
    target.write_text(json.dumps(document, indent=1, ensure_ascii=False), encoding="utf-8")


def main() -> None:
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        parts = {name: folder / name for name in ("samples", "blends", "scenes", "signals")}
        for part in parts.values():
            part.mkdir()
        haptic_tracing.register()
        save_samples(parts["samples"])
        frames = {f"samples/{name}": [first, last] for name, (first, last, _) in SAMPLES.items()}
        with suspended():
            bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
            made.build_materials(bpy.context.scene)
            bpy.ops.wm.save_as_mainfile(
                filepath=str(parts["blends"] / "00 every material.blend"), compress=False
            )
        frames["blends/00 every material"] = [1, 12]
        made.write_scenes(parts["scenes"])
        with tempfile.TemporaryDirectory() as exported:
            blends, scenes = collected(Path(sys.argv[1]), Path(exported))
            for number, path in enumerate(fewest(blends), 1):
                name = f"{number:02} {path.stem.removeprefix('addon_')}"
                bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
                frames[f"blends/{name}"] = frames_of(bpy.context.scene)
                shutil.copy(path, parts["blends"] / f"{name}.blend")
            for number, path in enumerate(fewest(scenes), 1):
                name = f"{number:02} {path.stem.removeprefix('addon_')}"
                shutil.copy(path, parts["scenes"] / f"{name}.json")
                as_version_1_0(path, parts["scenes"] / f"{name} 1.0.json")
        for path in CORPUS.glob("good*"):
            is_scene = path.suffixes[-1:] == [".json"] or path.suffix == ".gz"
            if path.name != "good.wav.json":
                shutil.copy(path, parts["scenes" if is_scene else "signals"])
        (folder / "frames.json").write_text(json.dumps(frames, indent=1), encoding="utf-8")
        snippets = re.findall(
            r"```python\n(.*?)```",
            (HERE.parents[1] / "docs" / "scripting.md").read_text(encoding="utf-8"),
            re.DOTALL,
        )
        script = "\n".join(snippets).replace("bl_ext.user_default.haptic_tracing", "haptic_tracing")
        (folder / "scripting.py").write_text(script, encoding="utf-8")
        with tarfile.open(compare.FILES, "w:xz", preset=9) as tar:
            tar.add(
                folder,
                ".",
                filter=lambda item: item.replace(
                    deep=False, mtime=0, uid=0, gid=0, uname="", gname=""
                ),
            )
        store_levels(folder)
        haptic_tracing.unregister()


def store_levels(files: Path) -> None:
    """Store what all files give."""
    measured = {}
    for name, frames in compare.names_in(files).items():
        with tempfile.TemporaryDirectory() as folder:
            try:
                measured[name] = {
                    "frames": frames,
                    "measured": compare.measure(name, frames, files, Path(folder)),
                }
            except Exception as error:
                print(f"left out: {name}: {error}", file=sys.stderr)
    lines = [
        f"{json.dumps(name)}: {json.dumps(value, separators=(',', ':'), ensure_ascii=False)}"
        for name, value in measured.items()
    ]
    compare.STORED.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
