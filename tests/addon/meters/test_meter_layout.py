"""The meters as shapes: everything within its plate, what has no room left out, nothing that says
more than the levels."""

import math

import numpy as np
import pytest
from haptic_tracing.addon.blender.text import text_width
from haptic_tracing.addon.view.levels import Level
from haptic_tracing.addon.view.meter_layout import MOST_ROWS, ROW, SWITCHES, colour_of, meter_hud
from haptic_tracing.core.scene.body import PAPER_LISTENERS
from hypothesis import given, settings
from hypothesis import strategies as st

deterministic = settings(derandomize=True, deadline=None)


def level(name, rms=-20.0, part=""):
    silent = rms == -math.inf
    return Level(name, name, part, rms, -math.inf if silent else rms + 40)


LEVELS = [level(name, -5.0 * k, name) for k, name in enumerate(PAPER_LISTENERS)]


def _texts(items):
    return [text.words for text in items.texts]


@deterministic
@given(
    st.floats(0, 1400),
    st.floats(0, 900),
    st.sampled_from([1.0, 1.5, 2.0]),
    st.integers(0, 40),
    st.booleans(),
)
def test_everything_lies_within_the_plate_and_the_plate_within_the_room(
    width, height, scale, count, body
):
    shown = [level(f"listener {k}", -1.5 * k, PAPER_LISTENERS[k % 10]) for k in range(count)]
    items = meter_hud(shown, (width, height), scale, "Mode HT", body=body)
    if not len(items.lines.width):
        assert items.texts == ()
        return
    ((left, bottom, right, top),) = items.bounds
    assert (left, bottom) == (0, 0)
    assert right <= width + 1e-3
    assert top <= height + 1e-3
    half = items.lines.width[:, None, None] / 2 * scale * (items.lines.shape == 0)[:, None, None]
    places = items.lines.position[:, :, :2]
    assert (places - half >= np.array([left, bottom]) - 1e-3).all()
    assert (places + half <= np.array([right, top]) + 1e-3).all()
    for text in items.texts:
        assert left <= text.position[0]
        assert text.position[0] + text_width(text.words, text.size) <= right + 1
        assert bottom <= text.position[1] <= top


def test_values_are_there_as_text():
    texts = _texts(meter_hud(LEVELS, (1200, 600), 1.0, "Mode HT"))
    for item in LEVELS:
        assert item.listener in texts
    assert {
        "Mode HT",
        "+35 dB",
        "Margin",
        "front",
        "back",
        "L",
        "R",
        "−20",
        "0",
        "+20",
    } <= set(texts)


def test_elements_without_room_are_left_out_in_order():
    full = meter_hud(LEVELS, (1200, 600), 1.0)
    narrow = meter_hud(LEVELS, (250, 600), 1.0)
    narrower = meter_hud(LEVELS, (204, 600), 1.0)
    lower = meter_hud(LEVELS, (300, 18 * ROW), 1.0)
    low = meter_hud(LEVELS, (300, 7 * ROW), 1.0)
    assert all("+35 dB" in _texts(shown) for shown in (full, narrow, narrower, low))
    assert "front" in _texts(narrow)
    assert "front" not in _texts(lower)
    assert any(words.startswith("and ") for words in _texts(low))
    assert meter_hud(LEVELS, (90, 600), 1.0).texts == ()
    assert meter_hud([], (900, 600), 1.0).texts == ()


def test_of_many_listeners_the_strongest_are_shown():
    many = [level(f"l{k}", -50.0 + k) for k in range(30)]
    texts = _texts(meter_hud(many, (900, 900), 1.0))
    assert [words for words in texts if words.startswith("l")] == [
        f"l{k}" for k in range(31 - MOST_ROWS, 30)
    ]
    assert f"and {31 - MOST_ROWS} more" in texts


def test_colours_rise_with_the_level_and_grey_is_not_felt():
    loud, soft, silent = (level("x", rms) for rms in (-3.0, -30.0, -math.inf))
    assert sum(colour_of(loud)[:2]) > sum(colour_of(soft)[:2])
    weak = Level("x", "x", "", -56.0, -4.0)
    assert colour_of(weak) == colour_of(silent)
    assert len(set(colour_of(silent)[:2])) == 1


def _luminance(colour):
    """Relative luminance of an sRGB colour, as WCAG 2.1 defines it."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in colour]
    return sum(share * c for share, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


@pytest.mark.parametrize("viewport", [0.24, 0.40])
def test_texts_can_be_read_in_both_themes(viewport):
    """Names, numbers and headings have the contrast of 4.5 that WCAG 2.1 asks of texts."""
    items = meter_hud(LEVELS, (1200, 600), 1.0, "Mode HT")
    lumas = []
    for shown in (items, items.on_light()):
        *plate, alpha = shown.lines.colour[0, 0].tolist()
        ground = _luminance([alpha * c + (1 - alpha) * viewport for c in plate])
        lumas.append(ground)
        for text in shown.texts:
            if text.words not in SWITCHES:
                dark, light = sorted((ground, _luminance(text.colour)))
                assert (light + 0.05) / (dark + 0.05) >= 4.5, text.words
    assert lumas[0] < 0.05 and lumas[1] > 0.5
    felt = items.lines.colour[:, 0]
    assert (np.ptp(felt[:, :3], axis=1) > 0.1).any(), "the bars are coloured"
    coloured = np.ptp(felt[:, :3], axis=1) > 0.1
    assert (items.on_light().lines.colour[coloured] == items.lines.colour[coloured]).all()
