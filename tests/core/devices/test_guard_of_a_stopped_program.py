"""Orders of a program that was stopped while they were on their way: whatever they say, silence is
the last that devices hear."""

import io
import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import pytest
from haptic_tracing.core.devices.guard_process import Service
from haptic_tracing.core.devices.status import Status

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows stops no processes")


made = []


class Recorder:
    """An output that takes ``seconds`` for a block and remembers its orders. Made in the guard by
    `open`."""

    def __init__(self, seconds):
        self.seconds, self.heard, self.status = seconds, [], Status("open")
        made.append(self)

    def __call__(self):
        return self

    def __reduce__(self):
        return Recorder, (self.seconds,)

    def start(self):
        pass

    def send(self):
        time.sleep(self.seconds)
        self.heard.append("send")

    def silence(self):
        self.heard.append("silence")

    def request_stop(self):
        self.heard.append("stop")

    def stop(self, timeout):
        return True


def test_silence_comes_after_orders_that_take_long():
    """The program stops; the first device's block takes so long that the guard looks for the
    program before it sends the second one."""
    made.clear()
    program = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
    reading, writing = os.pipe()
    service = Service(os.fdopen(reading, "rb"), io.BytesIO(), program.pid)
    thread = threading.Thread(target=service.run, daemon=True)
    thread.start()
    try:
        program.send_signal(signal.SIGSTOP)
        with os.fdopen(writing, "wb") as orders:
            pickle.dump([(0, "open", (Recorder(0.2),)), (1, "open", (Recorder(0.0),))], orders)
            pickle.dump([(0, "send", ()), (1, "send", ())], orders)
            orders.flush()
            time.sleep(0.6)
            heard = [list(recorder.heard) for recorder in made[-2:]]
    finally:
        program.kill()
        program.wait(20)
        thread.join(20)
    for orders in heard:
        assert "send" in orders
        assert orders[-1] == "silence"
