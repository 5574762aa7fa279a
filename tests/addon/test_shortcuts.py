"""The add-on's shortcuts: Blender uses none of them, they come and go, and the mode menu offers the
four renderings."""

import importlib.util
from pathlib import Path
from types import SimpleNamespace

import bpy
import haptic_tracing
import recording_layout
from haptic_tracing.addon.panels import object_menus, preferences
from haptic_tracing.core.scene.values import MODES

MODIFIERS = ("ctrl", "shift", "alt", "oskey")
OF_PLUGINS = {"haptic.drag_one_shot"}


def own_items():
    """The add-on's shortcuts, and the keymaps that they are in."""
    configuration = bpy.context.window_manager.keyconfigs.addon
    return [
        (name.name, item)
        for name in configuration.keymaps
        for item in name.keymap_items
        if preferences.is_own(item)
    ]


def blenders_items():
    """All shortcuts that Blender ships, as its own source has them: keymap, operator, and what is
    pressed."""
    path = (
        Path(bpy.utils.system_resource("SCRIPTS"))
        / "presets"
        / "keyconfig"
        / "keymap_data"
        / "blender_default.py"
    )
    specification = importlib.util.spec_from_file_location("blenders_keymaps", path)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return [
        (name, operator, pressed)
        for name, options, content in module.generate_keymaps(module.Params())
        if not options.get("modal")
        for operator, pressed, _ in content["items"]
    ]


def test_tracing_modes_preview_and_panic_have_shortcuts():
    found = {
        {
            "wm.call_menu_pie": lambda item: item.properties.name,
            "wm.context_toggle": lambda item: item.properties.data_path,
        }.get(item.idname, lambda item: item.idname)(item)
        for _, item in own_items()
    }
    assert (
        found | OF_PLUGINS
        == {
            "scene.haptics.tracing",
            "HAPTIC_MT_mode_pie",
            "haptic.panic",
            "haptic.toggle_preview",
        }
        | OF_PLUGINS
    )


def test_blender_uses_none_of_them():
    blenders = blenders_items()
    assert len(blenders) > 1000
    for _, item in own_items():
        if item.idname == "haptic.drag_one_shot":
            continue  # it passes on every press of the mouse beside a one-shot
        keys = tuple(bool(getattr(item, modifier)) for modifier in MODIFIERS)
        taken = [
            (name, operator)
            for name, operator, pressed in blenders
            if pressed["type"] == item.type
            and (
                pressed.get("any")
                or tuple(pressed.get(modifier, False) in (True, 1) for modifier in MODIFIERS)
                == keys
            )
        ]
        assert taken == [], item.idname


def test_they_are_taken_away():
    count = len(own_items())
    haptic_tracing.unregister()
    assert own_items() == []
    haptic_tracing.register()
    assert len(own_items()) == count > 0


def test_the_mode_menu_offers_every_mode(scene):
    pie = recording_layout.RecordingLayout()
    object_menus.HAPTIC_MT_mode_pie.draw(SimpleNamespace(layout=pie), bpy.context)
    assert pie.properties == ["mode"] * 4
    assert pie.labels == [f"{title} ({name})" for name, (title, _) in MODES.items()]


def test_preferences_list_them_where_they_can_be_changed(monkeypatch):
    import rna_keymap_ui

    drawn = []
    monkeypatch.setattr(rna_keymap_ui, "draw_kmi", lambda *what: drawn.append(what[3].idname))
    configurations = bpy.context.window_manager.keyconfigs
    layout = recording_layout.RecordingLayout()
    context = SimpleNamespace(
        window_manager=SimpleNamespace(keyconfigs=SimpleNamespace(user=configurations.addon))
    )
    preferences.draw_shortcuts(layout, context)
    assert sorted(drawn) == [
        "haptic.panic",
        "haptic.toggle_preview",
        "wm.call_menu_pie",
        "wm.context_toggle",
    ]
