"""The JavaScript client in Chromium, against the server."""

from __future__ import annotations

import functools
import http.server
import re
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "core" / "formats"))

from headless_chromium import Page

pytestmark = pytest.mark.slow


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *arguments):
        pass


@pytest.fixture
def site():
    handler = functools.partial(Quiet, directory=ROOT / "clients" / "javascript")
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.fixture
def server(site):
    command = [
        sys.executable,
        "-m",
        "haptic_tracing",
        "serve",
        "--listen",
        "127.0.0.1:0",
        "--allow-origin",
        site,
    ]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    yield re.search(r"ws://\S+(?=,)", process.stderr.readline())[0]
    process.terminate()
    process.wait(20)
    process.stderr.close()


def test_the_page_feels_the_crate_land(site, server, tmp_path):
    """The page drops its crate from 2 m: one blow, then the hum of the motor at the hand."""
    blank = tmp_path / "blank.html"
    blank.write_text("<title>blank</title>")
    with Page(blank, tmp_path / "profile") as page:
        page.ask("Page.navigate", page._session, url=f"{site}/index.html?server={server}")
        deadline = time.monotonic() + 60
        title = ""
        while "blows" not in title and time.monotonic() < deadline:
            time.sleep(0.2)
            title = page.run("document.title")
        assert title == "Haptic Tracing: 1 blows"
        time.sleep(1.0)
        assert re.fullmatch(r"-\d+ dB", page.run("document.getElementById('text').textContent"))
        assert page.run("document.getElementById('hand').value") > -60
