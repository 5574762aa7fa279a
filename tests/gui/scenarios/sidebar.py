"""The sidebar tab "Haptics" opens on the default scene."""


def steps(window):
    yield from window.show_sidebar()
    window.seen["tab"] = window.region("UI").active_panel_category
    yield from window.screenshot("sidebar")
