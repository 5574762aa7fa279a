"""The console program in a process of its own, with a temporary folder in which it must leave
nothing."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path


def environment(folder):
    """Variables of a process whose temporary files come into ``folder``."""
    return os.environ | {"TMPDIR": str(folder), "TEMP": str(folder)}


def run(*arguments, cwd=None):
    """Run the program to its end."""
    command = [sys.executable, "-m", "haptic_tracing", *map(str, arguments)]
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            command, env=environment(folder), cwd=cwd, capture_output=True, text=True, timeout=300
        )
        assert not any(Path(folder).iterdir())
    return done
