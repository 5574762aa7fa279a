"""What is written to Switch pads when, in simulated time."""

import pytest
from haptic_tracing.command_line.devices import rumble_report
from haptic_tracing.plugins.nintendo.switch import usb_command
from simulated_time import Simulation, is_silent, longest_pause, pacing


def test_a_switch_pad_is_told_zero_five_times():
    reports = Simulation(pacing("switch-pro", "usb")).run_until(1.0).reports
    assert reports == [
        rumble_report("switch-pro", 0.0, 0.0, "usb", sequence).data for sequence in range(5)
    ]


def test_the_ending_is_zero_and_the_pad_lets_go_of_usb_at_the_very_end():
    (zero,) = pacing("switch-pro", "usb").ending(False)
    assert is_silent("switch-pro", "usb", zero.data)
    zero, farewell = pacing("switch-pro", "usb").ending(True)
    assert is_silent("switch-pro", "usb", zero.data) and farewell == usb_command(5)


@pytest.mark.parametrize(("transport", "gap"), [("usb", 0.051), ("bt", 0.061)])
def test_a_steady_drive_is_refreshed_before_the_pad_lets_go(transport, gap):
    assert longest_pause("switch-pro", transport) <= gap
