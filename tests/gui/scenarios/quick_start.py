"""From the default cube to a felt effect by the six steps of the quick start, undo and redo after
each; then it is skipped."""

import bpy


def roles() -> dict[str, bool]:
    haptics = bpy.context.scene.objects["Cube"].haptics
    return {
        "haptic": haptics.enabled,
        "source": haptics.source.enabled,
        "listeners": len(bpy.context.scene.objects) == 15,
    }


def steps(window):
    quick_start = window.module("addon.panels.quick_start")

    def done():
        return [is_done for _, is_done in quick_start.steps(bpy.context)]

    yield from window.show_sidebar()
    window.seen["nothing is done yet"] = not any(done())
    buttons = ("haptic.make_objects", "haptic.add_source", "haptic.add_default_listeners")
    for number, button in enumerate(buttons):
        before = roles()
        yield from window.click_button(button)
        after = roles()
        yield from window.wait_until(lambda number=number: done()[number])
        window.seen[f"{button} is ticked off"] = done()[: number + 1] == [True] * (number + 1)
        yield from window.undo()
        yield from window.wait_until(lambda number=number: not done()[number])
        window.seen[f"{button} is undone"] = roles() == before != after
        window.seen[f"{button} is not ticked off"] = not done()[number]
        yield from window.redo()
        window.seen[f"{button} is redone"] = roles() == after
    window.seen["all roles"] = all(roles().values())
    window.seen["after three clicks"] = window.clicks == len(buttons)

    yield from window.click_button("screen.animation_play")
    yield from window.wait_until(lambda: done()[3])
    window.seen["playing is ticked off"] = done()[3]
    yield from window.click_button("screen.animation_play")
    window.seen["and paused"] = not window.window.screen.is_animation_playing
    yield from window.screenshot("felt")
    result = window.module("addon.session.session").result_of(bpy.context.scene)
    window.seen["twelve listeners feel it"] = result.amplitudes.shape == (1, 12) and bool(
        (result.amplitudes > 0).all()
    )
    cube = bpy.context.scene.objects["Cube"]
    for obj in bpy.context.scene.objects:
        obj.select_set(obj == cube)
    bpy.context.view_layer.objects.active = cube
    yield 0.5
    yield from window.drag("haptics.source.amplitude", -60)
    yield from window.wait_until(lambda: done()[4])
    window.seen["a dragged amplitude is ticked off"] = done()[4] and not done()[5]
    bpy.context.scene.frame_end = 12
    yield from window.scroll_sidebar(60)
    yield from window.click_button("haptic.bake")
    yield from window.wait_until(lambda: all(done()))
    yield from window.screenshot("done")
    window.seen["a bake is ticked off"] = all(done())
    window.module("addon.properties.preferences").preferences().show_quick_start = False
    window.seen["skipped"] = not quick_start.HAPTIC_PT_quick_start.poll(bpy.context)
    yield from window.screenshot("skipped")
