"""Twenty sources on a plate: who is felt by a palm, who is masked, and the palm's extent, in the
sidebar."""

import math

import bpy


def steps(window):
    bpy.context.preferences.view.ui_scale = 0.6  # all panels fit into the sidebar
    bpy.ops.mesh.primitive_cube_add(size=1)
    plate = bpy.context.object
    plate.name, plate.scale = "Plate", (4, 2, 0.1)
    plate.haptics.enabled = True
    plate.haptics.function, plate.haptics.alpha = "exponential", 0.5
    for k in range(20):
        bpy.ops.object.empty_add(
            type="PLAIN_AXES", radius=0.1, location=(1.8 * math.cos(k), 0.9 * math.sin(k), 0.05)
        )
        source = bpy.context.object.haptics.source
        bpy.context.object.name = f"Source {k + 1}"
        bpy.context.object.parent, bpy.context.object.matrix_parent_inverse = (
            plate,
            plate.matrix_world.inverted(),
        )
        source.enabled, source.frequency, source.amplitude = (
            True,
            30.0 * 1.18**k,
            0.05 + 0.9 * (7 * k % 20) / 20,
        )
    bpy.ops.object.empty_add(type="SPHERE", location=(0, 0, 0.05))
    palm = bpy.context.object
    palm.name, palm.parent, palm.matrix_parent_inverse = (
        "Palm",
        plate,
        plate.matrix_world.inverted(),
    )
    palm.haptics.listener.enabled = True
    listener = palm.haptics.listener
    window.open_only("HAPTIC_PT_roles", "HAPTIC_PT_result")
    yield from window.show_sidebar()
    watched, session = window.module("addon.view.watched"), window.module("addon.session.session")
    scene = bpy.context.scene

    def felt():
        latest = watched.felt_at_watched(scene)
        return (
            latest.value.counts()
            if latest is not None and latest.is_current and latest.value
            else None
        )

    yield from window.wait_until(lambda: felt() is not None)
    before = felt()
    window.seen["some are felt and some hidden"] = (
        sum(before) == 20 and before[0] > 0 and before[1] > 0
    )
    yield from window.screenshot("felt")
    gain = session.result_of(scene).amplitudes.sum()
    listener.radius = 1.0
    yield 1.0
    window.seen["a larger palm feels more"] = session.result_of(scene).amplitudes.sum() > 1.2 * gain
    window.seen["its empty is drawn as large"] = abs(palm.empty_display_size - 1.0) < 1e-6
    yield from window.screenshot("larger")
