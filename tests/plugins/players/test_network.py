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
from haptic_tracing.core.devices import inventory
from haptic_tracing.core.devices.connection import DeviceError
from haptic_tracing.core.devices.writer import DeviceWriter
from haptic_tracing.plugins.players import loopback, network
from haptic_tracing.plugins.players.loopback import (
    ANSWER_WITHIN,
    LARGEST_MESSAGE,
    websockets_client,
)
from haptic_tracing.plugins.players.network import bhaptics, intiface
from websockets.exceptions import ConnectionClosed
from websockets.sync.server import serve

VIBRATE = {"StepCount": 20, "ActuatorType": "Vibrate", "FeatureDescriptor": ""}
DEVICES = [
    {
        "DeviceIndex": 0,
        "DeviceName": "Cushion",
        "DeviceMessageTimingGap": 100,
        "DeviceMessages": {"ScalarCmd": [VIBRATE, VIBRATE]},
    },
    {
        "DeviceIndex": 3,
        "DeviceName": "Ring",
        "DeviceMessages": {"ScalarCmd": [{**VIBRATE, "ActuatorType": "Rotate"}, VIBRATE]},
    },
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
        self.thread.join(60)
        assert not self.thread.is_alive(), "the server goes on"


def buttplug(messages):
    (message,) = messages
    ((kind, content),) = message.items()
    number = content["Id"]
    if kind == "RequestServerInfo":
        assert content["MessageVersion"] == 3 and content["ClientName"]
        return [
            [
                {
                    "ServerInfo": {
                        "Id": number,
                        "ServerName": "made up",
                        "MessageVersion": 3,
                        "MaxPingTime": 0,
                    }
                }
            ]
        ]
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
        return [
            [s["Scalar"] for s in c["Scalars"]]
            for c in commands(made_up, "ScalarCmd")
            if c["DeviceIndex"] == device
        ]

    until(lambda: (output.send(wave(2, 1)), any(second > 0.9 for _, second in levels(0)))[-1])
    assert all(first == 0 for first, _ in levels(0))
    until(lambda: (other.send(wave(1, 0)), any(only > 0.9 for (only,) in levels(3)))[-1])
    assert commands(made_up, "ScalarCmd")[-1]["Scalars"][0]["Index"] in (0, 1)
    output.stop()
    until(lambda: commands(made_up, "StopDeviceCmd"))
    assert commands(made_up, "StopDeviceCmd")[-1]["DeviceIndex"] == 0
    assert levels(0)[-1] == [0.0, 0.0]
    assert len(made_up.connections) == 2, (
        "one to ask, and one for both devices: Intiface takes a single client"
    )


PING_TIME = 0.8


class StrictServer(Server):
    """Intiface with a MaxPingTime: what does not ping in time is told so, has its devices stopped,
    and is cut off."""

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
                    connection.send(
                        json.dumps(
                            [{"Error": {"Id": 0, "ErrorMessage": "Ping timed out", "ErrorCode": 2}}]
                        )
                    )
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
def test_a_connection_is_kept_alive_by_pings_while_nothing_plays_and_while_something_does(
    server, started
):
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
def test_a_connection_without_pings_is_cut_off_which_is_noticed_and_mended(
    server, started, monkeypatch
):
    strict = server(kind=StrictServer)
    monkeypatch.setattr(network, "_PINGS_IN_TIME", 0.1)  # far too late
    (cushion, module), _ = intiface(strict.url)
    output = started(cushion, module)
    until(lambda: strict.cut == 1)
    monkeypatch.undo()
    until(lambda: (output.send(wave(2, 0)), output.status.losses == 1)[-1])
    until(lambda: output.status.state == "open")
    until(
        lambda: (
            output.send(wave(2, 0)),
            commands(strict, "ScalarCmd")[-1:] and output.status.failed_writes == 3,
        )[-1]
    )
    time.sleep(1.5 * PING_TIME)
    assert strict.cut == 1, "the new connection pings"


@pytest.mark.parametrize("wanted", ["soon", [1], {}])
def test_a_ping_time_that_is_none_is_said(server, wanted):
    made_up = server(
        lambda message: [[{"ServerInfo": {"Id": 1, "MaxPingTime": wanted or {"a": 1}}}]]
    )
    with pytest.raises(DeviceError, match="MaxPingTime"):
        intiface(made_up.url)


def test_bhaptics_gets_frames_that_end_by_themselves(server, started):
    made_up = server()
    profile, module = bhaptics(made_up.url)
    places = {actuator.name: actuator.body_parts for actuator in profile.actuators}
    assert (
        places["VestBack 1"] == ("upper_back.L",)
        and places["VestBack 12"] == ("middle_back.R",)
        and len(places) == 70
    )
    assert places["Head 1"] == ("head", "ear.L") and all(parts for parts in places.values())
    row = list(places).index("VestBack 6")
    output = started(profile, module)

    def loudest():
        output.send(wave(len(places), row))
        frames = [
            s["Frame"]
            for message in made_up.said
            for s in message["Submit"]
            if s["Type"] == "frame"
        ]
        return [
            frame
            for frame in frames
            if any(point["Intensity"] > 90 for point in frame["DotPoints"])
        ]

    until(loudest)
    (frame, *_) = loudest()
    assert frame["Position"] == "VestBack" and frame["DurationMillis"] == 100
    assert [point["Index"] for point in frame["DotPoints"] if point["Intensity"]] == [5]
    assert sorted(point["Index"] for point in frame["DotPoints"]) == list(range(20))
    output.stop()
    until(lambda: made_up.said[-1] == {"Submit": [{"Type": "turnOffAll"}]})


@pytest.mark.slow
def test_a_player_that_ends_is_said_and_found_again(server, started):
    made_up = server()
    profile, module = bhaptics(made_up.url)
    output = started(profile, module)
    made_up.close()
    assert until(
        lambda: (output.send(wave(len(profile.actuators), 0)), output.status.losses == 1)[-1]
    )
    assert until(lambda: "no player answers" in output.status.message)
    server(port=made_up.port)
    assert until(lambda: output.status.state == "open")


def test_nobody_there_is_said_in_one_line():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        url = f"ws://127.0.0.1:{free.getsockname()[1]}"
    for ask in (bhaptics, intiface):
        with pytest.raises(
            DeviceError, match=r"^no player answers at ws://127\.0\.0\.1:\d+: [^\n]*$"
        ):
            ask(url)


@pytest.mark.slow
@pytest.mark.parametrize(
    "reply",
    [
        [],
        [[{"Error": {"Id": 1, "ErrorMessage": "busy"}}]],
        ["nonsense"],
        [[{"ServerInfo": {"Id": 1}}]],
        [7],
    ],
)
def test_a_server_that_is_something_else_is_said(server, reply):
    with pytest.raises(DeviceError, match="Intiface"):
        intiface(server(lambda message: reply).url)


class RawServer:
    """A player that is no player: what it says to whoever connects is given as bytes, and how long
    it waits after each of them."""

    def __init__(self, *said, pause=0.0):
        self.said, self.pause, self.connections = said, pause, 0
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"ws://127.0.0.1:{self.listener.getsockname()[1]}"
        self.thread = threading.Thread(target=self.talk, daemon=True)
        self.thread.start()

    def talk(self):
        with suppress(OSError):
            while True:
                connection, _ = self.listener.accept()
                self.connections += 1
                with connection, suppress(OSError):
                    connection.recv(4096)
                    for part in self.said:
                        connection.sendall(part)
                        time.sleep(self.pause)

    def close(self):
        self.listener.close()


MALFORMED = {
    "null": "null",
    "a number": "7",
    "text": "hello",
    "a list of nulls": "[null]",
    "no content": '[{"ServerInfo": null}]',
    "huge": '[{"ServerInfo": {"MaxPingTime": 1' + "0" * 400 + "}}]",
    "huger than Python reads": '[{"ServerInfo": {"MaxPingTime": 1' + "0" * 5000 + "}}]",
    "infinite": '[{"ServerInfo": {"MaxPingTime": 1e999}}]',
    "not a number": '[{"ServerInfo": {"MaxPingTime": NaN}}]',
    "negative": '[{"ServerInfo": {"MaxPingTime": -5}}]',
    "deep": "[" * 20_000 + "]" * 20_000,
    "an error that is none": '[{"Error": [1, 2]}]',
    "surrogates": '[{"Error": {"ErrorMessage": "\\ud800"}}]',
}


@pytest.mark.slow
@pytest.mark.parametrize("answer", MALFORMED.values(), ids=MALFORMED.keys())
def test_a_malformed_answer_is_one_message(server, answer):
    made_up = server(kind=Telling, said=[answer])
    with pytest.raises(DeviceError, match=r"^Intiface[^\n]*$"):
        intiface(made_up.url)


ACCEPTED = b"HTTP/1.1 101 S\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"


@pytest.mark.parametrize(
    "said",
    [
        b"\xff\x00garbage\r\n\r\n",
        b"HTTP/1.1 302 F\r\nLocation: http://127.0.0.1:1/\r\nLocation: http://127.0.0.1:2/\r\n\r\n",
        b"HTTP/1.1 200 OK\r\nContent-Length: -1\r\n\r\n",
        b"HTTP/1.1 101 S\r\nno colon\r\n\r\n",
        b"HTTP/1.1 101 " + b"a" * 100_000 + b"\r\n\r\n",
        ACCEPTED + b"Sec-WebSocket-Accept: x\r\n\r\n",
        ACCEPTED + b"Sec-WebSocket-Accept: x\r\nSec-WebSocket-Accept: y\r\n\r\n",
        ACCEPTED + b'Sec-WebSocket-Extensions: permessage-deflate; a="\r\n\r\n',
    ],
)
def test_a_handshake_that_is_none_is_one_message_and_prints_nothing(said, capfd):
    made_up = RawServer(said)
    with pytest.raises(DeviceError, match=r"^no player answers at [^\n]*$"):
        intiface(made_up.url)
    made_up.close()
    assert capfd.readouterr() == ("", "")


class Nonsense(Server):
    """A player that accepts, and says something else than frames of WebSocket."""

    def __init__(self, said, port=0):
        self.nonsense = said
        super().__init__(port=port)

    def talk(self, connection):
        self.connections.append(connection)
        connection.socket.sendall(self.nonsense)
        time.sleep(0.1)


@pytest.mark.parametrize(
    "said",
    [
        b"\xff" * 5,
        b"\x81\x02\xff\xfe",
        b"\x81\x83abcdxyz",
        b"\x88\x02\x00\x01",
        pytest.param(b"\x89\x7e\xff\xff", marks=pytest.mark.slow),
        b"\x81\x7f" + (2**62).to_bytes(8, "big"),
        b"\x01\x01a\x01\x01b",
    ],
)
def test_frames_that_are_none_are_one_message_and_print_nothing(server, said, capfd):
    made_up = server(kind=Nonsense, said=said)
    with pytest.raises(DeviceError, match=r"^Intiface[^\n]*$"):
        intiface(made_up.url)
    assert "Traceback" not in "".join(capfd.readouterr())


class Telling(Server):
    """Intiface that answers each question with the next of the given texts."""

    def __init__(self, said, port=0):
        self.texts = list(said)
        super().__init__(port=port)

    def talk(self, connection):
        self.connections.append(connection)
        with suppress(ConnectionClosed):
            for text in connection:
                self.said.append(json.loads(text))
                if self.texts:
                    connection.send(self.texts.pop(0))


GREETING = '[{"ServerInfo": {"Id": 1, "MaxPingTime": 0}}]'
DEVICE = (
    '{"DeviceIndex": 0, "DeviceName": "Cushion", "DeviceMessages": {"ScalarCmd": '
    '[{"ActuatorType": "Vibrate"}]}'
)


@pytest.mark.parametrize(
    "devices",
    [
        "null",
        "{}",
        "[null]",
        "[7]",
        "[{}]",
        '[{"DeviceIndex": 1e999, "DeviceName": "a", "DeviceMessages": {}}]',
        '[{"DeviceIndex": true, "DeviceName": "a", "DeviceMessages": {}}]',
        '[{"DeviceIndex": 0, "DeviceName": null, "DeviceMessages": {}}]',
        '[{"DeviceIndex": 0, "DeviceName": "a", "DeviceMessages": {"ScalarCmd": 5}}]',
        '[{"DeviceIndex": 0, "DeviceName": "a", "DeviceMessages": {"ScalarCmd": [5]}}]',
        f'[{DEVICE}, "DeviceMessageTimingGap": NaN}}]',
        f'[{DEVICE}, "DeviceMessageTimingGap": 1e999}}]',
        f'[{DEVICE}, "DeviceMessageTimingGap": 1{"0" * 400}}}]',
        f'[{DEVICE}, "DeviceMessageTimingGap": -1}}]',
        f"[{', '.join([DEVICE + '}'] * 65)}]",
    ],
)
def test_a_malformed_list_of_devices_is_one_message(server, devices):
    made_up = server(
        kind=Telling, said=[GREETING, f'[{{"DeviceList": {{"Id": 2, "Devices": {devices}}}}}]']
    )
    with pytest.raises(DeviceError, match=r"^Intiface[^\n]*$"):
        intiface(made_up.url)


def test_a_player_that_fails_takes_no_other_device_away(server, monkeypatch):
    """Nothing that a player says keeps the others from being found: here one says nonsense, and the
    other is found."""
    wrong = server(kind=Telling, said=["[" * 20_000])
    right = server()
    searches = lambda: (bhaptics(right.url),), lambda: intiface(wrong.url)
    monkeypatch.setattr(network, "SEARCHES", searches)
    found = inventory.look(with_players=True)
    assert "player bHaptics Player" in [device.key for device in found.devices]
    assert [problem for problem in found.problems if problem.startswith("Intiface")]


def test_no_redirect_is_followed_and_nothing_but_this_computer_is_connected_to(server):
    elsewhere = RawServer()
    sent_on = RawServer(
        f"HTTP/1.1 302 Found\r\nLocation: {elsewhere.url}\r\nContent-Length: 0\r\n\r\n".encode()
    )
    for ask in (intiface, bhaptics):
        with pytest.raises(DeviceError, match="no player answers"):
            ask(sent_on.url)
        for url in (
            "ws://192.0.2.1:12345",
            "ws://example.com",
            "wss://127.0.0.1:12345",
            "http://127.0.0.1",
            "ws://[::1]:5",
            "nonsense",
        ):
            with pytest.raises(DeviceError, match="is not on this computer"):
                ask(url)
    assert elsewhere.connections == 0
    sent_on.close(), elsewhere.close()


@pytest.mark.slow
@pytest.mark.parametrize(
    "said", [[], [b"HTTP/1.1 101 Switching Protocols\r\n"], [b"X: y\r\n"] * 40]
)
def test_a_player_that_takes_its_time_is_given_up_after_two_seconds(said):
    slow = RawServer(*said, pause=0.25)
    begun = time.monotonic()
    with pytest.raises(DeviceError, match="no player answers"):
        intiface(slow.url)
    assert time.monotonic() - begun < ANSWER_WITHIN + 1.0
    slow.close()


@pytest.mark.slow
def test_a_look_can_be_given_up():
    silent = RawServer(pause=60.0)
    problems = []

    def look():
        with pytest.raises(DeviceError) as raised:
            intiface(silent.url)
        problems.append(str(raised.value))

    thread = threading.Thread(target=look)
    thread.start()
    until(lambda: silent.connections == 1)
    begun = time.monotonic()
    until(lambda: (loopback.cancel(), not thread.is_alive())[-1])
    assert time.monotonic() - begun < 1.0 and problems[0].startswith("no player answers")
    silent.close()


class Shouting(Server):
    """Intiface that sends a message of more than 64 KiB in the middle of playing."""

    def __init__(self, port=0):
        self.shouted = False
        super().__init__(buttplug, port)

    def talk(self, connection):
        self.connections.append(connection)
        with suppress(ConnectionClosed):
            for text in connection:
                message = json.loads(text)
                self.said.append(message)
                if (
                    "ScalarCmd" in message[0]
                    and any(s["Scalar"] > 0.5 for s in message[0]["ScalarCmd"]["Scalars"])
                    and not self.shouted
                ):
                    self.shouted = True
                    connection.send("[" + " " * LARGEST_MESSAGE + "]")
                for reply in self.answer(message):
                    connection.send(json.dumps(reply))


def test_a_message_that_is_too_long_does_not_keep_the_stop_from_being_said(server, started):
    made_up = server(kind=Shouting)
    (cushion, module), *_ = intiface(made_up.url)
    output = started(cushion, module)
    until(lambda: (output.send(wave(2, 0)), made_up.shouted)[-1])
    assert output.stop(60.0)
    until(lambda: commands(made_up, "StopDeviceCmd"))


def test_a_missing_package_is_said(monkeypatch):
    monkeypatch.setitem(sys.modules, "websockets.sync.client", None)
    with pytest.raises(DeviceError, match="the Python package websockets"):
        websockets_client()
