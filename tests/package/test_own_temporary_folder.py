"""What the tests and benchmarks write in the temporary folder is gone when they end, in whatever
way."""

import os
import subprocess
import sys
from pathlib import Path

import own_temporary_folder
import pytest

PROGRAM = """
import os, signal, subprocess, sys, tempfile
import own_temporary_folder
own_temporary_folder.make()
tempfile.mkdtemp()
subprocess.run([sys.executable, "-c", "import os, tempfile; print(tempfile.mkdtemp(), flush=True); os._exit(0)"])
"""


@pytest.mark.parametrize(
    "end",
    [
        "sys.exit()",
        "os._exit(0)",
        "signal.raise_signal(signal.SIGTERM)",
        "signal.raise_signal(signal.SIGKILL)",
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has neither these signals nor sh")
def test_nothing_is_left(tmp_path, end):
    environment = {
        name: value for name, value in os.environ.items() if name != "BLENDER_USER_RESOURCES"
    }
    environment |= {
        "TMPDIR": str(tmp_path),
        "PYTHONPATH": str(Path(own_temporary_folder.__file__).parent),
    }
    # What it prints ends with the last process that may print: that which removes the folder.
    done = subprocess.run(
        [sys.executable, "-S", "-c", PROGRAM + end],
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert done.stdout.startswith(str(tmp_path)) and not any(tmp_path.iterdir())
