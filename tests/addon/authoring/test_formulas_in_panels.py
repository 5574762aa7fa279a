"""Formulas in the panel: the mark stands below the place; a wrong one stops nothing else."""

from types import SimpleNamespace

import blf
import bpy
import haptic_tracing
import pytest
import recording_layout
from haptic_tracing.addon.panels import formula
from haptic_tracing.addon.properties import preferences
from haptic_tracing.addon.registration.properties import classes_of
from haptic_tracing.addon.session import session
from haptic_tracing.core.scene.functions import check_expression


def _draw(panel):
    layout = recording_layout.RecordingLayout()
    drawn = SimpleNamespace(layout=layout)
    if hasattr(panel, "draw_header"):
        panel.draw_header(drawn, bpy.context)
    panel.draw(drawn, bpy.context)
    return layout


def _said(source):
    layout = recording_layout.RecordingLayout()
    finding = formula.draw_finding(layout, source, check_expression(source))
    return finding, layout.labels


def test_a_valid_formula_takes_no_room():
    assert _said("x * exp(-d)") == (None, [])


@pytest.mark.parametrize(
    "source", ["x * exp(-q * d)", "iiii * x", "WWWW + WW", "x" + " + x" * 40 + " + q" + " + x" * 10]
)
def test_the_mark_stands_below_the_place(source):
    _, (shown, mark, *_) = _said(source)
    place = shown.index(next(letter for letter in "qiW" if letter in shown))
    blf.size(0, 11)

    def width(text):
        return blf.dimensions(0, text + "|")[0] - blf.dimensions(0, "|")[0]

    middle = (width(shown[:place]) + width(shown[: place + 1])) / 2
    assert mark.strip() == "^"
    assert width(mark) - width("^") / 2 == pytest.approx(middle, abs=3)


def test_the_object_panel_shows_the_error(add_box):
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    bpy.context.view_layer.objects.active = box
    box.haptics.function, box.haptics.expression = "expression", "x * foo"
    labels = _draw(bpy.types.HAPTIC_PT_object).labels
    assert "x * foo" in labels
    assert any(label.strip() == "^" for label in labels)
    box.haptics.expression = "x / d"
    assert any("finite value at 0 m" in label for label in _draw(bpy.types.HAPTIC_PT_object).labels)


def test_what_stands_on_an_object_with_a_problem_is_left_out(add_box, add_empty, traced):
    bad, good = add_box("bad", (0, 0, 0), (1, 1, 1)), add_box("good", (5, 0, 0), (1, 1, 1))
    bad.haptics.function, bad.haptics.expression = "expression", "x * foo"
    add_empty("skin", (0, 0, 0), bad).haptics.listener.enabled = True
    good.haptics.source.enabled = good.haptics.listener.enabled = True
    assert traced().amplitudes.shape == (1, 1)
    assert [problem.object for problem in session.problems_of(bpy.context.scene)] == ["bad"]


def _advice(obj):
    bpy.context.view_layer.objects.active = obj
    return " ".join(_draw(bpy.types.HAPTIC_PT_object).labels)


def test_the_panel_says_where_nothing_passes_and_where_two_settings_are_the_same(add_box):
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    box.select_set(True)
    box.haptics.kappa = 1.0
    assert "Passes on nothing: κ is 1" in _advice(box)
    box.haptics.kappa, box.haptics.rho = 0.5, 0.0
    assert "Passes on nothing: ρ is 0" in _advice(box)
    bpy.context.view_layer.objects.active = box
    bpy.ops.haptic.apply_material(preset="stone")
    assert "Feels the same" not in _advice(box)
    box.haptics.material.name = ""
    box.haptics.kappa, box.haptics.rho = 0.15, 0.7
    assert "Feels the same as Stone" in _advice(box)
    box.haptics.function, box.haptics.constant = "constant", 0.0
    assert "the gain is 0" in _advice(box)


def test_every_panel_and_menu_of_authoring_draws(add_box, add_empty):
    box, empty = add_box("box", (0, 0, 0), (1, 1, 1)), add_empty("empty")
    armature = bpy.data.objects.new("armature", bpy.data.armatures.new("armature"))
    bpy.context.scene.collection.objects.link(armature)
    box.select_set(True)
    from haptic_tracing.addon.panels import (
        export,
        listener,
        materials,
        object,
        object_menus,
        output,
        result,
        roles,
        scene,
        settings,
        source,
    )

    drawn = (
        *(scene, roles, output, settings, object, source, listener, result, export, materials),
        object_menus,
    )

    for active in (None, box, empty, armature):
        bpy.context.view_layer.objects.active = active
        for made in (False, True):
            if made and active is box:
                bpy.ops.haptic.apply_material(preset="rubber")
                bpy.context.scene.frame_set(2)
            for cls in classes_of(*drawn):
                if hasattr(cls, "draw") and (not hasattr(cls, "poll") or cls.poll(bpy.context)):
                    layout = _draw(cls)
                    # Plug-ins add the buttons of the panel of exports.
                    assert cls in (object.HAPTIC_PT_object_settings, export.HAPTIC_PT_export) or (
                        layout.labels or layout.properties or layout.operators or layout.menus
                    ), cls


def test_panels_draw_with_an_object_of_another_library(add_box):
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    bpy.context.view_layer.objects.active = box
    box.haptics.material.name = "From Elsewhere"
    layout = _draw(bpy.types.HAPTIC_PT_object)
    assert "Not in this scene's library:" in layout.labels
    assert "haptic.new_material" in layout.operators


def test_every_operator_is_in_a_menu():
    from haptic_tracing.addon.panels import object_menus

    offered = set(object_menus.NEEDS_MORE)
    for menu in classes_of(object_menus):
        offered |= set(_draw(menu).operators)
    assert {f"haptic.{name}" for name in dir(bpy.ops.haptic)} <= offered


@pytest.fixture
def enabled():
    """The package enabled as an add-on, with preferences of its own."""
    haptic_tracing.unregister()
    bpy.ops.preferences.addon_enable(module="haptic_tracing")
    yield bpy.context.preferences.addons["haptic_tracing"].preferences
    bpy.ops.preferences.addon_disable(module="haptic_tracing")
    haptic_tracing.register()


def test_preferences_draw_and_count(enabled):
    layout = recording_layout.RecordingLayout()
    type(enabled).draw(_Drawn(enabled, layout), bpy.context)
    assert {"gain_unit", "curve_colour", "overlay_size", "default_device", "keep_awake"} <= set(
        layout.properties
    )
    assert preferences.gain_text(0.5) == "0.50  -6 dB"
    enabled.gain_unit = "FACTOR"
    assert preferences.gain_text(0.5) == "0.50"
    enabled.gain_unit = "DECIBEL"
    assert preferences.gain_text(0.5) == "-6 dB"


class _Drawn:
    """Preferences whose layout is a recorder."""

    def __init__(self, owner, layout):
        self.layout, self.bl_rna = layout, owner.bl_rna


def test_gains_are_written_without_the_add_on_enabled():
    assert preferences.gain_text(0.5) == "0.50  -6 dB"
    assert preferences.gain_text(0.0) == "0.00  -∞ dB"
    assert preferences.gain_text(0.012) == "0.012  -38 dB"
