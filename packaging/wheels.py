"""The extension's wheels, for the Python versions and platforms of all supported Blenders.

python packaging/wheels.py                    fetch the wheels that the manifest lists into
                                              wheels/, each checked against its pinned hash
python packaging/wheels.py --pin A==1 B==2    write these versions to wheels.txt, and the
                                              wheels found for them to the manifest
"""

import argparse
import hashlib
import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MANIFEST = ROOT / "blender_manifest.toml"
PINS = ROOT / "packaging" / "wheels.txt"
FOLDER = ROOT / "wheels"

PYTHONS = ("3.11", "3.13", "3.14")
# The newest platform tags that the oldest supported Blender still runs on; pip adds older macOS
# releases by itself.
PLATFORM_TAGS = {
    "windows-x64": ("win_amd64",),
    "macos-x64": ("macosx_11_0_x86_64",),
    "macos-arm64": ("macosx_11_0_arm64",),
    "linux-x64": (
        "manylinux_2_28_x86_64",
        "manylinux_2_24_x86_64",
        "manylinux_2_17_x86_64",
        "manylinux2014_x86_64",
    ),
}


def listed_wheels() -> list[str]:
    """File names of the wheels in the manifest, in its order."""
    manifest = tomllib.loads(MANIFEST.read_text(encoding="utf-8"))
    return [Path(wheel).name for wheel in manifest["wheels"]]


def pinned_hashes() -> set[str]:
    return set(re.findall(r"--hash=sha256:([0-9a-f]{64})", PINS.read_text(encoding="utf-8")))


def sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def missing_wheels() -> list[str]:
    """Listed wheels that are not in wheels/ or are not the pinned file."""
    hashes = pinned_hashes()
    return [
        name
        for name in listed_wheels()
        if not (FOLDER / name).is_file() or sha256(FOLDER / name) not in hashes
    ]


def download(folder: Path, *wanted: str) -> list[str]:
    """Download `wanted` (pip's arguments) for every target into `folder`; returns what pip said
    where it found no wheel."""
    failures = []
    for python in PYTHONS:
        for platform, tags in PLATFORM_TAGS.items():
            print(f"wheels for Python {python} on {platform}", flush=True)
            command = [
                sys.executable,
                "-m",
                "pip",
                "download",
                "-qq",
                "--disable-pip-version-check",
                "--no-deps",
                "--only-binary",
                ":all:",
            ]
            command += ["--python-version", python, "--dest", str(folder)]
            command += [part for tag in tags for part in ("--platform", tag)]
            answer = subprocess.run([*command, *wanted], capture_output=True, text=True)
            if answer.returncode:
                reason = answer.stderr.strip().splitlines()[-1:] or ["pip failed"]
                failures.append(f"Python {python} on {platform}: {reason[0]}")
    return failures


def fetch() -> list[str]:
    """Bring wheels/ up to the manifest. Returns one line for each problem."""
    if not missing_wheels():
        return []
    failures = download(FOLDER, "--require-hashes", "--requirement", str(PINS))
    return failures + [
        f"{name} is not what the manifest and {PINS.name} name" for name in missing_wheels()
    ]


def pin(requirements: list[str]) -> list[str]:
    """Rewrite wheels.txt and the manifest's list for `requirements` ("name==version"). Returns the
    targets without a wheel."""
    with tempfile.TemporaryDirectory() as folder:
        failures = [
            line for requirement in requirements for line in download(Path(folder), requirement)
        ]
        found = sorted(Path(folder).glob("*.whl"))
        lines = []
        for requirement in sorted(requirements):
            distribution = requirement.replace("-", "_").replace("==", "-")
            hashes = sorted(
                sha256(path) for path in found if path.name.startswith(f"{distribution}-")
            )
            lines.append(
                " \\\n".join([requirement, *(f"    --hash=sha256:{value}" for value in hashes)])
            )
    PINS.write_text("\n".join(lines) + "\n", encoding="utf-8")
    listing = "".join(f'    "./wheels/{path.name}",\n' for path in found)
    text = MANIFEST.read_text(encoding="utf-8")
    MANIFEST.write_text(
        re.sub(r"(?ms)^wheels = \[\n.*?^\]", lambda _: f"wheels = [\n{listing}]", text),
        encoding="utf-8",
    )
    return failures


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--pin", nargs="+", metavar="NAME==VERSION")
    arguments = parser.parse_args()
    problems = pin(arguments.pin) if arguments.pin else fetch()
    print(*problems, sep="\n", end="\n" if problems else "", file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
