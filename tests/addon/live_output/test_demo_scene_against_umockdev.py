"""End to end without hardware: the demo scene through the whole add-on to the real ``hidraw``
module on made-up devices."""

import json
import shutil
import sys
from pathlib import Path

import pytest
from bounded_program import run as run_bounded
from haptic_tracing.core.devices.families.registry import families
from made_up_devices import (
    DECK,
    DUALSENSE_BT,
    DUALSENSE_USB,
    STADIA_USB,
    SWITCH_PRO_BT,
    describe,
)

HERE = Path(__file__).parent
MADE_UP = {
    "dualsense usb": DUALSENSE_USB,
    "dualsense bt": DUALSENSE_BT,
    "stadia usb": STADIA_USB,
    "switch-pro bt": SWITCH_PRO_BT,
    "steam-deck usb": DECK,
}
# Two of them are driven by plug-ins, which need not be there.
DEVICES = {name: fake for name, fake in MADE_UP.items() if name.split()[0] in families()}

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not sys.platform.startswith("linux"), reason="umockdev and hidraw exist on Linux only"
    ),
]


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    if shutil.which("umockdev-run") is None:
        pytest.fail("umockdev-run is not installed: on Debian and Ubuntu, apt-get install umockdev")
    folder = tmp_path_factory.mktemp("umockdev")
    nodes = json.dumps({name: f"hidraw{number}" for number, name in enumerate(DEVICES)})
    described = describe(folder, DEVICES.values())
    command = [
        "umockdev-run",
        *described,
        "--",
        sys.executable,
        str(HERE / "umockdev_playback.py"),
        nodes,
    ]
    done = run_bounded(command)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def test_all_devices_play_the_demo_without_a_failed_write(played):
    assert set(played["devices"]) == set(DEVICES)
    assert all(state == ["open", 0, 0] for state in played["states"].values())


@pytest.mark.parametrize("name", DEVICES)
def test_every_captured_report_is_what_encoding_the_baked_blocks_gives(played, name):
    device = played["devices"][name]
    assert device["blocks"] >= 10
    assert device["different"] == 0, "blocks that are not the baked ones"
    assert device["captured"] == device["expected"]
    assert len(set(device["captured"])) > 5, "it is felt"


def test_a_dualsense_ends_silent_and_released(played):
    zero, release = "02020000" + "00" * 35 + "04" + "00" * 8, "02" + "00" * 47
    assert played["devices"]["dualsense usb"]["captured"][-2:] == [zero, release]
