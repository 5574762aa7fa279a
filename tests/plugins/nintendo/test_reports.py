"""Reports of Switch pads against published protocol facts: whole reports, and two tables."""

import math

import pytest
from haptic_tracing.core.devices.report import Tones
from haptic_tracing.plugins.nintendo.switch import (
    SWITCH_PRO,
    actuator_word,
    amplitude_index,
    enable_vibration,
    frequency_code,
    usb_command,
)
from hypothesis import given
from hypothesis import strategies as st
from published_reports import check, check_printed, published, rumble, vectors_of

VECTORS = vectors_of(__file__)
FREQUENCIES = published(__file__)["switch_tables"]["frequency"]
AMPLITUDES = published(__file__)["switch_tables"]["amplitude"]
SDL_TONES = Tones((0.5, 0.25, 0.5, 0.25), (150.0, 150.0, 150.0, 150.0))
ENCODED = {
    "switch_neutral_bt": lambda v: rumble("joycon-left", "bt", 0, 0),
    "switch_neutral_usb": lambda v: rumble("switch-pro", "usb", 0, 0),
    # The kernel sends the ten bytes that mean something; the rest is padding.
    "switch_neutral_any": lambda v: rumble("switch-pro", "bt", 0, 0)[:10],
    "switch_kernel_l0.5_r0.25": lambda v: rumble("switch-pro", "usb")[:10],
    "switch_sdl_low0.5_high0.25": lambda v: SWITCH_PRO.encode(SDL_TONES, "bt", 0).data,
    "switch_enable_vibration_bt": lambda v: enable_vibration("bt", 0).data,
    "switch_enable_vibration_usb": lambda v: enable_vibration("usb", 0).data,
    "switch_usb_status": lambda v: usb_command(v["input"]["cmd"]).data,
    "switch_usb_handshake": lambda v: usb_command(2).data,
}


@pytest.mark.parametrize("name", VECTORS)
def test_report_is_byte_exact(name):
    check(ENCODED[name](VECTORS[name]), VECTORS[name])


@pytest.mark.parametrize(
    ("device", "options"),
    [("switch-pro", "--transport usb"), ("joycon-left", "--transport bt"), ("joycon-right", "")],
)
def test_encode_prints_the_published_report(device, options, capsys):
    check_printed(capsys, device, options, VECTORS["switch_kernel_l0.5_r0.25"])


@pytest.mark.parametrize("row", FREQUENCIES, ids=lambda row: f"{row['hz']:.1f}Hz")
def test_switch_frequency_rows(row):
    code = frequency_code(row["hz"])
    assert row["hf"] is None or row["hf"] == (code - 0x60) * 4
    assert row["lf"] is None or row["lf"] == code - 0x40
    word = actuator_word(row["hz"], 0.0, row["hz"], 0.0)
    if row["lf"] is not None:
        assert word[2] == row["lf"]
    if row["hf"] is not None:
        assert word[0] | (word[1] & 1) << 8 == row["hf"]


@pytest.mark.parametrize(
    "row", [row for row in AMPLITUDES if row["idx"] <= 100], ids=lambda row: f"index{row['idx']}"
)
def test_switch_amplitude_rows(row):
    amplitude = min(row["amp"], 1.0)
    assert amplitude_index(amplitude) == row["idx"]
    word = actuator_word(160.0, amplitude, 320.0, amplitude)
    assert word[1] & 0xFE == row["ha"]
    assert [word[2] & 0x80, word[3]] == row["la"]


amplitudes = st.floats(0.0, 1.0)
frequencies = st.floats(1e-3, 1e6)


@given(low_hz=frequencies, low=amplitudes, high_hz=frequencies, high=amplitudes)
def test_switch_words_stay_in_the_valid_and_safe_range(low_hz, low, high_hz, high):
    word = actuator_word(low_hz, low, high_hz, high)
    high_code, high_index = word[0] | (word[1] & 1) << 8, (word[1] & 0xFE) // 2
    low_code, low_index = word[2] & 0x7F, 2 * (word[3] - 0x40) + (word[2] >> 7)
    assert 0x0004 <= high_code <= 0x01FC and high_code % 4 == 0
    assert 0x01 <= low_code <= 0x7F
    assert 0 <= high_index <= 100 and 0 <= low_index <= 100


@given(one=amplitudes, other=amplitudes)
def test_switch_amplitude_is_monotone_and_within_one_table_step(one, other):
    def index(amplitude):
        return (actuator_word(160.0, 0.0, 320.0, amplitude)[1] & 0xFE) // 2

    low, high = sorted((one, other))
    assert index(low) <= index(high)
    # A step of the table is at most a quarter of an octave from 0.0118 up, so the nearest row is
    # within an eighth.
    if high >= 0.0118:
        row = index(high)
        represented = (
            2 ** (row / 32) / 8.7
            if row >= 32
            else 2 ** (row / 16) / 17
            if row >= 16
            else 2 ** (row / 4) / 119.6
        )
        assert abs(math.log2(represented / high)) <= 1 / 8 + 1e-3


@given(sequence=st.integers(0, 10**6))
def test_switch_counter_wraps_and_both_words_are_sent(sequence):
    data = SWITCH_PRO.encode(
        Tones((0.5, 0.5, 0.25, 0.25), (160.0, 320.0, 160.0, 320.0)), "bt", sequence
    ).data
    assert data[:2] == bytes([0x10, sequence % 16])
    assert data[2:6] == actuator_word(160.0, 0.5, 320.0, 0.5) and data[6:10] == actuator_word(
        160.0, 0.25, 320.0, 0.25
    )
