"""Who is felt among 20 sources, by the published thresholds."""

from __future__ import annotations

import math

import pytest
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.perception import threshold_level
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.render.frame_result import Sounding
from haptic_tracing.core.render.masking import felt_sources, source_samples
from haptic_tracing.core.render.mixdown import listener_mixes, source_voices
from haptic_tracing.core.render.renderer import Renderer
from haptic_tracing.core.scene.functions import Constant
from haptic_tracing.core.scene.functions.physical import Physical, Wave
from haptic_tracing.core.scene.values import HapticObject, HapticScene, Listener, Settings, Source
from haptic_tracing.core.signals import Sine

RATE = 8000.0
# (Hz, dB of full scale)
TWENTY = [
    (25, -3), (31, -1), (33, -12), (66, -14), (68, -19), (70, -40), (90, -20), (166, -30), (168, -26), (171, -48),
    (174, -27), (230, -38), (240, -39), (250, -38), (260, -38.5), (270, -60), (480, -14), (500, -15), (800, -1), (900, -2),
]  # fmt: skip


def sounding(sources, listener=None, function=None, settings=None):
    """Sources and a listener at the origin of one object that passes everything on."""
    heard = listener or Listener("palm", "plate", radius=0.0)
    scene = HapticScene(
        (HapticObject("plate", 0, 1, function or Constant(gain_value=1.0)),),
        (),
        tuple(sources),
        (heard,),
    )
    return Sounding(
        0.0,
        scene.sources,
        scene.listeners,
        propagate(graph_of_scene(scene), settings or Settings(threshold=0.0)),
    )


def tones(levels):
    return [
        Source(f"tone {hertz} Hz", "plate", amplitude=10 ** (level / 20), signal=Sine(float(hertz)))
        for hertz, level in levels
    ]


def expected(levels):
    """By definition: own level, and what hides it where that is so."""
    sensation = {hertz: level - float(threshold_level(float(hertz))) for hertz, level in levels}
    found = {}
    for hertz, level in sensation.items():
        others = {
            h: 10 ** (v / 10)
            for h, v in sensation.items()
            if h != hertz and hertz / 1.6 < h < hertz * 1.6
        }
        rest = sum(others.values())
        raised = 10 * math.log10(1 + 10 ** (level / 10) / rest) if rest else math.inf
        hidden = level > 0 and rest > 1 and raised <= 3.72
        found[f"tone {hertz} Hz"] = (
            level,
            f"tone {max(others, key=others.get)} Hz" if hidden else "",
        )
    return found


def test_of_20_sources_those_are_felt_that_the_definition_says():
    felt = felt_sources(sounding(tones(TWENTY)), 0, RATE)
    wanted = expected(TWENTY)
    assert felt.listener == "palm" and {item.source.name for item in felt.sources} == set(wanted)
    for item in felt.sources:
        level, masker = wanted[item.source.name]
        assert item.margin == pytest.approx(level, abs=0.2), item
        assert item.masker == masker, item
        assert item.state == ("weak" if level <= 0 else "masked" if masker else "felt")
    assert felt.counts() == tuple(
        sum(state(*one) for one in wanted.values())
        for state in (
            lambda v, m: v > 0 and not m,
            lambda v, m: v > 0 and bool(m),
            lambda v, m: v <= 0,
        )
    )
    assert min(felt.counts()) >= 2, "there are some of each"
    assert [item.state for item in felt.sources] == sorted(
        (item.state for item in felt.sources), key=["felt", "masked", "weak"].index
    )


def test_alone_each_is_felt_or_weak_and_distant_frequencies_hide_nothing():
    alone = [felt_sources(sounding(tones([one])), 0).sources[0].state for one in TWENTY]
    assert "masked" not in alone and alone.count("felt") > 10
    apart = felt_sources(sounding(tones([(40, -3), (250, -3)])), 0)
    assert [item.state for item in apart.sources] == ["felt", "felt"]
    near = felt_sources(sounding(tones([(240, -20), (250, -3)])), 0)
    assert [(item.source.name, item.masker) for item in near.sources] == [
        ("tone 250 Hz", ""),
        ("tone 240 Hz", "tone 250 Hz"),
    ]


def test_what_does_not_arrive_is_not_counted():
    felt = felt_sources(sounding([Source("off", "plate", amplitude=0.0, signal=Sine(250.0))]), 0)
    assert felt.sources == () and felt.counts() == (0, 0, 0)


def test_bands_and_delays_stay_those_of_the_paths():
    """What the sources give one by one adds up to the mix."""
    function = Physical(
        wave=Wave.SURFACE, loss_factor=0.3, phase_speed=150.0, reference_distance=0.3, extent=1.0
    )
    sources = [
        Source(f"s{k}", "plate", (0.3 * k, 0.0, 0.5), 0.02, signal=Sine(40.0 * k))
        for k in range(1, 6)
    ]
    state = sounding(sources, Listener("palm", "plate", radius=0.0), function)
    renderer = Renderer(listener_mixes(state.listeners), RATE)
    voices = source_voices(state)
    renderer.render_frame(0.0, 0.0, voices)
    assert source_samples(state, 0, 0.25, RATE).sum(axis=0) == pytest.approx(
        renderer.render_frame(0.0, 0.25, voices)[0], abs=1e-9
    )
