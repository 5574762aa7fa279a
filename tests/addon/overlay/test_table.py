"""The result as a table."""

import bpy
from haptic_tracing.addon.view import table


def test_the_table_is_sorted(drill_and_hand, add_box, add_empty, traced, settle):
    fan = add_empty("fan", (0.0, 0, 0), bpy.data.objects["left"])
    fan.haptics.source.enabled, fan.haptics.source.amplitude = True, 0.01
    alone = add_box("alone", (9, 0, 0), (1, 1, 1))
    alone.haptics.listener.enabled = True
    traced()

    def names():
        rows = settle(lambda: table.rows(drill_and_hand))
        return [(row.listener, row.source) for row in rows]

    assert names() == [("alone", ""), ("hand", "drill"), ("hand", "fan")]
    drill_and_hand.haptics.meters.sort_table = "gain"
    assert names() == [("hand", "fan"), ("hand", "drill"), ("alone", "")], "nearer, not louder"
    drill_and_hand.haptics.meters.sort_table = "source"
    assert names() == [("alone", ""), ("hand", "drill"), ("hand", "fan")]
