"""Runs inside umockdev: a server with a pad, and a client that steps for a while.

Prints the reports written to the pad, and the time of the last step, as JSON.

Called as ``umockdev-run ... -- python pad_of_a_server.py FOLDER ENDING``.
"""

import json
import os
import signal
import sys
import threading
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "core" / "devices"))

from haptic_tracing.command_line.serve import Door, LiveView
from haptic_tracing.command_line.serve.stage import DeviceStage
from haptic_tracing.core.devices.guard import DeviceOutput
from haptic_tracing.core.devices.profile_files import profile
from haptic_tracing.core.run_time import load
from timed_hid import TimedHid, reports_of
from websockets.sync.client import connect

folder, ending = Path(sys.argv[1]), sys.argv[2]


def serve(pipe):
    """The server: prints its port into ``pipe``."""
    log = folder / "log"
    log.mkdir(exist_ok=True)
    stage = DeviceStage({"pad": DeviceOutput(profile("xbox"), hid=TimedHid(str(log)), rate=8000)})
    door = Door(
        load(folder / "loud.json"), stage, "127.0.0.1", "secret", (), LiveView(sys.stderr).show
    )
    with door.listen(0) as server:
        deadline = time.monotonic() + 20
        while stage.outputs["pad"].status.state != "open" and time.monotonic() < deadline:
            time.sleep(0.01)
        os.write(pipe, f"{server.socket.getsockname()[1]}\n".encode())
        server.serve_forever()


reader, writer = os.pipe()
child = os.fork()
if child == 0:
    try:
        serve(writer)
    finally:
        os._exit(0)
os.close(writer)  # so that a server that ends is noticed
port = int(os.read(reader, 20))
client = connect(f"ws://127.0.0.1:{port}")


def step(**message):
    client.send(json.dumps(message))
    return json.loads(client.recv(timeout=20))


assert step(type="hello", version=1, token="secret")["type"] == "scene"
start = time.perf_counter()
for k in range(40):
    step(type="step", time=k / 50)
    time.sleep(max(start + (k + 1) / 50 - time.perf_counter(), 0))
last_step = time.perf_counter()
if ending == "client goes":
    client.socket.close()
elif ending == "server is killed":
    os.kill(child, signal.SIGKILL)
time.sleep(1.0)
if ending != "server is killed":
    os.kill(child, signal.SIGKILL)
os.waitpid(child, 0)
time.sleep(0.3)
print(
    json.dumps(
        [
            [(seconds, data.hex()) for seconds, data in reports_of(folder / "log", "hidraw0")],
            last_step,
        ]
    )
)
threading.Thread(target=lambda: (time.sleep(5), os._exit(0)), daemon=True).start()
os._exit(0) if not sys.stdout.flush() else None
