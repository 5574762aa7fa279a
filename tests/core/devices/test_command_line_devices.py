"""Errors of the ``devices encode`` command."""

import pytest
from haptic_tracing.command_line import main


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
