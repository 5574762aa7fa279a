"""Ctrl-C while Blender calls a handler: Blender drops the KeyboardInterrupt, and the command must
end all the same."""

import signal

import pytest
from haptic_tracing import command_line
from haptic_tracing.command_line import arguments
from haptic_tracing.command_line.frame_bar import frame_bar


@pytest.fixture
def dropped(monkeypatch):
    """A Ctrl-C whose exception is lost."""
    monkeypatch.setattr(command_line, "_interrupts", [])
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    command_line.note_interrupts()
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("dropped")
def test_the_next_frame_ends_the_command():
    with frame_bar(3, "Tracing") as advance, pytest.raises(KeyboardInterrupt):
        advance()


@pytest.mark.usefixtures("dropped")
def test_what_is_missing_is_no_bad_input(monkeypatch, capsys):
    def run(args):
        raise ValueError("Frame 3 can't be traced")

    monkeypatch.setattr(command_line, "run", run)
    assert (
        command_line.main([next(iter(arguments.SUBCOMMANDS)), "scene.json"])
        == command_line.INTERRUPTED
    )
    assert capsys.readouterr().err == ""


def test_frames_advance_without_one(capsys):
    """Silently in a log; for a farm with a line for each percent."""
    with frame_bar(2, "Tracing") as advance:
        advance()
        advance()
    assert capsys.readouterr() == ("", "")
    with frame_bar(4, "Tracing", "openjd") as advance:
        for _ in range(4):
            advance()
    assert capsys.readouterr().out.split("\n")[:-1] == [
        f"openjd_progress: {percent}" for percent in (25, 50, 75, 100)
    ]
