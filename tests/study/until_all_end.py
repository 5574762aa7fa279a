"""Runs a command, and ends when everything that it has started has ended.

umockdev takes its devices away as soon as the program that it was given ends. The guard of a
program that is killed still has to write to them.

Called as ``umockdev-run ... -- python until_all_end.py COMMAND...``.
"""

import ctypes
import os
import subprocess
import sys
from contextlib import suppress

PR_SET_CHILD_SUBREAPER = 36  # as in linux/prctl.h: orphans become children of this process

ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
subprocess.Popen(sys.argv[1:])
with suppress(ChildProcessError):
    while True:
        os.wait()
