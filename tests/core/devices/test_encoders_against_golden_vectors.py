"""Every encoder against published protocol facts: whole reports, and the Switch's two tables."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from haptic_tracing.command_line.devices import rumble_report
from haptic_tracing.core.devices.families.dualsense import (
    DUALSENSE,
    DUALSENSE_FIRST_GENERATION,
    DUALSENSE_PCM,
)
from haptic_tracing.core.devices.families.steam import STEAM_CONTROLLER_PCM
from haptic_tracing.core.devices.families.switch import (
    SWITCH_PRO,
    actuator_word,
    amplitude_index,
    enable_vibration,
    frequency_code,
    usb_command,
)
from haptic_tracing.core.devices.report import Tones, levels

GOLDEN = json.loads((Path(__file__).parent / "hid_golden.json").read_text())
VECTORS = {vector["id"]: vector for vector in GOLDEN["vectors"]}
FREQUENCIES = GOLDEN["switch_tables"]["frequency"]
AMPLITUDES = GOLDEN["switch_tables"]["amplitude"]


def rumble(name, transport=None, left=0.5, right=0.25, sequence=0):
    return rumble_report(name, left, right, transport, sequence).data


def pcm(family, vector):
    """A vector's samples: both actuators in step, or one after the other."""
    given = vector["input"]
    if "samples" in given and isinstance(given["samples"], list):
        samples = np.array(given["samples"], dtype=np.int8).reshape(-1, 2).T
    elif "left_samples" in given:
        samples = np.array([given["left_samples"], given["right_samples"]], dtype=np.int8)
    else:
        samples = np.zeros((2, family.frames), dtype=np.int8)
    return family.encode(samples, given.get("ctr", 0)).data


def golden_samples(vector_id, frames, rate):
    """The vector's tone in samples, from its description."""
    given = VECTORS[vector_id]["input"]
    phase = 2 * math.pi * given["freq_hz"] / rate
    return [
        [round(given[side] * 127 * math.sin(phase * n)) for n in range(frames)]
        for side in ("left", "right")
    ]


SDL_TONES = Tones((0.5, 0.25, 0.5, 0.25), (150.0, 150.0, 150.0, 150.0))

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
    "xbox_bt_l0_r0": lambda v: rumble("xbox", left=0, right=0),
    "xbox_bt_l0.5_r0.25": lambda v: rumble("luna"),
    "xbox_bt_failsafe_l0.5_r0.25": lambda v: rumble("xbox"),
    "luna_bt_l0.5_r0.25": lambda v: rumble("luna"),
    "stadia_l0_r0": lambda v: rumble("stadia", "usb", 0, 0),
    "stadia_l0.5_r0.25": lambda v: rumble("stadia", "bt"),
    "shield2017_l0.5_r0.25_seq0": lambda v: rumble("shield-2017"),
    "shield2015_l0.5_r0.25": lambda v: rumble("shield-2015"),
    "8bitdo_l0.5_r0.25": lambda v: rumble("8bitdo"),
    "sinput_erm_l0.5_r0.25": lambda v: rumble("sinput"),
    "steamdeck_rumble_l0.5_r0.25": lambda v: rumble("steam-deck"),
    "steam_triton_rumble_l0.5_r0.25": lambda v: rumble("steam-controller"),
    "steam_triton_pcm_config_8k8bit": lambda v: STEAM_CONTROLLER_PCM.startup("usb", 0)[0].data,
    "steam_triton_pcm_cancel": lambda v: STEAM_CONTROLLER_PCM.release("usb", 0)[0].data,
    "steam_triton_pcm_silence": lambda v: pcm(STEAM_CONTROLLER_PCM, {"input": {}}),
    "steam_triton_pcm_160hz_l0.5_r0.25": lambda v: pcm(STEAM_CONTROLLER_PCM, v),
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


@pytest.mark.parametrize("vector_id", ENCODED)
def test_report_is_byte_exact(vector_id):
    vector = VECTORS[vector_id]
    report = ENCODED[vector_id](vector)
    assert report.hex() == vector["hex"]
    assert len(report) == vector["length"]


@pytest.mark.parametrize(
    ("vector_id", "frames", "rate"),
    [
        ("dualsense_bt_pcm_150hz_l0.5_r0.25_ctr1", 32, 3000),
        ("steam_triton_pcm_160hz_l0.5_r0.25", 31, 8000),
    ],
)
def test_published_samples_are_the_tone_they_claim(vector_id, frames, rate):
    given = VECTORS[vector_id]["input"]
    left, right = golden_samples(vector_id, frames, rate)
    published = (
        [given["samples"][0::2], given["samples"][1::2]]
        if "samples" in given
        else [given["left_samples"], given["right_samples"]]
    )
    assert published == [left, right]


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
