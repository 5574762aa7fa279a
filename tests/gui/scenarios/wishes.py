"""Design by Wish in the sidebar: a wished level and a free material, fulfilled by a click; one step
of undo. And the rules of contacts."""

import bpy


def steps(window):
    bpy.context.preferences.view.ui_scale = 0.6  # all panels fit into the sidebar
    scene = window.module("sample_scenes").build_sample("jackhammer_bench")
    bpy.context.window.scene = scene
    session = window.module("addon.session.session")
    levels = window.module("addon.view.levels")
    scene.haptics.strategy = "auto"
    window.open_only(
        "HAPTIC_PT_scene",
        "HAPTIC_PT_settings",
        "HAPTIC_PT_contacts",
        "HAPTIC_PT_materials",
        "HAPTIC_PT_wishes",
    )
    yield from window.show_sidebar()
    yield from window.show_properties("SCENE")
    scene.frame_set(scene.frame_start + 4)
    ground = max(
        (obj for obj in scene.objects if obj.haptics.enabled),
        key=lambda obj: obj.dimensions.x * obj.dimensions.y,
    )
    bpy.ops.haptic.select_object(name=ground.name)
    bpy.ops.haptic.apply_material(preset="concrete")
    item = scene.haptics.materials.items["Concrete"]
    item.is_free = True

    def level():
        result = session.result_of(bpy.context.scene)
        samples = window.module("core.render.history").still_samples(result, 0.25)
        return next(one.rms for one in levels.levels(result, samples) if one.listener == "hand.L")

    before, kappa = level(), item.kappa
    listener = scene.objects["hand.L"].haptics.listener
    listener.use_wish, listener.wish = True, before - 3.0
    bpy.ops.ed.undo_push(message="Wish")
    yield 1.0
    yield from window.screenshot("wish")
    yield from window.click_button("haptic.design_by_wish")
    yield 1.0
    window.seen["the wish is met"] = abs(level() - (before - 3.0)) < 0.5
    yield from window.screenshot("fulfilled")
    yield from window.undo()
    yield 0.5
    window.seen["undo brings the material back"] = (
        abs(bpy.context.scene.haptics.materials.items["Concrete"].kappa - kappa) < 1e-6
    )
    scene = bpy.context.scene
    bpy.ops.haptic.add_rule(table="transmission_table")
    scene.haptics.transmission_table.items[0].function = "resilient"
    yield 1.0
    yield from window.screenshot("contacts")
