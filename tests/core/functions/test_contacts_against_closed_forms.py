"""Functions of contacts: impedance, a soft layer, the pressing force; alone, by a table of a scene,
and in a file."""

from __future__ import annotations

import math

import numpy as np
import pytest
from haptic_tracing.core.contacts.scene_contacts import contacts_of_scene
from haptic_tracing.core.contacts.shapes import Box
from haptic_tracing.core.events.frame import Frame
from haptic_tracing.core.formats.scene.recording import frame_of
from haptic_tracing.core.formats.scene.scene_json import scene_of, scene_to_dict
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.message import Cause
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.functions import (
    Constant,
    Expression,
    Impedance,
    NormalForce,
    Physical,
    Resilient,
)
from haptic_tracing.core.scene.rule_table import Rule, RuleTable, Side
from haptic_tracing.core.scene.rules import ContactSettings, Motion
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Pose,
    Settings,
    Source,
)
from haptic_tracing.core.tracer import Tracer

LOSSLESS = {"loss_factor": 0.0, "extent": 0.1, "material_k": 0.01}
STEEL = Physical(phase_speed=5100.0, density=7850.0, **LOSSLESS)
RUBBER = Physical(phase_speed=60.0, density=1100.0, **LOSSLESS)


def pair(transmission, first=STEEL, second=RUBBER, **contact) -> HapticScene:
    at = (0.0, 0.0, 0.0)
    return HapticScene(
        (HapticObject("a", 0.5, 0.9, first), HapticObject("b", 0.5, 0.9, second)),
        (Contact(("a", "b"), (at, at), transmission, **contact),),
        (Source("s", "a", at),),
        (Listener("l", "b", at, radius=0.0),),
    )


def test_impedances_pass_the_root_of_the_power_of_a_plane_wave():
    """1 - r^2 of the power, r = (Z1 - Z2) / (Z1 + Z2) (any textbook of acoustics)."""
    one, other = 5100.0 * 7850.0, 60.0 * 1100.0
    reflected = (one - other) / (one + other)
    assert propagate(graph_of_scene(pair(Impedance())), Settings(threshold=0)).gain[
        0, 0
    ] == pytest.approx(math.sqrt(1 - reflected**2))
    assert propagate(graph_of_scene(pair(Impedance(), STEEL, STEEL)), Settings()).gain[0, 0] == 1.0
    assert (
        propagate(
            graph_of_scene(pair(Impedance(), STEEL, Constant(gain_value=1.0))), Settings()
        ).gain[0, 0]
        == 1.0
    )


def test_a_soft_layer_is_a_mass_on_a_spring():
    """Amplitudes of m x'' + k (1 + i n) (x - y) = 0, solved in complex numbers; never above 1."""
    layer = Resilient(stiffness=2e5, load=12.0, loss_factor=0.3)
    assert layer.resonance == pytest.approx(math.sqrt(2e5 / 12.0) / (2 * math.pi))
    for frequency in (1.0, 15.0, layer.resonance, 40.0, 200.0, 900.0):
        spring = 2e5 * (1 + 0.3j)
        expected = abs(spring / (spring - 12.0 * (2 * math.pi * frequency) ** 2))
        assert layer.transmissibility(frequency) == pytest.approx(min(1.0, expected), rel=1e-12)


@pytest.mark.parametrize("fall_off", [6.0, 12.0, 24.0])
def test_far_above_the_resonance_it_falls_by_so_many_decibels_per_octave(fall_off):
    layer = Resilient(stiffness=1e3, load=10.0, loss_factor=0.1, fall_off=fall_off)
    ratio = layer.transmissibility(500.0) / layer.transmissibility(1000.0)
    assert 20 * math.log10(ratio) == pytest.approx(fall_off, rel=0.01)


def test_the_gain_of_a_layer_is_that_of_its_highest_band():
    layer = Resilient(stiffness=1e4, load=20.0)
    found = propagate(graph_of_scene(pair(layer, STEEL, STEEL)), Settings(threshold=0))
    bands = [layer.transmissibility(math.sqrt(low * 2 * low)) for low in (20, 40, 80, 160, 320)] + [
        layer.transmissibility(800.0)
    ]
    assert found.band_gain[0, 0, :5] == pytest.approx(bands[:5], rel=1e-9)
    assert found.gain[0, 0] == pytest.approx(max(bands), rel=1e-9)


def standing(transmission, mass=5.0, motion=Motion.DYNAMIC) -> HapticScene:
    """A box of ``mass`` on a floor."""
    objects = (
        HapticObject(
            "box",
            0,
            1,
            STEEL,
            Box((0.2, 0.2, 0.2)),
            Pose((0, 0, 0.1)),
            mass,
            motion=motion,
            material="Steel",
        ),
        HapticObject(
            "floor",
            0,
            1,
            RUBBER,
            Box((4, 4, 0.2)),
            Pose((0, 0, -0.1)),
            motion=Motion.STATIC,
            material="Rubber",
        ),
    )
    scene = HapticScene(
        objects,
        (),
        (Source("s", "floor", (1.0, 0, 0)),),
        (Listener("l", "box", (0, 0, 0.2), radius=0.0),),
        Settings(threshold=0),
    )
    rules = ContactSettings(
        transmission_table=RuleTable(
            (Rule((Side(material="Rub*"), Side(object="box")), transmission),)
        )
    )
    return HapticScene(
        scene.objects, (), scene.sources, scene.listeners, scene.settings, rules=rules
    )


def traced(scene: HapticScene) -> float:
    frame: Frame = frame_of(scene, 1, 0.0, True)
    return float(Tracer(scene.rules).step(frame).propagation.gain[0, 0])


@pytest.mark.parametrize(
    ("exponent", "mass"), [(1 / 3, 5.0), (1.0, 5.0), (1.0, 0.5), (1 / 3, 1000.0)]
)
def test_the_heavier_presses_more(exponent, mass):
    expected = min(1.0, mass * 9.81 / 100.0) ** exponent
    assert traced(standing(NormalForce(reference=100.0, exponent=exponent), mass)) == pytest.approx(
        expected, rel=1e-4
    )
    formula = f"min(1, force / 100) ** {exponent!r}"
    assert traced(standing(Expression(expression=formula), mass)) == pytest.approx(
        expected, rel=1e-4
    )


def test_an_unknown_force_passes_everything():
    assert traced(standing(NormalForce(reference=1e6), mass=None)) == pytest.approx(1.0)


def test_rules_hold_for_contacts_that_are_found_and_survive_a_file():
    scene = standing(Constant(gain_value=0.25))
    found = contacts_of_scene(scene)
    assert [found.transmissions[k] for k in found.transmission] == [Constant(gain_value=0.25)]
    document = scene_to_dict(scene)
    assert document["rules"]["transmission_table"] == [
        {
            "between": [{"material": "Rub*"}, {"object": "box"}],
            "transmission": {"function": "constant", "gain": 0.25},
        }
    ]
    assert scene_of(document, "scene.json").rules == scene.rules
    assert traced(scene) == pytest.approx(0.25)


def test_edited_rules_count_from_the_next_frame():
    scene = standing(Constant(gain_value=0.25))
    tracer = Tracer(scene.rules)
    tracer.step(frame_of(scene, 1, 0.0, True))
    tracer.collisions.settings = standing(Constant(gain_value=0.5)).rules
    assert tracer.step(frame_of(scene, 2, 0.04, True)).propagation.gain[0, 0] == pytest.approx(0.5)


@pytest.mark.parametrize("wrong", [{"stiffness": 0.0}, {"load": -1.0}, {"fall_off": math.nan}])
def test_layers_of_nothing_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Resilient(**wrong)


def test_forces_are_only_computed_where_a_function_asks():
    assert graph_of_scene(pair(Impedance())).forces is None
    assert np.isnan(graph_of_scene(pair(NormalForce())).forces).all()


def test_a_force_that_is_not_known_is_said():
    frame = frame_of(standing(NormalForce(), mass=None), 1, 0.0, True)
    assert [
        m.cause for m in Tracer(standing(NormalForce(), mass=None).rules).step(frame).warnings
    ] == [Cause.FORCE_UNKNOWN]
    known = frame_of(standing(NormalForce()), 1, 0.0, True)
    assert Tracer(standing(NormalForce()).rules).step(known).warnings == ()
