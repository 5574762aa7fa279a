"""What the report says of materials side by side, against numbers by hand and closed forms."""

import numpy as np
import pytest
from haptic_tracing.core.scene.values import Mode
from haptic_tracing.core.signals import Sine
from haptic_tracing.sample_scenes.mine_ride import wall_frame
from haptic_tracing.study import physical_scenes
from haptic_tracing.study.baking import bake_ride
from haptic_tracing.study.checks import checks_of, felt_anywhere
from haptic_tracing.study.measures import felt_shares, highest_sensation
from haptic_tracing.study.report import write_report
from haptic_tracing.study.side_by_side import (
    felt_verdict,
    reasons,
    sensations,
    wall_verdict,
    walls_apart,
)

RATE = 8000


def test_a_tone_lies_above_the_threshold_by_its_level():
    times = np.arange(RATE) / RATE
    tones = np.array([0.1 * np.sin(2 * np.pi * 250 * times), np.zeros(RATE)])
    levels = highest_sensation(tones, RATE)
    assert levels[0] == pytest.approx(-20 + 45, abs=0.1)
    assert levels[1] == -np.inf
    assert felt_verdict(levels) == "+25.0 dB; 1 of 2 felt"
    assert felt_verdict(levels[1:]) == "silent"


def test_a_tone_is_felt_in_its_band():
    for band, hertz in enumerate((30, 60, 120, 250, 500, 800)):
        assert felt_shares(Sine(float(hertz)))[band] == pytest.approx(1, abs=0.02)


def test_a_difference_is_noticed_by_most_or_few_where_it_is_felt():
    assert (
        wall_verdict(np.array([3.8, -3.9, 2.0, 1.2, -1.2, np.nan]), 100.0)
        == "3.9 dB at most; most notice it at 2 of 5 that feel either, few at 2"
    )
    assert wall_verdict(np.array([4.5]), 20.0).startswith(
        "4.5 dB at most; most notice it at 0 of 1"
    )
    assert wall_verdict(np.array([np.nan]), 100.0) == "not felt"


def test_reasons_have_their_numbers_from_closed_forms():
    text = " ".join(reasons())
    assert f"stone {20 * np.log10(0.7 * 0.85):.1f}" in text
    # pi (f - resonance) eta / c of the thigh, in decibels.
    assert f"{20 * np.log10(np.e) * np.pi * 90 * 0.3 / 10:.0f} dB/m at 100 Hz" in text


@pytest.mark.slow
def test_ride_with_measured_materials_is_a_part_of_the_report_whatever_it_says(mine_ride, tmp_path):
    frames = (wall_frame(2) - 2, wall_frame(3) + 12)
    ride, _ = bake_ride(mine_ride, *frames)
    functions = {obj.name: obj.haptics.function for obj in mine_ride.objects}
    others = {}
    try:
        for way in physical_scenes.WAYS[1:]:
            physical_scenes.make(mine_ride, way)
            others[way], _ = bake_ride(mine_ride, *frames)
    finally:
        mine_ride.haptics.transmission_table.items.clear()
        for name, function in functions.items():
            mine_ride.objects[name].haptics.function = function
    # The impacts are the same, and so is what knows no materials.
    for other in others.values():
        assert [s.objects for s in other.soundings] == [s.objects for s in ride.soundings]
        assert other.renditions[Mode.MN].rms == pytest.approx(
            ride.renditions[Mode.MN].rms, abs=1e-9
        )
    ((pair, apart),) = walls_apart(ride)
    assert pair == "Stone and Wood"
    # At most the difference of one passage.
    assert np.nanmax(np.abs(apart)) < 20 * np.log10(0.595 / 0.455)
    path = tmp_path / "report.html"
    write_report(path, ride, checks_of(ride), [], {}, rides=others)
    text = path.read_text(encoding="utf-8")
    assert text.count("<th>measured materials") == 3
    for levels in (levels for each in (ride, *others.values()) for _, levels in sensations(each)):
        assert felt_verdict(levels) in text
    for other in others.values():
        ((_, difference),) = walls_apart(other)
        assert wall_verdict(difference, felt_anywhere(other)[1]) in text
