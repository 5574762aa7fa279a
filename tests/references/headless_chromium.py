"""A page in Chromium without a window, driven by DevTools messages over a pipe. It reaches no
network but this machine."""

from __future__ import annotations

import fcntl
import json
import os
import select
import shutil
import signal
import subprocess
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

LIMIT = 300
"""Seconds within which a browser answers, however slow the machine is."""


class Page:
    """A page that is open; ``run`` evaluates a script in it."""

    def __init__(
        self,
        path: Path,
        profile: Path,
        size: tuple[int, int] = (1280, 760),
        more: Sequence[str] = (),
    ) -> None:
        program = (
            shutil.which("chromium")
            or shutil.which("chromium-browser")
            or shutil.which("google-chrome")
        )
        assert program is not None, "Chromium is missing: packaging/system_packages test"
        ours, theirs = os.pipe(), os.pipe()
        (self._read, self._write), ends = (theirs[0], ours[1]), (ours[0], theirs[1])
        read, write = (fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in ends)
        # The browser reads from descriptor 3 and writes to 4.
        command = [
            "bash",
            "-c",
            f'exec "$0" "$@" 3<&{read} 4>&{write}',
            program,
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
        ]
        command += [
            f"--user-data-dir={profile}",
            "--mute-audio",
            "--no-first-run",
            "--remote-debugging-pipe",
            "about:blank",
        ]
        command += [
            f"--window-size={size[0]},{size[1]}",
            "--autoplay-policy=no-user-gesture-required",
            *more,
            "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
        ]
        self._process = subprocess.Popen(
            command,
            pass_fds=(read, write),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        for end in (*ends, read, write):
            os.close(end)
        self._asked, self._received = 0, b""
        try:
            self._show(path)
        except BaseException:
            self.__exit__()
            raise

    def _show(self, path: Path) -> None:
        target = self.ask("Target.createTarget", url=path.as_uri())["targetId"]
        self._session = self.ask("Target.attachToTarget", targetId=target, flatten=True)[
            "sessionId"
        ]
        # A promise of the blank page that comes first would end with it.
        self.until("location.protocol + document.readyState === 'file:complete'")

    def __enter__(self) -> Page:
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait(60)
        os.close(self._read)
        os.close(self._write)

    def ask(self, method: str, session: str | None = None, **parameters: object) -> dict:
        """The answer to a DevTools command."""
        self._asked += 1
        message = {
            "id": self._asked,
            "method": method,
            "params": parameters,
            **({"sessionId": session} if session else {}),
        }
        os.write(self._write, json.dumps(message).encode() + b"\0")
        end = time.monotonic() + LIMIT
        while True:
            text, ended, rest = self._received.partition(b"\0")
            if ended:
                self._received = rest
                answer = json.loads(text)
                if answer.get("id") == self._asked:
                    assert "error" not in answer, answer
                    return answer["result"]
            else:
                readable, _, _ = select.select(
                    [self._read], [], [], max(end - time.monotonic(), 0.0)
                )
                assert readable, f"Chromium does not answer {method} within {LIMIT} s"
                received = os.read(self._read, 1 << 16)
                assert received, f"Chromium ended at {method}"
                self._received += received

    def run(self, script: str) -> object:
        """The value that a promise of ``script`` gives."""
        answer = self.ask(
            "Runtime.evaluate",
            self._session,
            expression=script,
            awaitPromise=True,
            returnByValue=True,
        )
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def until(self, script: str, seconds: float = LIMIT) -> None:
        """Wait until ``script`` is true. It fails with the text of the page."""
        end = time.monotonic() + seconds
        while not self.run(f"Boolean({script})"):
            assert time.monotonic() < end, (script, self.run("document.body.innerText"))
            time.sleep(0.05)

    def picture(self) -> str:
        """The page as a PNG file in base64."""
        return self.ask("Page.captureScreenshot", self._session, format="png")["data"]
