"""Sliding and rolling: the sample in the window while its crate is dragged, the rules of its panel,
textures of materials by a click."""

import bpy


def steps(window):
    scene = bpy.context.scene
    for obj in list(scene.objects):
        bpy.data.objects.remove(obj)
    sessions = window.module("addon.session.sessions")
    sample = window.module("sample_scenes.sliding_and_rolling")
    with window.context():
        bpy.ops.haptic.add_sample(sample="sliding_and_rolling")
    scene = window.window.scene
    window.open_only("HAPTIC_PT_scene", "HAPTIC_PT_settings", "HAPTIC_PT_textures")
    yield from window.show_sidebar()
    yield from window.show_properties("SCENE")
    yield from window.wait_until(lambda: sessions.shown(scene) is not None)
    first, _ = sample.SECTIONS["Crate"]
    for frame in range(first - 1, first + 12):
        scene.frame_set(frame)
    yield from window.wait_until(lambda: sessions.shown(scene).result.number == first + 11)

    def plays():
        names = {source.name for source in sessions.shown(scene).result.sources}
        return (
            names == {"Crate sliding on Yard", "Yard sliding on Crate"}
            and sessions.shown(scene).result.amplitudes.any()
        )

    window.seen["the crate sounds while it is dragged"] = plays()
    yield from window.screenshot("crate-is-dragged")
    yield from window.scroll_sidebar(12)
    yield from window.screenshot("rules-of-what-slides")
    rows = scene.haptics.textures
    count = len(rows.items)
    yield from window.click_button("haptic.add_textures")
    materials = [row.first for row in rows.items[count:]]
    window.seen["a click adds the textures of all materials"] = {
        "Steel",
        "Concrete",
        "Gravel",
        "Flesh",
    } <= set(materials)
    rows.items[0].first_kind, rows.items[0].first = "OBJECT", "Rasp"
    rows.active = 0

    def said():
        return [
            problem.message
            for problem in sessions.shown_problems(scene)
            if problem.rule == ("textures", 0)
        ]

    yield from window.wait_until(lambda: bool(said()))
    window.seen["what is not there is said beside its row"] = (
        "there is no haptic object 'Rasp'" in said()
    )
    window.seen["the paused frame still sounds"] = plays()
    yield from window.screenshot("texture-with-a-problem")
    for frame in (first + 4, first + 11):
        scene.frame_set(frame)
        yield from window.wait_until(
            lambda number=frame: sessions.shown(scene).result.number == number
        )
        window.seen[f"a jump to frame {frame} brings back its slide"] = plays()
