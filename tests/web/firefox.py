"""Firefox without a screen, asked for the value of one JavaScript expression on a page of the disk."""

import json
import subprocess
from itertools import count
from pathlib import Path
from typing import Any

from websockets.sync.client import connect

LISTENING = "WebDriver BiDi listening on "


def asked(program: str, profile: Path, page: Path, expression: str) -> Any:
    """The value of an expression that gives a promise of JSON, over the protocol WebDriver BiDi."""
    profile.mkdir()
    options = ["--headless", "--no-remote", "--profile", str(profile), "--remote-debugging-port", "0"]
    command = [program, *options, "about:blank"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        try:
            address = next(line for line in process.stderr if LISTENING in line).partition(LISTENING)[2].strip()
            return _answer(address, page, expression)
        finally:
            process.kill()


def _answer(address: str, page: Path, expression: str) -> Any:
    with connect(f"{address}/session", max_size=None) as socket:
        numbers = count(1)

        def call(method: str, **values: Any) -> Any:
            number = next(numbers)
            socket.send(json.dumps({"id": number, "method": method, "params": values}))
            while (answer := json.loads(socket.recv(timeout=120.0))).get("id") != number:
                pass
            assert answer["type"] == "success", answer
            return answer["result"]

        call("session.new", capabilities={})
        context = call("browsingContext.getTree")["contexts"][0]["context"]
        call("browsingContext.navigate", context=context, url=page.as_uri(), wait="complete")
        found = call("script.evaluate", expression=expression, target={"context": context}, awaitPromise=True)
        assert found["type"] == "success", found
        return json.loads(found["result"]["value"])
