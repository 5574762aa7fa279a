"""``haptic-tracing study run``: two local pages, on which people feel, look and answer."""

from __future__ import annotations

import argparse
import json
import math
import secrets
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from http import HTTPStatus
from importlib import import_module
from mimetypes import guess_type
from pathlib import Path
from typing import Any, get_args
from urllib.parse import unquote

import numpy as np
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.sync.server import Server, ServerConnection, serve

from ..core.arrays import FloatArray
from ..core.devices.mapping import Place, map_listeners
from ..core.formats.tracks.wav import read
from ..core.forms import Form, JsonObject
from ..core.scene.body_map import View
from ..study.people.body import svg
from ..study.people.exposure import daily, limits_of
from ..study.people.plan import FORM, begin, read_form, stimuli
from ..study.people.sitting import Sitting
from . import say
from .serve.stage import DeviceStage
from .study_playing import RATE, FilmPlayer

PAGES = ("experimenter", "participant")
_FOLDER = Path(import_module("..study.people", __package__).__path__[0])


def run(args: argparse.Namespace) -> int:
    """Prepare what is missing, then serve the pages until Ctrl-C."""
    form = read_form(args.out)
    if not all(path.exists() for path in stimuli(args.out, form).values()):
        import_module(".study_stimuli", __package__).prepare(args.out, form)
    if args.prepare:
        return 0
    stage = DeviceStage.of(args.device)
    try:
        study = Study(args.out, form, args.participants, stage)
        with study.listen(args.port) as server:
            say(study.pages)
            server.serve_forever()
    finally:
        stage.close()
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
        files = stimuli(folder, form)
        self._tracks = {key: read(path) for key, path in files.items() if key[1]}
        ways = {
            tuple((one.name, one.body_part or one.name, one.sample_rate) for one in track.channels)
            for track in self._tracks.values()
        }
        names, self._parts, rates = zip(*ways.pop(), strict=True)
        if ways or rates[0] != RATE:
            raise ValueError(f"{folder}: all tracks need the same listeners, and {RATE} Hz")
        self._seconds = {
            key[0]: track.stored.shape[1] / RATE for key, track in self._tracks.items()
        }
        levels: dict[str, dict[str, list[float]]] = {name: {} for name in form["conditions"]}
        for scene, condition in self._tracks:
            rms = np.sqrt((self._samples(scene, condition) ** 2).mean(axis=1))
            levels[condition][scene] = rms.round(6).tolist()
        devices = {key: output.profile for key, output in self._outputs.items()}
        listeners = dict(zip(names, self._parts, strict=True))
        self._mapping = map_listeners(listeners, devices, chosen=self._chosen(listeners))
        self._plan = begin(folder, form, participants, self._parts, levels)
        self.exposure = [self._exposed(part) for part in dict.fromkeys(self._parts)]
        self._player = FilmPlayer(stage)
        self._sitting: Sitting | None = None
        self._served = {role: _FOLDER / f"{role}.html" for role in PAGES}
        self._served |= {f"film/{key[0]}": file for key, file in files.items() if not key[1]}
        self._connections: set[ServerConnection] = set()
        self._lock = threading.RLock()

    def _samples(self, scene: str, condition: str) -> FloatArray:
        return np.asarray(self._tracks[scene, condition].stored, dtype=np.float64)

    def _chosen(self, listeners: Mapping[str, str]) -> dict[str, list[Place]]:
        """The actuators of the listeners to whose body parts the form gives a device. Raises
        ValueError."""
        chosen: dict[str, list[Place]] = {}
        for part, text in self._form.get("devices", {}).items():
            places = [
                Place(key, actuator.name)
                for key, output in self._outputs.items()
                for actuator in output.profile.actuators
                if part in actuator.body_parts
                and text.lower() in f"{key} {output.profile.title}".lower()
            ]
            if not places or part not in self._parts:
                raise ValueError(
                    f"{self._folder / FORM}: devices: {part} = {text!r}: needs a listener and a "
                    "connected device there"
                )
            chosen |= {name: places for name, place in listeners.items() if place == part}
        return chosen

    def _exposed(self, part: str) -> list[Any]:
        """A body part as in `exposure`. A(8) is the sum of its listeners', never too low."""
        played, total = True, 0.0
        for number in (k for k, own in enumerate(self._parts) if own == part):
            actuators = [
                (gains[number], actuator.device)
                for key, output in self._outputs.items()
                for gains, actuator in zip(
                    self._mapping.weights[key], output.profile.actuators, strict=True
                )
                if gains[number]
            ]
            channels = [track.channels[number] for track in self._tracks.values()]
            tracks = [(np.asarray(channel.samples), channel.device) for channel in channels]
            value = daily(tracks, RATE, actuators, part)
            total += math.nan if value is None else value
            played = played and bool(actuators)
        return [part, played, None if math.isnan(total) else total, *limits_of(part)]

    def listen(self, port: int) -> Server:
        """The server, on this machine only. Raises OSError."""
        server = serve(self._handle, "127.0.0.1", port, process_request=self._admit)
        self._host = f"127.0.0.1:{server.socket.getsockname()[1]}"
        self._root = f"/{secrets.token_urlsafe(12)}/"
        self.pages = [f"http://{self._host}{self._root}{role}" for role in PAGES]
        return server

    def _admit(self, connection: ServerConnection, request: Request) -> Response | None:
        """Pages and films over HTTP, and the WebSockets of the pages."""
        name = unquote(request.path).removeprefix(self._root)
        if request.headers.get("Host") != self._host or name not in self._served:
            return connection.respond(HTTPStatus.FORBIDDEN, "not a page of this study\n")
        if "Upgrade" in request.headers:
            return None
        body, kind = self._served[name].read_bytes(), guess_type(self._served[name].name)[0]
        headers = Headers({"Content-Type": str(kind), "Content-Length": str(len(body))})
        return Response(HTTPStatus.OK, "OK", headers, body)

    def _handle(self, connection: ServerConnection) -> None:
        """Do what a page asks for until it is closed. The participant's page takes the vibration
        with it."""
        self._connections.add(connection)
        try:
            self._show()
            for text in connection:
                asked, *values = json.loads(text)
                if asked == "ping":
                    connection.send(json.dumps({"ping": values[0], "clock": time.perf_counter()}))
                    continue
                if asked == "halt":  # waits for nothing
                    self._player.halt("emergency stop")
                with self._lock:
                    goes_on = getattr(self, f"_on_{asked}")(*values)
                if not goes_on:
                    self._show()
        except (ConnectionClosed, ValueError, TypeError, KeyError, AttributeError):
            pass  # what does not speak as a page does is not answered
        finally:
            self._connections.remove(connection)
            pages = [one.request.path for one in self._connections if one.request is not None]
            if not any(page.endswith("participant") for page in pages):
                self._player.stop()

    def _note(self, what: str) -> None:
        if self._sitting is not None:
            self._sitting.note(what)

    def _on_look(self) -> None:
        """Show how devices are."""

    def _on_halt(self) -> None:
        self._note("stopped")

    def _on_resume(self) -> None:
        self._note(f"goes on after: {self._player.halted}")
        self._player.resume()

    def _on_begin(self, name: str) -> None:
        """Let a participant sit down."""
        self._player.stop()
        self._sitting = Sitting(self._folder, name, self._plan)

    def _on_touch(self, key: str, row: int) -> None:
        """Play half a second of 160 Hz on one actuator."""
        tone = np.zeros((len(self._outputs[key].profile.actuators), RATE // 2))
        tone[row] = 0.6 * np.sin(2 * np.pi * 160 * np.arange(RATE // 2) / RATE)
        self._player.touch(key, tone)

    def _on_play(self) -> None:
        """Begin a section; the film says when."""
        step = self._sitting.step if self._sitting is not None else None
        if step is not None and step["step"] == "play":
            self._player.load(self._mapping.blocks(self._samples(step["scene"], step["condition"])))
            self._note(f"plays {step['scene']}, {step['condition']}")

    def _on_picture(self, film: float, shown: float) -> bool:
        """Follow the film. Returns whether it goes on."""
        self._player.follow(film, shown)
        return not self._player.halted

    def _on_answer(self, number: int, answer: Any) -> None:
        """Take an answer; a section has been played if no device was lost."""
        sitting = self._sitting
        if sitting is not None and sitting.step is not None:
            if sitting.step["step"] == "play":
                late, sent = self._player.stop()
                missed = max(self._seconds[sitting.step["scene"]] - sent, 0.0)
                answer = [round(1e3 * late, 2), round(1e3 * missed, 2)]
            if not self._player.halted:
                sitting.take(number, answer)

    def _show(self) -> None:
        """Send all pages what they show."""
        state = json.dumps(self._state())
        for connection in list(self._connections):
            with suppress(ConnectionClosed):
                connection.send(state)

    def _state(self) -> JsonObject:
        sitting = self._sitting
        everybody = [Sitting(self._folder, name, self._plan) for name in self._plan["orders"]]
        return {
            "form": {**self._form, "about": list(self._form["about"].items())},
            "participants": [[one.participant, one.done, len(one.steps)] for one in everybody],
            "devices": [
                {
                    "key": key,
                    "title": output.profile.title,
                    "state": output.status.message or output.status.state,
                    "actuators": [actuator.name for actuator in output.profile.actuators],
                }
                for key, output in self._outputs.items()
            ],
            "exposure": self.exposure,
            "halted": self._player.halted,
            "bodies": [svg(view) for view in get_args(View)],
            "seconds": self._seconds,
            "sitting": sitting and sitting.participant,
            "number": sitting and sitting.done,
            "step": sitting and sitting.step,
        }
