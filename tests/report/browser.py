"""A browser without a screen that opens a page, is clicked, dragged and typed into, and is asked what it shows."""

import base64
import contextlib
import json
import os
import select
import subprocess
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

QUIET = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
PATIENCE = 60.0
"""Seconds within which the browser has to answer."""


class Browser:
    """One page, driven over the pipe that browsers offer to their developers' tools."""

    def __init__(self, to_browser: int, from_browser: int, profile: Path) -> None:
        self._to, self._from, self.profile = to_browser, from_browser, str(profile)
        self._rest = b""
        self._count = 0
        self._session: str | None = None
        self.events: list[Mapping[str, Any]] = []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable")

    def call(self, method: str, **values: Any) -> Mapping[str, Any]:
        """The answer to a command of the browser's protocol."""
        answer = self._answer(method, values)
        assert "error" not in answer, answer
        result: Mapping[str, Any] = answer["result"]
        return result

    def _answer(self, method: str, values: Mapping[str, Any]) -> Mapping[str, Any]:
        self._count += 1
        message = {"id": self._count, "method": method, "params": values}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self._count:
                return answer
            self.events.append(answer)

    def open(self, page: Path) -> None:
        """Opens a page of the disk and waits until it is loaded."""
        self.visit(page.as_uri())

    def visit(self, url: str) -> None:
        """Opens an address and waits until it is loaded."""
        self.events.clear()
        self.call("Page.navigate", url=url)
        while not self.named("Page.loadEventFired"):
            self.events.append(self._next())

    def ask(self, expression: str) -> Any:
        """The value of a JavaScript expression; a promise is awaited.

        The browser may forget that it waits for a promise while much memory is freed; then it is asked again.
        """
        values = {"expression": expression, "awaitPromise": True, "returnByValue": True}
        answer = self._answer("Runtime.evaluate", values)
        while "Promise was collected" in str(answer.get("error")):
            answer = self._answer("Runtime.evaluate", values)
        assert "error" not in answer, answer
        assert "exceptionDetails" not in answer["result"], answer["result"]["exceptionDetails"]
        return answer["result"]["result"].get("value")

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        """A movement, press or turn of the mouse at a point of the window."""
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def drag(self, begin: tuple[float, float], end: tuple[float, float], **more: Any) -> None:
        """Presses the left button at one point and lets go at another."""
        self.mouse("mouseMoved", *begin)
        self.mouse("mousePressed", *begin, button="left", clickCount=1, **more)
        for part in (0.3, 0.7, 1.0):
            point = (a + part * (b - a) for a, b in zip(begin, end, strict=True))
            self.mouse("mouseMoved", *point, button="left", buttons=1, **more)
        self.mouse("mouseReleased", *end, button="left", clickCount=1, **more)

    def click(self, x: float, y: float, times: int = 1) -> None:
        """Clicks once, or as often as a double click does."""
        self.mouse("mouseMoved", x, y)
        for count in range(1, times + 1):
            self.mouse("mousePressed", x, y, button="left", clickCount=count)
            self.mouse("mouseReleased", x, y, button="left", clickCount=count)

    def press(self, key: str) -> None:
        """Presses a key; a single letter is typed, and Enter does what it does in a field or on a button."""
        text = {"text": "\r" if key == "Enter" else key} if len(key) == 1 or key == "Enter" else {}
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, **text)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key)

    def screenshot(self) -> bytes:
        """What the window shows, as PNG."""
        return base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])

    def named(self, method: str) -> list[Mapping[str, Any]]:
        """Events of one kind since the page was opened."""
        return [event["params"] for event in self.events if event.get("method") == method]

    def _next(self) -> Mapping[str, Any]:
        deadline = time.monotonic() + PATIENCE
        while b"\0" not in self._rest:
            ready, _, _ = select.select([self._from], [], [], max(deadline - time.monotonic(), 0.0))
            assert ready, "the browser does not answer"
            self._rest += os.read(self._from, 1 << 16)
        message, self._rest = self._rest.split(b"\0", 1)
        event: Mapping[str, Any] = json.loads(message)
        return event


@contextlib.contextmanager
def running(program: str, profile: Path) -> Iterator[Browser]:
    """A browser with an empty profile; it ends with the block."""
    (its_input, to_browser), (from_browser, its_output) = os.pipe(), os.pipe()
    # The protocol is spoken on the descriptors 3 and 4; a shell puts them there.
    shell = f'exec "$@" 3<&{its_input} 4>&{its_output}'
    command = ["bash", "-c", shell, "bash", program, *QUIET, "--remote-debugging-pipe", f"--user-data-dir={profile}"]
    process = subprocess.Popen(
        [*command, "--window-size=1000,1400", "about:blank"],
        pass_fds=(its_input, its_output),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(its_input)
    os.close(its_output)
    try:
        yield Browser(to_browser, from_browser, profile)
    finally:
        process.terminate()
        process.wait(timeout=30)
        os.close(to_browser)
        os.close(from_browser)
