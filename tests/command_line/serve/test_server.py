"""The server as a program: connections, tokens, origins, slow readers, OSC, and devices that fall
silent."""

from __future__ import annotations

import json
import re
import shutil
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from contextlib import ExitStack, closing
from pathlib import Path

import numpy as np
import pytest
from bounded_program import bounded
from bounded_program import run as run_bounded
from crate_on_ground import SCENE
from haptic_tracing.command_line.serve import Door, LiveView
from haptic_tracing.command_line.serve.conversation import MOST_OBJECTS, Conversation
from haptic_tracing.command_line.serve.osc import OscDoor
from haptic_tracing.command_line.serve.stage import DeviceStage
from haptic_tracing.core.run_time import Scene, load
from pythonosc.dispatcher import Dispatcher
from pythonosc.osc_bundle_builder import OscBundleBuilder
from pythonosc.osc_message_builder import OscMessageBuilder
from pythonosc.osc_server import BlockingOSCUDPServer
from pythonosc.udp_client import SimpleUDPClient
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

pytestmark = pytest.mark.slow
DEVICES = Path(__file__).parents[2] / "core" / "devices"


class Served:
    """A running server. ``url``, ``token``: those it has printed."""

    def __init__(self, *arguments, prefix=()):
        command = [
            *prefix,
            sys.executable,
            "-m",
            "haptic_tracing",
            "serve",
            "--listen",
            "127.0.0.1:0",
            *map(str, arguments),
        ]
        self._stack = ExitStack()
        self.process = self._stack.enter_context(
            bounded(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL)
        )
        line = self.process.stderr.readline()
        found = re.fullmatch(r"listening on (ws://\S+), token (\S+)\n", line)
        assert found, line + self.stop()
        self.url, self.token = found.groups()

    def stop(self):
        with self._stack:
            self.process.terminate()
            self.process.wait(60)
            return self.process.stderr.read()


@pytest.fixture
def scene_file(tmp_path):
    path = tmp_path / "scene.json"
    path.write_text(json.dumps({"format": "haptic-scene", "version": "1.1", **SCENE}))
    return path


@pytest.fixture
def served(scene_file):
    server = Served(scene_file)
    yield server
    assert "Traceback" not in server.stop()


def ask(client, **message):
    client.send(json.dumps(message))
    return json.loads(client.recv(timeout=20))


def test_two_clients_have_a_run_each(served):
    with connect(served.url) as one, connect(served.url) as other:
        assert ask(one, type="hello", version=1)["objects"] == ["ground", "crate"]
        assert ask(
            other,
            type="hello",
            version=1,
            scene={"objects": [{"name": "moon", "kappa": 0, "rho": 0}]},
        )["objects"] == ["moon"]
        far = ask(one, type="step", time=0.0, poses={"crate": [0, 0, 9, 1, 0, 0, 0]})
        assert far["levels"]["hand"]["level"] is None
        assert ask(other, type="step", time=0.0)["levels"] == {}
        one.send(json.dumps({"type": "step", "time": 0.1, "samples": True}))
        frame, block = json.loads(one.recv(timeout=20)), one.recv(timeout=20)
        assert len(block) == 4 * frame["n"] * len(frame["listeners"])


def test_pages_of_other_origins_and_names_are_refused(served, scene_file):
    with pytest.raises(InvalidStatus, match="403"):
        connect(served.url, origin="https://example.org", legacy=True)
    with pytest.raises(InvalidStatus, match="403"):
        connect(
            "ws://example.org",
            sock=socket.create_connection(("127.0.0.1", int(served.url.rpartition(":")[2]))),
            legacy=True,
        )
    allowed = Served(scene_file, "--allow-origin", "https://example.org")
    with connect(allowed.url, origin="https://example.org") as client:
        assert ask(client, type="hello", version=1)["type"] == "scene"
    assert "Traceback" not in allowed.stop()
    health = served.url.replace("ws:", "http:") + "/health"
    assert urllib.request.urlopen(health, timeout=60).read() == b"ok\n"


def test_other_machines_need_a_token(scene_file):
    command = [
        sys.executable,
        "-m",
        "haptic_tracing",
        "serve",
        str(scene_file),
        "--listen",
        "0.0.0.0:0",
    ]
    done = run_bounded(command)
    assert done.returncode == 2
    assert "--token" in done.stderr
    server = Served(scene_file, "--listen", "0.0.0.0:0", "--token", "secret")
    url = server.url.replace("0.0.0.0", "127.0.0.1")
    with connect(url) as client:
        assert ask(client, type="hello", version=1)["where"] == "/token"
        assert ask(client, type="step", time=0.0)["where"] == "/token"
        assert ask(client, type="hello", version=1, token="secret")["type"] == "scene"
    assert "Traceback" not in server.stop()


def test_a_message_above_4_mb_is_refused(served):
    with connect(served.url) as client:
        client.send("[" + " " * (4 * 2**20) + "]")
        with pytest.raises(ConnectionClosed):
            client.recv(timeout=20)


def test_requests_that_come_to_nothing_take_no_place_and_leave_no_traceback(served):
    """Requests without a key, as by a page's `fetch`, and clients that go in the handshake."""
    address = served.url.removeprefix("ws://")
    host, port = address.split(":")
    where = host, int(port)
    request = f"GET / HTTP/1.1\r\nHost: {address}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    key = "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
    for _ in range(12):
        with socket.create_connection(where, 20) as one:
            one.sendall(f"{request}\r\n".encode())
            assert one.recv(100).startswith(b"HTTP/1.1 400")
        with socket.create_connection(where, 20) as one:
            one.sendall(f"{request}{key}\r\n".encode())
    deadline = time.monotonic() + 20
    with ExitStack() as stack:
        clients = []
        while len(clients) < 8 and time.monotonic() < deadline:
            try:
                clients.append(stack.enter_context(connect(served.url)))
            except InvalidStatus:  # one of those that went is not counted out yet
                time.sleep(0.05)
        assert len(clients) == 8
        assert all(ask(one, type="hello", version=1)["type"] == "scene" for one in clients)


def test_a_slow_reader_loses_frames_but_no_blow_no_id_and_no_sample(served):
    """A client that sends by its clock and reads nothing for a while: each id is answered or named
    as dropped, samples are numbered without a gap, and each blow arrives, once."""
    with connect(served.url, max_queue=1) as client:
        scene = SCENE | {"rules": {"least_energy": 0.5, "full_energy": 100}}
        ask(client, type="hello", version=1, scene=scene)
        count, sent = 1200, threading.Event()

        def send():
            for k in range(count):
                up = (k / 60) % 0.5 - 0.25
                pose = [0, 0, 0.5 + 9.81 / 2 * (0.25**2 - up**2), 1, 0, 0, 0]
                step = {"type": "step", "id": k, "time": k / 60, "poses": {"crate": pose}}
                client.send(json.dumps(step | {"samples": k % 7 == 0}))
            sent.set()

        threading.Thread(target=send, daemon=True).start()
        time.sleep(2.0)
        answered, blows, following = [], [], 0
        while not answered or answered[-1] != count - 1:
            message = client.recv(timeout=30)
            if isinstance(message, bytes):
                continue
            frame = json.loads(message)
            for part in (*frame.get("dropped", ()), frame):
                assert part["first_sample"] == following
                following += part["n"]
                answered += part["answers"]
            blows += [blow["time"] for blow in frame["impacts"]]
        assert answered == list(range(count))
        assert sent.wait(20)
        # It lands at each half second but at 0, when it is first seen.
        assert len(blows) == 39
        assert np.abs(np.array(blows) - np.arange(1, 40) / 2).max() < 0.01


def test_a_flood_is_answered_by_the_newest_step(served):
    """What waits is answered together, so that few frames answer a flood; a client that waits for
    each answer gets one for each step."""
    with connect(served.url) as client:
        ask(client, type="hello", version=1)
        frames = [ask(client, type="step", id=k, time=k / 60) for k in range(20)]
        assert [frame["answers"] for frame in frames] == [[k] for k in range(20)]
        count = 2000
        threading.Thread(
            target=lambda: [
                client.send(json.dumps({"type": "step", "id": k, "time": k / 60}))
                for k in range(20, count)
            ],
            daemon=True,
        ).start()
        answered, received = [], 0
        while not answered or answered[-1] != count - 1:
            frame = json.loads(client.recv(timeout=20))
            assert frame["id"] == frame["answers"][-1]
            answered += [one for part in frame.get("dropped", ()) for one in part["answers"]]
            answered += frame["answers"]
            received += 1
        assert answered == list(range(20, count))
        assert received < count / 2


def test_an_engine_that_just_goes_leaves_no_traceback(served):
    for _ in range(3):
        client = connect(served.url, legacy=True)
        ask(client, type="hello", version=1)
        client.socket.shutdown(socket.SHUT_RDWR)
    with connect(served.url) as client:
        assert ask(client, type="hello", version=1)["type"] == "scene"


def test_osc_is_answered_where_it_came_from(scene_file):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    server = Served(scene_file, "--osc", port)
    heard = []
    dispatcher = Dispatcher()
    dispatcher.set_default_handler(lambda address, *values: heard.append((address, *values)))
    answers = BlockingOSCUDPServer(("127.0.0.1", 0), dispatcher)
    answers.timeout = 20
    to = SimpleUDPClient("127.0.0.1", port)
    to._sock = answers.socket  # answers go to the port that asks
    to.send_message("/haptic/step", 0.0)
    answers.handle_request()
    to.send_message("/haptic/pose", ["crate", 0.0, 0.0, 9.0, 1.0, 0.0, 0.0, 0.0])
    to.send_message("/haptic/step", 0.1)
    answers.handle_request()
    to.send_message("/haptic/pose", ["moon", 0.0])
    to.send_message("/haptic/step", 0.2)
    answers.handle_request()
    answers.server_close()
    assert "Traceback" not in server.stop()
    (first, hand, level, _), (second, _, silence, _), (third, where, _) = heard
    assert (first, hand, second, third, where) == (
        "/haptic/level",
        "hand",
        "/haptic/level",
        "/haptic/error",
        "/poses/moon",
    )
    assert level > -60 > silence


def test_osc_waits_for_no_date_and_keeps_a_bounded_number_of_poses():
    """A bundle dated 20 s ahead, and poses of things that don't exist, with long names and lists,
    for which no step comes."""
    conversation = Conversation(Scene(**SCENE))
    with closing(OscDoor(conversation, 0)) as osc:
        osc.start()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
            client.bind(("127.0.0.1", 0))
            client.settimeout(20)
            to = osc.server.server_address

            def ask(*values):
                message = OscMessageBuilder("/haptic/step")
                for value in values:
                    message.add_arg(value, "d")
                client.sendto(message.build().dgram, to)
                return client.recv(9000)

            assert b"/haptic/level" in ask(0.0)
            ahead = OscBundleBuilder(time.time() + 20)
            ahead.add_content(OscMessageBuilder("/haptic/stop").build())
            client.sendto(ahead.build().dgram, to)
            begun = time.monotonic()
            assert b"/haptic/level" in ask(0.1)
            assert time.monotonic() - begun < 10
            lock = threading.Lock()  # the server is busy while steps come
            answers = conversation.answers

            def wait(texts):
                with lock:
                    told.append(len(texts))
                    return [*answers(texts)]

            told = []
            conversation.answers = wait
            with lock:
                for k in range(30):
                    message = OscMessageBuilder("/haptic/step")
                    message.add_arg(0.2 + k / 60, "d")
                    client.sendto(message.build().dgram, to)
                time.sleep(0.2)
            levels = [client.recv(9000)]
            client.settimeout(2)
            with pytest.raises(TimeoutError):
                while True:
                    levels.append(client.recv(9000))
            assert sum(told) == 30 and len(told) == len(levels) <= 3
        for k in range(2 * MOST_OBJECTS):
            osc._pose("/haptic/pose", f"{k} " + "x" * 5000, *range(500))
    assert len(osc._poses) == MOST_OBJECTS
    assert max(len(name) for name in osc._poses) <= 1024
    assert max(len(pose) for pose in osc._poses.values()) <= 8


@pytest.mark.parametrize(
    ("holder", "told"), [(None, [None, "another client"]), ("OSC", ["OSC", "OSC"])]
)
def test_who_does_not_get_the_devices_is_told_who_has_them(scene_file, holder, told):
    stage = DeviceStage({})
    door = Door(
        load(scene_file), stage, "127.0.0.1", "secret", (), LiveView(sys.stderr).show, holder
    )
    with door.listen(0) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        url = f"ws://127.0.0.1:{server.socket.getsockname()[1]}"
        with connect(url) as one, connect(url) as two, connect(url) as stranger:
            answers = [
                ask(client, type="hello", version=1, token="secret") for client in (one, two)
            ]
            silent = ask(stranger, type="hello", version=1, token="guessed")
        server.shutdown()
    stage.close()
    assert [answer.get("warnings") for answer in answers] == [
        who and [f"the devices play for {who}"] for who in told
    ]
    assert "warnings" not in silent


def test_osc_gets_devices_only_where_it_is_answered(scene_file):
    with pytest.raises(AssertionError, match="--osc-devices: needs --osc"):
        Served(scene_file, "--osc-devices")


@pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="umockdev and hidraw exist on Linux only"
)
@pytest.mark.parametrize("ending", ["no more steps", "client goes", "server is killed"])
def test_devices_fall_silent(tmp_path, ending):
    """A pad plays the steps of a client with the token, and nothing 250 ms after the last one,
    whoever ends."""
    if shutil.which("umockdev-run") is None:
        pytest.fail("umockdev-run is not installed: on Debian and Ubuntu, apt-get install umockdev")
    sys.path.insert(0, str(DEVICES))
    from made_up_devices import XBOX_BT, describe

    loud = {
        **SCENE,
        "listeners": [
            {
                "name": "hand",
                "object": "ground",
                "position": [2, 1, 0],
                "body_part": "hand.L",
                "radius": 0,
            }
        ],
    }
    (tmp_path / "loud.json").write_text(
        json.dumps({"format": "haptic-scene", "version": "1.1", **loud})
    )
    command = [
        "umockdev-run",
        *describe(tmp_path, [XBOX_BT]),
        "--",
        sys.executable,
        str(Path(__file__).parent / "pad_of_a_server.py"),
    ]
    done = run_bounded([*command, str(tmp_path), ending])
    assert done.returncode == 0, done.stderr
    reports, last_step = json.loads(done.stdout.splitlines()[-1])
    times = np.array([seconds for seconds, _ in reports])
    strengths = np.array([max(bytes.fromhex(report)[2:6]) for _, report in reports])
    assert strengths.max() > 0
    assert times[strengths > 0].max() <= last_step + 0.25
    assert strengths[-1] == 0
