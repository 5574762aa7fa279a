"""What is drawn and listed of a tone that passes objects which damp by frequency: its own gains,
against closed forms."""

import dataclasses
import math

import numpy as np
import pytest
from haptic_tracing.addon.session.sessions import Traced
from haptic_tracing.addon.view.paths import ListenerPath, listener_path
from haptic_tracing.addon.view.render_data import Options, listener_amplitudes
from haptic_tracing.core.diagnosis.connections import path_steps
from haptic_tracing.core.propagation.spread import spread
from haptic_tracing.core.render.filter_bank import bank_response
from haptic_tracing.core.render.history import still_samples
from haptic_tracing.core.render.renderer import SAMPLE_RATE
from haptic_tracing.core.scene.bands import BAND_EDGES
from haptic_tracing.core.scene.functions import Spectrum
from haptic_tracing.core.scene.values import Mode, Source
from haptic_tracing.core.signals import Sine

from .conftest import BRIDGE, traced

DECAYS = (0.0, 0.1, 0.3, 0.6, 1.1, 1.7)
"""1/m, on top of the 0.4 1/m of each part of the bridge."""
TO_WALKER = 2.5, 2.0, 2.0
"""Metres in deck, pier and ground."""
AMPLITUDE = 0.5


def rumbling_bridge(*frequencies):
    """The bridge with a tone per frequency where the truck is."""
    objects = tuple(
        dataclasses.replace(
            item,
            propagation=dataclasses.replace(
                item.propagation, spectrum=Spectrum(band_decays=DECAYS)
            ),
        )
        if item.name in ("deck", "pier", "ground")
        else item
        for item in BRIDGE.objects
    )
    sources = tuple(
        Source(f"tone {f:g} Hz", "deck", (-1.5, 0, 1), AMPLITUDE, signal=Sine(f))
        for f in frequencies
    )
    return traced(dataclasses.replace(BRIDGE, objects=objects, sources=sources))


def loss_per_metre(frequency):
    return 0.4 + DECAYS[int(np.searchsorted(BAND_EDGES, frequency, side="right")) - 1]


@pytest.mark.parametrize("frequency", [30.0, 50.0, 80.0, 100.0, 200.0])
def test_gains_are_those_of_the_tone_through_the_filters_of_the_bands(frequency):
    result = rumbling_bridge(frequency)
    walker = [listener.name for listener in result.listeners].index("walker")
    gains = np.exp(-(0.4 + np.array(DECAYS)) * sum(TO_WALKER))
    assert result.amplitudes[0, walker] == pytest.approx(
        AMPLITUDE * bank_response(frequency, SAMPLE_RATE) @ gains, rel=1e-6
    )


@pytest.mark.parametrize("frequency", [30.0, 60.0, 80.0, 110.0])
def test_gains_agree_with_levels(frequency):
    result = rumbling_bridge(frequency)
    rms = np.sqrt(np.mean(still_samples(result, 1.0)[:, 800:] ** 2, axis=1))
    assert np.sqrt(2) * rms == pytest.approx(result.amplitudes[0], rel=2e-3)


@pytest.mark.parametrize("frequency", [30.0, 50.0, 100.0, 200.0])
def test_lines_are_coloured_by_the_band_of_the_tone(frequency):
    result = rumbling_bridge(frequency)
    walker = [listener.name for listener in result.listeners].index("walker")
    expected = AMPLITUDE * math.exp(-loss_per_metre(frequency) * sum(TO_WALKER))
    node = result.graph.listener_nodes[walker]
    assert spread(result.graph).amplitude[node] == pytest.approx(expected, rel=1e-12)
    pair = 0, walker
    _, gain, _ = path_steps(
        result, result.graph, Mode.HT, {pair: result.propagation.best_path[pair]}
    )
    assert gain[-1, 1] == pytest.approx(expected, rel=1e-12)


def test_losses_of_a_path_are_those_of_the_band_of_the_tone_and_other_paths_add_what_other_bands_pass():
    result = rumbling_bridge(100.0)
    path = listener_path(
        Traced(result, BRIDGE.settings, np.zeros((len(result.listeners), 0))),
        ("walker", "", False),
    )
    assert isinstance(path, ListenerPath)
    fall = path.fall
    assert [hop.object for hop in fall.hops] == ["deck", "pier", "ground"]
    per_metre = 20 * math.log10(math.e) * loss_per_metre(100.0)
    assert [hop.loss for hop in fall.hops] == pytest.approx(
        [per_metre * metres for metres in TO_WALKER], rel=1e-9
    )
    assert fall.amplitude == pytest.approx(20 * math.log10(AMPLITUDE))
    through_filters = bank_response(100.0, SAMPLE_RATE) @ np.exp(
        -(0.4 + np.array(DECAYS)) * sum(TO_WALKER)
    )
    assert fall.gain == pytest.approx(20 * math.log10(through_filters), rel=1e-6)
    assert fall.others == pytest.approx(fall.gain + per_metre * sum(TO_WALKER), abs=1e-9), (
        "what the filters of the other bands add"
    )


def test_each_tone_arrives_in_its_own_band():
    result = rumbling_bridge(30.0, 200.0)
    walker = [listener.name for listener in result.listeners].index("walker")
    low, high = (
        AMPLITUDE * math.exp(-loss_per_metre(frequency) * sum(TO_WALKER))
        for frequency in (30.0, 200.0)
    )
    assert (
        listener_amplitudes(result, Options())[walker]
        == result.amplitudes[0, walker]
        > result.amplitudes[1, walker]
    )
    gains = [
        spread(result.graph, {source.name}).amplitude[result.graph.listener_nodes[walker]]
        for source in result.sources
    ]
    assert gains == pytest.approx([low, high], rel=1e-12)
    assert spread(result.graph).amplitude[result.graph.listener_nodes[walker]] == pytest.approx(
        low, rel=1e-12
    )
