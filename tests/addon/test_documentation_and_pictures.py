"""What menus and panels point to is there: a picture of every sample, material and signal, a page
of every operator and property."""

from fnmatch import fnmatchcase
from pathlib import Path

import bpy
from haptic_tracing.addon.blender.documentation import manual_map
from haptic_tracing.addon.registration import properties
from haptic_tracing.core.scene.materials import MATERIALS
from haptic_tracing.sample_scenes import SAMPLES

ROOT = Path(__file__).parents[2]
LARGEST = 16_000
"""Bytes of a picture."""


def test_every_choice_has_a_small_picture():
    wanted = {f"sample-{name}" for name in SAMPLES} | {f"material-{name}" for name in MATERIALS}
    wanted |= {f"signal-{kind}" for kind in ("SINE", "PULSE", "NOISE")}
    found = {path.stem: path.stat().st_size for path in (ROOT / "addon" / "thumbnails").iterdir()}
    assert found.keys() == wanted
    assert max(found.values()) < LARGEST


def test_every_operator_and_property_of_ours_has_a_page():
    prefix, entries = manual_map()
    names = [f"bpy.ops.haptic.{name}" for name in dir(bpy.ops.haptic)]
    names += [f"bpy.types.{group.__name__.lower()}.any" for group in properties.CLASSES]
    urls = {
        name: next((prefix + url for pattern, url in entries if fnmatchcase(name, pattern)), "")
        for name in names
    }
    assert len(names) > 50
    assert [
        name for name, url in urls.items() if not Path(url.removeprefix("file://")).is_file()
    ] == []
