import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from import_graph import Import, imports

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def root() -> Path:
    return ROOT


@pytest.fixture(scope="session")
def manifest(root) -> dict:
    return tomllib.loads((root / "blender_manifest.toml").read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def project(root) -> dict:
    return tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def pins(root) -> dict[str, str]:
    """Version by distribution name."""
    text = (root / "packaging" / "wheels.txt").read_text(encoding="utf-8")
    return dict(re.findall(r"^([\w-]+)==([\w.]+)", text, flags=re.MULTILINE))


@pytest.fixture(scope="session")
def found(root) -> list[Import]:
    """Every import statement of the package."""
    return imports(root)


@pytest.fixture(scope="session")
def zips(root, tmp_path_factory) -> dict[str, Path]:
    """The extension built by Blender's builder from this very tree: zip by platform
    ("linux_x64")."""
    folder = tmp_path_factory.mktemp("dist")
    subprocess.run([sys.executable, root / "packaging" / "build.py", folder], check=True)
    return {path.stem.rpartition("-")[2]: path for path in folder.glob("*.zip")}
