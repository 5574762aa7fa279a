"""From the default cube to a felt effect by clicks, undo and redo after each."""

import bpy


def roles() -> dict[str, bool]:
    haptics = bpy.context.scene.objects["Cube"].haptics
    return {
        "haptic": haptics.enabled,
        "source": haptics.source.enabled,
        "listeners": len(bpy.context.scene.objects) == 15,
    }


def steps(window):
    yield from window.show_sidebar()
    for button in ("haptic.make_objects", "haptic.add_source", "haptic.add_default_listeners"):
        before = roles()
        yield from window.click_button(button)
        after = roles()
        yield from window.undo()
        window.seen[f"{button} is undone"] = roles() == before != after
        yield from window.redo()
        window.seen[f"{button} is redone"] = roles() == after
    window.seen["all roles"] = all(roles().values())

    window.point_at_view()
    yield
    yield from window.press("SPACE")
    yield 2.0
    yield from window.press("SPACE")
    yield from window.screenshot("felt")
    result = window.module("addon.session.session").result_of(bpy.context.scene)
    window.seen["twelve listeners feel it"] = result.amplitudes.shape == (1, 12) and bool(
        (result.amplitudes > 0).all()
    )
