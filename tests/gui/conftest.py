"""The window tests need a Blender with a window: BLENDER, the path of one, or REAL_BLENDER, a
program that runs one on a virtual screen (called as `REAL_BLENDER gui ARGUMENTS` and `REAL_BLENDER
run ARGUMENTS`, sharing the folder REAL_BLENDER_FOLDER with it)."""

import json
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from own_temporary_folder import MACHINES

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).parent
BLENDER = os.environ.get("BLENDER")
REAL_BLENDER = os.environ.get("REAL_BLENDER")
SIZE = (1600, 1000)
SECONDS = 300

collect_ignore = [
    *([] if BLENDER or REAL_BLENDER else ["test_in_blenders_window.py"]),
    *([] if REAL_BLENDER else ["test_in_vr.py"]),
    *([] if os.environ.get("GODOT") else ["test_in_godot.py"]),
]


def commands() -> tuple[list[str], list[str]]:
    """How Blender is started in the background, and in a window."""
    if REAL_BLENDER:
        return [REAL_BLENDER, "run", "--background"], [REAL_BLENDER, "gui"]
    screen = []
    if (
        sys.platform == "linux"
        and not os.environ.get("DISPLAY")
        and not os.environ.get("WAYLAND_DISPLAY")
    ):
        if shutil.which("xvfb-run") is None:
            raise pytest.UsageError(
                "there is no display, and no xvfb-run to make one: install xvfb"
            )
        screen = [
            "xvfb-run",
            "--auto-servernum",
            "--server-args",
            "-screen 0 {}x{}x24".format(*SIZE),
        ]
    return [BLENDER, "--background"], [
        *screen,
        BLENDER,
        "--window-geometry",
        "0",
        "0",
        *map(str, SIZE),
    ]


@pytest.fixture(scope="session")
def folder():
    """A folder that this program and Blender both see under the same path."""
    shared = (
        os.environ.get("REAL_BLENDER_FOLDER", str(Path(MACHINES) / "real-blender-io"))
        if REAL_BLENDER
        else None
    )
    with tempfile.TemporaryDirectory(dir=shared, prefix="haptic-tracing-") as name:
        yield Path(name)


@pytest.fixture(scope="session")
def environment(folder) -> dict[str, str]:
    resources = folder / "resources"
    (resources / "config").mkdir(parents=True)  # Blender uses only folders that are there
    return os.environ | {
        "BLENDER_USER_RESOURCES": str(resources),
        "LIBGL_ALWAYS_SOFTWARE": "1",
        "LIMIT": str(SECONDS),
    }


@pytest.fixture(scope="session")
def installed(folder, environment) -> str:
    """The extension built and installed from its zip, no splash screen; what Blender printed on the
    way."""
    subprocess.run(
        [sys.executable, ROOT / "packaging" / "build.py", folder / "dist"],
        check=True,
        stdout=subprocess.PIPE,
    )
    system = {"linux": "linux", "win32": "windows"}.get(sys.platform, "macos")
    (package,) = (folder / "dist").glob(
        f"*-{system}_{'arm64' if platform.machine() == 'arm64' else 'x64'}.zip"
    )
    background, _ = commands()
    quiet = (
        "import bpy; p = bpy.context.preferences; p.view.show_splash = "
        "p.use_preferences_save = False; bpy.ops.wm.save_userpref()"
    )
    printed = ""
    validate, install = (
        ["validate", str(package)],
        ["install-file", "-r", "user_default", "-e", str(package)],
    )
    for arguments in (
        ["--python-expr", quiet],
        ["--command", "extension", *validate],
        ["--command", "extension", *install],
    ):
        answer = subprocess.run(
            [*background, *arguments],
            env=environment,
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=SECONDS,
        )
        printed += answer.stdout + answer.stderr
        assert answer.returncode == 0, printed
    return printed


@pytest.fixture
def play(folder, environment, installed):
    """Plays a scenario; returns its report and what Blender printed. The pictures are kept in
    out/gui/SCENARIO."""

    def play(scenario: Path, mode: str = "gui") -> tuple[dict, str]:
        stage = folder / scenario.stem
        stage.mkdir()
        for source in (
            HERE / "window.py",
            HERE / "vr_stage.py",
            HERE.parent / "package" / "registered.py",
            HERE.parent / "references" / "recording_layout.py",
            ROOT / "docs" / "tutorial.md",
            scenario,
        ):
            shutil.copy(source, stage)
        _, window = commands()
        command = [
            *(window if mode == "gui" else [REAL_BLENDER, mode]),
            "--enable-event-simulate",
            "--python",
            str(stage / "window.py"),
            "--",
            str(stage / scenario.name),
            str(stage),
        ]
        answer = subprocess.run(
            command,
            env=environment | ({"TMPDIR": "/tmp"} if mode == "vr" else {}),
            cwd=stage,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=SECONDS + 60,
        )
        printed = answer.stdout + answer.stderr
        pictures = ROOT / "out" / "gui" / scenario.stem
        pictures.mkdir(parents=True, exist_ok=True)
        for path in stage.glob("*.png"):
            shutil.copy(path, pictures)
        assert (stage / "report.json").is_file(), f"Blender ended without a report:\n{printed}"
        return json.loads((stage / "report.json").read_text(encoding="utf-8")), printed

    return play
