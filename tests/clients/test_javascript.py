"""The JavaScript client in Chromium, against the server."""

from __future__ import annotations

import functools
import http.server
import json
import math
import re
import shutil
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CLIENT = ROOT / "clients" / "javascript"

from headless_chromium import Page

pytestmark = pytest.mark.slow


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *arguments):
        pass


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A copy of the sample's folder in which npm has installed its packages."""
    folder = tmp_path_factory.mktemp("client") / "javascript"
    shutil.copytree(CLIENT, folder, ignore=shutil.ignore_patterns("node_modules"))
    subprocess.run(["npm", "ci"], cwd=folder, check=True, capture_output=True, timeout=300)
    return folder


@pytest.fixture(scope="module")
def site(folder):
    """The folder on a server of pages."""
    handler = functools.partial(Quiet, directory=folder)
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


@pytest.fixture
def page(site, server, tmp_path):
    """The sample's page, with WebGL."""
    blank = tmp_path / "blank.html"
    blank.write_text("<title>blank</title>")
    with Page(blank, tmp_path / "profile", more=("--enable-unsafe-swiftshader",)) as opened:
        opened.ask("Page.navigate", opened._session, url=f"{site}/index.html?server={server}")
        yield opened


def wait_for(page, script, wanted):
    """Wait until a script gives what is ``wanted``, and return it."""
    deadline = time.monotonic() + 90
    value = None
    while time.monotonic() < deadline:
        value = page.run(script)
        if value is not None and re.search(wanted, str(value)):
            return value
        time.sleep(0.2)
    fault = page.run("document.getElementById('text')?.textContent")
    raise AssertionError(f"{script} gives {value!r}, not {wanted}; the page says {fault!r}")


def test_rapiers_crate_is_felt_when_it_lands_and_where_it_rests(page):
    """Rapier drops a crate onto the bench; then a hand on the bench feels the hum of the motor, as
    the table and the body map show."""
    wait_for(page, "document.title", "[1-9] blows")
    hand = "[...document.querySelectorAll('#levels tr')].find(row => /^hand/.test(row.textContent))"
    wait_for(page, f"{hand}?.textContent", r"^hand-\d+ dB")
    limb = "document.querySelector('[data-part=\"hand.R\"]').getAttribute('stroke')"
    wait_for(page, limb, "^hsl")
    assert (
        page.run("document.querySelector('[data-part=\"foot.R\"]').getAttribute('stroke')")
        == "#bbb"
    )
    assert page.run("document.getElementById('text').textContent") == ""  # there is a picture
    before = page.run("document.title")
    page.run("document.getElementById('view').click()")
    wait_for(page, f"document.title !== {json.dumps(before)}", "True")


def test_a_page_without_its_server_says_how_to_start_one(site, tmp_path):
    blank = tmp_path / "blank.html"
    blank.write_text("<title>blank</title>")
    with socket.socket() as taken:  # bound, but nothing listens
        taken.bind(("127.0.0.1", 0))
        address = f"ws://127.0.0.1:{taken.getsockname()[1]}"
        with Page(blank, tmp_path / "profile", more=("--enable-unsafe-swiftshader",)) as opened:
            opened.ask("Page.navigate", opened._session, url=f"{site}/index.html?server={address}")
            said = wait_for(
                opened, "document.getElementById('text')?.textContent", "does not answer"
            )
    assert f"haptic-tracing serve --allow-origin {site}" in said


def test_levels_shake_pads_and_controllers(page):
    """A gamepad by dual-rumble, a controller of WebXR by a pulse: stand-ins, which say what they are
    told."""
    script = """
    import("./haptic-tracing.js").then(({HapticTracing}) => [
      HapticTracing.rumble({vibrationActuator: {playEffect: (kind, how) => [kind, how.strongMagnitude, how.duration]}}, -20),
      HapticTracing.rumble({hapticActuators: [{pulse: (magnitude, duration) => [magnitude, duration]}]}, -20),
      HapticTracing.rumble({hapticActuators: [{pulse: magnitude => magnitude}]}, null),
      HapticTracing.rumble(null, -20) ?? "nothing",
    ])
    """
    strength = pytest.approx(math.sqrt(2) / 10)
    assert page.run(script) == [["dual-rumble", strength, 60], [strength, 60], 0, "nothing"]


def test_the_page_without_a_server_feels_a_crate_land(site, tmp_path):
    """After the blow the hand feels the motor, 2 m away through the ground and the middle of the
    bench, and the foot, as far away through the ground alone, feels it better."""
    blank = tmp_path / "blank.html"
    blank.write_text("<title>blank</title>")
    with Page(blank, tmp_path / "profile") as opened:
        opened.ask("Page.navigate", opened._session, url=f"{site}/tracer.html")
        wait_for(opened, "document.title", "[1-9] blows")
        calm = round(20 * math.log10(0.1 / math.sqrt(2) * math.exp(-0.2 * 2)))
        wait_for(opened, "document.getElementById('text').textContent", f"foot {calm} dB")
        hand = math.exp(-0.2 * (3 + math.hypot(0.6, 0.5)))
        wait_for(
            opened,
            "document.getElementById('text').textContent",
            f"Hand {round(20 * math.log10(0.1 / math.sqrt(2) * hand))} dB",
        )


def test_what_touches_in_rapier_is_traced(folder):
    """Two crates of 5 kg and half a metre on each other: the forces are their weights, and the tone
    runs 1 m through the ground and 0.5 m through either crate."""
    script = shutil.copy(Path(__file__).with_name("rapier.mjs"), folder)
    done = subprocess.run(["node", script], check=True, capture_output=True, text=True, timeout=60)
    felt = json.loads(done.stdout)
    pairs = {(c["one"], c["other"]): c["force"] for c in felt["contacts"]}
    assert pairs == {
        (0, 1): pytest.approx(10 * 9.81, rel=0.01),
        (1, 2): pytest.approx(5 * 9.81, rel=0.01),
    }
    assert felt["path"] == [0, 1, 2]
    assert felt["gain"] == pytest.approx(math.exp(-0.2 * 2), rel=0.002)
    assert felt["level"] == pytest.approx(20 * math.log10(felt["gain"] / math.sqrt(2)), abs=0.01)


def test_the_body_map_is_that_of_the_panels():
    assert (CLIENT / "body-map.json").read_bytes() == (
        ROOT / "core" / "scene" / "body_map.json"
    ).read_bytes()
