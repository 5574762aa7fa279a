"""Impacts feel like the materials that meet: the source of an impact plays the template of the
pair."""

import bpy
import pytest
from haptic_tracing.addon.session import session
from haptic_tracing.core.signals import DEFAULT_IMPACT, impact_template


@pytest.fixture
def drop(add_box, add_empty, scene):
    """A crate that falls on the ground; returns the signal of its impact."""
    bpy.ops.rigidbody.world_add()
    ground = add_box("ground", (0, 0, -0.5), (10, 10, 1), "PASSIVE")
    crate = add_box("crate", (0, 0, 1.25), (0.5, 0.5, 0.5), "ACTIVE", mass=8.0)
    add_empty("skin", (0.1, 0, 0.5), ground).haptics.listener.enabled = True

    def drop(*materials):
        for obj, name in zip((ground, crate), materials, strict=True):
            obj.haptics.material.name = name
        signals = []
        for frame in range(1, 40):
            scene.frame_set(frame)
            signals += [source.signal for source in session.result_of(scene).sources]
        assert signals and all(signal == signals[0] for signal in signals)
        return signals[0]

    return drop


@pytest.mark.parametrize(
    ("materials", "pair"),
    [
        (("Stone", "Softwood"), ("stone", "wood")),
        (("Steel.001", "Concrete"), ("metal", "concrete")),
    ],
)
def test_an_impact_plays_the_template_of_its_pair(drop, materials, pair):
    assert drop(*materials) == impact_template(*pair)


def test_it_is_plain_where_a_material_is_unknown(drop):
    assert drop("Stone", "") == DEFAULT_IMPACT
