"""The scope and the body map, pixel by pixel."""

import math

import numpy as np
import pytest
from haptic_tracing.addon.view.levels import Level
from haptic_tracing.addon.view.meter_layout import (
    SCOPE_COLOUR,
    Scope,
    add_body,
    add_scope,
    colour_of,
    full_scale,
    spans,
)
from haptic_tracing.addon.view.panel_picture import SIZE, Canvas
from haptic_tracing.core.scene.body import BODY_PARTS
from haptic_tracing.core.scene.body_map import HALF_WIDTH, HEIGHT, figure

RATE = 8000.0


def scope_picture(scope):
    canvas = Canvas()
    add_scope(canvas, (0.0, 0.0), (SIZE, SIZE), scope)
    return canvas.painted()


def body_picture(parts):
    """Both figures, side by side over the width of the picture."""
    canvas = Canvas()
    height = SIZE * HEIGHT / (4 * HALF_WIDTH)
    add_body(canvas, (0.0, (SIZE - height) / 2), height, parts, ())
    return canvas.painted()


def wave(pixels):
    """Which pixels have the colour of the wave."""
    return np.abs(pixels[..., :3] - SCOPE_COLOUR[:3]).max(axis=2) < 0.02


def test_full_scale_is_the_next_step_of_ten_decibels():
    for peak, full in ((1.0, 1.0), (0.99, 1.0), (0.3, 10**-0.5), (0.1, 0.1), (0.0, 0.001)):
        assert full_scale(Scope("a", np.array([0.0, -peak]), RATE)) == pytest.approx(full)


def test_spans_hold_the_lowest_and_highest_sample():
    samples = np.random.default_rng(1).normal(size=5000)
    columns, least, greatest = spans(Scope("a", samples, RATE), 100)
    # 80 samples each, the first 3000 are not there yet.
    assert columns.tolist() == list(range(38, 100))
    assert least.tolist() == [
        samples[80 * k - 3000 : 80 * k - 2920].min() for k in columns.tolist()
    ]
    assert greatest.tolist() == [
        samples[80 * k - 3000 : 80 * k - 2920].max() for k in columns.tolist()
    ]
    assert len(spans(Scope("a", np.zeros(0), RATE), 100)[0]) == 0


def test_scope_shows_a_burst_where_and_as_high_as_it_was():
    samples = np.zeros(8000)
    samples[4000:6000] = 0.5 * np.sin(np.arange(2000))
    drawn = wave(scope_picture(Scope("a", samples, RATE)))
    height, place = np.ptp(np.where(drawn.any(axis=1))[0]), np.where(drawn.sum(axis=0) > 10)[0]
    assert height == pytest.approx(238 * 0.5, abs=4)  # of full scale 1
    assert (place.min(), place.max()) == (
        pytest.approx(128, abs=2),
        pytest.approx(192, abs=2),
    )


def test_scope_of_nothing_is_empty():
    assert not wave(scope_picture(Scope("a", np.zeros(0), RATE))).any()


@pytest.mark.parametrize("part", [part.name for part in BODY_PARTS])
def test_a_body_part_lights_up_alone(part):
    level = Level("x", "x", part, -9.0, 30.0)
    dark, lit = body_picture({}), body_picture({part: level})
    step = np.array(colour_of(level)[:3]) - dark[dark[..., 3] > 0.99][0, :3]
    changed = np.abs(lit - dark).max(axis=2) > 0.01
    assert changed.any() and (dark[changed][:, 3] > 0).all()
    covered = ((lit - dark)[..., :3] @ step).sum() / (step @ step)
    areas = [math.pi * limb.width**2 / 4 + limb.width * math.dist(limb.start, limb.end) for v in ("front", "back") for limb in figure(v)
             if limb.part == part]  # fmt: skip
    # Belly and hips overlap a little, and upper limbs lie under lower ones.
    assert covered == pytest.approx(sum(areas) * (256 / (4 * HALF_WIDTH)) ** 2, rel=0.2)
