"""Programs run with different numbers of threads of the libraries for linear algebra."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path


def printed(code: str, test_file: str, threads: int) -> str:
    """What a program prints, which may import from the folder of ``test_file``, where libraries may
    start so many threads."""
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(Path(test_file).parent), *sys.path]),
        "OPENBLAS_NUM_THREADS": str(threads),
        "OMP_NUM_THREADS": str(threads),
    }
    return subprocess.run(
        [sys.executable, "-c", code], env=environment, check=True, capture_output=True, text=True
    ).stdout
