"""Draws the tutorial's pictures: ``REAL_BLENDER=... python docs/pictures/tutorial/draw_tutorial.py
[FOLDER]``.

Builds the extension, installs it in Blender, goes through the steps in Blender's own window and
photographs it. Blender is started as for the tests of `tests/gui`: as ``REAL_BLENDER gui
ARGUMENTS`` and ``REAL_BLENDER run ARGUMENTS``, which share a folder with this program.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

HERE = Path(__file__).parent
ROOT = HERE.parents[2]
WHOLE = ("objects", "physics", "failure")
"""Pictures of the whole window; the others are of the viewport."""


def main() -> None:
    output = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE
    blender = os.environ["REAL_BLENDER"]
    shared = os.environ.get(
        "REAL_BLENDER_FOLDER", str(Path(tempfile.gettempdir()) / "real-blender-io")
    )
    with tempfile.TemporaryDirectory(dir=shared, prefix="haptic-tutorial-") as name:
        folder = Path(name)
        (folder / "resources" / "config").mkdir(parents=True)
        environment = os.environ | {
            "BLENDER_USER_RESOURCES": str(folder / "resources"),
            "LIMIT": "300",
        }
        subprocess.run(
            [sys.executable, ROOT / "packaging" / "build.py", folder / "dist"], check=True
        )
        (package,) = (folder / "dist").glob("*linux_x64.zip")
        quiet = (
            "import bpy; bpy.context.preferences.view.show_splash = False; "
            "bpy.ops.wm.save_userpref()"
        )
        install = [
            "--command",
            "extension",
            "install-file",
            "-r",
            "user_default",
            "-e",
            str(package),
        ]
        for arguments in (["--python-expr", quiet], install):
            subprocess.run(
                [blender, "run", "--background", *arguments],
                env=environment,
                cwd=folder,
                check=True,
            )
        for source in (
            ROOT / "tests/gui/window.py",
            ROOT / "tests/package/registered.py",
            *HERE.glob("*.py"),
        ):
            shutil.copy(source, folder)
        scenario = [str(folder / "window.py"), "--", str(folder / "scenario.py"), str(folder)]
        subprocess.run(
            [blender, "gui", "--enable-event-simulate", "--python", *scenario],
            env=environment,
            cwd=folder,
            check=True,
        )
        report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
        for path in folder.glob("*.png"):
            with Image.open(path) as picture:
                box = None if path.stem in WHOLE else report["seen"]["viewport"]
                picture.convert("RGB").crop(box).save(output / path.name, optimize=True)
        if report["error"]:
            raise SystemExit(report["error"])
        print(report["seen"])


if __name__ == "__main__":
    main()
