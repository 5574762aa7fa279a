"""A participant in Chromium, with two pads that umockdev makes up: from the consent to the end,
killed in the middle and resumed, and that each pad is felt in the beats of its own hand."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import bpy
import numpy as np
import pytest
from bounded_program import bounded, line_of
from haptic_tracing.command_line import main
from haptic_tracing.core.devices.profile_files import profile
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.formats.tracks.wav import described, write_wav
from haptic_tracing.study.people.exposure import hand_weighting
from haptic_tracing.study.people.record import read_steps
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

sys.path.insert(0, str(Path(__file__).parents[1] / "core" / "devices"))

from headless_chromium import Page
from made_up_devices import DUALSENSE_USB, XBOX_BT, describe
from timed_hid import reports_of

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not sys.platform.startswith("linux"), reason="umockdev and hidraw exist on Linux only"
    ),
]

RATE, SECONDS = 8000, 3.0


@dataclass(frozen=True)
class Pad:
    """A pad in one hand. beats: seconds of the film at which the tracks of that hand vibrate for
    0.2 s; levels: the bytes of a report that drive the motors."""

    name: str
    hand: str
    beats: tuple[float, ...]
    levels: slice

    def strength(self, report):
        """Of the strongest motor."""
        return max(report[self.levels])


PADS = {
    "hidraw0": Pad("dualsense", "hand.L", (0.6, 1.2, 1.8, 2.4), slice(3, 5)),
    "hidraw1": Pad("xbox", "hand.R", (0.3, 0.9, 1.5, 2.1), slice(4, 6)),
}
FORM = """
title = "Two pads"
seed = 7
smallest_effect = 0.5
consent = "I take part."
devices = {"hand.L" = "dualsense", "hand.R" = "Xbox Wireless"}
instructions = "Look and feel."
about = {age = [], hand = ["left", "right"]}
words = ["Why?"]
scale = {low = 1, high = 7}
items = [{factor = "Realism", text = "First item"}, {factor = "Harmony", text = "Second item"}]
exclusion = {incomplete = true, same_answers = true, seconds_per_item = 0.0, missed_ms = 5000}
conditions = {loud = {}, soft = {}}
scenes = {beats = {film = "film.webm", tracks = {loud = "loud.wav", soft = "soft.wav"}}}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    prepare(folder)
    return folder


def prepare(folder):
    """Write the form, the tracks and the film of a study."""
    (folder / "study.toml").write_text(FORM)
    times = np.arange(int(RATE * SECONDS)) / RATE
    beats = [
        sum((times >= beat) & (times < beat + 0.2) for beat in pad.beats) for pad in PADS.values()
    ]
    waves = np.array(beats) * np.sin(2 * np.pi * 160 * times)
    listeners = tuple(ListenerTrack(pad.hand, pad.hand) for pad in PADS.values())
    for name, amplitude in (("loud", 0.9), ("soft", 0.5)):
        tracks = Tracks(listeners, RATE, amplitude * waves, 0.0)
        write_wav(tracks, folder / f"{name}.wav")
        (folder / f"{name}.wav.json").write_text(json.dumps(described(tracks)))
    film(folder / "film.webm")


def film(path):
    """A film of 3 s at 24 frames per second, of an empty scene."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(scene.camera)
    render = scene.render
    render.engine = "CYCLES"
    scene.cycles.samples = 1
    render.resolution_x, render.resolution_y = 64, 48
    scene.frame_start, scene.frame_end = 1, round(24 * SECONDS)
    if hasattr(render.image_settings, "media_type"):
        render.image_settings.media_type = "VIDEO"
    render.image_settings.file_format = "FFMPEG"
    render.ffmpeg.format, render.ffmpeg.codec = "WEBM", "WEBM"
    render.use_file_extension = False
    render.filepath = str(path)
    bpy.ops.render.render(animation=True)


@contextmanager
def laboratory(folder, tmp_path):
    """The program with both pads; gives its process and what it prints."""
    if shutil.which("umockdev-run") is None:
        pytest.fail("umockdev-run is not installed: on Debian and Ubuntu, apt-get install umockdev")
    tmp_path.mkdir(exist_ok=True)
    until_all_end, program = (
        str(Path(__file__).with_name(name)) for name in ("until_all_end.py", "laboratory.py")
    )
    command = ["umockdev-run", *describe(tmp_path, [DUALSENSE_USB, XBOX_BT]), "--"]
    command += [sys.executable, until_all_end, sys.executable, program, str(folder)]
    with bounded(command, 900, stdout=subprocess.PIPE) as process:
        *lines, own = list(iter(partial(line_of, process), ""))
        try:
            yield int(own), lines
        finally:
            with suppress(ProcessLookupError):
                os.kill(int(own), signal.SIGTERM)
            process.wait(60)


class Sitter:
    """Both pages in browsers."""

    def __init__(self, stack, lines, tmp_path):
        blank = tmp_path / "blank.html"
        blank.write_text("<title>blank</title>")
        self.experimenter, self.participant = (
            stack.enter_context(Page(blank, tmp_path / name)) for name in ("one", "two")
        )
        for page, address in zip((self.experimenter, self.participant), lines, strict=False):
            page.ask("Page.navigate", page._session, url=address)
            page.until("location.protocol + document.readyState === 'http:complete'")

    def begin(self, name):
        self.experimenter.until(f"document.getElementById('{name}')")
        self.experimenter.run(f"document.getElementById('{name}').click()")

    def go_on(self, last):
        """Answer steps until the step ``last`` is shown."""
        before = None  # as where the experimenter is waited for
        while True:
            self.participant.until(
                f"state.form && (state.step ? state.number : null) !== {json.dumps(before)}",
            )
            step, before = self.participant.run(
                "state.step ? [state.step.step, state.number] : ['wait', null]"
            )
            if step == last:
                return
            self.participant.run(ANSWERS.get(step, NEXT))


NEXT = "document.getElementById('next').click()"
KEEP = """
window.pictures = [];
{
  const old = send;
  send = (...message) => { if (message[0] === "picture") pictures.push(message.slice(1)); old(...message); };
}
"""
"""Keeps what the page says about the pictures that it shows."""
ANSWERS = {
    "consent": "document.getElementById('agree').click(); " + NEXT,
    "about": "document.querySelector('input').value = '31'; "
    "document.querySelector('select').value = 'left'; "
    "document.querySelector('select').onchange(); " + NEXT,
    "play": "new Promise((done) => { const wait = () => { const button = "
    "document.getElementById('next'); if (!button || button.disabled) setTimeout(wait, 20); "
    "else { button.click(); done(); } }; wait(); })",
    "place": "for (const limb of document.querySelectorAll('[data-part=\"hand.L\"]')) "
    "{ const box = limb.getBoundingClientRect(); limb.dispatchEvent(new MouseEvent('click', "
    "{bubbles: true, clientX: box.x + box.width / 2, clientY: box.y + box.height / 2})); } " + NEXT,
    "rate": "for (const value of ['5']) for (const box of "
    "document.querySelectorAll(`input[value='${value}']`)) box.click(); " + NEXT,
    "rank": "for (const ride of [...document.querySelectorAll('.ride')].reverse()) ride.click(); "
    + NEXT,
    "words": "document.querySelector('textarea').value = 'So.'; " + NEXT,
}


def test_a_participant_is_killed_in_the_middle_and_loses_nothing(folder, tmp_path):
    path = folder / "P01.jsonl"
    with laboratory(folder, tmp_path / "a") as (program, lines), ExitStack() as stack:
        sitter = Sitter(stack, lines, tmp_path)
        said = sitter.experimenter.run("document.getElementById('exposure').innerText")
        (value,) = re.findall(r"hand.L: A\(8\) = (\S+) m/s²", said)
        assert float(value) == pytest.approx(exposure(), rel=0.1)
        assert "no A(8) for hand.R: no calibration" in said
        sitter.begin("P01")
        sitter.go_on("rate")
        sitter.participant.run(ANSWERS["rate"])
        sitter.participant.until("state.step.step === 'play'")
        sitter.participant.run(KEEP + ANSWERS["play"])
        sitter.participant.until("pictures.length > 20")
        os.kill(program, signal.SIGKILL)
    before = path.read_bytes()
    until_silent(folder)
    assert [step["step"] for step in read_steps(path) if "answer" in step] == [
        *("consent", "about", "start", "play", "place", "rate")
    ]
    with laboratory(folder, tmp_path / "b") as (_, lines), ExitStack() as stack:
        (tmp_path / "again").mkdir()
        sitter = Sitter(stack, lines, tmp_path / "again")
        sitter.begin("P01")
        sitter.go_on("wait")
    assert path.read_bytes().startswith(before)
    steps = [step for step in read_steps(path) if "answer" in step]
    assert [step["step"] for step in steps] == [
        *("consent", "about", "start"),
        *("play", "place", "rate") * 2,
        *("rank", "words", "end"),
    ]
    (order,) = (step["conditions"] for step in steps if step["step"] == "rank")
    assert [step["condition"] for step in steps if step["step"] == "rate"] == order
    (rank,) = (step["answer"] for step in steps if step["step"] == "rank")
    assert {row["item"]: row["value"] for row in rank} == {order[0]: 2, order[1]: 1}
    for play in (step["answer"] for step in steps if step["step"] == "play"):
        values = {row["item"]: row["value"] for row in play}
        assert values.keys() == {"late_ms", "missed_ms"} and 0 <= values["missed_ms"] < 3000
    felt = [step["answer"] for step in steps if step["step"] == "place"]
    for noticed, *spots in felt:
        assert noticed == {"item": "noticed", "value": 1} and len(spots) >= 2
        assert all(spot["value"] == "hand.L" for spot in spots)
    plays = [step for step in read_steps(path) if step.get("note") == "play"]
    assert len(plays) == 3  # one of them was cut off
    assert main(["study", "analyse", str(folder)]) == 0


def until_silent(folder, seconds=60.0):
    """Wait until the last report of each pad is zero. Returns how many have driven it."""
    end = time.monotonic() + seconds
    while True:
        found = {
            pad.name: [pad.strength(data) > 0 for _, data in reports_of(folder / "log", node)]
            for node, pad in PADS.items()
        }
        if not any(strong[-1] for strong in found.values()):
            return {name: sum(strong) for name, strong in found.items()}
        assert time.monotonic() < end, "the pads do not fall silent"
        time.sleep(0.05)


def exposure():
    """A(8) of both tracks on the left motor, 20 m/s² at full scale, as if they were sines: their
    beginnings and ends also have lower frequencies, which weigh more."""
    weight = hand_weighting(np.array([160.0]))[0]
    squares = sum((amplitude * 20.0 * weight) ** 2 / 2 for amplitude in (0.9, 0.5))
    return np.sqrt(squares * 0.2 * len(PADS["hidraw0"].beats) / 28_800)


def test_each_pad_is_felt_in_the_beats_of_its_hand(folder, tmp_path):
    """The hands take turns: the beat whose middle is nearest says in which hand one was due. How
    punctually is measured by ``benchmarks/bench_people.py``."""
    everything = np.sort(np.concatenate([pad.beats for pad in PADS.values()]))
    pictures, felt_by = felt_onsets(folder, tmp_path, "P02")
    for pad, times in felt_by:
        onsets = np.interp(times, pictures[:, 1], pictures[:, 0])
        nearest = np.abs(onsets[:, None] - (everything + 0.1)).argmin(axis=1)
        felt = everything[nearest]
        assert len(felt) and set(felt) <= set(pad.beats), (pad, onsets)
        assert (np.diff(nearest) >= 0).all()
        # A machine that is too slow shows no pictures, and plays nothing.
        shown = {beat for beat in pad.beats if np.sum(abs(pictures[:, 0] - beat) < 0.3) > 10}
        assert set(felt) >= shown, (pad, onsets)


def felt_onsets(folder, tmp_path, name):
    """The pictures that the page shows (n, 2), seconds of the film and when; and for each pad when
    a participant begins to feel vibration: the times of its reports plus its latency."""
    with laboratory(folder, tmp_path / "a") as (_, lines), ExitStack() as stack:
        sitter = Sitter(stack, lines, tmp_path)
        sitter.begin(name)
        sitter.go_on("play")
        began = time.perf_counter()
        sitter.participant.run(KEEP + ANSWERS["play"])
        sitter.participant.until("state.step.step === 'place'")
        pictures = np.array(sitter.participant.run("pictures"))
        ended = time.perf_counter()
    found = []
    for node, pad in PADS.items():
        reports = [
            (seconds, pad.strength(data) > 0)
            for seconds, data in reports_of(folder / "log", node)
            if began < seconds < ended
        ]
        times = [
            seconds
            for (_, before), (seconds, now) in zip([(0, False), *reports], reports, strict=False)
            if now and not before
        ]
        found.append((pad, np.array(times) + profile(pad.name).latency))
    return pictures, found


def test_the_emergency_stop_silences_and_other_pages_are_refused(folder, tmp_path):
    with laboratory(folder, tmp_path / "a") as (_, lines), ExitStack() as stack:
        sitter = Sitter(stack, lines, tmp_path)
        sitter.begin("P03")
        sitter.go_on("play")
        sitter.participant.run(KEEP + ANSWERS["play"])
        sitter.participant.until("pictures.length && pictures.at(-1)[0] > 0.6")
        sitter.experimenter.run("document.getElementById('halt').click()")
        sitter.participant.until("document.body.innerText.includes('Stopped')")
        silent = until_silent(folder)
        time.sleep(1.0)
        assert until_silent(folder, 0.0) == silent, "nothing is felt any more"
        notes = [step["note"] for step in read_steps(folder / "P03.jsonl") if "note" in step]
        assert notes[-1] == "halt"
        sitter.experimenter.run("document.getElementById('resume').click()")
        sitter.participant.until("state.step.step === 'play' && !state.halted")
        scheme, _, host, _, role = lines[0].split("/")
        for path in ("guessed/participant", "participant", f"guessed/{role}"):
            with pytest.raises(InvalidStatus, match="403"):
                connect(f"ws://{host}/{path}", origin=f"{scheme}//{host}")


def test_a_section_whose_devices_are_lost_is_not_played_and_is_repeated(folder, tmp_path):
    """The guard is killed in the middle of a section: pads fall silent, the page says which, and
    goes on with the same section on the same pads."""
    path = folder / "P04.jsonl"
    with laboratory(folder, tmp_path / "a") as (program, lines), ExitStack() as stack:
        sitter = Sitter(stack, lines, tmp_path)
        sitter.begin("P04")
        sitter.go_on("play")
        number = sitter.participant.run("state.number")
        sitter.participant.run(KEEP + ANSWERS["play"])
        sitter.participant.until("pictures.length && pictures.at(-1)[0] > 0.6")
        children = Path(f"/proc/{program}/task/{program}/children").read_text().split()
        for child in map(int, children):
            os.kill(child, signal.SIGKILL)
        sitter.participant.until("document.body.innerText.includes('Stopped')")
        until_silent(folder)
        sitter.experimenter.until("document.getElementById('why').innerText")
        why = sitter.experimenter.run("document.getElementById('why').innerText")
        assert "Controller" in why and "the process that guards the devices has ended" in why
        before = sum(until_silent(folder).values())
        sitter.experimenter.run("document.getElementById('resume').click()")
        sitter.participant.until("state.step.step === 'play' && !state.halted")
        assert sitter.participant.run("state.number") == number
        sitter.participant.run(ANSWERS["play"])
        sitter.participant.until("state.step.step === 'place'")
        assert sum(until_silent(folder).values()) > before, "the pads are felt again"
    steps = read_steps(path)
    assert [step["step"] for step in steps if "answer" in step][-1] == "play"
    assert sum(step.get("note") == "play" for step in steps) == 2
