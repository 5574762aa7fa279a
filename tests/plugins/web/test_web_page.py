"""The exported web page, played by Chromium without a network and with a made-up pad."""

import json
import re
import sys

import numpy as np
import pytest
from haptic_tracing.core.formats import registry
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.scene.values import HapticScene
from haptic_tracing.plugins.web.web import decoded, encoded
from headless_chromium import Page

HOSTILE = """</script><script>document.title='taken'</script><img src=x onerror="document.title='taken'">"""
RATE = 8000

PAD = """<script>
window.calls = [];
const pad = { id: "made-up pad", connected: true, vibrationActuator: {
  playEffect: (kind, effect) => { calls.push([kind, effect, performance.now()]); return Promise.resolve("complete"); },
  reset: () => { calls.push(["reset"]); return Promise.resolve("complete"); } } };
navigator.getGamepads = () => [null, pad];
</script>"""

DRIVER = """<script>
const wait = (ms) => new Promise((done) => setTimeout(done, ms));
const text = (id) => document.getElementById(id).textContent;
const seconds = () => parseFloat(text("time"));
const press = () => document.getElementById("play").click();
const put = (time) => { const bar = document.getElementById("seek"); bar.value = time; bar.dispatchEvent(new Event("input")); };
const brightest = () => {
  const c = document.getElementById("body"); let best = 0;
  const d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
  for (let k = 0; k < d.length; k += 4) best = Math.max(best, d[k]);
  return best;
};
(async () => {
  while (document.body.dataset.ready !== "yes") await wait(20);
  const found = { before: [seconds(), text("play"), calls.length], dark: brightest() };
  press();
  for (let k = 0; k < 100 && seconds() < 0.6; k++) await wait(50);
  found.playing = [seconds(), text("play")]; found.lit = brightest();
  found.low = calls.filter(([kind]) => kind === "dual-rumble").at(-1);
  press(); await wait(100);
  found.paused = [seconds(), text("play")];
  found.stopped = calls.at(-1)[0];
  const count = calls.length; await wait(300);
  found.silent = calls.length === count && seconds() === found.paused[0];
  put(9.5); await wait(50); found.sought = seconds();
  press(); await wait(300);
  found.high = calls.filter(([kind]) => kind === "dual-rumble").at(-1);
  put(11.8);
  for (let k = 0; k < 100 && text("play") !== "Play"; k++) await wait(50);
  found.end = [seconds(), text("play")];
  found.names = [...document.querySelectorAll(".row b")].map((b) => b.textContent);
  found.options = [...document.querySelectorAll("#who option")].map((o) => o.textContent);
  found.title = document.title; found.heading = text("play") && document.querySelector("h1").textContent;
  found.pad = text("pad"); found.images = document.images.length;
  document.body.dataset.found = JSON.stringify(found);
})();
</script>"""


@pytest.fixture(scope="module")
def tone():
    """12 s: silence, from 0.3 to 8 s a tone of 40 Hz on the left hand, from 9 s on one of 300 Hz on
    the right hand."""
    time = np.arange(12 * RATE) / RATE
    low = 0.8 * np.sin(2 * np.pi * 40 * time) * ((time > 0.3) & (time < 8))
    high = 0.8 * np.sin(2 * np.pi * 300 * time) * (time > 9)
    return Tracks(
        (ListenerTrack("left hand", "hand.L"), ListenerTrack(HOSTILE, "hand.R")),
        RATE,
        np.array([low, high]),
    )


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="Chromium is a Debian package of the tests")
def test_the_page_plays_in_chromium(tmp_path, tone):
    written = registry.write("web", Export("a <b> & ride", HapticScene(), tone), tmp_path)
    page = written.files[0].read_text("utf-8")
    driven = tmp_path / "driven.html"
    driven.write_text(
        page.replace("</head>", PAD + "</head>").replace("</body>", DRIVER + "</body>"), "utf-8"
    )
    with Page(driven, tmp_path / "profile") as opened:
        found = json.loads(
            opened.run(
                "new Promise((done) => setInterval(() => document.body.dataset.found && "
                "done(document.body.dataset.found), 50))"
            )
        )
    assert found["before"] == [0, "Play", 0]
    assert (
        found["playing"][1] == "Pause"
        and 0.6 <= found["playing"][0] <= 7
        and found["lit"] > found["dark"] + 60
    )
    kind, effect, _ = found["low"]
    assert (
        kind == "dual-rumble" and 0 < effect["duration"] <= 200
    )  # it ends by itself where a page hangs
    assert 1 >= effect["strongMagnitude"] > max(0.5, 2 * effect["weakMagnitude"])
    assert found["paused"][1] == "Play" and found["stopped"] == "reset" and found["silent"]
    assert found["sought"] == 9.5
    assert (
        1 >= found["high"][1]["weakMagnitude"] > max(0.5, 2 * found["high"][1]["strongMagnitude"])
    )
    assert found["end"] == [12, "Play"]
    assert found["names"] == ["left hand", HOSTILE] and found["options"] == [
        "All",
        "left hand",
        HOSTILE,
    ]
    assert found["title"] == found["heading"] == "a <b> & ride" and found["images"] == 0
    assert found["pad"] == "Pad: made-up pad"


def test_the_page_loads_nothing(tmp_path, tone):
    (path,) = registry.write("web", Export("ride", HapticScene(), tone), tmp_path).files
    page = path.read_text("utf-8")
    around, _, rest = page.partition('id="data">')
    document, _, script = rest.partition("</script>")
    assert json.loads(document)["listeners"][1]["name"] == HOSTILE and "<" not in document
    loads = r"""(https?:)?//[\w.]|src=["']|href=|@import|url\(|fetch\(|XMLHttp|WebSocket"""
    assert (
        not re.search(loads, around + script)
        and "default-src 'none'" in around
        and page.count("<script") == 2
    )
    assert path.name == "ride.html" and [p.name for p in tmp_path.iterdir()] == ["ride.html"]


@pytest.mark.slow
def test_two_and_a_half_minutes_of_ten_listeners_stay_below_5_mb(tmp_path):
    """Of noise, which nothing packs."""
    noise = np.random.default_rng(0).uniform(-0.9, 0.9, (10, 150 * RATE)).astype(np.float32)
    tracks = Tracks(tuple(ListenerTrack(f"listener {k}", "belly") for k in range(10)), RATE, noise)
    (path,) = registry.write("web", Export("long", HapticScene(), tracks), tmp_path).files
    assert path.stat().st_size < 5_000_000


def test_bytes_keep_a_sample_to_3_percent():
    samples = np.concatenate(
        [np.geomspace(1e-3, 1, 400), -np.geomspace(1e-3, 1, 400), [0.0, 2.0, -2.0]]
    )
    again = decoded(encoded(samples))
    expected = np.clip(samples, -1, 1)
    assert (
        np.abs(again - expected).max() <= 0.023
        and (np.abs(again - expected) <= 0.03 * np.abs(expected) + 9e-5).all()
    )
    assert decoded(encoded(np.zeros(3))).tolist() == [0, 0, 0]
