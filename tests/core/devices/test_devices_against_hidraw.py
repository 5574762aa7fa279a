"""End to end without hardware: the real ``hidraw`` module on devices that Debian's umockdev makes
up, whose nodes keep the bytes."""

import sys
from dataclasses import replace
from pathlib import Path

import pytest
from made_up_devices import (
    DUALSENSE_BT,
    DUALSENSE_USB,
    KEYBOARD,
    STADIA_USB,
    STRANGER,
    XBOX_BT,
    Fake,
)
from published_reports import vectors_of
from umockdev_runs import split

VECTORS = {name: vector["hex"] for name, vector in vectors_of(__file__).items()}
pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="umockdev and hidraw exist on Linux only"
)


def test_devices_are_found_with_their_transport_and_strangers_are_named(scene):
    keyboard = Fake(3, 0x046D, 0xC31C, "Keyboard", number=0, descriptor=KEYBOARD)
    found = scene(
        "list",
        fakes=[DUALSENSE_USB, DUALSENSE_BT, STADIA_USB, XBOX_BT, STRANGER, keyboard],
    )
    assert {(device["title"], device["transport"], *device["families"]) for device in found} == {
        ("DualSense Wireless Controller", "usb", "dualsense"),
        ("DualSense Wireless Controller", "bt", "dualsense", "dualsense-pcm"),
        ("Stadia Controller", "usb", "stadia"),
        ("Xbox Wireless Controller", "bt", "xbox"),
        ("Somebody's gamepad", "usb"),
    }


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fake", "name", "transport", "vectors"),
    [
        (
            DUALSENSE_USB,
            "dualsense",
            "usb",
            ["dualsense_usb_v2_l0_r0", "dualsense_usb_v2_l0.5_r0.25"],
        ),
        (
            DUALSENSE_BT,
            "dualsense",
            "bt",
            ["dualsense_bt_v2_seq0_l0_r0", "dualsense_bt_v2_seq0_l0.5_r0.25"],
        ),
        (XBOX_BT, "xbox", "bt", ["xbox_bt_l0_r0", "xbox_bt_failsafe_l0.5_r0.25"]),
    ],
)
def test_reports_arrive_byte_exact(scene, fake, name, transport, vectors):
    expected = [VECTORS[vector] for vector in vectors]
    assert (
        split(scene("write", name, transport, fakes=[fake]), len(expected[0]) // 2)[:2] == expected
    )


def test_playing_on_a_dualsense_over_usb(scene):
    answer = scene("play", "dualsense", "200", fakes=[DUALSENSE_USB])
    reports = split(answer["captured"], 48)
    zero, driven, release = (
        VECTORS[f"dualsense_usb_{kind}"] for kind in ("v2_l0_r0", "v2_l0.5_r0.25", "release")
    )
    assert reports[0] == zero and reports[-2:] == [zero, release]
    assert driven in reports
    assert reports.index(driven) <= 4, "the slew limit is passed within 50 ms"
    assert answer["done"] and answer["state"] == "stopped" and answer["message"] == ""
    assert answer["written"] == len(reports) and answer["failed_writes"] == answer["losses"] == 0


@pytest.mark.slow
def test_playing_on_a_dualsense_over_bluetooth_counts_reports_and_keeps_the_checksum(scene):
    reports = split(scene("play", "dualsense", "200", fakes=[DUALSENSE_BT])["captured"], 78)
    assert [int(report[2], 16) for report in reports] == [i % 16 for i in range(len(reports))]
    assert reports[0] == VECTORS["dualsense_bt_v2_seq0_l0_r0"]
    assert any(report[10:14] == "4080" for report in reports)
    for report in reports:
        register = 0xFFFFFFFF
        for byte in b"\xa2" + bytes.fromhex(report)[:-4]:
            register ^= byte
            for _ in range(8):
                register = register >> 1 ^ (0xEDB88320 if register & 1 else 0)
        assert report[-8:] == (register ^ 0xFFFFFFFF).to_bytes(4, "little").hex()


@pytest.mark.slow
def test_an_old_dualsense_gets_the_reports_of_its_generation(scene):
    version = bytearray(64)
    version[0], version[44:46] = 0x20, (0x0210).to_bytes(2, "little")
    old = Fake(
        3,
        0x054C,
        0x0CE6,
        "DualSense Wireless Controller",
        number=3,
        features=[f"HIDIOCGFEATURE 64 {version.hex()}"],
    )
    assert VECTORS["dualsense_usb_v1_l0.5_r0.25"] in split(
        scene("play", "dualsense", "200", fakes=[old])["captured"], 48
    )


@pytest.mark.slow
def test_the_watchdog_silences_the_real_device(scene):
    reports = split(scene("watchdog", "dualsense", fakes=[DUALSENSE_USB])["captured"], 48)
    assert VECTORS["dualsense_usb_v2_l0.5_r0.25"] in reports
    assert reports[-1] == VECTORS["dualsense_usb_v2_l0_r0"]


@pytest.mark.slow
def test_a_program_that_just_ends_leaves_the_device_silent_and_released(scene):
    answer = scene("exit", "dualsense", fakes=[DUALSENSE_USB])
    assert split(answer["captured"], 48)[-2:] == [
        VECTORS["dualsense_usb_v2_l0_r0"],
        VECTORS["dualsense_usb_release"],
    ]


@pytest.mark.slow
def test_an_unplugged_device_is_counted_searched_and_driven_again(scene):
    answer = scene("unplug", "dualsense", fakes=[DUALSENSE_USB])
    assert answer["lost"]["losses"] == 1 and answer["lost"]["failed_writes"] == 3
    assert answer["after"]["state"] == "open" and answer["after"]["message"] == ""
    assert answer["after"]["losses"] == 1 and answer["after"]["failed_writes"] == 3
    assert answer["after"]["written"] > answer["lost"]["written"]
    assert VECTORS["dualsense_usb_v2_l0.5_r0.25"] in split(answer["captured"], 48)
    assert answer["done"]


@pytest.mark.slow
def test_a_program_ends_in_time_and_without_a_crash_while_a_write_is_blocked(scene):
    stuck = replace(DUALSENSE_BT, keeps=False)
    answer = scene("stuck", "dualsense", fakes=[stuck])
    done, state, writing_for = answer["stopped"]
    assert not done and state == "open" and writing_for > 0.3
    assert answer["code"] == 0 and answer["errors"] == ""


def test_missing_permission_comes_with_the_udev_rule_to_copy(scene):
    usb = scene("no_permission", "dualsense", fakes=[DUALSENSE_USB])["error"]
    assert "no permission for /dev/hidraw0" in usb and "\n" not in usb
    assert usb.endswith(
        'KERNEL=="hidraw*", ATTRS{idVendor}=="054c", ATTRS{idProduct}=="0ce6", MODE="0660", '
        'TAG+="uaccess"'
    )
    bluetooth = scene("no_permission", "dualsense", fakes=[DUALSENSE_BT])["error"]
    assert bluetooth.endswith(
        'KERNEL=="hidraw*", KERNELS=="*054C:0CE6*", MODE="0660", TAG+="uaccess"'
    )


COMMAND = [
    "-c",
    "import sys; from haptic_tracing.command_line import main; sys.exit(main())",
    "devices",
]


def test_the_command_lists_devices_and_names_what_it_can_not_drive(under_umockdev):
    done = under_umockdev(COMMAND, DUALSENSE_BT, STADIA_USB, STRANGER)
    assert done.returncode == 0 and done.stderr == ""
    assert sorted(done.stdout.splitlines()) == [
        "dualsense, dualsense-pcm\tDualSense Wireless Controller\tbt\t054c:0ce6\ta0:ab:51:00:00:01",
        "not supported\tSomebody's gamepad\tusb\t1234:abcd",
        "stadia\tStadia Controller\tusb\t18d1:9400",
    ]
    assert under_umockdev(COMMAND).stdout == "no haptic device is connected\n"


@pytest.mark.slow
def test_the_command_plays_a_sweep_on_one_actuator_after_the_other(under_umockdev):
    program = (
        "import sys; from haptic_tracing.command_line import main; main(); "
        "print(open('/dev/hidraw0', 'rb').read().hex())"
    )
    done = under_umockdev(
        ["-c", program, "devices", "test", "dualsense", "--seconds", "0.8"], DUALSENSE_USB
    )
    summary, captured = done.stdout.splitlines()
    reports = [bytes.fromhex(report) for report in split(captured, 48)]
    assert summary.startswith(f"dualsense: {len(reports)} reports written, the last is release")
    assert [reports[-2].hex(), reports[-1].hex()] == [
        VECTORS["dualsense_usb_v2_l0_r0"],
        VECTORS["dualsense_usb_release"],
    ]
    left, right = (
        [i for i, report in enumerate(reports) if report[place] > 0x60] for place in (4, 3)
    )
    assert left and right and max(left) < max(right) and min(left) < min(right)


GUARD_DIES = f"""
import os, signal, sys, threading, time
from haptic_tracing.command_line import main
sys.path.append({str(Path(__file__).parent)!r})
from umockdev_scenes import children

def kill():
    while not any(open("/dev/hidraw0", "rb").read()[3::48]):  # until the sweep drives a motor
        time.sleep(0.05)
    (guard,) = children()
    os.kill(guard, signal.SIGKILL)

threading.Thread(target=kill, daemon=True).start()
sys.exit(main())
"""


@pytest.mark.slow
def test_a_sweep_whose_guard_dies_is_no_success(under_umockdev):
    done = under_umockdev(
        ["-c", GUARD_DIES, "devices", "test", "dualsense", "--seconds", "4"], DUALSENSE_USB
    )
    assert done.returncode == 2 and done.stdout == ""
    assert "the process that guards the devices has ended (-9)" in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["test", "toaster"], "device 'toaster' is unknown"),
        (["test", "dualsense", "--seconds", "nan"], "seconds nan is not in [0.1, 60]"),
        (["test", "xbox"], "Xbox Wireless Controller (Bluetooth) is not connected"),
        (["--profiles", "/nowhere"], "/nowhere: is not a folder"),
    ],
)
def test_the_command_says_in_one_line_what_is_wrong(under_umockdev, arguments, message):
    done = under_umockdev([*COMMAND, *arguments], DUALSENSE_USB)
    assert done.returncode == 2 and done.stdout == ""
    assert message in done.stderr and done.stderr.count("\n") == 1


def test_a_broken_profile_of_the_users_is_named_and_the_others_are_used(under_umockdev, tmp_path):
    folder = tmp_path / "profiles"
    folder.mkdir()
    (folder / "mine.json").write_text('{"format": "haptic-device"}')
    done = under_umockdev([*COMMAND, "--profiles", str(folder)], DUALSENSE_USB)
    assert done.returncode == 0 and done.stdout.startswith("dualsense\t")
    assert (
        done.stderr.startswith(f"{folder / 'mine.json'}: /version: is required")
        and done.stderr.count("\n") == 1
    )
