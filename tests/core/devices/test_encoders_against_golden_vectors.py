"""Every encoder against published protocol facts: whole reports."""

import pytest
from haptic_tracing.core.devices.families.dualsense import (
    DUALSENSE,
    DUALSENSE_FIRST_GENERATION,
    DUALSENSE_PCM,
)
from haptic_tracing.core.devices.report import levels
from published_reports import check, check_printed, pcm, rumble, tone_of, vectors_of

VECTORS = vectors_of(__file__)

ENCODED = {
    "dualsense_usb_v2_l0_r0": lambda v: rumble("dualsense", "usb", 0, 0),
    "dualsense_bt_v2_seq0_l0_r0": lambda v: rumble("dualsense", "bt", 0, 0),
    "dualsense_usb_v2_l0.5_r0.25": lambda v: rumble("dualsense", "usb"),
    "dualsense_bt_v2_seq0_l0.5_r0.25": lambda v: rumble("dualsense", "bt"),
    "dualsense_bt_v2_seq3_l0.5_r0.25": lambda v: rumble("dualsense", "bt", sequence=3),
    "dualsense_bt_v2_seq15_l0.5_r0.25": lambda v: rumble("dualsense", "bt", sequence=15),
    "dualsense_usb_v1_l0.5_r0.25": lambda v: (
        DUALSENSE_FIRST_GENERATION.encode(levels(0.5, 0.25), "usb", 0).data
    ),
    # SDL halves both motors of an old pad: the same report at half the level.
    "dualsense_usb_v1_sdl_halved_l0.5_r0.25": lambda v: (
        DUALSENSE_FIRST_GENERATION.encode(levels(0.25, 0.125), "usb", 0).data
    ),
    # The kernel appends 15 reserved bytes.
    "dualsense_usb_v2_kernel63_l0.5_r0.25": lambda v: rumble("dualsense", "usb") + bytes(15),
    "dualsense_usb_release": lambda v: DUALSENSE.release("usb", 0)[0].data,
    "dualsense_bt_release": lambda v: DUALSENSE.release("bt", 0)[0].data,
    "dualsense_bt_pcm_silence_ctr0": lambda v: pcm(DUALSENSE_PCM, v),
    "dualsense_bt_pcm_150hz_l0.5_r0.25_ctr1": lambda v: pcm(DUALSENSE_PCM, v),
    "ds4_usb_l0_r0": lambda v: rumble("dualshock4", "usb", 0, 0),
    "ds4_bt_c0_l0_r0": lambda v: rumble("dualshock4", "bt", 0, 0),
    "ds4_usb_l0.5_r0.25": lambda v: rumble("dualshock4", "usb"),
    "ds4_bt_c0_l0.5_r0.25": lambda v: rumble("dualshock4", "bt"),
    "xbox_bt_l0_r0": lambda v: rumble("xbox", left=0, right=0),
    "xbox_bt_failsafe_l0.5_r0.25": lambda v: rumble("xbox"),
    "stadia_l0_r0": lambda v: rumble("stadia", "usb", 0, 0),
    "stadia_l0.5_r0.25": lambda v: rumble("stadia", "bt"),
}

NOT_DRIVEN = {
    "ds4_bt_c4_l0.5_r0.25": "also sets the interval of input reports, which stays as it is",
    "xboxone_gip_usb_l0.5_r0.25": "no HID device",
    "xbox360_usb_l0.5_r0.25": "no HID device",
    "haptic_page_dial_click": "plays single clicks, takes no level or samples",
    "mxmaster4_get_feature_index": "plays single waveforms, takes no level or samples",
}


def test_every_published_vector_is_either_encoded_or_named_as_not_drivable():
    assert ENCODED.keys() | NOT_DRIVEN.keys() == VECTORS.keys()
    assert not ENCODED.keys() & NOT_DRIVEN.keys()


@pytest.mark.parametrize("name", ENCODED)
def test_report_is_byte_exact(name):
    check(ENCODED[name](VECTORS[name]), VECTORS[name])


def test_published_samples_are_the_tone_they_claim():
    vector = VECTORS["dualsense_bt_pcm_150hz_l0.5_r0.25_ctr1"]
    samples = vector["input"]["samples"]
    assert [samples[0::2], samples[1::2]] == tone_of(vector, 32, 3000)


@pytest.mark.parametrize(
    ("device", "options", "vector"),
    [
        ("dualsense", "--transport usb", "dualsense_usb_v2_l0.5_r0.25"),
        ("dualsense", "--transport bt", "dualsense_bt_v2_seq0_l0.5_r0.25"),
        ("dualsense", "--transport bt --sequence 3", "dualsense_bt_v2_seq3_l0.5_r0.25"),
        ("dualsense", "--transport bt --sequence 15", "dualsense_bt_v2_seq15_l0.5_r0.25"),
        ("dualsense", "", "dualsense_usb_v2_l0.5_r0.25"),
        ("dualshock4", "--transport usb", "ds4_usb_l0.5_r0.25"),
        ("dualshock4", "--transport bt", "ds4_bt_c0_l0.5_r0.25"),
        ("xbox", "--transport bt", "xbox_bt_failsafe_l0.5_r0.25"),
        ("stadia", "--transport usb", "stadia_l0.5_r0.25"),
    ],
)
def test_encode_prints_the_published_report(device, options, vector, capsys):
    check_printed(capsys, device, options, VECTORS[vector])
