"""The table of rules of impacts: buttons, what a row is for, what it plays, and what is wrong with
it beside the row."""

import bpy


def steps(window):
    scene = bpy.context.scene
    for obj in list(scene.objects):
        bpy.data.objects.remove(obj)
    sessions = window.module("addon.session.sessions")
    window.module("sample_scenes").build_sample("hammer_nail")
    scene = window.window.scene
    table = scene.haptics.impact_table
    window.open_only("HAPTIC_PT_scene", "HAPTIC_PT_settings", "HAPTIC_PT_impacts")
    yield from window.show_sidebar()
    yield from window.show_properties("SCENE")
    with window.context():
        bpy.context.view_layer.objects.active = scene.objects["Hammer"]
    yield from window.screenshot("rule-of-a-sample")
    count = len(table.items)
    yield from window.click_button("haptic.add_rule")
    window.seen["a rule for what the active object is made of"] = len(
        table.items
    ) == count + 1 and (
        table.items[-1].first_kind,
        table.items[-1].first,
    ) == ("MATERIAL", "Steel")
    rule = table.items[-1]
    rule.second_kind, rule.second, rule.template, rule.filepath = (
        "OBJECT",
        "Nai*",
        "FILE",
        "/nowhere/knock.wav",
    )
    rule.variation = 0.2

    def said():
        return [
            problem.message
            for problem in sessions.shown_problems(scene)
            if problem.rule == ("impact_table", count)
        ]

    yield from window.wait_until(lambda: bool(said()))
    window.seen["the missing file is said beside its row"] = any(
        "there is no file" in words for words in said()
    )
    yield from window.screenshot("rule-with-a-problem")
    yield from window.scroll_sidebar(20)
    yield from window.screenshot("curves-of-a-rule")
    yield from window.scroll_sidebar(-15)
    yield from window.click_button("haptic.remove_rule")
    window.seen["another removes it"] = len(window.window.scene.haptics.impact_table.items) == count
