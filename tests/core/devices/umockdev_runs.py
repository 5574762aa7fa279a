"""Commands and scenes with devices that umockdev makes up."""

import json
import shutil
import sys
from pathlib import Path

import pytest
from bounded_program import run as run_bounded
from made_up_devices import describe

HERE = Path(__file__).parent


@pytest.fixture
def under_umockdev(tmp_path):
    """Runs a command with the fakes connected and returns the finished process."""
    if shutil.which("umockdev-run") is None:
        pytest.fail("umockdev-run is not installed: on Debian and Ubuntu, apt-get install umockdev")

    def run(command, *fakes):
        return run_bounded(
            ["umockdev-run", *describe(tmp_path, fakes), "--", sys.executable, *command]
        )

    return run


@pytest.fixture
def scene(under_umockdev):
    """Runs a scene of ``umockdev_scenes.py`` and returns its answer."""

    def run(name, *arguments, fakes):
        done = under_umockdev([str(HERE / "umockdev_scenes.py"), name, *arguments], *fakes)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


def split(captured, length):
    data = bytes.fromhex(captured)
    assert len(data) % length == 0
    return [data[i : i + length].hex() for i in range(0, len(data), length)]
