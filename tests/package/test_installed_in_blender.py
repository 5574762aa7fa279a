import json
import os
import platform
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow  # all read the report of one installation, which takes seconds

HERE = Path(__file__).parent
CARRIED = {"fcl", "python_fcl", "hid", "hidraw", "hidapi", "fastjsonschema", "soxr", "__editable__"}


@pytest.fixture(scope="module")
def blender_only(tmp_path_factory) -> Path:
    """A site folder with everything of this environment except this package and what the extension
    carries."""
    folder = tmp_path_factory.mktemp("site")
    for path in Path(sysconfig.get_path("platlib")).iterdir():
        name = path.name.lower()
        if not name.endswith(".pth") and not any(name.startswith(package) for package in CARRIED):
            (folder / path.name).symlink_to(path)
    return folder


def this_platform() -> str:
    system = {"linux": "linux", "win32": "windows"}.get(sys.platform, "macos")
    return f"{system}_{'arm64' if platform.machine() == 'arm64' else 'x64'}"


@pytest.fixture(scope="module")
def run(zips, blender_only, tmp_path_factory) -> tuple[dict, str, Path]:
    """What the installed extension reported, what Blender printed, and Blender's user folder."""
    resources = tmp_path_factory.mktemp("resources")
    report = resources / "report.json"
    environment = os.environ | {
        "BLENDER_USER_RESOURCES": str(resources),
        "PYTHONPATH": os.pathsep.join([str(HERE), str(blender_only)]),
        "https_proxy": "http://127.0.0.1:9",
        "http_proxy": "http://127.0.0.1:9",
    }
    command = [
        sys.executable,
        "-S",
        str(HERE / "installed_extension.py"),
        str(zips[this_platform()]),
        str(report),
    ]
    answer = subprocess.run(command, env=environment, cwd=resources, capture_output=True, text=True)
    printed = answer.stdout + answer.stderr
    assert answer.returncode == 0, printed
    return json.loads(report.read_text(encoding="utf-8")), printed, resources


def test_installs_offline_and_enables(run):
    found, printed, resources = run
    assert found["install"] == ["FINISHED"]
    assert found["enabled"]
    assert (
        Path(found["module"]).parent == resources / "extensions" / "user_default" / "haptic_tracing"
    )
    assert [
        line
        for line in printed.splitlines()
        if "Error" in line or "Traceback" in line or "Warning" in line
    ] == []


def test_imports_the_wheels_it_carries(run):
    found, _, resources = run
    local = resources / "extensions" / ".local"
    assert [
        name for name, path in found["wheels"].items() if not Path(path).is_relative_to(local)
    ] == []
    assert found["distance"] == pytest.approx(-0.5, abs=1e-12)


def test_plays_the_demo_and_exports_what_the_command_line_finds_again(run):
    demo = run[0]["demo"]
    command = [sys.executable, "-m", "haptic_tracing", "propagate", demo["scene"]]
    answer = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    assert len(demo["gains"]) >= 3
    assert max(pair["gain"] for pair in demo["gains"]) > 0.01
    assert demo["loudest"] > 0
    for found, again in zip(demo["gains"], answer["gains"], strict=True):
        assert (found["source"], found["listener"]) == (again["source"], again["listener"])
        assert again["gain"] == pytest.approx(found["gain"], rel=1e-9)


def test_adds_what_a_designer_uses(run):
    adds = run[0]["adds"]
    assert any(line.startswith("+ frame_change_post") for line in adds["handlers"])
    assert any("HAPTIC_PT_" in line for line in adds["classes"])
    assert any("TOPBAR_MT_file_export" in line for line in adds["menu entries"])
    assert all(line.startswith("+ ") for lines in adds.values() for line in lines)


def test_leaves_nothing_when_disabled(run):
    assert run[0]["left after disabling"] == {}


def test_is_the_same_when_enabled_again(run):
    assert run[0]["changed by enabling again"] == {}


def test_registers_and_unregisters_three_times(run):
    assert run[0]["left after unregistering"] == {}


def test_leaves_no_file_when_uninstalled(run):
    assert run[0]["left after uninstalling"] == {}
    assert run[0]["files left"] == []
