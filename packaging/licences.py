"""Writes docs/third_party.md: what the extension carries of others, under which licence, and what
it takes: ``python packaging/licences.py``, with the wheels of `wheels.txt` in ``wheels/``."""

import email
import re
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "third_party.md"
CARRIED = {
    "cffi": ("MIT-0", "libffi (MIT)"),
    "fastjsonschema": ("BSD-3-Clause", ""),
    "hidapi": ("BSD-3-Clause, or GPL-3.0", "HIDAPI (BSD-3-Clause), libusb (LGPL-2.1-or-later)"),
    "pycparser": ("BSD-3-Clause", ""),
    "python-fcl": ("BSD-3-Clause", "FCL, OctoMap, libccd (BSD-3-Clause)"),
    "sounddevice": ("MIT", "PortAudio (MIT)"),
    "soxr": ("LGPL-2.1-or-later", "libsoxr (LGPL-2.1-or-later), PFFFT (BSD-like)"),
    "websockets": ("BSD-3-Clause", ""),
}
"""The licence of each package, and the libraries inside it, as its wheel says."""
SYSTEMS = {
    "Windows": "win_amd64",
    "macOS, Intel": "macosx_10|universal2",
    "macOS, Apple silicon": "macosx_11_0_arm64|universal2",
    "Linux": "manylinux",
}


def metadata_of(wheel: Path) -> dict[str, str]:
    """Name, version and home page of a wheel."""
    with zipfile.ZipFile(wheel) as archive:
        name = next(n for n in archive.namelist() if n.endswith(".dist-info/METADATA"))
        found = email.message_from_bytes(archive.read(name))
    links = [link.partition(", ")[2] for link in found.get_all("Project-URL", [])]
    return {
        "name": found["Name"].lower().replace("_", "-"),
        "version": found["Version"],
        "home": found["Home-page"] or (links or [""])[0],
    }


def page() -> str:
    """The text of the page."""
    wheels = sorted((ROOT / "wheels").glob("*.whl"))
    packages = {item["name"]: item for item in map(metadata_of, wheels)}
    if packages.keys() != CARRIED.keys():
        raise ValueError(f"wheels/: {sorted(packages.keys() ^ CARRIED.keys())} differ from CARRIED")
    rows = []
    for name, (licence, inside) in CARRIED.items():
        home, version = packages[name]["home"], packages[name]["version"]
        rows.append(f"| [{name}]({home}) | {version} | {licence} | {inside} |")
    sizes = []
    for system, pattern in SYSTEMS.items():
        own = [w for w in wheels if re.search(rf"({pattern})|-none-any", w.name)]
        total = sum(wheel.stat().st_size for wheel in own) / 1e6
        sizes.append(f"| {system} | {len(own)} | {total:.1f} MB |")
    return "\n".join(
        [
            "# What the extension carries",
            "",
            "Written by `packaging/licences.py` from the wheels. Each wheel holds the text of its "
            "licence; all are compatible with",
            "the GNU General Public License, version 3 or later, of Haptic Tracing itself.",
            "",
            "| package | version | licence | libraries inside |",
            "|---|---|---|---|",
            *rows,
            "",
            "The zip for a system has the wheels for its three Pythons:",
            "",
            "| system | wheels | together |",
            "|---|---:|---:|",
            *sizes,
            "",
        ]
    )


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(f"wrote {PAGE}")
