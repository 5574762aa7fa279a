"""The result as a table."""

import bpy
import pytest
from haptic_tracing.addon.view import table

ALPHA = {"left": 0.5, "right": 2.0}


@pytest.fixture
def pair(scene, add_box, add_empty, traced):
    """Two boxes of 2 m that touch at x = 0; a source at x = -1.8 and a listener at x = 1.8."""
    for name, x in (("left", -1), ("right", 1)):
        box = add_box(name, (x, 0, 0), (2, 2, 2))
        box.haptics.function, box.haptics.alpha = "exponential", ALPHA[name]
    drill = add_empty("drill", (-0.4, 0, 0), bpy.data.objects["left"])
    drill.haptics.source.enabled, drill.haptics.source.amplitude = True, 0.5
    hand = add_empty("hand", (0.4, 0, 0), bpy.data.objects["right"])
    hand.haptics.listener.enabled, hand.haptics.listener.radius = True, 0.0
    traced()
    return scene


def test_the_table_is_sorted(pair, add_box, add_empty, traced, settle):
    fan = add_empty("fan", (0.0, 0, 0), bpy.data.objects["left"])
    fan.haptics.source.enabled, fan.haptics.source.amplitude = True, 0.01
    alone = add_box("alone", (9, 0, 0), (1, 1, 1))
    alone.haptics.listener.enabled = True
    traced()
    names = lambda: [(row.listener, row.source) for row in settle(lambda: table.rows(pair))]  # noqa: E731
    assert names() == [("alone", ""), ("hand", "drill"), ("hand", "fan")]
    pair.haptics.meters.sort_table = "gain"
    assert names() == [("hand", "fan"), ("hand", "drill"), ("alone", "")], "nearer, not louder"
    pair.haptics.meters.sort_table = "source"
    assert names() == [("alone", ""), ("hand", "drill"), ("hand", "fan")]
