"""Draws the page that ``--to web`` writes: ``python docs/pictures/draw_web_page.py``, with bpy 5.2,
Pillow, Chromium and the package.

Takes three minutes: it bakes the sample *Mine Ride*.
"""

from __future__ import annotations

import base64
import io
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

FOLDER = Path(__file__).parent
sys.path.insert(0, str(FOLDER.parents[1] / "tests" / "core" / "formats"))

from headless_chromium import Page  # noqa: E402

SECONDS = 35.9
"""The wind shakes the bridge."""


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scene = folder / "Mine Ride.blend"
        for arguments in (
            ["sample", "mine_ride", "--output", scene],
            ["export", scene, "--to", "web", "--out", folder],
        ):
            subprocess.run(
                [sys.executable, "-m", "haptic_tracing", *arguments], cwd=folder, check=True
            )
        with Page(scene.with_suffix(".html"), folder / "profile") as page:
            page.run(
                "new Promise((done) => setInterval(() => "
                "document.getElementById('play').disabled || done(true), 50))"
            )
            page.run(
                f"bar = document.getElementById('seek'); bar.value = {SECONDS}; "
                "bar.dispatchEvent(new Event('input'))"
            )
            page.run("new Promise((done) => setTimeout(done, 1000))")
            picture = Image.open(io.BytesIO(base64.b64decode(page.picture())))
    picture.convert("RGB").save(FOLDER / "web_page.png", optimize=True)


if __name__ == "__main__":
    main()
