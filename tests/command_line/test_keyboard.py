"""Keys of the terminal: a program that is ended leaves the terminal as it was."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from time import monotonic, sleep

import pytest

termios = pytest.importorskip("termios", reason="Windows has no such terminals")

PROGRAM = """
import time
from haptic_tracing.command_line.keyboard import pressed_keys
from haptic_tracing.command_line.standard_streams import leave_in_order_when_ended
leave_in_order_when_ended()
with pressed_keys():
    time.sleep(60)
"""


def echoes(terminal):
    return bool(termios.tcgetattr(terminal)[3] & termios.ECHO)


def test_a_terminal_shows_what_is_typed_again_after_the_program_is_ended():
    keyboard, terminal = os.openpty()
    assert echoes(terminal)
    with subprocess.Popen([sys.executable, "-c", PROGRAM], stdin=terminal) as program:
        until = monotonic() + 60
        while echoes(terminal) and program.poll() is None and monotonic() < until:
            sleep(0.02)
        assert not echoes(terminal)
        program.send_signal(signal.SIGTERM)
        assert program.wait(60) == 128 + signal.SIGTERM
    assert echoes(terminal)
    os.close(keyboard)
    os.close(terminal)
