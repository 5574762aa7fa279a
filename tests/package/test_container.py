"""The container file: what it starts serves, and its check of health tells whether it does."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def commands():
    """The commands of the container file by keyword."""
    text = (ROOT / "packaging" / "Containerfile").read_text()
    return {
        keyword: json.loads(command)
        for keyword, command in re.findall(r"^(ENTRYPOINT|HEALTHCHECK CMD) (\[.*\])$", text, re.M)
    }


@pytest.mark.slow
def test_what_the_container_starts_is_healthy_until_it_ends():
    program, *arguments = commands()["ENTRYPOINT"]
    assert program == "haptic-tracing"
    _, *check = commands()["HEALTHCHECK CMD"]
    server = subprocess.Popen(
        [
            *(sys.executable, "-m", "haptic_tracing", *arguments),
            *("--listen", "0.0.0.0:0", "--token", "secret"),
        ],
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        port = re.search(r"ws://0\.0\.0\.0:(\d+),", server.stderr.readline())[1]
        check = [sys.executable, *(word.replace(":7710/", f":{port}/") for word in check)]
        assert subprocess.run(check, timeout=60).returncode == 0
    finally:
        server.terminate()
        server.wait(20)
        server.stderr.close()
    assert subprocess.run(check, timeout=60, capture_output=True).returncode != 0
