"""``haptic-tracing study run``: two local pages, on which people feel, look and answer."""

from __future__ import annotations

import argparse
import hmac
import json
import secrets
import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from importlib import import_module
from mimetypes import guess_type
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from websockets.datastructures import Headers
from websockets.http11 import Request, Response
from websockets.sync.server import Server, ServerConnection

from ..core.formats.tracks.wav import read
from ..core.forms import Form, JsonObject
from ..study.people.body import body
from ..study.people.exposure import daily, limits_of
from ..study.people.plan import FORM, HERE, begin, read_form, stimuli
from ..study.people.record import Sitting, add_step, alone
from . import say
from .serve.front import Front, serve_forever
from .serve.stage import DeviceStage
from .study_playing import RATE, FilmPlayer

PAGES = ("experimenter", "participant")
_TONE = 0.6 * np.sin(2 * np.pi * 160 * np.arange(RATE // 2) / RATE)


def run(args: argparse.Namespace) -> int:
    """Prepare what is missing, then serve the pages until Ctrl-C."""
    form = read_form(args.out)
    if not all(path.exists() for path in stimuli(args.out, form).values()):
        import_module(".study_stimuli", __package__).prepare(args.out, form)
    if not args.prepare:
        with alone(args.out), closing(DeviceStage.of(args.device)) as stage:
            study = Study(args.out, form, args.participants, stage)
            with study.listen(args.port) as server:
                say(study.pages)
                serve_forever(server)
    return 0


class Study:
    """The study of a folder: its stimuli, its devices, and the participant who is sitting.

    pages: addresses. exposure: of each body part, whether devices play all its listeners, A(8)
    [m/s^2], None without a calibration, and from where action is due and the limit.
    """

    def __init__(self, folder: Path, form: Form, participants: int, stage: DeviceStage) -> None:
        """Raises ValueError if tracks are missing or differ in their listeners, or if a device of
        the form is not connected."""
        self._folder, self._form, self._outputs = folder, form, stage.outputs
        self._served = {role: HERE / f"{role}.html" for role in PAGES}
        self._tracks = {}
        self._seconds = {}
        levels: JsonObject = {}
        kinds = set()
        for (scene, condition), path in stimuli(folder, form).items():
            if not condition:
                self._served[f"film/{scene}"] = path
                continue
            track = self._tracks[scene, condition] = read(path)
            listeners = [(one.name, one.body_part or one.name) for one in track.channels]
            kinds.add((track.channels[0].sample_rate, *listeners))
            samples = np.asarray(track.stored)
            rms = np.sqrt((samples**2).mean(axis=1))
            levels.setdefault(condition, {})[scene] = rms.round(6).tolist()
            self._seconds[scene] = samples.shape[1] / RATE
        if kinds != {(RATE, *listeners)}:
            raise ValueError(f"{folder}: all tracks need the same listeners, and {RATE} Hz")
        parts = [part for _, part in listeners]
        self._parts = np.array(parts)
        self._mapping = stage.mapping(dict(listeners))
        self._choose_devices()
        self._front = Front("127.0.0.1")
        self._root = f"/{secrets.token_urlsafe(12)}/"
        self._plan = begin(folder, form, participants, parts, levels)
        self.exposure = [self._exposed(part) for part in dict.fromkeys(parts)]
        self._player = FilmPlayer(stage)
        self._sittings = {name: Sitting(folder, name, self._plan) for name in self._plan["orders"]}
        self._sitting: Sitting | None = None
        self._lock = threading.Lock()

    def _choose_devices(self) -> None:
        """Let listeners play only on the devices that the form gives to their body parts. Raises
        ValueError."""
        weights = self._mapping.weights
        for part, text in self._form.get("devices", {}).items():
            mine = self._parts == part
            for key, output in self._outputs.items():
                if text.lower() not in f"{key} {output.profile.title}".lower():
                    weights[key][:, mine] = 0.0
            if not any(gains[:, mine].any() for gains in weights.values()):
                raise ValueError(
                    f"{self._folder / FORM}: devices: {part} = {text!r}: needs a listener and a "
                    "connected device there"
                )

    def _exposed(self, part: str) -> list[Any]:
        """A body part as in `exposure`. A(8) is the sum of its listeners', never too low."""
        played, total = True, 0.0
        for number in np.flatnonzero(self._parts == part):
            actuators = [
                (gains[number], actuator.device)
                for key, output in self._outputs.items()
                for gains, actuator in zip(
                    self._mapping.weights[key], output.profile.actuators, strict=True
                )
                if gains[number]
            ]
            channels = [track.channels[number] for track in self._tracks.values()]
            total += daily(channels, actuators, part)
            played &= bool(actuators)
        return [part, played, None if np.isnan(total) else total, *limits_of(part)]

    def listen(self, port: int) -> Server:
        """The server, on this machine only. Raises OSError."""
        server = self._front.listen(port, self._handle, self._page)
        port = server.socket.getsockname()[1]
        self.pages = [f"http://127.0.0.1:{port}{self._root}{role}" for role in PAGES]
        return server

    def _page(self, connection: ServerConnection, request: Request) -> Response | None:
        """Pages and films over HTTP, and the WebSockets of the pages."""
        root, name = request.path[: len(self._root)], unquote(request.path[len(self._root) :])
        is_known = hmac.compare_digest(root.encode("utf-8", "surrogatepass"), self._root.encode())
        file = self._served.get(name) if is_known else None
        if file is None:
            return connection.respond(403, "not a page of this study\n")
        if "Upgrade" in request.headers:
            return None
        content = file.read_bytes()
        headers = Headers(
            {"Content-Type": str(guess_type(file)[0]), "Content-Length": str(len(content))}
        )
        return Response(200, "OK", headers, content)

    def _handle(self, connection: ServerConnection) -> None:
        """Answer a page until it is closed, or says what no page does."""
        with suppress(ValueError, TypeError, LookupError):
            for text in connection if self._front.take_place(connection) else ():
                connection.send(json.dumps(self._reply(json.loads(text))))

    def _reply(self, said: Any) -> JsonObject:
        """Do what a page asks for. Returns what has changed of what it shows."""
        match said:
            case "ping", sent:
                return {"ping": sent, "clock": time.perf_counter()}
            case "picture", film, shown:
                self._player.follow(film, shown)
                return {"halted": self._player.halted}
            case ["halt"]:  # waits for nothing
                self._player.halt("emergency stop")
        with self._lock:
            with self._halted_by_errors():
                if self._sitting and said[0] in ("play", "halt", "resume"):
                    add_step(self._sitting.path, {"note": said[0]})
                match said:
                    case ["resume"]:
                        self._player.resume()
                    case "begin", name:
                        self._player.stop()
                        self._sitting = Sitting(self._folder, name, self._plan)
                        self._sittings[name] = self._sitting
                    case "touch", key, row:
                        self._touch(key, row)
                    case ["play"]:
                        track = self._tracks[self._step["scene"], self._step["condition"]]
                        self._player.load(self._mapping.blocks(np.asarray(track.stored)))
                    case "answer", number, rows, seconds:
                        self._take(number, rows, seconds)
            return self._state()

    @contextmanager
    def _halted_by_errors(self) -> Iterator[None]:
        """Halt where the record can't be written: the step is then asked again."""
        try:
            yield
        except OSError as error:
            self._player.halt(f"nothing can be written to {self._folder}: {error.strerror}")

    @property
    def _step(self) -> JsonObject:
        """The step at which the current participant is; empty without a participant."""
        return self._sitting.step if self._sitting else {}

    def _touch(self, key: str, row: int) -> None:
        """Play half a second of 160 Hz on one actuator."""
        output = self._outputs[key]
        if not self._player.halted:
            output.send(np.outer(np.eye(len(output.profile.actuators))[row], _TONE))

    def _take(self, number: int, rows: Any, seconds: float) -> None:
        """Take an answer; a section has been played if no device was lost."""
        if self._step.get("step") == "play":
            late, sent = self._player.stop()
            missed = max(self._seconds[self._step["scene"]] - sent, 0.0)
            rows = [
                {"item": "late_ms", "value": round(1e3 * late, 2)},
                {"item": "missed_ms", "value": round(1e3 * missed, 2)},
            ]
        if self._sitting and not self._player.halted:
            self._sitting.take(number, rows, seconds)

    def _state(self) -> JsonObject:
        return {
            "form": self._form,
            "participants": [
                [name, one.done, len(one.steps)] for name, one in self._sittings.items()
            ],
            "devices": [
                [
                    key,
                    output.profile.title,
                    output.status.message or output.status.state,
                    [actuator.name for actuator in output.profile.actuators],
                ]
                for key, output in self._outputs.items()
            ],
            "exposure": self.exposure,
            "halted": self._player.halted,
            "body": body({}),
            "seconds": self._seconds,
            "sitting": self._sitting and self._sitting.participant,
            "step": self._step or None,
        }
