"""Haptic players against servers of the package ``websockets``, which speak as the players do."""

import json
import socket
import sys
import threading
import time
from contextlib import suppress

import numpy as np
import pytest
from fake_hid import until
from haptic_tracing.core.devices import network
from haptic_tracing.core.devices.connection import DeviceError
from haptic_tracing.core.devices.loopback import websockets_client
from haptic_tracing.core.devices.network import bhaptics, intiface
from haptic_tracing.core.devices.writer import DeviceWriter
from websockets.exceptions import ConnectionClosed
from websockets.sync.server import serve

VIBRATE = {"StepCount": 20, "ActuatorType": "Vibrate", "FeatureDescriptor": ""}
DEVICES = [
    {"DeviceIndex": 0, "DeviceName": "Cushion", "DeviceMessageTimingGap": 100, "DeviceMessages": {"ScalarCmd": [VIBRATE, VIBRATE]}},
    {"DeviceIndex": 3, "DeviceName": "Ring", "DeviceMessages": {"ScalarCmd": [{**VIBRATE, "ActuatorType": "Rotate"}, VIBRATE]}},
    {"DeviceIndex": 4, "DeviceName": "Light", "DeviceMessages": {"StopDeviceCmd": {}}},
]


class Server:
    """A player that keeps what it is told. It listens on the loopback address only."""

    def __init__(self, answer=lambda message: [], port=0):
        self.answer, self.said, self.connections = answer, [], []
        self.server = serve(self.talk, "127.0.0.1", port)
        self.port = self.server.socket.getsockname()[1]
        self.url = f"ws://127.0.0.1:{self.port}"
        self.thread = threading.Thread(target=self.server.serve_forever, daemon=True)
        self.thread.start()

    def talk(self, connection):
        self.connections.append(connection)
        try:
            for text in connection:
                message = json.loads(text)
                self.said.append(message)
                for reply in self.answer(message):
                    connection.send(json.dumps(reply))
        except ConnectionClosed:
            pass

    def close(self):
        for connection in self.connections:
            connection.close()
        self.server.shutdown()
        self.thread.join()


def buttplug(messages):
    (message,) = messages
    ((kind, content),) = message.items()
    number = content["Id"]
    if kind == "RequestServerInfo":
        assert content["MessageVersion"] == 3 and content["ClientName"]
        return [[{"ServerInfo": {"Id": number, "ServerName": "made up", "MessageVersion": 3, "MaxPingTime": 0}}]]
    if kind == "RequestDeviceList":
        return [[{"DeviceAdded": {"Id": 0}}], [{"DeviceList": {"Id": number, "Devices": DEVICES}}]]
    return [[{"Ok": {"Id": number}}]]


@pytest.fixture
def server():
    servers = []

    def start(*arguments, kind=Server, **options):
        servers.append(kind(*arguments, **options))
        return servers[-1]

    yield start
    for running in servers:
        running.close()


@pytest.fixture
def started():
    outputs = []

    def start(profile, module):
        output = DeviceWriter(profile, hid=module)
        outputs.append(output)
        output.start()
        until(lambda: output.status.state == "open")
        return output

    yield start
    ended = [output.stop(60.0) for output in outputs]
    assert all(ended)


def wave(rows, *loud):
    block = np.zeros((rows, 800))
    block[list(loud)] = np.sin(2 * np.pi * 150 * np.arange(800) / 8000)
    return block


def commands(server, kind):
    return [message[0][kind] for message in server.said if kind in message[0]]


def test_intifaces_motors_are_driven_silenced_and_stopped(server, started):
    made_up = server(buttplug)
    (cushion, module), (ring, ring_module) = intiface(made_up.url)
    assert [actuator.name for actuator in cushion.actuators] == ["motor 1", "motor 2"]
    assert (cushion.title, ring.title, len(ring.actuators)) == ("Cushion", "Ring", 1)
    assert (cushion.interval("usb"), ring.interval("usb")) == (0.1, 0.05)
    output, other = started(cushion, module), started(ring, ring_module)

    def levels(device):
        return [[s["Scalar"] for s in c["Scalars"]] for c in commands(made_up, "ScalarCmd") if c["DeviceIndex"] == device]

    until(lambda: (output.send(wave(2, 1)), any(second > 0.9 for _, second in levels(0)))[-1])
    assert all(first == 0 for first, _ in levels(0))
    until(lambda: (other.send(wave(1, 0)), any(only > 0.9 for (only,) in levels(3)))[-1])
    assert commands(made_up, "ScalarCmd")[-1]["Scalars"][0]["Index"] in (0, 1)
    output.stop()
    until(lambda: commands(made_up, "StopDeviceCmd"))
    assert commands(made_up, "StopDeviceCmd")[-1]["DeviceIndex"] == 0
    assert levels(0)[-1] == [0.0, 0.0]
    assert len(made_up.connections) == 2, "one to ask, and one for both devices: Intiface takes a single client"


PING_TIME = 0.8


class StrictServer(Server):
    """Intiface with a MaxPingTime: what does not ping in time is told so, has its devices stopped, and is cut off."""

    def __init__(self, port=0):
        self.cut = 0
        super().__init__(self.reply, port)

    def reply(self, messages):
        answers = buttplug(messages)
        for (message,) in answers:
            if "ServerInfo" in message:
                message["ServerInfo"]["MaxPingTime"] = round(1000 * PING_TIME)
        return answers

    def talk(self, connection):
        self.connections.append(connection)
        due = time.monotonic() + PING_TIME
        with suppress(ConnectionClosed):
            while True:
                try:
                    message = json.loads(connection.recv(timeout=max(due - time.monotonic(), 0.0)))
                except TimeoutError:
                    if time.monotonic() > due + 0.05:  # the machine stood still, for both sides
                        due = time.monotonic() + PING_TIME
                        continue
                    self.cut += 1
                    connection.send(json.dumps([{"Error": {"Id": 0, "ErrorMessage": "Ping timed out", "ErrorCode": 2}}]))
                    connection.close()
                    return
                self.said.append(message)
                if "Ping" in message[0]:
                    due = time.monotonic() + PING_TIME
                for reply in self.answer(message):
                    connection.send(json.dumps(reply))


def pings():
    return [thread for thread in threading.enumerate() if thread.name == "haptics ping"]


@pytest.mark.slow
def test_a_connection_is_kept_alive_by_pings_while_nothing_plays_and_while_something_does(server, started):
    strict = server(kind=StrictServer)
    (cushion, module), _ = intiface(strict.url)
    assert not pings(), "the connection that asked for devices is closed"
    output = started(cushion, module)
    time.sleep(2 * PING_TIME)
    assert strict.cut == 0 and len(commands(strict, "Ping")) >= 2
    assert all(ping["Id"] >= 1 for ping in commands(strict, "Ping"))
    begun = time.monotonic()
    while time.monotonic() < begun + 2 * PING_TIME:
        output.send(wave(2, 0))
        time.sleep(0.05)
    assert strict.cut == 0 and output.status.losses == 0 and output.status.failed_writes == 0
    assert any(command["Scalars"][0]["Scalar"] > 0.9 for command in commands(strict, "ScalarCmd"))
    assert output.stop()
    assert strict.cut == 0 and not pings()


@pytest.mark.slow
def test_a_connection_without_pings_is_cut_off_which_is_noticed_and_mended(server, started, monkeypatch):
    strict = server(kind=StrictServer)
    monkeypatch.setattr(network, "_PINGS_IN_TIME", 0.1)  # far too late
    (cushion, module), _ = intiface(strict.url)
    output = started(cushion, module)
    until(lambda: strict.cut == 1)
    monkeypatch.undo()
    until(lambda: (output.send(wave(2, 0)), output.status.losses == 1)[-1])
    until(lambda: output.status.state == "open")
    until(lambda: (output.send(wave(2, 0)), commands(strict, "ScalarCmd")[-1:] and output.status.failed_writes == 3)[-1])
    time.sleep(1.5 * PING_TIME)
    assert strict.cut == 1, "the new connection pings"


@pytest.mark.parametrize("wanted", ["soon", [1], {}])
def test_a_ping_time_that_is_none_is_said(server, wanted):
    made_up = server(lambda message: [[{"ServerInfo": {"Id": 1, "MaxPingTime": wanted or {"a": 1}}}]])
    with pytest.raises(DeviceError, match="MaxPingTime"):
        intiface(made_up.url)


def test_bhaptics_gets_frames_that_end_by_themselves(server, started):
    made_up = server()
    profile, module = bhaptics(made_up.url)
    places = {actuator.name: actuator.body_parts for actuator in profile.actuators}
    assert places["upper back left"] == ("upper_back.L",)
    row = list(places).index("upper back left")
    output = started(profile, module)

    def loudest():
        output.send(wave(len(places), row))
        frames = [s["Frame"] for message in made_up.said for s in message["Submit"] if s["Type"] == "frame"]
        return [frame for frame in frames if any(point["Intensity"] > 90 for point in frame["DotPoints"])]

    until(loudest)
    (frame, *_) = loudest()
    assert frame["Position"] == "VestBack" and frame["DurationMillis"] == 100
    assert {point["Index"] for point in frame["DotPoints"] if point["Intensity"]} == {0, 1, 4, 5}
    assert sorted(point["Index"] for point in frame["DotPoints"]) == list(range(20))
    output.stop()
    until(lambda: made_up.said[-1] == {"Submit": [{"Type": "turnOffAll"}]})


@pytest.mark.slow
def test_a_player_that_ends_is_said_and_found_again(server, started):
    made_up = server()
    profile, module = bhaptics(made_up.url)
    output = started(profile, module)
    made_up.close()
    assert until(lambda: (output.send(wave(len(profile.actuators), 0)), output.status.losses == 1)[-1])
    assert until(lambda: "no player answers" in output.status.message)
    server(port=made_up.port)
    assert until(lambda: output.status.state == "open")


def test_nobody_there_is_said_in_one_line():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        url = f"ws://127.0.0.1:{free.getsockname()[1]}"
    for ask in (bhaptics, intiface):
        with pytest.raises(DeviceError, match=r"^no player answers at ws://127\.0\.0\.1:\d+: [^\n]*$"):
            ask(url)


@pytest.mark.parametrize("reply", [[], [[{"Error": {"Id": 1, "ErrorMessage": "busy"}}]], ["nonsense"], [[{"ServerInfo": {"Id": 1}}]], [7]])
def test_a_server_that_is_something_else_is_said(server, reply):
    with pytest.raises(DeviceError, match="Intiface"):
        intiface(server(lambda message: reply).url)


def test_a_missing_package_is_said(monkeypatch):
    monkeypatch.setitem(sys.modules, "websockets.sync.client", None)
    with pytest.raises(DeviceError, match="the Python package websockets"):
        websockets_client()
