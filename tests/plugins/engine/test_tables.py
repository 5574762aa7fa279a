"""The tables of a tracer: as their schema says, and as closed forms are."""

import base64
import json
import math
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from haptic_tracing.core.contacts.shapes import Box
from haptic_tracing.core.scene.functions import Constant, Expression, NormalForce, Resilient
from haptic_tracing.core.scene.impact_rule import ImpactLimits, ImpactRule
from haptic_tracing.core.scene.joint import Joint
from haptic_tracing.core.scene.rule_table import Rule, RuleTable, Side
from haptic_tracing.core.scene.rules import ContactSettings
from haptic_tracing.core.scene.values import HapticObject, HapticScene, Listener, Pose, Source
from haptic_tracing.core.signals import Noise, Pulse, Sine
from haptic_tracing.plugins.engine import tables as engine_tables

SCHEMA = Path(engine_tables.__file__).with_name("tracer.schema.json")
ANY = Side()


def box(name, place, **more):
    return HapticObject(name, 0.1, 0.9, shape=Box((1, 2, 3)), pose=Pose(place), **more)


def tables(**lists):
    found = json.loads(json.dumps(engine_tables.tables(HapticScene(**lists)), allow_nan=False))
    jsonschema.validate(found, json.loads(SCHEMA.read_text("utf-8")))
    return found


def samples(signal):
    rows = [np.frombuffer(base64.b64decode(row), "<i2") for row in signal["rows"]]
    return signal["peak"] / 32767 * np.array(rows)


def signal_of_source(found):
    return found["signals"][found["sources"][0]["signal"]]


def test_a_loop_of_a_tone_has_the_tones_level_and_no_seam():
    found = tables(objects=[box("a", (0, 0, 0))], sources=[Source("s", "a", signal=Sine(61.7))])
    (row,) = samples(signal_of_source(found))
    assert found["lanes"] == 1 and signal_of_source(found)["loops"]
    assert np.sqrt(np.mean(row**2)) == pytest.approx(math.sqrt(0.5), rel=1e-3)
    steepest = 2 * math.pi * 61.7 / found["sample_rate"]
    assert np.abs(np.diff(np.concatenate([row, row]))).max() < 1.01 * steepest


@pytest.mark.parametrize("signal", [Pulse(25.0), Noise(0.5, seed=1)])
def test_bands_add_up_to_the_signal_and_their_power_to_one(signal):
    banded = HapticObject("a", 0.1, 0.9, propagation=Resilient(frequency=50.0))
    source = Source("s", "a", signal=signal)
    alone = tables(objects=[box("a", (0, 0, 0))], sources=[source])
    split = tables(objects=[banded], sources=[source])
    (whole,) = samples(signal_of_source(alone))
    added = samples(signal_of_source(split)).sum(axis=0)
    assert added == pytest.approx(whole, abs=1e-3 * np.abs(whole).max())
    gains = np.ones(7)
    assert gains @ signal_of_source(split)["power"] @ gains == pytest.approx(1.0, rel=1e-3)


def test_formulas_are_sampled_over_what_they_depend_on():
    halves = Expression(expression="exp(-0.3 * d) / (1 + d)")
    table = RuleTable(
        (
            Rule((Side("a"), Side("b")), NormalForce(reference=10.0, exponent=0.5)),
            Rule((Side("a"), Side("c")), Expression(expression="min(1, area / 0.02)")),
        )
    )
    found = tables(
        objects=[box("a", (0, 0, 0), propagation=halves), box("b", (2, 0, 0)), box("c", (4, 0, 0))],
        rules=ContactSettings(transmission_table=table),
    )
    grid = np.array(found["grid"])
    a, b, c = (item["class"] for item in found["objects"])
    functions = found["functions"]
    inside = functions[found["objects"][0]["function"]]
    expected = 0.3 * grid + np.log1p(grid)
    assert inside["over"] == "distance"
    assert inside["costs"] == pytest.approx(np.minimum(expected, 14.0), abs=1e-6)
    pressed, spread = functions[found["between"][a][b]], functions[found["between"][c][a]]
    assert (pressed["over"], spread["over"]) == ("force", "area")
    at = np.searchsorted(grid, 1.0)
    assert pressed["costs"][at] == pytest.approx(-0.5 * math.log(grid[at] / 10), abs=1e-6)
    assert spread["costs"][at] == 0 and spread["costs"][1] == pytest.approx(-math.log(1e-3 / 0.02))
    assert functions[found["between"][b][c]]["spring"] == [None, 0.0]  # by impedance


def test_blows_have_the_rules_of_their_classes():
    quiet = ImpactRule(gain=(0.25, 0.5), pitch=(1.0, 2.0), limits=ImpactLimits(2.0, 8.0))
    rules = ContactSettings(
        full_energy=50.0,
        impact_table=RuleTable((Rule((Side(material="felt"), ANY), quiet),)),
    )
    found = tables(
        objects=[box("a", (0, 0, 0), mass=3.0), box("b", (2, 0, 0), material="felt")], rules=rules
    )
    a, b = (item["class"] for item in found["objects"])
    hard, soft = (found["impacts"][found["blows"][a][k]] for k in (a, b))
    assert (hard["least_energy"], hard["full_energy"], hard["gain"]) == (0.05, 50.0, [0, 1])
    assert (soft["least_energy"], soft["full_energy"], soft["gain"]) == (2.0, 8.0, [0.25, 0.5])
    slow, *_, fast = (len(samples(found["signals"][k])[0]) for k in soft["signals"])
    assert fast == pytest.approx(slow / 2, rel=0.01) and len(hard["signals"]) == 1
    assert [item["mass"] for item in found["objects"]] == [3.0, 0.0]


def test_joints_stay_and_places_are_in_the_space_of_their_objects():
    turned = Pose((1, 0, 0), (math.sqrt(0.5), 0, 0, math.sqrt(0.5)))  # y is its x
    link = HapticObject("b", 0.1, 0.9, shape=Box((2, 1, 3)), pose=turned, propagation=Constant())
    joint = Joint(
        objects=("a", "b"), positions=((0.5, 0, 0), (0, 0.5, 0)), rotation=turned.rotation
    )
    found = tables(
        objects=[box("a", (0, 0, 0)), link],
        listeners=[Listener("l", "b", (1, 2, 3))],
        rules=ContactSettings(joints=(joint,)),
    )
    (contact,) = found["contacts"]
    assert contact["objects"] == [0, 1]
    # In the axes of glTF: x, z, -y.
    assert contact["positions"][0] == pytest.approx([0.5, 0, 0], abs=1e-9)
    assert contact["positions"][1] == pytest.approx([0, 0, -0.5], abs=1e-9)
    assert found["listeners"][0]["position"] == pytest.approx([2, 3, 0], abs=1e-9)
    assert found["objects"][1]["pose"] == pytest.approx(
        [1, 0, 0, math.sqrt(0.5), 0, math.sqrt(0.5), 0], abs=1e-9
    )
    assert found["objects"][0]["size"] == [1, 3, 2]
