"""What a client says, and what it is answered: the messages of `docs/run_time.md`, without a
socket."""

from __future__ import annotations

import json
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from ...core.formats.io.error import FormatError, json_pointer
from ...core.formats.io.schema import validate
from ...core.formats.io.strict_json import parse_json
from ...core.forms import Form, JsonObject
from ...core.run_time import Run, Scene, Step
from ...core.run_time import open as open_run
from ...core.scene.references import PlacedError
from .. import say
from .convention import Convention
from .stage import RATE, DeviceStage

VERSION = 1
MOST_OBJECTS = 10_000
"""Objects, sources or listeners of a run."""
MESSAGES = ("hello", "step", "add", "replace", "remove", "play", "stop")
Answer = JsonObject | bytes


class Conversation:
    """The messages of one client about one run. ``scene``: the run's until the client brings one.
    ``admit``: takes the first message, and returns the devices that play for this client, None for
    none, or why they do not; it raises PlacedError to answer with an error and be asked again.
    Without it, none do.

    stage: the devices. failures: messages that the program could not cope with."""

    def __init__(
        self, scene: Scene | None, admit: Callable[[Any], DeviceStage | str | None] | None = None
    ) -> None:
        self._scene, self.admit = scene, admit
        self.is_admitted = False
        self.stage: DeviceStage | None = None
        self._warnings: list[str] = []
        self._convention = Convention()
        self.run: Run | None = None
        self.last: Step | None = None
        self.failures = 0
        self._steps: list[Any] = []  # ids of the steps that are followed and not answered
        self._begun: set[str] = set()  # sources that began to play in these

    def answer(self, text: str | bytes) -> list[Answer]:
        """The answers to a message for which the client waits."""
        return [answer for answers in self.answers([text]) for answer in answers]

    def answers(self, texts: Iterable[str | bytes]) -> Iterator[list[Answer]]:
        """The answers to messages that wait, or to their UTF-8, in turn. Of steps that follow each
        other only the newest is answered, and names all; their poses, blows and samples are in its
        frame. A message that is not valid is answered by an error; it never raises."""
        for text in texts:
            yield from self._checked(partial(self._heard, text))
        yield from self._checked(self._frame)

    def _checked(self, answers: Callable[[], Iterator[list[Answer]]]) -> Iterator[list[Answer]]:
        """What ``answers`` gives, and errors in place of what it raises."""
        self._name: Any = None
        try:
            yield from answers()
        except PlacedError as error:
            yield [self._error(json_pointer(error.place), error.reason)]
        except FormatError as error:
            yield [self._error(error.pointer, error.reason)]
        except (ValueError, ArithmeticError) as error:
            yield [self._error("", str(error))]
        except Exception as error:  # a fault of this program: others go on
            self.failures += 1
            place = traceback.extract_tb(error.__traceback__)[-1]
            say([f"failure {self.failures}: {error!r} in {place.filename}, line {place.lineno}"])
            self._steps.clear()
            if self.run is not None:
                self.run.stop()
            yield [self._error("", "the server failed at this message; the run begins anew")]

    def _heard(self, text: str | bytes) -> Iterator[list[Answer]]:
        message = parse_json(
            text.encode("utf-8", "surrogatepass") if isinstance(text, str) else text, "message"
        )
        self._name = message.get("id") if isinstance(message, dict) else None
        if not self.is_admitted:
            admitted = None if self.admit is None else self.admit(message)
            if isinstance(admitted, str):
                self._warnings = [admitted]
            else:
                self.stage = admitted
            self.is_admitted = True
            self.run = None if self._scene is None else open_run(self._scene, RATE)
        kind = message.get("type") if isinstance(message, dict) else None
        if kind not in MESSAGES:
            raise PlacedError(("type",), f"must be one of {', '.join(MESSAGES)}")
        validate(message, f"run-time-1#{kind}", "message")
        if kind == "step" and self.run is not None:
            yield from self._step(self.run, message)
        else:
            yield from self._frame()
            yield self._answered(kind, message)

    def _answered(self, kind: str, message: Form) -> list[Answer]:
        """The answer to a message other than a step."""
        if kind == "hello":
            return [self._hello(message)]
        if self.run is None:
            raise PlacedError(("type",), "there is no scene: say hello with one first")
        match kind:
            case "play":
                self.run.play(message["source"])
                return []
            case "stop":
                self.run.stop()
                if self.stage is not None:
                    self.stage.stop()
                return [{"type": "stopped"}]
        parts = {key: message[key] for key in ("object", "source", "listener") if key in message}
        getattr(self.run, kind)(**parts)
        if max(map(len, (self.run.objects, self.run.sources, self.run.listeners))) > MOST_OBJECTS:
            self.run = None
            raise PlacedError(("object",), f"more than {MOST_OBJECTS}: the scene is dropped")
        return [self.scene()]

    def _hello(self, message: Form) -> JsonObject:
        names = ("up", "handedness", "metres_per_unit")
        self._convention = Convention(**{key: message[key] for key in names if key in message})
        scene = self._scene
        if "scene" in message:
            for key in ("objects", "sources", "listeners"):
                items = message["scene"].get(key)
                if isinstance(items, list) and len(items) > MOST_OBJECTS:
                    raise PlacedError(("scene", key), f"must have at most {MOST_OBJECTS} items")
            try:
                scene = Scene.of_document(
                    {"format": "haptic-scene", "version": "1.1", **message["scene"]}, "scene"
                )
            except FormatError as error:
                raise PlacedError(
                    ("scene", *error.pointer.strip("/").split("/")), error.reason
                ) from None
        if scene is None:
            raise PlacedError(("scene",), "is required: the server was started without one")
        self._scene = scene
        self.run = open_run(scene, message.get("sample_rate", RATE))
        return self.scene()

    def _error(self, where: str, reason: str) -> JsonObject:
        """The answer to the message that is heard."""
        name = self._name
        known = {"id": name} if isinstance(name, int | str) and not isinstance(name, bool) else {}
        return {"type": "error", **known, "where": where, "message": reason}

    def scene(self) -> JsonObject:
        """The message that names what the run has."""
        assert self.run is not None
        warnings = [*self._warnings, *self.run.warnings]
        return {
            "type": "scene",
            "version": VERSION,
            "objects": list(self.run.objects),
            "sources": list(self.run.sources),
            "listeners": list(self.run.listeners),
            "sample_rate": self.run.sample_rate,
            "latency": 0.0 if self.stage is None else self.stage.latency,
            "calibrated": self.run.is_calibrated,
            **({"warnings": warnings} if warnings else {}),
        }

    def _step(self, run: Run, message: Form) -> Iterator[list[Answer]]:
        """Follow a step, and answer those before it where it begins the run anew or ends what began
        to play in them."""
        sources = message.get("sources", {}).items()
        ended = {name for name, form in sources if form.get("playing") is False}
        if not run.continues(message["time"]) or ended & self._begun:
            yield from self._frame()
        given = dict(message)
        for key in ("type", "id", "samples", "velocities"):
            given.pop(key, None)
        run.follow(**(given if self._convention.is_own else self._converted(given)))
        self._steps.append(message.get("id"))
        self._begun |= {name for name, form in sources if form.get("playing")}
        if message.get("samples"):
            yield from self._frame(samples=True)

    def _frame(self, samples: bool = False) -> Iterator[list[Answer]]:
        """The answer to the steps since the last one, if there are any."""
        if self._steps and self.run is not None:
            steps, self._steps = self._steps, []
            self._begun.clear()
            name, self._name = self._name, steps[-1]
            step = self.last = self.run.answer()
            self._name = name
            if self.stage is not None:
                self.stage.play(self.run, step)
            frame = frame_message(step, steps, self._convention)
            yield [frame, step.block.astype("<f4").tobytes()] if samples else [frame]

    def release(self, why: str) -> None:
        """Give the devices back, silent; the next `scene` says why."""
        stage, self.stage = self.stage, None
        self._warnings = [why]
        if stage is not None:
            stage.stop()

    def _converted(self, given: JsonObject) -> JsonObject:
        """The arguments of a step in the axes and units of scenes."""
        own = self._convention
        if poses := given.get("poses"):
            try:
                rows = own.poses(
                    np.array(list(poses.values()), dtype=np.float64).reshape(len(poses), 7)
                )
            except (TypeError, ValueError):
                pass  # the run names the faulty one
            else:
                given["poses"] = dict(zip(poses, rows, strict=True))
        for key in ("source_positions", "listener_positions"):
            if key in given:
                given[key] = {name: own.position(place) for name, place in given[key].items()}
        if "impacts" in given:
            given["impacts"] = [
                {**form, "position": own.position(form["position"])} for form in given["impacts"]
            ]
        if "contacts" in given:
            given["contacts"] = [_contact(form, own) for form in given["contacts"]]
        return given


def _contact(form: Form, own: Convention) -> JsonObject:
    placed = {**form, "positions": [own.position(place) for place in form["positions"]]}
    return placed | {"normal": own.direction(form["normal"])} if "normal" in form else placed


def frame_message(step: Step, names: Sequence[Any], convention: Convention) -> JsonObject:
    """The answer to the last of the steps whose ids are ``names``, None for a step without."""
    return {
        "type": "frame",
        **({} if names[-1] is None else {"id": names[-1]}),
        "answers": [name for name in names if name is not None],
        "time": step.time,
        "levels": {
            listener: {"level": level.level, "margin": level.margin, "gains": level.gains}
            for listener, level in step.levels.items()
        },
        "impacts": [
            {
                "time": blow.time,
                "objects": blow.objects,
                "position": convention.position_back(blow.position),
                "energy": blow.energy,
                "amplitude": blow.amplitude,
                "estimated": blow.estimated,
                "gains": blow.gains,
            }
            for blow in step.impacts
        ],
        "first_sample": step.first_sample,
        "n": step.block.shape[1],
        "listeners": step.listeners,
        "milliseconds": {stage: round(value, 3) for stage, value in step.milliseconds.items()},
        **({"warnings": step.warnings} if step.warnings else {}),
    }


text_of: Callable[[JsonObject], str] = json.JSONEncoder(
    ensure_ascii=False, allow_nan=False, separators=(",", ":")
).encode
"""An answer as JSON."""
