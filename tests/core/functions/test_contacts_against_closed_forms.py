"""Functions of contacts: impedance, a spring, the pressing force; alone, by a table of a scene,
and in a file."""

from __future__ import annotations

import math
from dataclasses import replace

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


def test_impedances_count_in_the_direction_of_travel():
    """2 Z1 / (Z1 + Z2) of a light and a heavy block, masses both, and nothing lost on the way
    back."""
    light, heavy = (
        replace(STEEL, thickness=0.01, extent=0.01, length=length) for length in (0.002, 0.02)
    )
    there, back = (
        propagate(graph_of_scene(pair(Impedance(), *bodies)), Settings()).band_gain[0, 0]
        for bodies in ((light, heavy), (heavy, light))
    )
    assert there == pytest.approx(2 * 0.1 / 1.1, rel=0.02)
    assert back.tolist() == [1.0] * 6
    unknown = graph_of_scene(pair(Impedance(), STEEL, Constant(gain_value=1.0)))
    assert propagate(unknown, Settings()).gain[0, 0] == 1.0


@pytest.mark.parametrize("frequency", [5.0, 14.5, 60.0])
def test_a_typed_spring_is_a_mass_on_a_spring(frequency):
    """Amplitudes of m x'' + k (1 + i n) (x - y) = 0 with k = m (2 pi f0)^2, solved in complex
    numbers; never above 1, nor less than that below sqrt(2) f0."""
    spring = Resilient(frequency=frequency, loss_factor=0.3)
    for f in (1.0, 15.0, frequency, 40.0, 200.0, 900.0):
        stiff = frequency**2 * (1 + 0.3j)
        expected = abs(stiff / (stiff - f**2)) if f**2 > 2 * frequency**2 else 1.0
        assert spring.transmissibility(f) == pytest.approx(min(1.0, expected), rel=1e-12)


def test_a_spring_by_its_stiffness_has_the_resonance_of_its_mass():
    spring = Resilient(stiffness=2e5, loss_factor=0.3)
    typed = Resilient(frequency=math.sqrt(2e5 / 12.0) / (2 * math.pi), loss_factor=0.3)
    for f in (15.0, 40.0, 200.0):
        assert spring.transmissibility(f, 12.0) == pytest.approx(typed.transmissibility(f))


def test_far_above_the_resonance_it_falls_by_twelve_decibels_per_octave():
    spring = Resilient(frequency=1.0, loss_factor=0.1)
    ratio = spring.transmissibility(500.0) / spring.transmissibility(1000.0)
    assert 20 * math.log10(ratio) == pytest.approx(12.04, rel=0.01)


@pytest.mark.parametrize("is_in_contact", [True, False])
def test_the_gain_of_a_spring_is_that_of_its_highest_band(is_in_contact):
    spring = Resilient(frequency=11.0)
    scene = pair(spring, STEEL, STEEL) if is_in_contact else pair(Impedance(), STEEL, spring)
    found = propagate(graph_of_scene(scene), Settings(threshold=0))
    bands = [spring.transmissibility(math.sqrt(low * 2 * low)) for low in (20, 40, 80, 160, 320)]
    assert found.band_gain[0, 0, :5] == pytest.approx(bands, rel=1e-9)
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


@pytest.mark.parametrize("wrong", [{"stiffness": 0.0}, {"frequency": -1.0}])
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
