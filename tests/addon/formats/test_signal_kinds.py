"""Signals that a kind and a frequency describe: written to the properties of a source and read
again."""

from __future__ import annotations

import bpy
import pytest
from haptic_tracing.addon.io.property_writer import write_source
from haptic_tracing.addon.properties.signal_kinds import PLAIN
from haptic_tracing.addon.scene_reader.signals import read_signal
from haptic_tracing.core.scene.values import Source
from haptic_tracing.core.signals import Noise, Pulse, Saw, Sine


@pytest.fixture
def properties():
    return bpy.data.objects.new("Drill", None).haptics.source


@pytest.mark.parametrize(
    ("kind", "signal"), [("SINE", Sine(82.5)), ("PULSE", Pulse(25.0)), ("NOISE", Noise())]
)
def test_a_plain_signal_is_written_as_its_kind_and_read_as_it_was(properties, kind, signal):
    write_source(properties, Source("Drill", "Floor", (0.0, 0.0, 0.0), signal=signal))
    assert properties.signal == kind
    assert read_signal(properties) == signal


@pytest.mark.parametrize("kind", PLAIN)
def test_every_kind_can_be_chosen_written_and_read(properties, kind):
    made = PLAIN[kind].make(50.0)
    write_source(properties, Source("Drill", "Floor", (0.0, 0.0, 0.0), signal=made))
    assert (properties.signal, read_signal(properties)) == (kind, made)


@pytest.mark.parametrize("signal", [Sine(1 / 3), Sine(60.0, 0.5), Saw(60.0), Sine(2000.0)])
def test_what_the_properties_cannot_hold_is_kept_as_it_is(properties, signal):
    write_source(properties, Source("Drill", "Floor", (0.0, 0.0, 0.0), signal=signal))
    assert properties.signal == "KEPT"
