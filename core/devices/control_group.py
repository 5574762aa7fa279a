"""The guard's own control group (cgroup v2, Linux): what kills or freezes the program's group then
leaves the guard to silence the devices.

A group that contains the one in which the guard finds a place still ends both: a container, a
user's whole session.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_NAME = "haptic-tracing-guard-"


@contextmanager
def own_control_group() -> Iterator[None]:
    """Move this process to a group of its own, as far up as the user may, and back at the end; does
    nothing where the user may not."""
    before = current_group()
    own = before and _moved(before)
    try:
        yield
    finally:
        if before and own:
            # The group from before is gone: whoever comes next removes this one.
            with suppress(OSError):
                _join(before)
            _remove(own)


def current_group() -> Path | None:
    """The folder of this process's control group; None without cgroup v2, or in its root, which
    nothing kills."""
    try:
        mounts = [line.split() for line in Path("/proc/self/mountinfo").read_text().splitlines()]
        groups = Path("/proc/self/cgroup").read_text().splitlines()
    except OSError:
        return None
    path = next((line.removeprefix("0::/") for line in groups if line.startswith("0::/")), "")
    folders = [
        Path(fields[4], path) for fields in mounts if "cgroup2" in fields[fields.index("-") :]
    ]
    return (
        next((folder for folder in folders if folder.is_dir()), None)
        if path and ".." not in path
        else None
    )


def _moved(group: Path) -> Path | None:
    """Move this process into a new control group, within the outermost of the groups that contain
    ``group`` and permit it. Returns the new group, None where none permits it."""
    around = [parent for parent in group.parents if (parent / "cgroup.procs").exists()]
    for parent in reversed(around):
        for left_behind in parent.glob(f"{_NAME}*"):
            _remove(left_behind)
        own = parent / f"{_NAME}{os.getpid()}"
        with suppress(OSError):
            own.mkdir()
            try:
                _join(own)
            except OSError:
                own.rmdir()
                raise
            return own
    return None


def _join(group: Path) -> None:
    (group / "cgroup.procs").write_text(str(os.getpid()))


def _remove(group: Path) -> None:
    with suppress(OSError):  # a guard is in it
        group.rmdir()
