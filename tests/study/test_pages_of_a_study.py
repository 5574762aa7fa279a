"""What the pages of a study say to its program, as a browser would."""

import json
import time

import pytest
import small_study
from haptic_tracing.study.people.record import read_steps
from small_study import SECONDS
from websockets.sync.client import connect


@pytest.fixture
def study(tmp_path):
    with small_study.served(tmp_path) as study:
        yield study


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


def test_an_answer_that_can_not_be_written_halts_and_is_asked_again(study):
    resource = pytest.importorskip("resource")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    with page(study, "participant") as participant, page(study, "experimenter") as experimenter:
        say(experimenter, "begin", "P01")
        resource.setrlimit(resource.RLIMIT_FSIZE, (10, limits[1]))
        try:
            state = say(participant, "answer", 0, [], 1.0)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        assert "nothing can be written" in state["halted"]
        assert number_of_step(state) == 0
        assert not say(experimenter, "resume")["halted"]
        assert number_of_step(say(participant, "answer", 0, [], 1.0)) == 1
