"""What must hold for every drive: lengths, checksums computed another way, order of amplitudes, and
the Switch's safe range."""

import math

import numpy as np
import pytest
from haptic_tracing.command_line.devices import rumble_report
from haptic_tracing.core.devices.families.dualsense import DUALSENSE_PCM
from haptic_tracing.core.devices.families.family import RumbleFamily, StreamFamily
from haptic_tracing.core.devices.families.registry import FAMILIES
from haptic_tracing.core.devices.families.switch import SWITCH_PRO, actuator_word
from haptic_tracing.core.devices.report import Tones
from hypothesis import given
from hypothesis import strategies as st

amplitudes = st.floats(0.0, 1.0)
sequences = st.integers(0, 15)
RUMBLE = [
    (family, transport)
    for family in FAMILIES.values()
    if isinstance(family, RumbleFamily)
    for transport in family.transports
]
NAMED = {"ids": lambda value: value if isinstance(value, str) else value.name}

# Where a report's motor levels stand, low byte first: (left, right).
FIELDS = {
    ("dualsense", "usb"): ([4], [3]),
    ("dualsense", "bt"): ([6], [5]),
    ("dualshock4", "usb"): ([5], [4]),
    ("dualshock4", "bt"): ([7], [6]),
    ("xbox", "bt"): ([4], [5]),
    ("luna", "bt"): ([4], [5]),
    ("stadia", "usb"): ([1, 2], [3, 4]),
    ("stadia", "bt"): ([1, 2], [3, 4]),
    ("steam-deck", "usb"): ([6, 7], [8, 9]),
    ("steam-controller", "usb"): ([4, 5], [7, 8]),
    ("steam-controller", "bt"): ([4, 5], [7, 8]),
    ("shield-2017", "usb"): ([4], [5]),
    ("shield-2017", "bt"): ([4], [5]),
    ("shield-2015", "usb"): ([2], [4]),
    ("8bitdo", "usb"): ([1], [2]),
    ("8bitdo", "bt"): ([1], [2]),
    ("sinput", "usb"): ([3], [5]),
    ("sinput", "bt"): ([3], [5]),
}
LENGTHS = {
    ("dualsense", "usb"): 48,
    ("dualsense", "bt"): 78,
    ("dualshock4", "usb"): 32,
    ("dualshock4", "bt"): 78,
    ("switch-pro", "usb"): 64,
    ("switch-pro", "bt"): 49,
    ("joycon-left", "usb"): 64,
    ("joycon-left", "bt"): 49,
    ("joycon-right", "usb"): 64,
    ("joycon-right", "bt"): 49,
    ("xbox", "bt"): 9,
    ("luna", "bt"): 9,
    ("stadia", "usb"): 5,
    ("stadia", "bt"): 5,
    ("steam-deck", "usb"): 65,
    ("steam-controller", "usb"): 10,
    ("steam-controller", "bt"): 10,
    ("shield-2017", "usb"): 33,
    ("shield-2017", "bt"): 33,
    ("shield-2015", "usb"): 7,
    ("8bitdo", "usb"): 5,
    ("8bitdo", "bt"): 5,
    ("sinput", "usb"): 48,
    ("sinput", "bt"): 48,
}


def bitwise_crc(data):
    """CRC-32 by its definition: a shift register of the reflected polynomial, one bit at a time."""
    register = 0xFFFFFFFF
    for byte in data:
        register ^= byte
        for _ in range(8):
            register = register >> 1 ^ (0xEDB88320 if register & 1 else 0)
    return register ^ 0xFFFFFFFF


def motors(name, transport, report):
    left, right = FIELDS[name, transport]
    return tuple(
        int.from_bytes(bytes(report[place] for place in field), "little") for field in (left, right)
    )


@pytest.mark.slow
@pytest.mark.parametrize(("family", "transport"), RUMBLE, **NAMED)
@given(left=amplitudes, right=amplitudes, sequence=sequences)
def test_length_is_fixed_and_sony_checksums_hold(family, transport, left, right, sequence):
    data = rumble_report(family.name, left, right, transport, sequence).data
    assert len(data) == LENGTHS[family.name, transport]
    if family.name in ("dualsense", "dualshock4") and transport == "bt":
        assert int.from_bytes(data[-4:], "little") == bitwise_crc(b"\xa2" + data[:-4])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("family", "transport"), [pair for pair in RUMBLE if not pair[0].has_tones], **NAMED
)
@given(one=amplitudes, other=amplitudes)
def test_more_amplitude_never_drives_less_and_sides_stay_apart(family, transport, one, other):
    low, high = sorted((one, other))
    weak, strong = (
        motors(family.name, transport, rumble_report(family.name, level, 0.0, transport).data)
        for level in (low, high)
    )
    assert weak[0] <= strong[0] and weak[1] == strong[1] == 0
    weak, strong = (
        motors(family.name, transport, rumble_report(family.name, 0.0, level, transport).data)
        for level in (low, high)
    )
    assert weak[1] <= strong[1] and weak[0] == strong[0] == 0


@pytest.mark.parametrize(
    ("family", "transport"), [pair for pair in RUMBLE if not pair[0].has_tones], **NAMED
)
def test_full_amplitude_is_the_largest_value_of_the_field(family, transport):
    full = {"xbox": 100, "luna": 100, "shield-2017": 31}.get(
        family.name, 256 ** len(FIELDS[family.name, transport][0]) - 1
    )
    assert motors(family.name, transport, rumble_report(family.name, 1.0, 1.0, transport).data) == (
        full,
        full,
    )


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


@given(data=st.data())
def test_streams_carry_every_sample(data):
    for family in (family for family in FAMILIES.values() if isinstance(family, StreamFamily)):
        shape = (2, family.frames)
        drawn = data.draw(st.binary(min_size=shape[0] * shape[1], max_size=shape[0] * shape[1]))
        samples = np.frombuffer(drawn, dtype=np.int8).clip(-127).reshape(shape)
        report = family.encode(samples, data.draw(st.integers(0, 1000))).data
        if family is DUALSENSE_PCM:
            carried = np.frombuffer(report, dtype=np.int8)[13:77].reshape(-1, 2).T
            assert int.from_bytes(report[-4:], "little") == bitwise_crc(b"\xa2" + report[:-4])
        else:
            carried = np.frombuffer(report, dtype=np.int8)[2:].reshape(2, -1)
        assert (carried == samples).all()


@pytest.mark.parametrize("level", [-0.01, 1.01, math.nan, math.inf, -math.inf])
@pytest.mark.parametrize(("family", "transport"), RUMBLE, **NAMED)
def test_amplitudes_out_of_range_are_refused(family, transport, level):
    with pytest.raises(ValueError, match=r"amplitude .* is not in \[0, 1\]"):
        rumble_report(family.name, level, 0.0, transport)
    with pytest.raises(ValueError, match=r"amplitude .* is not in \[0, 1\]"):
        rumble_report(family.name, 0.0, level, transport)


def test_wrong_names_transports_and_sequences_are_refused():
    with pytest.raises(ValueError, match="device 'gamecube' is unknown: use one of dualsense"):
        rumble_report("gamecube", 0.0, 0.0)
    with pytest.raises(ValueError, match="'usb' does not exist for xbox: use bt"):
        rumble_report("xbox", 0.0, 0.0, "usb")
    with pytest.raises(ValueError, match=r"sequence 16 is not in 0\.\.15"):
        rumble_report("dualsense", 0.0, 0.0, "bt", 16)
    with pytest.raises(ValueError, match="takes samples"):
        rumble_report("dualsense-pcm", 0.0, 0.0)
