"""A gamepad's event device as the kernel has it: umockdev's node, and an answer to what is asked of
it.

umockdev passes the ioctls and writes of a program on to a socket; whoever serves it stands for the
kernel.
"""

import os
import socket
import statistics
import struct
import threading
import time
from contextlib import suppress
from pathlib import Path

IOCTL, RESULT_DONE, READ_MEMORY, WRITE_MEMORY, WRITE = 1, 3, 5, 6, 8
UPLOAD = 0x40304580  # EVIOCSFF of a 64-bit kernel, as in strace's table
EFFECT_BYTES = 48


def describe_pad(name, vendor, product, number=0, serial="", bus=3, capabilities="107030000 0"):
    """What umockdev is told of a pad: lines for its description. The capabilities are those that
    xpad has."""
    device = f"/devices/virtual/input/input{number}"
    lines = [
        f"P: {device}",
        "E: SUBSYSTEM=input",
        f"A: name={name}",
        f"A: uniq={serial}",
        f"A: capabilities/ff={capabilities}",
    ]
    lines += [
        f"A: id/vendor={vendor:04x}",
        f"A: id/product={product:04x}",
        f"A: id/bustype={bus:04x}",
        "",
    ]
    lines += [
        f"P: {device}/event{number}",
        f"N: input/event{number}",
        "E: SUBSYSTEM=input",
        f"E: DEVNAME=/dev/input/event{number}",
    ]
    return "\n".join([*lines, f"L: device=../../input{number}", ""]) + "\n"


class Kernel:
    """Serves one event device: keeps the effects and when each was started or stopped. Runs inside
    umockdev."""

    def __init__(self, number=0):
        # (strong, weak, milliseconds) by id; (seconds, id, value).
        self.effects, self.events = {}, []
        self.started = []  # strengths of each effect that was started
        path = Path(os.environ["UMOCKDEV_DIR"], "ioctl", "dev", "input", f"event{number}")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.unlink(missing_ok=True)
        self.listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.listener.bind(str(path))
        self.listener.listen()
        threading.Thread(target=self.accept, daemon=True).start()

    @property
    def usual(self):
        """The median strength of each motor. A block that comes late or is lost where the processor
        is busy is a click, which is short."""
        return [statistics.median(motor) for motor in zip(*self.started, strict=True)]

    @property
    def strength(self):
        """What the pad does now: the last effect that was started and neither stopped nor over, or
        erased."""
        if not self.events:
            return 0, 0
        at, effect, value = self.events[-1]
        strong, weak, milliseconds = self.effects.get(effect, (0, 0, 0))
        lasts = value and time.perf_counter() < at + milliseconds / 1000
        return (strong, weak) if lasts else (0, 0)

    def accept(self):
        while True:
            connection, _ = self.listener.accept()
            threading.Thread(target=self.serve, args=(connection,), daemon=True).start()

    def serve(self, connection):
        with connection, suppress(OSError, struct.error):
            while True:
                command, first, second = struct.unpack("QQQ", received(connection, 24))
                if command == IOCTL:
                    # ENOTTY.
                    answer = self.upload(connection, second) if first == UPLOAD else (2**64 - 1, 25)
                else:
                    assert command == WRITE
                    answer = self.play(connection, first, second), 0
                connection.sendall(struct.pack("QQQ", RESULT_DONE, *answer))
        self.effects.clear()  # as when the last program closes the device

    def upload(self, connection, address):
        connection.sendall(struct.pack("QQQ", READ_MEMORY, address, EFFECT_BYTES))
        effect = bytearray(received(connection, EFFECT_BYTES))
        kind, number, _, _, _, length, _, strong, weak = struct.unpack_from("=HhHHHHH2xHH", effect)
        assert kind == 0x50
        if number < 0:
            number = len(self.effects)
            struct.pack_into("=h", effect, 2, number)
        elif number not in self.effects:
            return 2**64 - 1, 22  # EINVAL
        self.effects[number] = strong, weak, length
        connection.sendall(struct.pack("QQQ", WRITE_MEMORY, address, EFFECT_BYTES) + effect)
        return 0, 0

    def play(self, connection, address, count):
        connection.sendall(struct.pack("QQQ", READ_MEMORY, address, count))
        _, _, kind, code, value = struct.unpack("=qqHHi", received(connection, count))
        assert kind == 0x15
        self.events.append((time.perf_counter(), code, value))
        if value:
            self.started.append(self.effects[code][:2])
        return count


def received(connection, count):
    data = b""
    while len(data) < count:
        part = connection.recv(count - len(data))
        if not part:
            raise OSError("closed")
        data += part
    return data
