"""What is written to a Steam Controller when, in simulated time."""

from simulated_time import longest_pause, pacing, tone


def test_a_startup_that_did_not_arrive_begins_again():
    paced = pacing("steam-controller-pcm", "usb")
    paced.accept(tone(0.04), 0.0)
    begun = paced.next_report(1.0)
    assert begun.data[0] == 0x86
    paced.failed()
    assert paced.next_report(2.0) == begun


def test_the_ending_is_zero_then_release():
    zero, release = pacing("steam-controller-pcm", "usb").ending(True)
    assert zero.data == bytes([0x88, 31]) + bytes(62) and release.data == bytes([0x86, 1, 2, 0])


def test_a_steady_drive_is_refreshed_before_the_device_lets_go():
    assert longest_pause("steam-controller", "usb") <= 0.041
