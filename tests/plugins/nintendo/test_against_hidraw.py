"""A Switch pad that umockdev makes up, through the real ``hidraw`` module."""

import sys

import pytest
from made_up_devices import SWITCH_PRO_BT, SWITCH_PRO_USB
from published_reports import vectors_of
from umockdev_runs import split

VECTORS = {name: vector["hex"] for name, vector in vectors_of(__file__).items()}
pytestmark = [
    pytest.mark.skipif(
        not sys.platform.startswith("linux"), reason="umockdev and hidraw exist on Linux only"
    ),
    pytest.mark.slow,
]


def test_it_is_found(scene):
    (found,) = scene("list", fakes=[SWITCH_PRO_BT])
    assert (found["title"], found["transport"]) == ("Pro Controller", "bt")
    assert found["families"] == ["switch-pro"]


def test_playing_on_a_switch_pro_over_usb_and_bluetooth(scene):
    words = VECTORS["switch_kernel_l0.5_r0.25"][4:]
    neutral = VECTORS["switch_neutral_any"][4:]
    for fake, length, startup in ((SWITCH_PRO_USB, 64, 9), (SWITCH_PRO_BT, 49, 2)):
        answer = scene("play", "switch-pro", "160", "320", fakes=[fake])
        reports = split(answer["captured"], length)
        # The made-up pad never answers, so each command that expects an answer is sent twice.
        if fake is SWITCH_PRO_USB:
            assert [report[:4] for report in reports[:7]] == [
                "8002",
                "8002",
                "8003",
                "8003",
                "8002",
                "8002",
                "8004",
            ]
            assert reports.pop()[:4] == "8005"
        else:
            assert reports[0] == VECTORS["switch_enable_vibration_bt"]
        assert {report[:2] + report[20:24] for report in reports[startup - 2 : startup]} == {
            "014801"
        }
        rumble = reports[startup:]
        assert all(report[:2] == "10" for report in rumble)
        assert [int(report[2:4], 16) for report in rumble] == [
            (startup + i) % 16 for i in range(len(rumble))
        ]
        assert rumble[-1][4:20] == neutral
        assert words in [report[4:20] for report in rumble]
        assert answer["written"] == len(reports) + (fake is SWITCH_PRO_USB)
