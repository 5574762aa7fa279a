"""What is written to a device when, in simulated time."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
from haptic_tracing.command_line.devices import rumble_report
from haptic_tracing.core.devices.pacing import pacing_of
from haptic_tracing.core.devices.profile_files import profile
from haptic_tracing.core.devices.profiles import Adjustment

RATE = 8000


def pacing(name, transport, delay=0.0, **changes):
    device = replace(profile(name), **changes)
    return pacing_of(device, device.family, transport, RATE, Adjustment(delay=delay))


def tone(seconds, frequency=200.0, amplitude=0.5, rows=2, start=0.0):
    row = amplitude * np.sin(
        2 * math.pi * frequency * (start + np.arange(round(seconds * RATE)) / RATE)
    )
    return np.tile(row, (rows, 1))


class Simulation:
    """The thread's loop without a thread: asks when it is told to, and never earlier."""

    def __init__(self, paced, start=0.0):
        self.paced, self.now, self.written = paced, start, []

    def run_until(self, end):
        """Ask until ``end``; then stay there."""
        while True:
            report = self.paced.next_report(self.now)
            if report is not None:
                self.written.append((self.now, report.data))
                continue
            due = self.paced.wake(self.now)
            if due is None or due > end:
                self.now = max(self.now, end)
                return self
            # A thread never wakes exactly when it wanted to.
            self.now = max(due, self.now) + 1e-6

    def play(self, block):
        self.paced.accept(block, self.now)
        return self.run_until(self.now + block.shape[1] / RATE)

    @property
    def reports(self):
        return [data for _, data in self.written]


def is_silent(name, transport, data):
    """Whether it is the zero report with any sequence number."""
    return any(
        data == rumble_report(name, 0.0, 0.0, transport, sequence).data for sequence in range(16)
    ) or (name == "shield-2017" and data[4:6] == bytes(2))


def sounded(name, reports):
    if name == "dualsense-pcm":
        packets = [
            np.frombuffer(data, np.int8)[13:77].reshape(-1, 2).T
            for data in reports
            if data[0] == 0x32
        ]
    else:
        packets = [
            np.frombuffer(data, np.int8)[2:].reshape(2, -1) for data in reports if data[0] == 0x88
        ]
    return np.concatenate(packets, axis=1) / 127.0


def longest_pause(name, transport):
    """Longest time in s between two reports of a steady drive."""
    simulation = Simulation(pacing(name, transport)).run_until(1.0)
    start, rows = simulation.now, len(profile(name).actuators)
    for i in range(25):
        simulation.play(tone(0.04, frequency=200.0, start=0.04 * i, rows=rows))
    times = [time for time, _ in simulation.written if time >= start]
    return max(later - earlier for earlier, later in pairwise(times))
