"""``haptic-tracing study run``: two local pages, on which people feel, look and answer."""

from __future__ import annotations

import argparse
import json
import math
import secrets
import threading
import time
from collections.abc import Mapping
from contextlib import closing, suppress
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
from ..core.devices.mapping import ListenerMapping, map_listeners
from ..core.formats.tracks.wav import read
from ..core.forms import Form, JsonObject
from ..core.scene.body_map import View
from ..study.people.body import svg
from ..study.people.exposure import daily, limits_of
from ..study.people.plan import FORM, HERE, begin, read_form, stimuli
from ..study.people.sitting import Sitting
from . import say
from .serve.stage import DeviceStage
from .study_playing import RATE, FilmPlayer

PAGES = ("experimenter", "participant")
_TONE = 0.6 * np.sin(2 * np.pi * 160 * np.arange(RATE // 2) / RATE)


def run(args: argparse.Namespace) -> int:
    """Prepare what is missing, then serve the pages until Ctrl-C."""
    form = read_form(args.out)
    if not all(path.exists() for path in stimuli(args.out, form).values()):
        import_module(".study_stimuli", __package__).prepare(args.out, form)
    if args.prepare:
        return 0
    with closing(DeviceStage.of(args.device)) as stage:
        study = Study(args.out, form, args.participants, stage)
        with study.listen(args.port) as server:
            say(study.pages)
            server.serve_forever()
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
        self._served = {role: HERE / f"{role}.html" for role in PAGES}
        self._served |= {f"film/{key[0]}": file for key, file in files.items() if not key[1]}
        self._tracks = {key: read(path) for key, path in files.items() if key[1]}
        ways = {
            tuple((one.name, one.body_part or one.name, one.sample_rate) for one in track.channels)
            for track in self._tracks.values()
        }
        names, parts, rates = zip(*ways.pop(), strict=True)
        if ways or rates[0] != RATE:
            raise ValueError(f"{folder}: all tracks need the same listeners, and {RATE} Hz")
        self._parts = np.array(parts)
        self._seconds = {
            scene: track.stored.shape[1] / RATE for (scene, _), track in self._tracks.items()
        }
        levels = {
            condition: {scene: self._levels(scene, condition) for scene in form["scenes"]}
            for condition in form["conditions"]
        }
        self._mapping = self._mapped(dict(zip(names, parts, strict=True)))
        self._plan = begin(folder, form, participants, parts, levels)
        self.exposure = [self._exposed(part) for part in dict.fromkeys(parts)]
        self._player = FilmPlayer(stage)
        self._sitting: Sitting | None = None
        self._connections: set[ServerConnection] = set()
        self._lock = threading.RLock()

    def _samples(self, scene: str, condition: str) -> FloatArray:
        return np.asarray(self._tracks[scene, condition].stored, dtype=np.float64)

    def _levels(self, scene: str, condition: str) -> list[float]:
        """RMS by listener."""
        rms = np.sqrt((self._samples(scene, condition) ** 2).mean(axis=1))
        return list(rms.round(6).tolist())

    def _mapped(self, listeners: Mapping[str, str]) -> ListenerMapping:
        """The actuators of the listeners, on the devices that the form gives to their body parts.
        Raises ValueError."""
        devices = {key: output.profile for key, output in self._outputs.items()}
        mapping = map_listeners(listeners, devices)
        for part, text in self._form.get("devices", {}).items():
            mine = self._parts == part
            for key, device in devices.items():
                if text.lower() not in f"{key} {device.title}".lower():
                    mapping.weights[key][:, mine] = 0.0
            if not any(weights[:, mine].any() for weights in mapping.weights.values()):
                raise ValueError(
                    f"{self._folder / FORM}: devices: {part} = {text!r}: needs a listener and a "
                    "connected device there"
                )
        return mapping

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
            played = played and bool(actuators)
        return [part, played, None if math.isnan(total) else total, *limits_of(part)]

    def listen(self, port: int) -> Server:
        """The server, on this machine only. Raises OSError."""
        server = serve(self._handle, "127.0.0.1", port, process_request=self._admit)
        host = f"http://127.0.0.1:{server.socket.getsockname()[1]}"
        self._root = f"/{secrets.token_urlsafe(12)}/"
        self.pages = [f"{host}{self._root}{role}" for role in PAGES]
        return server

    def _admit(self, connection: ServerConnection, request: Request) -> Response | None:
        """Pages and films over HTTP, and the WebSockets of the pages."""
        file = self._served.get(unquote(request.path).removeprefix(self._root))
        if file is None:
            return connection.respond(HTTPStatus.FORBIDDEN, "not a page of this study\n")
        if "Upgrade" in request.headers:
            return None
        body = file.read_bytes()
        kind = str(guess_type(file)[0])
        headers = Headers({"Content-Type": kind, "Content-Length": str(len(body))})
        return Response(HTTPStatus.OK, "OK", headers, body)

    def _handle(self, connection: ServerConnection) -> None:
        """Do what a page asks for until it is closed."""
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
                    if self._sitting and asked in ("play", "halt", "resume"):
                        self._sitting.note(asked)
                    getattr(self, f"_on_{asked}")(*values)
                if asked != "picture" or self._player.halted:
                    self._show()
        except (ConnectionClosed, ValueError, TypeError, KeyError, AttributeError):
            pass  # what does not speak as a page does is not answered
        finally:
            self._connections.remove(connection)

    @property
    def _step(self) -> JsonObject:
        """The step at which the current participant is; empty without a participant."""
        return self._sitting.step if self._sitting else {}

    def _on_look(self) -> None:
        """Show how devices are."""

    def _on_halt(self) -> None:
        """Show that the player has halted."""

    def _on_resume(self) -> None:
        self._player.resume()

    def _on_begin(self, name: str) -> None:
        """Let a participant sit down."""
        self._player.stop()
        self._sitting = Sitting(self._folder, name, self._plan)

    def _on_touch(self, key: str, row: int) -> None:
        """Play half a second of 160 Hz on one actuator."""
        output = self._outputs[key]
        if not self._player.halted:
            output.send(np.outer(np.eye(len(output.profile.actuators))[row], _TONE))

    def _on_play(self) -> None:
        """Begin a section; the film says when."""
        if self._step.get("step") == "play":
            samples = self._samples(self._step["scene"], self._step["condition"])
            self._player.load(self._mapping.blocks(samples))

    def _on_picture(self, film: float, shown: float) -> None:
        self._player.follow(film, shown)

    def _on_answer(self, number: int, rows: Any, seconds: float) -> None:
        """Take an answer; a section has been played if no device was lost."""
        if self._step.get("step") == "play":
            late, sent = self._player.stop()
            missed = max(self._seconds[self._step["scene"]] - sent, 0.0)
            times = {"late_ms": 1e3 * late, "missed_ms": 1e3 * missed}
            rows = [{"item": item, "value": round(value, 2)} for item, value in times.items()]
        if self._sitting and not self._player.halted:
            self._sitting.take(number, rows, seconds)

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
            "form": self._form,
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
            "bodies": [svg(view, {}) for view in get_args(View)],
            "seconds": self._seconds,
            "sitting": sitting and sitting.participant,
            "number": sitting and sitting.done,
            "step": self._step or None,
        }
