"""The extension works from its own wheels, and the sidebar tab "Haptics" opens on the default
scene; Make Haptic makes its cube haptic."""

import importlib
import sys

import bpy


def steps(window):
    carried = ["fcl", "fastjsonschema", "soxr", "hidraw" if sys.platform == "linux" else "hid"]
    own = bpy.utils.user_resource("EXTENSIONS", path=".local")
    window.seen["own wheels"] = [
        name for name in carried if importlib.import_module(name).__file__.startswith(own)
    ] == carried
    yield from window.show_sidebar()
    window.seen["tab"] = window.region("UI").active_panel_category == "Haptics"
    yield from window.screenshot("sidebar")
    haptics = bpy.context.object.haptics
    yield from window.click_button("haptic.make_objects")
    window.seen["Make Haptic made the cube haptic"] = (haptics.enabled, haptics.function) == (
        True,
        "physical",
    )
    yield from window.screenshot("made-haptic")
    yield from window.undo()
    yield from window.screenshot("undone")
    window.seen["undone"] = not bpy.context.object.haptics.enabled
