"""A temporary folder for a process and all that it starts, removed when that process ends, in
whatever way.

Blender's preferences and extensions are in it too, so that this machine's own stay out.
"""

import os
import subprocess
import tempfile
from pathlib import Path

MACHINES = tempfile.gettempdir()  # also for what is kept, or shared with other programs
_held = []


def make(anew: bool = False) -> None:
    """Make the folder, before ``bpy`` is imported. Where BLENDER_USER_RESOURCES is set, the process
    that started this one has made it.

    anew: make one all the same, beside that of the process that started this one.
    """
    if "BLENDER_USER_RESOURCES" in os.environ and not anew:
        return
    beside = (
        os.environ["PYTEST_DEBUG_TEMPROOT"] if anew else None
    )  # in that one, names of sockets would become too long
    folder = tempfile.TemporaryDirectory(
        prefix="haptic-tracing-", dir=beside, ignore_cleanup_errors=True
    )
    _held.append(folder)
    Path(folder.name).chmod(0o711)  # programs of other users, too, may be started there
    if os.name == "posix":
        # A process ended by a signal or by os._exit removes nothing itself, but its end closes this
        # pipe.
        command = ["sh", "-c", 'read -r _; rm -rf "$0"', folder.name]
        _held.append(subprocess.Popen(command, stdin=subprocess.PIPE, start_new_session=True))
    resources, temporary = Path(folder.name) / "resources", Path(folder.name) / "temporary"
    resources.mkdir()
    temporary.mkdir()
    os.environ["BLENDER_USER_RESOURCES"] = str(resources)
    os.environ.setdefault(
        "PYTEST_DEBUG_TEMPROOT", MACHINES
    )  # pytest keeps the folders of its last three runs
    os.environ["TMPDIR"] = tempfile.tempdir = str(temporary)
