"""Commands that are ended from outside end as asked, and leave nothing in the temporary folder, as
those that end by themselves (``program.run``)."""

import json
import signal
import subprocess
import sys
from functools import partial

import pytest
from program import environment


def started(folder, *arguments, **more):
    command = [sys.executable, "-m", *map(str, arguments)]
    return subprocess.Popen(
        command,
        env=environment(folder),
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
        **more,
    )


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows ends processes without a signal")
@pytest.mark.parametrize(
    ("sent", "code"), [(signal.SIGTERM, -signal.SIGTERM), (signal.SIGINT, 130)]
)
def test_nothing_is_left_by_a_command_that_a_farm_or_a_user_ends(falling, tmp_path, sent, code):
    out = tmp_path.with_name(f"{tmp_path.name} out")
    # A shell starts what it runs in the background with SIGINT ignored.
    heeded = partial(signal.signal, sent, signal.SIG_DFL)
    process = started(
        tmp_path,
        "haptic_tracing",
        "trace",
        falling / "hammer.blend",
        "--end",
        1_000_000,
        "--out",
        out,
        preexec_fn=heeded,
    )
    while process.stderr.read(1) not in (
        "",
        "%",
    ):  # the bar of progress shows that frames are traced
        pass
    assert any(tmp_path.iterdir())
    process.send_signal(sent)
    try:
        _, errors = process.communicate(timeout=60)
    finally:
        process.kill()
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
