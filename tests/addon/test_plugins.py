"""Plug-ins of other packages and extensions: what they offer is there, and one that fails stops
nothing."""

import json
import os
import subprocess
import sys

import pytest
import recording_layout
from haptic_tracing.addon.panels import preferences
from haptic_tracing.core import plugins

FORMAT = """
from haptic_tracing.core.formats.io.catalogue import Format

FORMATS = (
    Format(
        name={name!r},
        label="A count of samples",
        suffix=".{name}",
        module=f"{{__name__}}.counting",
        files="<scene>.{name}",
        carries="how many samples there are",
    ),
)
"""
COUNTING = """
def loss(export, options):
    yield "everything but the count"

def comparison(tracks, options, progress):
    return None

def write(export, folder, options, measured):
    path = folder / "count"
    path.write_text(str(export.need_tracks().count))
    return [path]
"""
PANEL = """
import bpy

class {name}_PT_panel(bpy.types.Panel):
    bl_space_type, bl_region_type, bl_label = "VIEW_3D", "UI", "{name}"

    def draw(self, context):
        pass

class {name}_PT_unfinished(bpy.types.Panel):
    bl_space_type, bl_region_type, bl_label = "VIEW_3D", "UI", "Draws nothing"

CLASSES = ({name}_PT_panel, {more})

def register():
    bpy.types.Scene.{name} = bpy.props.BoolProperty()

def unregister():
    del bpy.types.Scene.{name}
"""
FILES = {
    "good/__init__.py": FORMAT.format(name="good"),
    "good/counting.py": COUNTING,
    "good/blender.py": PANEL.format(name="GOOD", more=""),
    "good/german.json": json.dumps({"A count of samples": "Eine Zahl von Werten"}),
    "broken/__init__.py": "import nothing_of_this_name",
    "half/__init__.py": "",
    "half/blender.py": PANEL.format(name="HALF", more="HALF_PT_unfinished"),
    "late/__init__.py": FORMAT.format(name="late"),
    "late/counting.py": COUNTING,
    "others-1.0.dist-info/METADATA": "Metadata-Version: 2.1\nName: others\nVersion: 1.0\n",
    "others-1.0.dist-info/entry_points.txt": "[haptic_tracing.formats]\ngood = good\n"
    "broken = broken\n[haptic_tracing.devices]\nhalf = half\n",
}
PROGRAM = """
import json
import bpy
import haptic_tracing
from haptic_tracing.addon import translations
from haptic_tracing.core import plugins
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
import numpy as np

def seen():
    properties = bpy.ops.export_scene.haptic_tracks.get_rna_type().properties
    return {
        "formats": [item.identifier for item in properties["formats"].enum_items],
        "panels": [name for name in ("GOOD", "HALF") if hasattr(bpy.types, f"{name}_PT_panel")],
        "scene": [name for name in ("GOOD", "HALF") if hasattr(bpy.types.Scene, name)],
    }

haptic_tracing.register()
moments = {"registered": seen(), "failures": dict(plugins.failures)}
moments["german"] = translations.read_language("german")["messages"].get("A count of samples")
tracks = Tracks((ListenerTrack("hand"),), 8000, np.zeros((1, 123)))
(path,) = registry.write("good", Export("count", None, tracks), ".").files
moments["written"] = path.read_text()
import late
haptic_tracing.add_plugin("late", late)
moments["added"] = seen()
haptic_tracing.remove_plugin("late")
moments["removed"] = seen()
haptic_tracing.unregister()
moments["panels left"] = [name for name in ("GOOD", "HALF") if hasattr(bpy.types, f"{name}_PT_panel")]
moments["properties left"] = [name for name in ("GOOD", "HALF") if hasattr(bpy.types.Scene, name)]
print(json.dumps(moments))
"""


@pytest.fixture(scope="module")
def moments(tmp_path_factory):
    """What a Blender with these packages had at each moment."""
    folder = tmp_path_factory.mktemp("packages")
    for name, text in FILES.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
    environment = {**os.environ, "PYTHONPATH": str(folder), "BLENDER_USER_RESOURCES": str(folder)}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], env=environment, cwd=folder, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.slow
def test_a_package_offers_a_format_with_its_words_and_its_part_in_blender(moments):
    assert "good" in moments["registered"]["formats"]
    assert moments["german"] == "Eine Zahl von Werten" and moments["written"] == "123"
    assert moments["registered"]["panels"] == moments["registered"]["scene"] == ["GOOD"]


@pytest.mark.slow
def test_one_that_fails_stops_nothing_and_leaves_no_class(moments):
    assert moments["failures"].keys() == {"broken", "half"}
    assert "nothing_of_this_name" in moments["failures"]["broken"]
    assert moments["panels left"] == moments["properties left"] == []


@pytest.mark.slow
def test_another_extension_adds_one_and_removes_it(moments):
    assert moments["added"]["formats"] == [*moments["registered"]["formats"], "late"]
    assert moments["removed"] == moments["registered"]


def test_preferences_name_the_plug_ins_that_are_left_out(monkeypatch):
    monkeypatch.setitem(plugins.failures, "odd", "ImportError: no module named 'odder'")
    layout = recording_layout.RecordingLayout()
    preferences.draw_failures(layout)
    text = " ".join(layout.labels)
    assert "odd" in text and "no module named 'odder'" in text
