"""The panels in the light theme, at a scale of 1.5 and in German, with the title of each in the
language of the interface."""

import bpy


def steps(window):
    scene = window.module("sample_scenes").build_sample("jackhammer_bench")
    window.window.scene = scene
    view = bpy.context.preferences.view
    bpy.context.view_layer.objects.active = scene.objects["Jackhammer"]
    scene.frame_set(scene.frame_start + 10)
    yield from window.show_sidebar()
    yield from window.show_properties("OBJECT")
    yield 2.0
    yield from window.screenshot("dark")
    yield from window.use_theme("Blender_Light")
    yield from window.screenshot("light")
    yield from window.use_theme("Blender_Dark")
    yield from window.use_scale(1.5)
    yield 1.0
    yield from window.screenshot("scale-1.5")
    yield from window.use_scale(1.0)
    view.language = "de_DE"
    view.use_translate_interface = view.use_translate_tooltips = True
    yield 2.0
    yield from window.screenshot("german")
    words = bpy.app.translations.pgettext_iface
    window.seen["in German"] = (words("What Is Felt"), words("Output"), words("Why")) == (
        "Was gefühlt wird",
        "Ausgabe",
        "Warum",
    )
    bpy.context.preferences.view.language = "en_US"
    yield 0.5
