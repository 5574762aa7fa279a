"""Every panel draws, with nothing, with a result and with problems; what it shows is what was
traced."""

from types import SimpleNamespace

import bpy
import pytest
import recording_layout
from haptic_tracing.addon.registration.properties import classes_of
from haptic_tracing.addon.scene_reader import functions


def _panels():
    from haptic_tracing.addon.panels import (
        export,
        listener,
        object,
        output,
        quick_start,
        result,
        roles,
        scene,
        settings,
        sound,
        source,
    )

    every = classes_of(
        *(quick_start, scene, roles, result, output),
        *(settings, object, source, sound, listener, export),
    )
    return [panel for panel in every if issubclass(panel, bpy.types.Panel)]


def _draw(panel):
    layout = recording_layout.RecordingLayout()
    if not hasattr(panel, "poll") or panel.poll(bpy.context):
        drawn = SimpleNamespace(layout=layout)
        for part in ("draw_header", "draw_header_preset", "draw"):
            if hasattr(panel, part):
                getattr(panel, part)(drawn, bpy.context)
    return layout


def _panel(name):
    return next(panel for panel in _panels() if panel.__name__ == name)


def test_panels_draw_in_an_empty_file():
    for panel in _panels():
        assert isinstance(_draw(panel).labels, list)


def _select(obj):
    bpy.context.view_layer.objects.active = obj


def test_object_panel_shows_the_parameter_of_the_chosen_function(add_box):
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    _select(box)
    for function, parameter in (
        ("exponential", "alpha"),
        ("linear", "range"),
        ("constant", "constant"),
        ("expression", "expression"),
    ):
        box.haptics.function = function
        assert parameter in _draw(_panel("HAPTIC_PT_object")).properties
    box.haptics.function = "haptic_tracing"
    assert not {"alpha", "range", "constant", "expression"} & set(
        _draw(_panel("HAPTIC_PT_object")).properties
    )


def test_the_checkbox_of_a_new_object_makes_it_haptic_as_the_button_does(add_box):
    boxes = [add_box(name, (0, 0, 0), (1, 1, 1), haptic=False) for name in ("Anvil", "Anvil 2")]
    by_button, by_checkbox = boxes
    _select(by_checkbox)
    assert "enabled" in _draw(_panel("HAPTIC_PT_object")).properties
    by_checkbox.haptics.enabled = True
    by_button.select_set(True)
    bpy.ops.haptic.make_objects()
    values = [functions.read_function(box.haptics) for box in boxes]
    assert values[0] == values[1] and values[0].name == "physical"
    assert [box.haptics.material.name for box in boxes] == ["Steel", "Steel"]
    by_checkbox.haptics.loss_factor = 0.5
    by_checkbox.haptics.enabled = False
    by_checkbox.haptics.enabled = True
    assert by_checkbox.haptics.loss_factor == 0.5


def test_the_panel_of_a_linked_object_offers_to_override_it(add_box, tmp_path):
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    _select(box)
    assert "object.make_override_library" not in _draw(_panel("HAPTIC_PT_roles")).operators
    bpy.data.libraries.write(str(tmp_path / "library.blend"), {box})
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, wanted):
        wanted.objects = ["box"]
    bpy.context.scene.collection.objects.link(wanted.objects[0])
    _select(wanted.objects[0])
    layout = _draw(_panel("HAPTIC_PT_roles"))
    assert (
        "object.make_override_library" in layout.operators
        and "Linked: override it to edit it" in layout.labels
    )


def test_who_is_felt_names_what_hides_a_source(add_box, add_empty, traced, settle):
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    box.haptics.function, box.haptics.constant = "constant", 1.0
    box.haptics.listener.enabled = True
    for name, frequency, amplitude in (
        ("saw", 250.0, 1.0),
        ("fan", 240.0, 0.1),
        ("hum", 40.0, 1.0),
        ("fly", 40.0, 0.0001),
    ):
        source = add_empty(name, parent=box).haptics.source
        source.enabled, source.frequency, source.amplitude = True, frequency, amplitude
    _select(box)
    traced()
    labels = settle(lambda: _draw(_panel("HAPTIC_PT_result"))).labels
    shown = [labels[labels.index(name) + 1] for name in ("saw", "hum", "fan", "fly")]
    assert (
        shown[0] == "+45 dB"
        and shown[1] in ("+13 dB", "+14 dB")
        and shown[2] == "not felt"
        and shown[3].startswith("\N{MINUS SIGN}")
    )
    places = [labels.index(name) for name in ("fan", "fly", "hum", "saw")]
    assert places == sorted(places), "by name, so that rows stay where they are"


def test_a_source_that_reaches_nobody_is_listed_with_its_switches(add_box, traced, settle):
    add_box("near", (0, 0, 0), (1, 1, 1)).haptics.source.enabled = True
    add_box("far", (9, 0, 0), (1, 1, 1)).haptics.listener.enabled = True
    traced()
    drawn = settle(lambda: _draw(_panel("HAPTIC_PT_result")))
    assert drawn.labels[drawn.labels.index("near") + 1] == "\N{EM DASH}"
    assert drawn.properties == ["show", "solo", "muted"]


def test_long_lists_are_cut_and_say_by_how_much(add_box, add_empty, traced, settle):
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    for number in range(14):
        for role in ("source", "listener"):
            getattr(add_empty(f"{role} {number:02}", parent=box).haptics, role).enabled = True
    bpy.data.objects["source 13"].haptics.source.amplitude = 1.0
    for number in range(13):
        bpy.data.objects[f"source {number:02}"].haptics.source.amplitude = 0.01 * (1 + number)
    traced()
    bpy.context.scene.haptics.meters.show = False
    labels = settle(lambda: _draw(_panel("HAPTIC_PT_result"))).labels
    assert "and 4 more" in labels and "and 10 more" in labels
    assert [name for name in labels if name.startswith("source")] == [
        f"source {number:02}" for number in range(10, 14)
    ], "the strongest, in the order of their names"


def test_scene_panel_lists_problems_with_a_button_to_their_object(add_empty, traced):
    add_empty("ghost").haptics.source.enabled = True
    traced()
    for panel in ("HAPTIC_PT_scene", "HAPTIC_PT_why"):
        layout = _draw(_panel(panel))
        assert any(label.startswith("This source is on no haptic") for label in layout.labels)
    assert "ghost" in layout.labels
    assert layout.operators.count("haptic.select_object") == 2, "in the header, and beside its text"


def test_listener_panel_warns_where_it_feels_nothing(add_empty):
    ghost = add_empty("ghost")
    ghost.haptics.listener.enabled = True
    _select(ghost)
    assert "Not on a haptic object:" in _draw(_panel("HAPTIC_PT_listener")).labels


def test_source_panel_shows_the_curves_of_a_drawn_signal(add_box):
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    _select(box)
    box.haptics.source.enabled, box.haptics.source.signal = True, "DRAWN"
    assert "mapping" not in _draw(_panel("HAPTIC_PT_source")).properties
    bpy.ops.haptic.draw_signal()
    bpy.ops.haptic.edit_emphasis()
    drawn = _draw(_panel("HAPTIC_PT_source"))
    assert drawn.properties.count("mapping") == 2
    assert {"duration", "place", "strength", "sharpness"} <= set(drawn.properties)


def test_signal_library_shows_every_signal(add_box):
    from haptic_tracing.addon.io import signal_library

    _select(add_box("box", (0, 0, 0), (1, 1, 1)))
    drawn = _draw(_panel("HAPTIC_PT_signals"))
    names = [path.stem for path in signal_library.files()]
    assert [label for label in drawn.labels if label in names] == names
    assert drawn.operators.count("haptic.hear_signal") == len(names) >= 14


@pytest.mark.plugins
def test_the_export_panel_shows_what_each_listener_loses(tmp_path):
    """A player without actuators at the leg."""
    import numpy as np
    from haptic_tracing.addon.operators.exporting import track_writer
    from haptic_tracing.core.formats.export import Export
    from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks

    blow = np.zeros(8000)
    blow[4000:4400] = np.sin(2 * np.pi * 100 * np.arange(400) / 8000)
    listeners = tuple(
        ListenerTrack(f"on {part}", part, np.array([[0.5, 1.0]]))
        for part in ("hand.L", "upper_leg.L")
    )
    export = Export("blow", tracks=Tracks(listeners, 8000, np.array([0.9 * blow, 0.1 * blow])))
    track_writer("tact", tmp_path, {})(export, SimpleNamespace(progress=None))
    labels = _draw(_panel("HAPTIC_PT_export")).labels
    place = labels.index("on upper_leg.L")
    assert "Lost in blow" in labels[place - 1]
    assert labels[place + 1 : place + 4] == ["-120.0 dB", "Missing onsets: 1", "0.50 s"]
    assert labels[place + 4] == "on hand.L"


def test_dials_that_a_script_has_set_are_shown(add_box):
    """Not those of the library's material, which count no longer."""
    box = add_box("box", (0, 0, 0), (1, 1, 1), haptic=False)
    _select(box)
    box.select_set(True)
    bpy.ops.haptic.make_objects()
    material = bpy.context.scene.haptics.materials.items[box.haptics.material.name]
    shown = {}
    layout = recording_layout.RecordingLayout()
    layout.prop = lambda owner, name, **_: shown.update({name: getattr(owner, name)})
    for kappa in (material.kappa, 0.125):
        box.haptics.kappa = kappa
        _panel("HAPTIC_PT_object").draw(SimpleNamespace(layout=layout), bpy.context)
        assert shown["kappa"] == kappa != 0.5
