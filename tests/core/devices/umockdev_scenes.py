"""What runs inside umockdev: the real ``hidraw`` module on devices that are made up. Prints one
JSON object.

Called as ``umockdev-run ... -- python umockdev_scenes.py SCENE [ARGUMENT ...]``.
"""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from haptic_tracing.command_line.devices import rumble_report
from haptic_tracing.core.devices import guard
from haptic_tracing.core.devices.connection import connected, hid_module, open_device
from haptic_tracing.core.devices.families.registry import family
from haptic_tracing.core.devices.guard import DeviceOutput, stop_all
from haptic_tracing.core.devices.inventory import look
from haptic_tracing.core.devices.profile_files import profile
from haptic_tracing.core.devices.writer import DeviceWriter
from kernel_input import Kernel
from processor_waits import Waits
from timed_hid import TimedHid, reports_of

RATE = 8000
NODE = Path("/dev/hidraw0")
HERE = str(Path(__file__).parent)


class Recorder:
    """hidraw, with a copy of every feature report: umockdev answers them but does not keep them."""

    def __init__(self):
        self.hid, self.features = hid_module(), []
        self.enumerate = self.hid.enumerate

    def device(self):
        recorder, real = self, self.hid.device()

        class Device:
            def __getattr__(self, name):
                return getattr(real, name)

            def send_feature_report(self, data):
                copy = bytes(bytearray(data))
                sent = real.send_feature_report(data)
                recorder.features.append([copy.hex(), sent])
                return sent

        return Device()


def loud(device):
    """The device with ceilings of 0.5 on its first actuator and 0.25 on its second: a loud signal
    then has exact levels."""
    actuators = tuple(
        replace(actuator, safe_maximum=top)
        for actuator, top in zip(device.actuators, (0.5, 0.25), strict=True)
    )
    return replace(device, actuators=actuators)


def play(output, seconds, rows, *frequencies):
    """Blocks in real time, as a timeline at 50 frames per second sends them."""
    count = round(seconds * 50)
    for i in range(count):
        times = (i * 160 + np.arange(160)) / RATE
        output.send(np.tile(sum(np.sin(2 * np.pi * f * times) for f in frequencies), (rows, 1)))
        time.sleep(0.02)


def serial_of(number):
    """The serial number of the device behind ``/dev/hidraw<number>``, where there is one of each
    family."""
    return f"a0:ab:51:00:01:{number:02x}"


def wait_until(condition, seconds=100.0):
    end = time.perf_counter() + seconds
    while not condition():
        if time.perf_counter() > end:
            raise TimeoutError(f"{condition} did not come true")
        time.sleep(0.005)


def status_of(output):
    status = output.status
    return {name: getattr(status, name) for name in status.__slots__}


def scene_list():
    return [
        {
            "title": device.first.title,
            "serial": device.first.serial,
            "transport": device.first.transport,
            "families": [family.name for family in device.families],
            "paths": [interface.path.decode() for interface in device.interfaces],
        }
        for device in connected(hid_module())
    ]


def scene_write(name, transport):
    """The encoders' reports through the real module, and what the node kept of them."""
    opened = open_device(hid_module(), family(name))
    for left, right in ((0.0, 0.0), (0.5, 0.25), (1.0, 1.0)):
        assert opened.hid.write(rumble_report(name, left, right, transport).data) >= 0
    opened.close()
    return NODE.read_bytes().hex()


def scene_play(name, *frequencies):
    recorder = Recorder()
    output = DeviceWriter(loud(profile(name)), hid=recorder)
    output.start()
    wait_until(lambda: output.status.state == "open")
    play(output, 0.6, 2, *map(float, frequencies))
    done = output.stop()
    return {
        "done": done,
        "captured": NODE.read_bytes().hex(),
        "features": recorder.features,
        **status_of(output),
    }


def scene_watchdog(name):
    output = DeviceOutput(loud(profile(name)))
    output.start()
    wait_until(lambda: output.status.state == "open")
    play(output, 0.2, 2, 200.0)
    time.sleep(0.6)
    captured = NODE.read_bytes().hex()
    output.stop()
    return {"captured": captured}


def scene_exit(name):
    """A program that ends without stopping its output."""
    program = f"""
import time, sys
from umockdev_scenes import *
output = DeviceOutput(loud(profile({name!r})))
output.start()
wait_until(lambda: output.status.state == "open")
play(output, 0.2, 2, 200.0)
"""
    done = subprocess.run([sys.executable, "-c", program], cwd=HERE, check=True)
    return {"code": done.returncode, "captured": NODE.read_bytes().hex()}


ENDINGS = ("SIGKILL", "SIGTERM", "SIGHUP", "SIGSEGV", "SIGSTOP", "exit", "process group")
GROUP_ENDINGS = ("kill", "freeze")


def scene_ends(ending, folder, *names, group=None):
    """A program that plays on devices and ends in the middle of it: what was written to each node,
    with seconds after that, how long what has to silence the devices had waited for a processor by
    then, and when the guard ended.

    ending: a signal, ``exit``, ``process group`` (SIGKILL to all of it), or what is done to the
    control ``group`` of the program.
    """
    program = f"""
import sys; sys.path[0] = {HERE!r}
from umockdev_scenes import *
if {str(group or "")!r}: Path({str(group)!r}, "cgroup.procs").write_text(str(os.getpid()))
devices = [replace(profile(name), slew=10_000.0) for name in {names!r}]
outputs = [DeviceOutput(device, serial=serial_of(i), hid=TimedHid({folder!r})) for i, device in enumerate(devices)]
for output in outputs: output.start()
wait_until(lambda: all(output.status.state == "open" for output in outputs), 10.0)
for i in range(100):
    wave = 0.5 * np.sin(2 * np.pi * 200.0 * (i * 320 + np.arange(4000)) / RATE)
    for output in outputs:
        rows = len(output.profile.actuators)
        output.send(np.tile(wave[:320], (rows, 1)), sent := time.perf_counter())
        output.expect(np.tile(wave[320:], (rows, 1)), sent)
    if i == 10: print(flush=True)
    time.sleep(0.04)
    if i == 12 and {ending!r} == "exit": os._exit(3)
"""
    child = subprocess.Popen(
        [sys.executable, "-c", program],
        cwd=HERE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    child.stdout.readline()
    (guard,) = children(child.pid)
    time.sleep(0.09)
    if group is not None:
        (group / f"cgroup.{ending}").write_text("1")
    elif ending == "process group":
        os.killpg(child.pid, signal.SIGKILL)
    elif ending != "exit":
        child.send_signal(signal.Signals[ending])
    while (
        ending != "freeze" and state_of(child.pid) not in "TZX"
    ):  # a busy machine may let it run on for a while
        pass
    ended = time.perf_counter()
    # The guard's thread that watches the program wakes a device's thread; umockdev answers what is
    # no write to a node.
    chains, waits = Waits({guard: 2, os.getppid(): 1}), []
    while time.perf_counter() < ended + (1.0 if ending == "freeze" else 0.6):
        time.sleep(0.01)
        waits.append((time.perf_counter() - ended, chains.until_now()))
    nodes = sorted(path.name for path in Path(folder).iterdir())
    reports = {
        node: [(seconds - ended, data.hex()) for seconds, data in reports_of(folder, node)]
        for node in nodes
    }
    child.kill()
    if ending == "freeze":
        (group / "cgroup.freeze").write_text("0")
    child.wait()
    wait_until(lambda: state_of(guard) in "ZX")
    return {"reports": reports, "waits": waits, "guard ended": time.perf_counter() - ended}


def scene_group_ends(ending, folder, *names):
    """What `scene_ends` returns for a program in a control group of its own, and what is left of
    the guard's."""
    around = Path(os.environ["CONTROL_GROUPS"])
    group = around / f"program-{os.getpid()}"
    group.mkdir()
    try:
        found = scene_ends(ending, folder, *names, group=group)
        wait_until(lambda: (group / "cgroup.procs").read_text() == "")
    finally:
        group.rmdir()
    return {**found, "left": [path.name for path in around.rglob("haptic-tracing-guard-*")]}


def state_of(process):
    """The letter that the kernel gives to a process: T stopped, Z ended, X gone."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return "X"


def scene_lock(name, folder):
    """A program that plays, and holds Python's lock for 300 ms in the middle of it, as a heavy
    operator does.

    told: when the guard had been told of samples, and until when they last. waited: for a processor
    while the lock was held.
    """
    import ctypes

    output = DeviceOutput(replace(profile(name), slew=10_000.0), hid=TimedHid(folder))
    output.start()
    wait_until(lambda: output.status.state == "open")
    wave = np.tile(
        0.5 * np.sin(2 * np.pi * 200.0 * np.arange(4000) / RATE), (len(output.profile.actuators), 1)
    )
    (guard,) = children()
    told = []
    began = time.perf_counter()
    for i in range(20):
        output.send(wave[:, :320], sent := time.perf_counter())
        told.append((time.perf_counter() - began, sent + 0.04 - began))
        output.expect(wave[:, 320:], sent)
        told.append((time.perf_counter() - began, sent + 0.5 - began))
        if i == 10:
            waits = Waits({guard: 1})
            locked = time.perf_counter()
            ctypes.PyDLL(None).usleep(300_000)
            free = time.perf_counter()
            waited = waits.until_now()
        time.sleep(0.04)
    ended = time.perf_counter()
    output.stop()
    return {
        "seconds": ended - began,
        "lock": [locked - began, free - began],
        "told": told,
        "waited": waited,
        "reports": [(at - began, data.hex()) for at, data in reports_of(folder, "hidraw0")],
    }


def scene_guard_fails(how, folder, *names):
    """The guard itself is killed or stopped while it plays; then the devices are connected again
    and play.

    Returns seconds since then: of the reports, of the statuses, and of connecting again.
    """
    devices = [replace(profile(name), slew=10_000.0) for name in names]

    def started():
        outputs = [
            DeviceOutput(device, serial=serial_of(i), hid=TimedHid(folder))
            for i, device in enumerate(devices)
        ]
        for output in outputs:
            output.start()
        return outputs

    def play_all(outputs):
        for _ in range(20):
            for output in outputs:
                output.send(
                    np.tile(
                        0.5 * np.sin(2 * np.pi * 200.0 * np.arange(320) / RATE),
                        (len(output.profile.actuators), 1),
                    )
                )
            time.sleep(0.02)

    outputs = started()
    wait_until(lambda: all(output.status.state == "open" for output in outputs))
    (guard,) = children()
    play_all(outputs)
    failed = time.perf_counter()
    os.kill(guard, signal.Signals[how])
    wait_until(lambda: any(output.status.state == "failed" for output in outputs))
    said = time.perf_counter()
    wait_until(lambda: all(output.is_silent for output in outputs))
    quiet, messages = time.perf_counter(), [output.status.message for output in outputs]
    stopped = [output.stop() for output in outputs]
    again = started()
    begun = time.perf_counter()
    wait_until(lambda: all(output.status.state == "open" for output in again))
    reopened = time.perf_counter()
    play_all(again)
    stop_all()
    reports = {f"hidraw{i}": reports_of(folder, f"hidraw{i}") for i in range(len(names))}
    return {
        "said": said - failed,
        "quiet": quiet - failed,
        "again": begun - failed,
        "reopened": reopened - begun,
        "messages": messages,
        "stopped": stopped,
        "guards": len(children()),
        "reports": {
            node: [(seconds - failed, data.hex()) for seconds, data in written]
            for node, written in reports.items()
        },
    }


def scene_stop_with_a_hung_guard(name, folder):
    """The guard hangs when all output is to be stopped."""
    output = DeviceOutput(replace(profile(name), slew=10_000.0), hid=TimedHid(folder))
    output.start()
    wait_until(lambda: output.status.state == "open")
    play(output, 0.3, len(output.profile.actuators), 200.0)
    (guard,) = children()
    os.kill(guard, signal.SIGSTOP)
    begun = time.perf_counter()
    done = stop_all(10.0)
    seconds, last = time.perf_counter() - begun, reports_of(folder, NODE.name)[-1][1]
    return {"done": done, "silent": output.is_silent, "seconds": seconds, "last": last.hex()}


def scene_launched(name, folder):
    """A guard that is started as on Windows: killed, then stopped, and what is left at the end."""
    guard._state.start = partial(guard.start_process, by_launcher=True)

    def fails(failure):
        output = DeviceOutput(replace(profile(name), slew=10_000.0), hid=TimedHid(folder))
        output.start()
        wait_until(lambda: output.status.state == "open" and len(guards()) == 1)
        (process,) = guards()
        play(output, 0.3, 2, 200.0)
        is_child = process in children()
        os.kill(process, failure)
        wait_until(lambda: output.is_silent)
        return [is_child, reports_of(folder, NODE.name)[-1][1].hex()]

    found = [*fails(signal.SIGKILL), *fails(signal.SIGSTOP)]
    stop_all()
    wait_until(lambda: not guards())
    return found


def guards():
    """The guards of this process, wherever they are."""
    return [
        int(path.name)
        for path in Path("/proc").iterdir()
        if path.name.isdigit()
        and "guard_process" in command_of(path)
        and f"{os.getpid()}]" in command_of(path)
    ]


def command_of(process):
    try:
        return (process / "cmdline").read_text()
    except OSError:
        return ""


def scene_program_pauses(name, folder):
    """A program that is stopped for 2 s, and then holds Python's lock for 2 s."""
    program = f"""
import sys; sys.path[0] = {HERE!r}
from umockdev_scenes import *
import ctypes
output = DeviceOutput(profile({name!r}), hid=TimedHid({folder!r}))
output.start()
wait_until(lambda: output.status.state == "open")
play(output, 0.2, 2, 200.0)
before = children()
print(flush=True)
time.sleep(0.5)
ctypes.PyDLL(None).usleep(900_000)
ctypes.PyDLL(None).usleep(900_000)
time.sleep(1.0)
print(json.dumps({{"state": output.status.state, "same guard": children() == before}}), flush=True)
"""
    child = subprocess.Popen(
        [sys.executable, "-c", program], cwd=HERE, stdout=subprocess.PIPE, text=True
    )
    child.stdout.readline()
    child.send_signal(signal.SIGSTOP)
    time.sleep(2.0)
    child.send_signal(signal.SIGCONT)
    found = json.loads(child.stdout.readline())
    child.wait()
    return found


def scene_nothing_left(name):
    """What runs when the last output has stopped."""
    output = DeviceOutput(profile(name))
    output.start()
    wait_until(lambda: output.status.state == "open")
    opened = len(children()) == 1
    stop_all()
    return {"guards": len(children()), "threads": threading.active_count(), "opened": opened}


def children(parent=None):
    """The processes that this one, or another, has started."""
    parent = parent or os.getpid()
    return [
        int(path.name)
        for path in Path("/proc").iterdir()
        if path.name.isdigit() and parent_of(path) == parent
    ]


def parent_of(process):
    try:
        return int((process / "stat").read_text().rpartition(")")[2].split()[1])
    except OSError:
        return None


def scene_stuck(name):
    """A device that takes no more reports: a terminal that nobody reads, whose buffer fills up. The
    program ends while a write blocks."""
    program = f"""
from umockdev_scenes import *
output = DeviceOutput(profile({name!r}))
output.start()
wait_until(lambda: output.status.state == "open")
# Every step of noise has another level, so that every one is a report.
noise = np.random.default_rng(1)
wait_until(lambda: (output.send(noise.normal(0.0, 0.2, (2, 400))), time.sleep(0.05), output.status.writing_for > 0.3)[-1])
print(json.dumps([output.stop(0.1), output.status.state, output.status.writing_for]))
"""
    done = subprocess.run([sys.executable, "-c", program], cwd=HERE, capture_output=True, text=True)
    return {"code": done.returncode, "errors": done.stderr, "stopped": json.loads(done.stdout)}


def scene_unplug(name):
    """The kernel takes the open node away while it is played: the module's own write fails until
    the device is opened again."""
    output = DeviceWriter(loud(profile(name)))
    output.start()
    wait_until(lambda: output.status.state == "open")
    play(output, 0.2, 2, 200.0)
    for link in Path("/proc/self/fd").iterdir():
        # The listing's own descriptor is gone by now.
        if link.exists() and str(link.readlink()).endswith("dev/hidraw0"):
            os.close(int(link.name))
    # Only a change is written, so only a change shows that the device is gone.
    wait_until(
        lambda: (
            play(output, 0.02, 2, 200.0),
            output.silence(),
            time.sleep(0.02),
            output.status.losses == 1,
        )[-1]
    )
    lost = status_of(output)
    wait_until(lambda: output.status.state == "open")
    play(output, 0.2, 2, 200.0)
    after = status_of(output)
    return {
        "lost": lost,
        "after": after,
        "done": output.stop(),
        "captured": NODE.read_bytes().hex(),
    }


def become_nobody():
    """Only the permission of the nodes counts from here on."""
    if os.geteuid() == 0:
        # umockdev's folder and sockets are made for its user alone.
        Path(os.environ["UMOCKDEV_DIR"]).chmod(0o755)
        for path in Path(os.environ["UMOCKDEV_DIR"], "ioctl", "dev").rglob("*"):
            path.chmod(0o777)
        os.setgroups([])
        os.setresgid(65534, 65534, 65534)
        os.setresuid(65534, 65534, 65534)


def scene_no_permission(name):
    """The node belongs to root and this user is somebody else."""
    NODE.chmod(0)
    become_nobody()
    try:
        open_device(hid_module(), family(name))
    except OSError as error:
        return {"error": str(error)}
    return {"error": None}


def scene_force_feedback(ending):
    """A pad that the kernel drives, while it can't be opened as a HID device: found, played,
    paused, and after the program has ended."""
    kernel = Kernel()
    Path(os.environ["UMOCKDEV_DIR"], "dev", "hidraw0").unlink(
        missing_ok=True
    )  # as a sandbox hides it
    found = look()
    program = f"""
import sys; sys.path[0] = {HERE!r}
from umockdev_scenes import *
from haptic_tracing.core.devices.profiles import Adjustment
(found,) = [device for device in look().devices if not device.permission]
output = found.open(Adjustment())
output.start()
wait_until(lambda: output.status.state == "open", 10.0)
play(output, 0.5, 1, 60.0)
print("plays", flush=True)
if {ending!r} == "rest": output.rest()
if {ending!r} == "stop": output.stop()
play(output, 30.0 if {ending!r} == "kill" else 0.0, 1, 60.0)
time.sleep(60.0)
"""
    child = subprocess.Popen(
        [sys.executable, "-c", program], cwd=HERE, stdout=subprocess.PIPE, text=True
    )
    assert child.stdout.readline() == "plays\n"
    (guard,) = children(child.pid)
    waits = Waits({guard: 2, child.pid: 2})
    if ending == "kill":
        child.kill()
    begun = time.perf_counter()
    wait_until(lambda: kernel.strength == (0, 0), 5.0)
    silent, waited = time.perf_counter() - begun, waits.until_now()
    wait_until(lambda: ending == "rest" or not kernel.effects, 5.0)
    effects = dict(kernel.effects)
    child.kill()
    child.wait()
    keys = [[device.key, device.title, device.kind, device.permission] for device in found.devices]
    return {
        "found": keys,
        "strangers": found.strangers,
        "usual": kernel.usual,
        "silent": silent,
        "waited": waited,
        "effects": len(effects),
    }


if __name__ == "__main__":
    # Standard output is for the answer alone.
    print(json.dumps(globals()[f"scene_{sys.argv[1]}"](*sys.argv[2:])))
