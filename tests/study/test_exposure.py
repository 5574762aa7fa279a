"""Daily exposure to vibration: against the tables of the standards, SciPy and closed forms."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
import small_study
from haptic_tracing.command_line.serve.stage import DeviceStage
from haptic_tracing.command_line.study_run import Study
from haptic_tracing.core.devices.guard import DeviceOutput
from haptic_tracing.core.devices.mapping import map_listeners
from haptic_tracing.core.devices.profile_files import profile
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.formats.tracks.vibration_file import Channel
from haptic_tracing.core.formats.tracks.wav import described, read, write_wav
from haptic_tracing.core.perception import FullScale
from haptic_tracing.study.people.exposure import (
    BODY,
    HAND,
    body_weighting,
    daily,
    hand_weighting,
    limits_of,
)
from haptic_tracing.study.people.plan import read_form
from scipy import signal

HAND_TABLE = dict(
    zip(
        10 ** (np.arange(8, 31) / 10),
        (
            0.727, 0.873, 0.951, 0.958, 0.896, 0.782, 0.647, 0.519, 0.411, 0.324, 0.256, 0.202,
            0.160, 0.127, 0.101, 0.0799, 0.0634, 0.0503, 0.0398, 0.0314, 0.0245, 0.0186, 0.0135,
        ),
        strict=True,
    )
)  # fmt: skip
"""W_h by frequency 10^(n/10) Hz: ISO 5349-1:2001, table A.2."""
BODY_TABLE = {1: 0.482, 2: 0.531, 4: 0.967, 5: 1.039, 6.3: 1.054, 8: 1.036, 10: 0.988, 16: 0.768,
              20: 0.636, 31.5: 0.405, 63: 0.186, 80: 0.132}  # fmt: skip
"""W_k by nominal frequency: ISO 2631-1:1997, table 3."""


@pytest.mark.parametrize(
    ("weighting", "table"), [(hand_weighting, HAND_TABLE), (body_weighting, BODY_TABLE)]
)
def test_weightings_are_those_of_the_tables(weighting, table):
    found = weighting(np.array(list(table)))
    assert found == pytest.approx(list(table.values()), rel=0.01)


RATE, HERTZ, SECONDS = 8000, 125.0, 4.0
SINE = 0.5 * np.sin(2 * math.pi * HERTZ * np.arange(int(RATE * SECONDS)) / RATE)
DEVICE = FullScale(((HERTZ, 20.0),))
OTHER = FullScale(((40.0, 3.0), (250.0, 90.0)))


def track(device):
    """`SINE`, of a listener with this calibration."""
    return Channel("Listener", SECONDS, samples=SINE, sample_rate=RATE, device=device)


def rms_of_sine(part):
    """Weighted acceleration [m/s^2] of `SINE` on `DEVICE`: of hands by ISO 5349-1's filters, which
    SciPy evaluates."""
    if part == "upper_leg.R":
        return 0.5 * 20 / math.sqrt(2) * body_weighting(np.array([HERTZ]))[0]
    angular, corner = 2 * math.pi * HERTZ, 2 * math.pi * 15.915
    gain = 1.0
    for numerator, denominator in (
        signal.butter(2, 2 * math.pi * 6.310, "highpass", analog=True),
        signal.butter(2, 2 * math.pi * 1258.9, analog=True),
        ([corner, corner**2], [1, corner / 0.64, corner**2]),
    ):
        gain *= abs(signal.freqs(numerator, denominator, [angular])[1][0])
    return 0.5 * 20 / math.sqrt(2) * gain


@pytest.mark.parametrize("part", ["hand.L", "upper_leg.R"])
@pytest.mark.parametrize(
    ("listener", "actuators", "times"),
    [
        (DEVICE, [], 1.0),
        (DEVICE, [(1.0, OTHER)], 1.0),  # the listener's goes before the profile's
        (None, [(1.0, DEVICE)], 1.0),
        (None, [(0.25, DEVICE), (0.5, DEVICE)], 0.5),  # the stronger one
    ],
)
def test_the_exposure_of_a_sine_is_its_weighted_rms_over_eight_hours(
    part, listener, actuators, times
):
    found = daily([track(listener)] * 3, actuators, part)
    expected = times * rms_of_sine(part) * math.sqrt(3 * SECONDS / 28_800)
    assert found == pytest.approx(expected, rel=1e-9)


def test_without_a_calibration_there_is_no_exposure():
    assert math.isnan(daily([track(None)], [], "hand.L"))
    assert math.isnan(daily([track(DEVICE), track(None)], [(1.0, None)], "hand.L"))
    assert math.isnan(daily([track(None)], [(1.0, DEVICE), (1.0, None)], "hand.L"))


FORM = (
    small_study.FORM
    + """conditions = {one = {}, two = {}}
scenes = {sine = {tracks = {one = "one.wav", two = "two.wav"}}}
"""
)


def test_a_study_knows_the_exposure_by_the_calibration_beside_the_tracks(tmp_path):
    (tmp_path / "study.toml").write_text(FORM)
    listeners = (
        ListenerTrack("Left", "hand.L", device=DEVICE),
        ListenerTrack("Right", "hand.R"),
        ListenerTrack("Leg", "upper_leg.R", device=FullScale(((20.0, 0.5), (200.0, 2.0)), True)),
    )
    tracks = Tracks(listeners, RATE, np.tile(SINE, (3, 1)))
    for name in ("one", "two"):
        write_wav(tracks, tmp_path / f"{name}.wav", "float32")
        (tmp_path / f"{name}.wav.json").write_text(json.dumps(described(tracks)))
    assert [item.device for item in read(tmp_path / "one.wav").channels] == [
        item.device for item in listeners
    ]
    study = Study(tmp_path, read_form(tmp_path), 2, DeviceStage({}))
    left, right, leg = study.exposure
    expected = rms_of_sine("hand.L") * math.sqrt(2 * SECONDS / 28_800)
    assert left == ["hand.L", False, pytest.approx(expected, rel=1e-6), *HAND]
    assert right == ["hand.R", False, None, *HAND]
    assert leg == ["upper_leg.R", False, pytest.approx(leg[2]), *BODY] and leg[2] > 0
    for part in ("hand.L", "head"):
        with pytest.raises(ValueError, match=f"devices: {part} = 'pad'"):
            Study(
                tmp_path,
                {**read_form(tmp_path), "devices": {part: "pad"}},
                2,
                DeviceStage({}),
            )
    form = described(tracks)
    form["listeners"][1]["full_scale"] = [[100.0, -3.0]]
    (tmp_path / "two.wav.json").write_text(json.dumps(form))
    (loss,) = read(tmp_path / "two.wav").losses
    assert "two.wav.json is not used" in loss
    with pytest.raises(ValueError, match="all tracks need the same listeners"):
        Study(tmp_path, read_form(tmp_path), 2, DeviceStage({}))


def test_listeners_at_one_body_part_are_played_and_add_up(tmp_path):
    (tmp_path / "study.toml").write_text(FORM)
    places = {"Palm": "hand.L", "Thumb": "hand.L", "Heel": "foot.L", "Other palm": "hand.R"}
    tracks = Tracks(
        tuple(ListenerTrack(name, part, device=DEVICE) for name, part in places.items()),
        RATE,
        np.array([[0.4], [0.2], [0.1], [0.3]]) * 2 * SINE,
    )
    for name in ("one", "two"):
        write_wav(tracks, tmp_path / f"{name}.wav", "float32")
        (tmp_path / f"{name}.wav.json").write_text(json.dumps(described(tracks)))
    pad = DeviceOutput(profile("dualsense"), hid=None, rate=RATE)
    stage = SimpleNamespace(
        outputs={"pad": pad},
        mapping=lambda parts: map_listeners(parts, {"pad": pad.profile}),
        stop=lambda: None,
    )
    study = Study(tmp_path, read_form(tmp_path), 2, stage)
    (left, foot, right), once = study.exposure, rms_of_sine("hand.L") * math.sqrt(SECONDS / 14_400)
    assert left == ["hand.L", True, pytest.approx((0.8 + 0.4) * once, rel=1e-6), *HAND]
    assert right == ["hand.R", True, pytest.approx(0.6 * once, rel=1e-6), *HAND]
    assert foot[:2] == ["foot.L", False]
    played = study._mapping.blocks(tracks.samples)["pad"]
    assert np.allclose(played, np.array([[1.2], [0.6]]) * SINE, atol=1e-6)


def test_hands_have_other_limits_than_the_rest_of_the_body():
    assert limits_of("hand.R") is HAND
    assert limits_of("upper_leg.L") is BODY
