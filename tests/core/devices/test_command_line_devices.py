"""The ``devices encode`` command against the published vectors, and its errors."""

import json
from pathlib import Path

import pytest
from haptic_tracing.command_line import main

VECTORS = {
    v["id"]: v["hex"]
    for v in json.loads((Path(__file__).parent / "hid_golden.json").read_text())["vectors"]
}


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
        ("switch-pro", "--transport usb", "switch_kernel_l0.5_r0.25"),
        ("joycon-left", "--transport bt", "switch_kernel_l0.5_r0.25"),
        ("joycon-right", "", "switch_kernel_l0.5_r0.25"),
        ("xbox", "--transport bt", "xbox_bt_failsafe_l0.5_r0.25"),
        ("stadia", "--transport usb", "stadia_l0.5_r0.25"),
        ("steam-deck", "", "steamdeck_rumble_l0.5_r0.25"),
        ("steam-controller", "", "steam_triton_rumble_l0.5_r0.25"),
    ],
)
def test_encode_prints_the_published_report(device, options, vector, capsys):
    assert (
        main(["devices", "encode", device, *options.split(), "--left", "0.5", "--right", "0.25"])
        == 0
    )
    printed = capsys.readouterr().out.rstrip("\n")
    # The Switch's vector has the ten bytes that mean something; the rest of the report is padding.
    assert printed.startswith(VECTORS[vector]) and set(printed[len(VECTORS[vector]) :]) <= {"0"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("gamecube --left 0.5", "device 'gamecube' is unknown"),
        ("dualsense --left 1.5", "amplitude 1.5 is not in [0, 1]"),
        ("dualsense --left nan", "amplitude nan is not in [0, 1]"),
        ("dualsense --right=-0.1", "amplitude -0.1 is not in [0, 1]"),
        ("dualsense --left much", "invalid float value"),
        ("dualsense --sequence 16", "sequence 16 is not in 0..15"),
        ("dualsense --transport wifi", "invalid choice"),
        ("xbox --transport usb", "transport 'usb' does not exist for xbox"),
        ("dualsense-pcm --left 0.5", "takes samples"),
        ("", "DEVICE"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(arguments, message, capsys):
    assert main(["devices", "encode", *arguments.split()]) == 2
    streams = capsys.readouterr()
    assert message in streams.err and streams.err.count("\n") == 1 and streams.out == ""
