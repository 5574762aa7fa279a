"""Hostile clients, against the front that both servers have."""

from __future__ import annotations

import base64
import json
import re
import socket
import sys
import threading
import time
from contextlib import ExitStack, contextmanager, suppress
from types import SimpleNamespace
from urllib.parse import urlsplit

import pytest
import small_study
from crate_on_ground import SCENE
from haptic_tracing.command_line.serve import front as front_module
from haptic_tracing.command_line.serve.conversation import Conversation
from haptic_tracing.command_line.serve.front import MOST_CONNECTIONS, MOST_UNFINISHED, PATIENCE
from haptic_tracing.command_line.serve.sockets import Door
from haptic_tracing.command_line.serve.stage import DeviceStage
from haptic_tracing.core.run_time import Scene
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect


@pytest.fixture(params=["serve", "study"])
def served(request, tmp_path):
    """A running server: ``url`` of its WebSocket, and ``enter``, which says there what gets a place
    and returns whether it is answered."""
    with ExitStack() as stack:
        if request.param == "serve":
            yield stack.enter_context(door())
        else:
            study = stack.enter_context(small_study.served(tmp_path))
            yield SimpleNamespace(
                url=study.pages[0].replace("http:", "ws:"), enter=lambda one: said(one, ["ping", 0])
            )


@contextmanager
def door(stage=None):
    door = Door(Scene(**SCENE), stage, "127.0.0.1", "secret", (), lambda conversation: None)
    with door.listen(0) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        url = f"ws://127.0.0.1:{server.socket.getsockname()[1]}/"
        yield SimpleNamespace(url=url, enter=hello)
        server.shutdown()


def said(client, message):
    client.send(json.dumps(message))
    return json.loads(client.recv(timeout=20))


def hello(client, **more):
    answer = said(client, {"type": "hello", "version": 1, **more})
    return answer if answer["type"] == "scene" else None


def address(served):
    parts = urlsplit(served.url)
    return parts.hostname, parts.port


def request(served, path, **headers):
    """The status of an upgrade to a WebSocket that is asked for by hand."""
    host, port = address(served)
    fields = {
        "Host": f"{host}:{port}",
        "Upgrade": "websocket",
        "Connection": "Upgrade",
        "Sec-WebSocket-Key": base64.b64encode(bytes(16)).decode(),
        "Sec-WebSocket-Version": "13",
        **headers,
    }
    lines = [f"GET {path} HTTP/1.1", *(f"{key}: {value}" for key, value in fields.items())]
    with socket.create_connection((host, port), 20) as one:
        one.sendall(("\r\n".join(lines) + "\r\n\r\n").encode("latin-1"))
        answer = one.recv(200)
    return int(answer.split()[1]) if answer else None


def test_pages_of_other_origins_and_names_are_refused(served):
    path = urlsplit(served.url).path
    host, port = address(served)
    own = f"http://{host}:{port}"
    assert request(served, path) == 101
    assert request(served, path, Origin=own) == 101
    assert request(served, path, Host=f"localhost:{port}") == 101
    for headers in (
        {"Origin": "http://evil.example"},
        {"Origin": f"http://evil.example:{port}"},
        {"Origin": "null"},
        {"Host": f"evil.example:{port}"},
        {"Host": "127.0.0.1"},
        {"Host": ""},
    ):
        assert request(served, path, **headers) == 403, headers


def test_a_key_without_its_slash_or_with_bytes_opens_no_study(tmp_path):
    with small_study.served(tmp_path) as study:
        served = SimpleNamespace(url=study.pages[0].replace("http:", "ws:"))
        path = urlsplit(served.url).path
        key = path.rpartition("/")[0]
        assert request(served, path) == 101
        for wrong in ("experimenter", "/experimenter", "//experimenter", f"{key}x/experimenter",
                      path[1:], "/\xff", "*", f"{key}/../experimenter"):  # fmt: skip
            assert request(served, wrong) in (400, 403, None), wrong


def test_idle_connections_take_no_place_and_are_ended(served):
    """Sockets that say nothing, halves of requests, and WebSockets without a word."""
    host, port = address(served)
    with ExitStack() as stack:
        idle = []
        for k in range(3 * MOST_UNFINISHED):
            one = stack.enter_context(socket.create_connection((host, port), 20))
            if k % 2:
                one.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX-")
            idle.append(one)
        with connect(served.url) as client:
            assert served.enter(client)
            time.sleep(PATIENCE + 2)
            assert served.enter(client)
        for one in idle:
            one.settimeout(20)
            with suppress(ConnectionError):
                while one.recv(1000):
                    pass


def test_who_says_nothing_valid_is_closed_and_leaves_the_owner_a_place():
    with door() as served, ExitStack() as stack:
        silent = [stack.enter_context(connect(served.url)) for _ in range(MOST_UNFINISHED)]
        silent[-1].send("[]]")
        begun = time.monotonic()
        owner = stack.enter_context(connect(served.url))
        assert hello(owner)
        assert time.monotonic() - begun < PATIENCE / 2
        with pytest.raises(ConnectionClosed):
            while True:
                silent[-1].recv(timeout=PATIENCE + 10)
        assert hello(owner)


def test_a_ninth_client_is_told_and_gets_the_place_of_one_that_goes(served):
    with ExitStack() as stack:
        clients = [stack.enter_context(connect(served.url)) for _ in range(MOST_CONNECTIONS)]
        assert all(served.enter(client) for client in clients)
        ninth = stack.enter_context(connect(served.url))
        with suppress(ConnectionClosed):
            assert not served.enter(ninth)
        clients[0].close()
        end = time.monotonic() + 20
        while True:  # the server counts a client out once it has noticed
            with connect(served.url) as another, suppress(ConnectionClosed):
                if served.enter(another):
                    break
            assert time.monotonic() < end
            time.sleep(0.05)


def test_a_lack_of_descriptors_passes(served, monkeypatch):
    """The system refuses to accept for a while, as where no file descriptor is left."""
    failing = threading.Event()
    accept = socket.socket.accept

    def refuse(self):
        if failing.is_set():
            raise OSError(24, "Too many open files")
        return accept(self)

    monkeypatch.setattr(socket.socket, "accept", refuse)
    failing.set()
    host, port = address(served)
    waiting = socket.create_connection((host, port), 20)
    time.sleep(0.3)
    failing.clear()
    with waiting, connect(served.url) as client:
        assert served.enter(client)


def test_a_server_that_can_not_go_on_says_so():
    door = Door(None, None, "127.0.0.1", "secret", (), lambda conversation: None)
    server = door.listen(0)
    threading.Timer(0.2, server.shutdown).start()
    with pytest.raises(OSError, match="can't accept"):
        front_module.serve_forever(server)


def test_devices_go_to_who_asks_with_the_token_where_their_holder_is_gone():
    """A client that reads nothing, nor answers pings, loses the devices to another that has the
    token; one that only lets time pass keeps them."""
    stage = DeviceStage({})
    with door(stage) as served, ExitStack() as stack:
        idle = stack.enter_context(connect(served.url))
        assert "warnings" not in hello(idle, token="secret")
        other = stack.enter_context(connect(served.url))
        assert hello(other, token="secret")["warnings"] == ["the devices play for another client"]
        idle.close()
        host, port = address(served)
        dead = socket.create_connection((host, port), 20)
        stack.callback(dead.close)
        key = base64.b64encode(bytes(16)).decode()
        dead.sendall(
            f"GET / HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade"
            f"\r\nSec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        assert dead.recv(1000).startswith(b"HTTP/1.1 101")
        text = json.dumps({"type": "hello", "version": 1, "token": "secret"}).encode()
        end = time.monotonic() + 20
        dead.sendall(bytes([0x81, 0x80 | len(text)]) + bytes(4) + text)
        assert b'"warnings"' not in dead.recv(4000)
        stranger = stack.enter_context(connect(served.url))
        assert "warnings" not in hello(stranger)
        begun = time.monotonic()
        asking = stack.enter_context(connect(served.url))
        assert "warnings" not in hello(asking, token="secret")
        assert 1.5 < time.monotonic() - begun < min(10, end - begun)
        third = stack.enter_context(connect(served.url))
        assert "warnings" in hello(third, token="secret")
    stage.close()


def test_names_reach_the_terminal_without_escape_sequences(capsys, monkeypatch):
    from haptic_tracing.command_line.serve.live_view import LiveView

    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    conversation = Conversation(None)
    scene = {
        **SCENE,
        "listeners": [{"name": "\x1b]0;owned\x07", "object": "crate", "position": [0, 0, 1]}],
    }
    conversation.answer(json.dumps({"type": "hello", "version": 1, "scene": scene}))
    conversation.answer(json.dumps({"type": "step", "time": 0.0}))
    LiveView(sys.stdout).show(conversation)
    shown = capsys.readouterr().out
    assert "owned" in shown
    assert re.search(r"[\x00-\x0c\x0e-\x1f\x7f]", shown) is None
