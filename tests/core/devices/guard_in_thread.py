"""The guard's work in a thread of this process, over pipes as ever: so that it drives the devices
that a test makes up in memory."""

import os
import threading

from haptic_tracing.core.devices.guard_process import Service


class GuardInThread:
    """In the place of the guard process."""

    def __init__(self):
        self.pid = os.getpid()
        orders, self.stdin = (
            os.fdopen(end, mode) for end, mode in zip(os.pipe(), ("rb", "wb"), strict=True)
        )
        self.stdout, statuses = (
            os.fdopen(end, mode) for end, mode in zip(os.pipe(), ("rb", "wb"), strict=True)
        )
        self._thread = threading.Thread(
            target=self._run, args=(orders, statuses), name="haptics guard", daemon=True
        )
        self._thread.start()

    def _run(self, orders, statuses):
        with orders, statuses:
            Service(orders, statuses, os.getpid()).run()

    def kill(self):
        self.stdin.close()

    def wait(self):
        self._thread.join(60)
        assert not self._thread.is_alive(), "the guard goes on"
        return 0
