"""Programs that tests start. Each of them ends, with all that it has started, whatever happens."""

import os
import signal
import subprocess
import sys
import threading
from contextlib import contextmanager, suppress

LIMIT = 300
"""Seconds after which a program is ended: far more than any needs on a slow machine."""


@contextmanager
def bounded(command, seconds=LIMIT, **options):
    """A running program with pipes of text. After ``seconds`` it is killed, so that whoever reads
    from it comes to an end."""
    process = subprocess.Popen(command, start_new_session=True, text=True, **options)
    timer = threading.Timer(seconds, kill, [process])
    timer.daemon = True
    timer.start()
    try:
        yield process
    finally:
        kill(process)
        timer.cancel()
        process.wait(20)
        for pipe in filter(None, (process.stdin, process.stdout, process.stderr)):
            pipe.close()


def run(command, seconds=LIMIT, **options):
    """What a program returns and prints; it fails if it has not ended after ``seconds``."""
    pipe = subprocess.PIPE
    with bounded(command, seconds, stdout=pipe, stderr=pipe, **options) as process:
        out, errors = process.communicate(timeout=seconds + 60)
        code = process.wait(20)
    killed = sys.platform != "win32" and code == -signal.SIGKILL
    assert not killed, f"{command} was killed, after {seconds} s at most: {out} {errors}"
    return subprocess.CompletedProcess(command, code, out, errors)


def line_of(process):
    """The next line that a program prints; it fails if the program ends before."""
    line = process.stdout.readline()
    assert line, f"{process.args} printed nothing more, and has ended with {process.poll()}"
    return line.rstrip("\n")


def kill(process):
    """End a program and its process group."""
    if sys.platform == "win32":
        process.kill()
        return
    process.send_signal(signal.SIGCONT)
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
