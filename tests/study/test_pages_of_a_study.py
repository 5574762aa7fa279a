"""What the pages of a study say to its program, as a browser would."""

import json
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest
import small_study
from haptic_tracing.command_line.study_run import Study
from haptic_tracing.core.devices.mapping import map_listeners
from haptic_tracing.core.devices.profile_files import profile
from haptic_tracing.core.devices.status import Status
from haptic_tracing.core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from haptic_tracing.core.formats.tracks.wav import described, write_wav
from haptic_tracing.study.people.plan import read_form
from haptic_tracing.study.people.record import read_steps
from websockets.sync.client import connect

RATE, SECONDS = 8000, 2.0
FORM = (
    small_study.FORM
    + """conditions = {one = {}, two = {}}
scenes = {buzz = {tracks = {one = "one.wav", two = "two.wav"}}}
"""
)


@pytest.fixture
def study(tmp_path):
    (tmp_path / "study.toml").write_text(FORM)
    times = np.arange(round(RATE * SECONDS)) / RATE
    tracks = Tracks(
        (ListenerTrack("Hand", "hand.L"),), RATE, 0.5 * np.sin(2 * np.pi * 160 * times)[None]
    )
    for name in ("one", "two"):
        write_wav(tracks, tmp_path / f"{name}.wav")
        (tmp_path / f"{name}.wav.json").write_text(json.dumps(described(tracks)))
    log = []
    pad = SimpleNamespace(
        profile=profile("dualsense"),
        status=Status("open"),
        send=lambda block, due=None: log.append("block"),
        expect=lambda block, due: None,
    )
    stage = SimpleNamespace(
        outputs={"pad": pad},
        mapping=lambda parts: map_listeners(parts, {"pad": pad.profile}),
        stop=lambda: log.append("silence"),
    )
    study = Study(tmp_path, read_form(tmp_path), 2, stage)
    study.log = log
    with study.listen(0) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield study
        server.shutdown()


def page(study, role):
    (address,) = (one for one in study.pages if one.endswith(role))
    return connect(address.replace("http", "ws"))


def say(page, *message):
    """Say something, and wait until it is done. Returns what the page shows then."""
    for text in (message, ("ping", 0)):
        page.send(json.dumps(text))
    while "ping" not in (said := json.loads(page.recv(timeout=60))):
        state = said
    return state


def begin_section(study, participant, experimenter):
    """Answer all until a section has begun. Returns the number of its step."""
    say(experimenter, "begin", "P01")
    while (state := say(participant, "look"))["step"]["step"] != "play":
        say(participant, "answer", number_of_step(state), [], 1.0)
    say(participant, "play")
    return number_of_step(state)


def number_of_step(state):
    return {name: done for name, done, _ in state["participants"]}[state["sitting"]]


def show_pictures(participant, seconds):
    """The pictures of a film, 50 each second."""
    begun = time.perf_counter()
    while (film := time.perf_counter() - begun) < seconds:
        participant.send(json.dumps(["picture", film, time.perf_counter()]))
        participant.recv(timeout=60)
        time.sleep(0.02)


def missed(folder, number, participant):
    """Answer the section. Returns how many milliseconds were missed."""
    say(participant, "answer", number, [], 1.0)
    (step,) = (one for one in read_steps(folder / "P01.jsonl") if one.get("step") == "play")
    return {row["item"]: row["value"] for row in step["answer"]}["missed_ms"]


def test_another_page_of_the_participant_that_is_closed_ends_nothing(study, tmp_path):
    with page(study, "participant") as participant, page(study, "experimenter") as experimenter:
        with page(study, "participant"):
            number = begin_section(study, participant, experimenter)
            show_pictures(participant, SECONDS / 2)
        show_pictures(participant, SECONDS / 2)
        assert missed(tmp_path, number, participant) < 1000 * SECONDS / 2


def test_a_section_that_was_not_felt_is_noted_as_missed(study, tmp_path):
    """No pictures come, or somebody is seated again while the film goes on."""
    with page(study, "participant") as participant, page(study, "experimenter") as experimenter:
        number = begin_section(study, participant, experimenter)
        show_pictures(participant, SECONDS / 2)
        say(experimenter, "begin", "P01")
        assert not study._player._tracks
        assert missed(tmp_path, number, participant) == pytest.approx(1000 * SECONDS)


def test_the_page_that_plays_takes_the_vibration_with_it(study):
    with page(study, "experimenter") as experimenter:
        with page(study, "participant") as participant:
            begin_section(study, participant, experimenter)
            show_pictures(participant, SECONDS / 4)
            assert study.log[-1] == "block"
        deadline = time.monotonic() + 60
        while study.log[-1] != "silence":
            assert time.monotonic() < deadline
            time.sleep(0.02)
        time.sleep(0.1)
        assert study.log[-1] == "silence"
