"""Commands that are ended from outside end as asked, and leave nothing in the temporary folder, as
those that end by themselves (``program.run``)."""

import json
import os
import select
import signal
import subprocess
import sys
import time
from functools import partial

import pytest
from program import environment

WITHIN = 120.0
"""Seconds in which a command has traced its first frame."""


def started(folder, *arguments, stderr=subprocess.PIPE, **more):
    command = [sys.executable, "-m", *map(str, arguments)]
    return subprocess.Popen(
        command,
        env=environment(folder),
        stderr=stderr,
        stdout=subprocess.DEVNULL,
        text=True,
        **more,
    )


def read_until_a_bar(terminal):
    """What a command writes on the terminal until its bar of progress shows a frame: in a log there
    is none."""
    shown, end = b"", time.monotonic() + WITHIN
    while b"frame/s" not in shown and b"s/frame" not in shown:
        readable, _, _ = select.select([terminal], [], [], max(0.0, end - time.monotonic()))
        assert readable, f"no bar within {WITHIN} s, but {shown!r}"
        shown += os.read(terminal, 4096)


def read_to_the_end(terminal):
    """The rest of what was written on the terminal."""
    shown = b""
    while select.select([terminal], [], [], 0.0)[0]:
        try:
            shown += os.read(terminal, 4096)
        except OSError:  # the other side is closed
            break
    return shown.decode(errors="replace")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows ends processes without a signal")
@pytest.mark.parametrize(
    ("sent", "code"), [(signal.SIGTERM, -signal.SIGTERM), (signal.SIGINT, 130)]
)
def test_nothing_is_left_by_a_command_that_a_farm_or_a_user_ends(falling, tmp_path, sent, code):
    out = tmp_path.with_name(f"{tmp_path.name} out")
    # A shell starts what it runs in the background with SIGINT ignored.
    heeded = partial(signal.signal, sent, signal.SIG_DFL)
    import termios  # not on Windows

    terminal, its_side = os.openpty()
    termios.tcsetwinsize(its_side, (24, 80))
    process = started(
        tmp_path,
        "haptic_tracing",
        "trace",
        falling / "hammer.blend",
        "--end",
        1_000_000,
        "--out",
        out,
        stderr=its_side,
        preexec_fn=heeded,
    )
    try:
        os.close(its_side)
        read_until_a_bar(terminal)
        assert any(tmp_path.iterdir())
        process.send_signal(sent)
        process.wait(timeout=60)
        errors = read_to_the_end(terminal)
    finally:
        process.kill()
        os.close(terminal)
    assert process.returncode == code
    assert "Nothing is tagged" not in errors, (
        "what an interrupted frame lacks is no mistake of the file"
    )
    assert not any(tmp_path.iterdir())


@pytest.mark.slow
def test_nothing_is_left_by_a_variant_of_a_sweep_that_went_away(tmp_path):
    process = started(tmp_path, "haptic_tracing.command_line.sweep.task", stdin=subprocess.PIPE)
    process.stdin.write(json.dumps({}) + "\n")
    process.communicate(timeout=120)
    assert process.returncode == 1
    assert not any(tmp_path.iterdir())
