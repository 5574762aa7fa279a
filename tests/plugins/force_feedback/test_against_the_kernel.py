"""The kernel's force feedback: event devices that umockdev makes up, with a kernel behind them that
keeps the effects."""

import json
import shutil
import sys
from pathlib import Path

import pytest
from bounded_program import run as run_bounded
from haptic_tracing.plugins.force_feedback.kernel import event_nodes
from kernel_input import describe_pad
from made_up_devices import DUALSENSE_BT, XBOX_BT, describe

SCENES = Path(__file__).parents[2] / "core" / "devices" / "umockdev_scenes.py"
pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="force feedback is Linux's"
)


@pytest.fixture
def scene(tmp_path):
    """Runs a scene with a pad of the kernel, and with HID devices."""
    if shutil.which("umockdev-run") is None:
        pytest.fail("umockdev-run is not installed: on Debian and Ubuntu, apt-get install umockdev")

    def run(ending, pad, *fakes):
        (tmp_path / "pad.umockdev").write_text(pad)
        command = [
            "umockdev-run",
            "-d",
            str(tmp_path / "pad.umockdev"),
            *(describe(tmp_path, fakes) if fakes else []),
        ]
        command += [
            "--",
            sys.executable,
            str(SCENES),
            "force_feedback",
            ending,
        ]
        done = run_bounded(command)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


XBOX_USB = describe_pad("Microsoft X-Box One S pad", 0x045E, 0x02EA)


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["rest", "stop", "kill"])
def test_a_pad_that_is_no_hid_device_is_felt_and_falls_silent(scene, ending):
    played = scene(ending, XBOX_USB)
    name = "Microsoft X-Box One S pad"
    assert played["found"] == [[f"force-feedback {name}", name, "USB, kernel", ""]]
    strong, weak = played["usual"]
    assert strong > 0x4000 and weak == 0, "a low tone goes to the strong motor"
    assert played["silent"] - played["waited"] <= 0.15
    assert played["effects"] == (1 if ending == "rest" else 0), (
        "one effect, changed as it plays, and erased with its device"
    )


@pytest.mark.slow
def test_a_pad_that_may_not_be_opened_as_hid_device_is_driven_by_the_kernel(scene):
    same = describe_pad(
        "DualSense Wireless Controller", 0x054C, 0x0CE6, serial=DUALSENSE_BT.serial.upper(), bus=5
    )
    played = scene("stop", same, DUALSENSE_BT)
    assert [key for key, *_ in played["found"]] == [
        f"dualsense-pcm {DUALSENSE_BT.serial}",
        f"dualsense {DUALSENSE_BT.serial}",
        f"force-feedback DualSense Wireless Controller {DUALSENSE_BT.serial.upper()}",
    ]
    assert ["hides it" in permission for *_, permission in played["found"]] == [True, True, False]
    assert played["usual"][0] > 0x4000


def test_only_devices_that_take_rumble_are_listed(tmp_path):
    """The files are as the kernel writes them; 0x50 is FF_RUMBLE in linux/input-event-codes.h."""
    pads = {
        "event3": "107030000 0",
        "event4": "0",
        "event5": "10000 0",
        "event6": "8000 0",
        "event7": "not a number",
    }
    for name, capabilities in pads.items():
        device = tmp_path / name / "device"
        (device / "capabilities").mkdir(parents=True)
        (device / "id").mkdir()
        (device / "capabilities" / "ff").write_text(capabilities + "\n")
        for key, value in (("vendor", "045e"), ("product", "0b13"), ("bustype", "0005")):
            (device / "id" / key).write_text(value + "\n")
        (device / "name").write_text("Xbox Wireless Controller\n")
        (device / "uniq").write_text(XBOX_BT.serial + "\n")
    (tmp_path / "event8").mkdir()
    first, second = event_nodes(tmp_path)
    assert [node.path for node in (first, second)] == [b"/dev/input/event3", b"/dev/input/event5"]
    assert (first.vendor, first.product, first.transport, first.title) == (
        0x045E,
        0x0B13,
        "bt",
        "Xbox Wireless Controller",
    )
    assert first.serial == XBOX_BT.serial
    assert event_nodes(tmp_path / "nowhere") == ()
