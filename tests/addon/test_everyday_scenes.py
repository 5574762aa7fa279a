"""The ten everyday scenes of the validation, made by *Make Haptic*: the levels are the same."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.session import session
from haptic_tracing.study.everyday import scenes

EVERY = {scene.name: scene for scene in scenes()}


@pytest.mark.parametrize("name", EVERY)
def test_make_haptic_gives_the_same(name, add_box, add_empty, scene):
    wanted = EVERY[name]
    for thing in wanted.things:
        box = add_box(thing.name, thing.at, thing.size, haptic=False)
        bpy.ops.object.select_all(action="DESELECT")
        box.select_set(True)
        bpy.context.view_layer.objects.active = box
        bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
        if thing.mass is not None:
            bpy.ops.rigidbody.object_add()
            box.rigid_body.mass, box.rigid_body.collision_shape = thing.mass, "BOX"
        bpy.context.view_layer.update()
        bpy.ops.haptic.make_objects()
        bpy.ops.haptic.apply_material(preset=thing.material)
        if thing.in_a_building:
            box.haptics.absorption = thing.haptic_object().propagation.absorption
    for role, (on, at) in {
        "source": (wanted.source.on, wanted.source.at),
        **{name: (place.on, place.at) for name, place in wanted.places.items()},
    }.items():
        empty = add_empty(role, (0, 0, 0), bpy.data.objects[on])
        empty.matrix_world.translation = at
        (empty.haptics.source if role == "source" else empty.haptics.listener).enabled = True
        if role != "source":
            empty.haptics.listener.radius = 0.0
    bpy.context.view_layer.update()
    result = session.result_of(scene)
    found = dict(
        zip(
            (listener.name for listener in result.listeners),
            20 * np.log10(result.propagation.band_gain[0, :, wanted.band]),
            strict=True,
        )
    )
    for place, level in wanted.levels().items():
        assert found[place] == pytest.approx(level, abs=0.5)
