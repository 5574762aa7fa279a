"""Processor, system and versions of a measurement, without names of the machine."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = ("numpy", "networkx", "scipy", "rustworkx")


def processor() -> str:
    """The model of the processor."""
    file = Path("/proc/cpuinfo")
    if file.exists():
        for line in file.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def installed(package: str) -> str:
    """The version of a package; "none" where it is not installed, as not every benchmark needs
    each."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "none"


def machine() -> dict[str, str | int]:
    """Processor, its cores, system and the versions that matter."""
    return {
        "processor": processor(),
        "cores": os.cpu_count() or 1,
        "system": platform.system(),
        "python": platform.python_version(),
        **{name: installed(name) for name in PACKAGES},
    }


def described() -> str:
    """The description as one line."""
    known = machine()
    packages = ", ".join(f"{name} {known[name]}" for name in PACKAGES)
    return (
        f"{known['processor']}, {known['cores']} cores, {known['system']}; Python "
        f"{known['python']}, {packages}"
    )
