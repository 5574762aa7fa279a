"""The body map, pixel by pixel."""

import math

import numpy as np
import pytest
from haptic_tracing.addon.view.levels import Level
from haptic_tracing.addon.view.meter_layout import add_body, colour_of
from haptic_tracing.addon.view.panel_picture import SIZE, Canvas
from haptic_tracing.core.scene.body import BODY_PARTS
from haptic_tracing.core.scene.body_map import HALF_WIDTH, HEIGHT, figure


def body_picture(parts):
    """Both figures, side by side over the width of the picture."""
    canvas = Canvas()
    height = SIZE * HEIGHT / (4 * HALF_WIDTH)
    add_body(canvas, (0.0, (SIZE - height) / 2), height, parts, ())
    return canvas.painted()


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
