"""Chromium without a screen, through its debugging socket."""

from __future__ import annotations

import base64
import contextlib
import json
import subprocess
import time
import urllib.request
from typing import TYPE_CHECKING, Any

from websockets.sync.client import ClientConnection, connect

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

MOST_S = 240.0
FLAGS = ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage")


class Browser:
    """One page. `errors`: what its console complained about."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket, self._number = socket, 0
        self.errors: list[str] = []
        for domain in ("Page", "Runtime", "Log"):
            self._call(f"{domain}.enable")

    def open(self, address: str, width: int = 1300, *, dark: bool = False) -> None:
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self._call("Emulation.setEmulatedMedia", features=[scheme])
        size = {"width": width, "height": 1200, "deviceScaleFactor": 1, "mobile": width < 600}
        self._call("Emulation.setDeviceMetricsOverride", **size)
        self._call("Page.navigate", url=address)

    def run(self, script: str) -> Any:
        """The value of an expression in the page."""
        found = self._call("Runtime.evaluate", expression=script, returnByValue=True)
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def wait(self, script: str) -> Any:
        """Until the expression is true; its value."""
        end_s = time.monotonic() + MOST_S
        while not (value := self.run(f"(() => {{ try {{ return {script} }} catch {{}} }})()")):
            assert time.monotonic() < end_s, f"never true: {script}; {self.errors}"
            time.sleep(0.1)
        return value

    def picture(self, file: Path) -> None:
        file.write_bytes(base64.b64decode(self._call("Page.captureScreenshot")["data"]))

    def _call(self, method: str, **params: Any) -> Any:
        self._number += 1
        request = {"id": self._number, "method": method, "params": params}
        self._socket.send(json.dumps(request))
        while True:
            answer = json.loads(self._socket.recv(timeout=MOST_S))
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                return answer["result"]
            event = answer.get("params", {})
            if answer.get("method") == "Runtime.exceptionThrown":
                self.errors.append(str(event["exceptionDetails"]))
            elif answer.get("method") == "Log.entryAdded" and event["entry"]["level"] == "error":
                self.errors.append(event["entry"]["text"])


@contextlib.contextmanager
def browser(folder: Path) -> Iterator[Browser]:
    words = [*FLAGS, "--remote-debugging-port=0", f"--user-data-dir={folder}", "about:blank"]
    nowhere = subprocess.DEVNULL
    with subprocess.Popen(["chromium", *words], stdout=nowhere, stderr=nowhere) as process:
        try:
            note, end_s = folder / "DevToolsActivePort", time.monotonic() + MOST_S
            while not (note.is_file() and note.read_text().count("\n")):
                assert time.monotonic() < end_s, "Chromium does not start"
                time.sleep(0.05)
            port = note.read_text().split()[0]
            with urllib.request.urlopen(f"http://127.0.0.1:{port}/json") as pages:
                address = next(p for p in json.load(pages) if p["type"] == "page")
            with connect(address["webSocketDebuggerUrl"], max_size=None) as socket:
                yield Browser(socket)
        finally:
            process.terminate()
