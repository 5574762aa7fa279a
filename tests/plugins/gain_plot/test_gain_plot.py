"""The plot of the gain over distance against closed forms, and its panel."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from haptic_tracing.core.scene.functions import Constant, HapticTracing, Physical, Spectrum, Wave
from haptic_tracing.plugins.gain_plot import gain_plot
from haptic_tracing.plugins.gain_plot.gain_plot import gain_curve


def test_the_curve_shows_what_is_traced():
    curve = gain_curve(HapticTracing(), 0.2, 0.9, 0.1)
    k = 0.8 * 0.9
    assert curve.gains == pytest.approx(k * np.exp(-k * curve.distances))
    assert curve.length == 10.0
    assert curve.bands is None
    banded = gain_curve(
        HapticTracing(spectrum=Spectrum(band_decays=(0, 0, 0, 0, 0, 3.0))), 0.2, 0.9, 0.1
    )
    assert banded.bands[0] == pytest.approx(banded.gains)
    rubber = Physical(wave=Wave.SURFACE, loss_factor=0.15, phase_speed=60.0, material_k=0.12)
    drawn = gain_curve(rubber, 0.8, 0.6, 0.1)
    # Those with 30, 100 and 300 Hz.
    for gains, low, high in zip(drawn.bands, (20, 80, 160), (40, 160, 320), strict=True):
        alpha = np.pi * np.sqrt(low * high) * 0.15 / 60.0
        assert gains == pytest.approx(
            (1 + drawn.distances / 0.5) ** -0.5 * np.exp(-alpha * drawn.distances), rel=1e-6
        )


def test_the_picture_is_drawn_again_only_where_something_changed(monkeypatch, settle):
    drawn = []
    monkeypatch.setattr(
        gain_plot,
        "picture",
        lambda *arguments: (
            drawn.append(1) or np.zeros((gain_plot.SIZE, gain_plot.SIZE, 4), np.float32)
        ),
    )
    first, second = (gain_curve(HapticTracing(), kappa, 0.9, 0.1) for kappa in (0.2, 0.3))
    for curve in (first, first, second, second):
        settle(lambda curve=curve: gain_plot.icon(curve, (1, 1, 1), (0, 0, 0)))
    settle(lambda: gain_plot.icon(second, (1, 0, 0), (0, 0, 0)))
    assert len(drawn) == 3
    gain_plot._picture.forget()


@pytest.mark.parametrize("decibels", [0.0, -20.0, -47.0])
def test_the_picture_has_the_curve_at_its_height(decibels):
    curve = gain_curve(Constant(gain_value=10 ** (decibels / 20)), 0, 1, 0.1)
    pixels = gain_plot.picture(curve, (1.0, 0.5, 0.0), (0.9, 0.9, 0.9))
    assert pixels.shape == (gain_plot.SIZE, gain_plot.SIZE, 4)
    assert np.isfinite(pixels).all()
    assert pixels.min() >= 0
    assert pixels.max() <= 1 + 1e-6
    assert (pixels[..., :3] <= pixels[..., 3:] + 1e-6).all()  # colours are times opacity
    strongest = np.argmax(pixels[:, 77, 0] - pixels[:, 77, 2])
    assert abs(strongest - (10 + (1 + decibels / 60) * (gain_plot.SIZE - 21))) <= 2


def test_a_formula_without_a_gain_has_no_curve(add_box, recording_layout):
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    bpy.context.view_layer.objects.active = box
    box.haptics.function, box.haptics.expression = "expression", "x * foo"
    layout = recording_layout()
    bpy.types.HAPTIC_PT_gain.draw(SimpleNamespace(layout=layout), bpy.context)
    assert layout.labels == ["The formula gives no gain"]


def test_only_a_haptic_object_has_a_plot(add_box):
    box = add_box("box", (0, 0, 0), (1, 1, 1), haptic=False)
    bpy.context.view_layer.objects.active = box
    assert not bpy.types.HAPTIC_PT_gain.poll(bpy.context)
    box.haptics.enabled = True
    assert bpy.types.HAPTIC_PT_gain.poll(bpy.context)
