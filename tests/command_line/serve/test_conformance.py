"""The conformance files against the server of this package, and against their script."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import pytest
from haptic_tracing.command_line import conformance, main
from haptic_tracing.command_line.serve.conversation import Conversation, text_of
from haptic_tracing.core.formats.io.strict_json import read_json

FOLDER = Path(__file__).parents[3] / "conformance"


class Spoken:
    """A conversation without a socket."""

    def __init__(self):
        self._conversation, self._answers = Conversation(None, None), []

    def send(self, text):
        self._answers += [text_of(answer) for answer in self._conversation.answer(text)]

    def recv(self, timeout):
        return self._answers.pop(0)


def test_the_files_are_those_of_their_script():
    specification = importlib.util.spec_from_file_location("make", FOLDER / "make.py")
    make = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(make)
    assert {path.name: path.read_text() for path in FOLDER.glob("*.json")} == dict(make.written())


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, marks=pytest.mark.slow) if path.name.startswith("sample_") else path
        for path in sorted(FOLDER.glob("*.json*"))
    ],
    ids=lambda path: path.name.partition(".")[0],
)
def test_answers_are_as_expected(path):
    assert list(conformance.differences(read_json(path), Spoken(), None)) == []


def test_what_differs_is_named():
    document = json.loads((FOLDER / "chain.json").read_text())
    level = document["exchange"][-1]["expect"]["levels"]["hand"]
    level["level"] += 0.02
    (fault,) = conformance.differences(document, Spoken(), None)
    assert fault.startswith("message 40 (step): levels hand level: expected")
    level["gains"]["drill"] *= 1.01
    assert len(list(conformance.differences(document, Spoken(), None))) == 2


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ("[]", "/exchange: is required"),
        ('{"messages": []}', "/exchange: is required"),
        ('{"exchange": [{"send": {"type": "stop"}}, {"send": {}}]}', "/exchange/1/send: is req"),
    ],
)
def test_a_file_that_is_no_conversation_is_named(text, where, tmp_path, capsys):
    file = tmp_path / "own.json"
    file.write_text(text)
    assert main(["conformance", "ws://127.0.0.1:9", str(file)]) == 2
    assert capsys.readouterr().err.startswith(f"{file}: {where}")


def test_a_server_that_is_not_there_is_named(capsys):
    assert main(["conformance", "ws://127.0.0.1:9"]) == 2
    assert capsys.readouterr().err.startswith("ws://127.0.0.1:9: ")
