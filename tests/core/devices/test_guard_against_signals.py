"""Whatever ends a program that plays, its devices fall silent: every family, on devices that
umockdev makes up."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from bounded_program import run as run_bounded
from fake_hid import RELEASE
from haptic_tracing.core.devices.families.family import Interface, RumbleFamily
from haptic_tracing.core.devices.pacing import WATCHDOG
from haptic_tracing.core.devices.profile_files import load_profiles
from made_up_devices import DUALSENSE_USB, GAMEPAD, VENDOR, Fake, describe
from umockdev_scenes import ENDINGS, GROUP_ENDINGS, serial_of

HERE = Path(__file__).parent
PROFILES = load_profiles()[0]
SILENT_WITHIN = 0.150
ON_THE_WAY, REMINDER = 0.050, 0.050
"""Seconds in which an order arrives at the guard, and within which these devices need a report."""
pytestmark = [
    pytest.mark.skipif(
        not sys.platform.startswith("linux"), reason="umockdev and hidraw exist on Linux only"
    ),
    pytest.mark.slow,
]


# Any feature report of 65 bytes is taken; one that is read says that a DualSense's firmware is new
# and that an 8BitDo pad rumbles.
ANSWERS = [
    "HIDIOCSFEATURE 65 " + "00" * 65,
    "HIDIOCGFEATURE 64 " + bytes([0x30, 0, 0, 1]).ljust(64, b"\xff").hex(),
]


def fake_of(name, number):
    """A device of the family, on its slowest transport."""
    family = PROFILES[name].family
    vendor, product = min(family.ids)
    bus = 5 if "bt" in family.transports else 3
    transport = "bt" if bus == 5 else "usb"
    descriptor, number_of_interface = next(
        (descriptor, interface)
        for descriptor, usage in ((GAMEPAD, (0x01, 0x05)), (VENDOR, (0xFF00, 0x01)))
        for interface in (0, 1, 2)
        if family.matches(Interface(b"", vendor, product, "", "", *usage, interface, transport))
    )
    return Fake(
        bus,
        vendor,
        product,
        f"Pad {name}",
        number=number_of_interface,
        serial=serial_of(number),
        descriptor=descriptor,
        features=ANSWERS,
    )


def scene(tmp_path, fakes, *arguments):
    if shutil.which("umockdev-run") is None:
        pytest.fail("umockdev-run is not installed: on Debian and Ubuntu, apt-get install umockdev")
    command = [
        "umockdev-run",
        *describe(tmp_path, fakes),
        "--",
        sys.executable,
        str(HERE / "umockdev_scenes.py"),
        *arguments,
    ]
    done = run_bounded(command)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def is_silent(family, report):
    """Whether a report says zero on every channel."""
    if isinstance(family, RumbleFamily):
        sequences = range(256) if "shield" in family.name else range(16)
        return any(
            report == family.encode(family.silence(), transport, sequence).data
            for transport in family.transports
            for sequence in sequences
        )
    # A stream goes to zero within the first 8 samples of the packet, of 32 pairs or of two times
    # 31.
    return not any(report[29:77] if report[0] == 0x32 else report[10:33] + report[41:])


NAMES = list(PROFILES)


@pytest.mark.parametrize("ending", ENDINGS)
def test_every_family_is_silent_within_150_ms(tmp_path, ending):
    """150 ms of the guard's own: what it waits for a processor that other programs have is not its
    doing."""
    ends(tmp_path, "ends", ending, SILENT_WITHIN)


def ends(tmp_path, name, ending, within):
    """What the scene returns, in which each device has to be silent within so many seconds."""
    folder = tmp_path / "reports"
    folder.mkdir()
    fakes = [fake_of(family, number) for number, family in enumerate(NAMES)]
    written = scene(tmp_path, fakes, name, ending, str(folder), *NAMES)
    found = times_to_silence(written["reports"])
    waited = {
        name: next((wait for at, wait in written["waits"] if at >= seconds), 0.0)
        for name, seconds in found.items()
    }
    print(ending, {name: (round(1000 * found[name]), round(1000 * waited[name])) for name in NAMES})
    late = {
        name: (seconds, waited[name])
        for name, seconds in found.items()
        if seconds - waited[name] > within
    }
    assert late == {}
    assert written["guard ended"] < 5.0
    return written


@pytest.fixture
def control_groups(tmp_path):
    """The control groups (version 2), mounted outside /sys, which umockdev hides."""
    folder = tmp_path / "groups"
    folder.mkdir()
    subprocess.run(["mount", "-t", "cgroup2", "none", str(folder)], check=True, timeout=60)
    yield str(folder)
    subprocess.run(["umount", str(folder)], check=True, timeout=60)


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may mount control groups")
@pytest.mark.parametrize("ending", GROUP_ENDINGS)
def test_every_family_is_silent_when_the_programs_control_group_is_killed_or_frozen(
    tmp_path, ending, control_groups, monkeypatch
):
    """As a session manager or the out-of-memory killer ends one. A frozen program counts as one
    that hangs."""
    monkeypatch.setenv("CONTROL_GROUPS", control_groups)
    written = ends(
        tmp_path, "group_ends", ending, SILENT_WITHIN + (WATCHDOG if ending == "freeze" else 0.0)
    )
    assert written["left"] == []


def times_to_silence(written):
    """Seconds from the end of the program to the zero of each family."""
    found = {}
    for number, name in enumerate(NAMES):
        family = PROFILES[name].family
        reports = [(seconds, bytes.fromhex(data)) for seconds, data in written[f"hidraw{number}"]]
        # Set up, silent, driven, silent.
        silent = [is_silent(family, data) for _, data in reports]
        opened = silent.index(True) if isinstance(family, RumbleFamily) else 0
        driven = silent.index(False, opened)
        assert reports[driven][0] < -0.2, f"{name} is not driven"
        assert True in silent[driven:], f"{name} is not silenced"
        found[name] = reports[silent.index(True, driven)][0]
    return found


@pytest.mark.parametrize(
    "name",
    [
        "dualsense",
        "dualsense-pcm",
        pytest.param("switch-pro", marks=pytest.mark.plugins),
        pytest.param("steam-controller-pcm", marks=pytest.mark.plugins),
    ],
)
def test_pythons_lock_held_for_300_ms_silences_nobody(tmp_path, name):
    """Pads that hold their level, live on samples, or need a reminder every 50 ms.

    A silence is false while there is something to play of what the guard had been told. On a busy
    machine the program itself may be late.
    """
    folder = tmp_path / "reports"
    folder.mkdir()
    played = scene(tmp_path, [fake_of(name, 0)], "lock", name, str(folder))
    family = PROFILES[name].family
    assert played["seconds"] > 1.1
    locked, free = played["lock"]
    reports = [(seconds, bytes.fromhex(data)) for seconds, data in played["reports"]]
    first = next(
        seconds for seconds, data in reports if seconds > 0.0 and not is_silent(family, data)
    )
    assert first < locked
    silences = [
        seconds
        for seconds, data in reports
        if first <= seconds < played["seconds"] and is_silent(family, data)
    ]
    told_until = {
        at: max([until for told, until in played["told"] if told < at - ON_THE_WAY], default=0.0)
        for at in silences
    }
    assert [at for at, until in told_until.items() if at < until] == [], name
    if name != "dualsense":
        meanwhile = sum(locked < seconds < free for seconds, _ in reports)
        assert meanwhile + played["waited"] / REMINDER >= 3, "reports go on meanwhile"


HOLDS = ("dualsense", "stadia", "xbox")
"""Pads that hold their level or go on for a while, and so vibrate on if nobody tells them to
stop."""


@pytest.mark.parametrize("how", ["SIGKILL", "SIGSTOP"])
def test_a_guard_that_dies_or_hangs_is_replaced_and_the_devices_play_again(tmp_path, how):
    """Silent within 1.5 s, and open again within 2 s; but for the time that the machine is busy
    with others."""
    folder = tmp_path / "reports"
    folder.mkdir()
    found = scene(
        tmp_path,
        [fake_of(name, number) for number, name in enumerate(HOLDS)],
        "guard_fails",
        how,
        str(folder),
        *HOLDS,
    )
    print(how, {name: round(found[name], 3) for name in ("said", "quiet", "reopened")})
    for number, name in enumerate(HOLDS):
        family = PROFILES[name].family
        released = {
            r.data.hex()
            for transport in family.transports
            for sequence in range(16)
            for r in family.release(transport, sequence)
        }
        written = [
            (seconds, data)
            for seconds, data in found["reports"][f"hidraw{number}"]
            if data not in released
        ]
        reports = [(seconds, is_silent(family, bytes.fromhex(data))) for seconds, data in written]
        assert not [silent for seconds, silent in reports if seconds < 0.0][-1], f"{name} is driven"
        later = [seconds for seconds, silent in reports if seconds > 0.0 and silent]
        assert later and later[0] < 1.5, f"{name} is silenced"
        assert all(silent for seconds, silent in reports if later[0] <= seconds < found["quiet"]), (
            f"{name} stays silent"
        )
        assert not all(silent for seconds, silent in reports if seconds > found["again"]), (
            f"{name} plays again"
        )
    assert all(
        "guards the devices has ended" in message and "has silenced it" in message
        for message in found["messages"]
    )
    assert all(found["stopped"]) and found["reopened"] < 2.0 and found["guards"] == 0


def test_a_guard_outside_the_programs_tree_is_watched_as_well(tmp_path):
    """The way in which Windows starts it."""
    folder = tmp_path / "reports"
    folder.mkdir()
    assert (
        scene(tmp_path, [DUALSENSE_USB], "launched", "dualsense", str(folder))
        == [False, RELEASE.hex()] * 2
    )


def test_stop_all_with_a_hung_guard_reaches_the_devices(tmp_path):
    folder = tmp_path / "reports"
    folder.mkdir()
    found = scene(tmp_path, [DUALSENSE_USB], "stop_with_a_hung_guard", "dualsense", str(folder))
    assert found["done"] and found["silent"]
    assert bytes.fromhex(found["last"]) == RELEASE
    assert found["seconds"] < 2.0


def test_a_program_that_was_stopped_keeps_its_guard(tmp_path):
    """The program's own pause, or a lock held for long, is no silence of the guard."""
    folder = tmp_path / "reports"
    folder.mkdir()
    found = scene(tmp_path, [DUALSENSE_USB], "program_pauses", "dualsense", str(folder))
    assert found == {"state": "open", "same guard": True}


def test_nothing_is_left_running(tmp_path):
    """Neither a process nor a thread is left behind when the last output has stopped."""
    left = scene(tmp_path, [DUALSENSE_USB], "nothing_left", "dualsense")
    assert left == {"guards": 0, "threads": 1, "opened": True}
