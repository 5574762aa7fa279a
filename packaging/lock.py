"""The exact versions of every package in the environments: packaging/constraints-3.11.txt and
constraints-3.13.txt.

python packaging/lock.py      resolve the newest versions that pyproject.toml allows, for each of
the two Pythons, and write the files

Packages of the extension keep the version in wheels.txt. NumPy is left out: each bpy wheel needs
its own (see make_environment).
"""

import argparse
import json
import re
import subprocess
import tempfile
import tomllib
from itertools import chain
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
NUMPY = {
    "3.11": "numpy<2",
    "3.13": "numpy<3",
}  # what make_environment installs beside the newest bpy for each Python
LEFT_OUT = {"haptic-tracing", "numpy"}


def resolve(python: str, requirements: list[str]) -> dict[str, str]:
    """Version by name of everything that the requirements need, by pip of that interpreter."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([python, "-m", "venv", folder], check=True)
        carried = Path(folder, "carried.txt")
        pins = (ROOT / "packaging" / "wheels.txt").read_text(encoding="utf-8")
        carried.write_text(
            "\n".join(re.findall(r"^[\w-]+==[\w.]+", pins, flags=re.MULTILINE)), encoding="utf-8"
        )
        pip = [
            f"{folder}/bin/python",
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
            "--ignore-installed",
            "--dry-run",
        ]
        answer = subprocess.run(
            [*pip, "--report", "-", "--constraint", carried, *requirements],
            check=True,
            stdout=subprocess.PIPE,
        )
    found = [package["metadata"] for package in json.loads(answer.stdout)["install"]]
    return {
        package["name"]: package["version"] for package in found if package["name"] not in LEFT_OUT
    }


def main() -> None:
    argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    ).parse_args()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    groups = project["optional-dependencies"]
    lint = groups.pop("lint")  # resolved by itself: it has a NumPy of its own
    for version, numpy in NUMPY.items():
        python = subprocess.run(
            [ROOT / "packaging" / "find_python", version], capture_output=True, text=True
        ).stdout.strip()
        if not python:
            raise SystemExit(f"Python {version} (with its venv module) not found")
        versions = resolve(python, lint) | resolve(
            python, [numpy, *project["dependencies"], *chain.from_iterable(groups.values())]
        )
        lines = [f"{name}=={versions[name]}\n" for name in sorted(versions, key=str.lower)]
        path = ROOT / "packaging" / f"constraints-{version}.txt"
        path.write_text("".join(lines), encoding="utf-8")
        print(f"{path.relative_to(ROOT)}: {len(lines)} packages")


if __name__ == "__main__":
    main()
