"""The report is one file that says what was measured, and says what is missing."""

import base64
import json
import re
import subprocess
import sys
from html.parser import HTMLParser

import numpy as np
import pytest
from haptic_tracing.command_line import main
from haptic_tracing.study import plots
from haptic_tracing.study.body_map import body_map, shade_numbers, shades
from haptic_tracing.study.checks import checks_of
from haptic_tracing.study.report import write_numbers, write_report

FRAMES = (2100, 2130)


class Elements(HTMLParser):
    """Counts elements and what they refer to."""

    def __init__(self):
        super().__init__()
        self.count, self.references = {}, []

    def handle_starttag(self, tag, attributes):
        self.count[tag] = self.count.get(tag, 0) + 1
        self.references += [value for key, value in attributes if key in ("src", "href")]


def elements_of(path):
    elements = Elements()
    elements.feed(path.read_text(encoding="utf-8"))
    return elements


@pytest.fixture
def report(bake, tmp_path):
    ride = bake(*FRAMES)
    path = tmp_path / "report.html"
    figures = [("Title & more", "Caption <b>", b"\x89PNG")]
    write_report(path, ride, checks_of(ride), figures, {}, ["There are no pictures: a < b."])
    return path


@pytest.mark.slow
def test_needs_nothing_beside_it(report):
    elements = elements_of(report)
    assert elements.references and all(
        reference.startswith("data:") for reference in elements.references
    )
    # Of the player, of the only section, and the level of each listener.
    assert elements.count["svg"] == 4 + 4 + 4 * 10
    text = report.read_text(encoding="utf-8")
    assert "http:" not in text and "https:" not in text
    assert "Title &amp; more" in text and "Caption &lt;b&gt;" in text and "a &lt; b" in text


@pytest.mark.slow
def test_player_has_the_levels_of_all_frames_modes_and_listeners(report, bake):
    ride = bake(*FRAMES)
    found = json.loads(re.search(r"const ride=(\{.*?\});\n", report.read_text(encoding="utf-8"))[1])
    assert (found["first"], found["count"], found["listeners"]) == (2100, 31, 10)
    levels = base64.b64decode(found["levels"])
    assert len(levels) == 31 * 4 * 10
    assert max(levels) < len(found["shades"])
    assert levels[10 * 4 * 17 + 30 : 10 * 4 * 17 + 40] == bytes(
        shade_numbers(ride.renditions["MN"].peak[17])
    )


@pytest.mark.slow
def test_numbers_are_json_with_every_check_measure_and_impact(bake, tmp_path):
    ride = bake(*FRAMES)
    write_numbers(tmp_path / "study.json", ride, checks_of(ride))
    found = json.loads((tmp_path / "study.json").read_text(encoding="utf-8"))
    assert len(found["checks"]) == len(checks_of(ride))
    assert [(row["section"], row["mode"]) for row in found["measures"]] == [
        ("Explosion", mode) for mode in ("HT", "SD", "MD", "MN")
    ]
    assert len(found["impacts"]) == len(ride.began("Shock Front")) > 5
    assert all(
        sum(gain > 0 for gain in impact["amplitudes"]["SD"]) == 1 for impact in found["impacts"]
    )


def test_body_map_has_a_disc_for_every_default_listener():
    from haptic_tracing.core.scene.body import PAPER_LISTENERS

    svg = body_map(PAPER_LISTENERS)
    assert svg.count('class="disc"') == len(PAPER_LISTENERS)
    assert "hand L" not in svg and "<title>upper leg.R</title>" in svg


def test_shades_go_from_silence_to_full_scale():
    numbers = shade_numbers(np.array([0.0, 0.001, 0.0051, 0.1, 1.0, 2.0]))
    assert list(numbers[:2]) == [0, 0]
    assert numbers[2] == 1
    assert numbers[4] == numbers[5] == len(shades()) - 1
    assert len(set(shades())) == len(shades())


@pytest.mark.slow
def test_plots_are_pictures_of_what_there_is_data_for(bake):
    drawn = {title: png for title, _, png in plots.plots(bake(*FRAMES))}
    assert list(drawn) == [
        "What is felt, where and when",
        "Margins by section",
        "Ranges",
        "Explosion",
        "Spectrogram",
        "Shock wave",
    ]
    assert all(png.startswith(b"\x89PNG\r\n\x1a\n") and len(png) > 5000 for png in drawn.values())


@pytest.mark.slow
def test_command_writes_everything(tmp_path):
    command = [
        sys.executable,
        "-m",
        "haptic_tracing",
        "study",
        "--frames",
        "64:72",
        "--out",
        str(tmp_path),
        "--pictures",
        "1",
    ]
    answer = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert answer.returncode == 0, answer.stderr
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == [
        "mine_ride.HT.wav",
        "mine_ride.MD.wav",
        "mine_ride.MN.wav",
        "mine_ride.SD.wav",
        "report.html",
        "study.json",
    ]
    assert "DOES NOT HOLD  HT: both legs: 0 of 1 stalactites felt" in answer.stdout
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    if plots.can_plot():  # pictures come before tables
        assert text.index("<figure>") < text.index("id=player") < text.index("<th>Statement")
    # What there is none of is said.
    assert ("alt='frame" in text) != ("There are no pictures of the ride" in text)
    assert ("<figure>" in text) == plots.can_plot() != ("There are no plots" in text)


@pytest.mark.parametrize("frames", ["0:10", "5", "9:3", "a:b"])
def test_frames_that_are_none_are_refused_in_a_line(frames, tmp_path, capfd):
    out = tmp_path / "out"
    assert main(["study", "--frames", frames, "--out", str(out)]) == 2
    assert capfd.readouterr().err.count("\n") == 1
    assert not out.exists()


def test_frames_after_the_end_are_refused(tmp_path, capfd):
    assert main(["study", "--frames", "3590:3700", "--out", str(tmp_path / "out")]) == 2
    assert capfd.readouterr().err.strip() == "--frames: the ride ends with frame 3600, not 3700"
    assert not (tmp_path / "out").exists()
