"""The workbench as a process of its own, asked over real sockets."""

import contextlib
import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from http.client import HTTPConnection
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsWriter
from tests.report.browser import running
from tests.workbench.steps import COMPLETE, wait_for

from vvdp.systems.system import source_text


class Running(NamedTuple):
    url: str
    port: int
    token: str
    folder: Path
    process: "subprocess.Popen[str]"

    def ask(self, method: str, path: str, body: Any = None, **headers: str) -> tuple[int, Any, dict[str, str]]:
        """Status, JSON or text, and headers of an answer; with the token unless other headers are given."""
        connection = HTTPConnection("127.0.0.1", self.port, timeout=60)
        sent = {
            "Authorization": f"Bearer {self.token}",
            **{key.replace("_", "-"): text for key, text in headers.items()},
        }
        asked = body if isinstance(body, bytes | None) else json.dumps(body).encode()
        connection.request(method, path, asked, {key: text for key, text in sent.items() if text})
        answer = connection.getresponse()
        content = answer.read()
        found = dict(answer.getheaders())
        connection.close()
        if found.get("content-type") == "application/octet-stream":
            return answer.status, content, found
        text = content.decode()
        return answer.status, json.loads(text) if found.get("content-type") == "application/json" else text, found


LOG = "time [s],p_in [bar],q [L/min],x\n" + "".join(
    f"{0.9 + 1e-4 * i:.4f},{60 + 2 * i},{20 + 0.1 * i},{i}\n" for i in range(40)
)


@contextlib.contextmanager
def serving(path: Path, *more: str) -> Iterator[Running]:
    """A workbench for a file, as a process; it ends with the block, by Ctrl-C unless it has ended already."""
    command = [sys.executable, "-m", "vvdp", "workbench", str(path), "--json", "--no-browser", *more]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=path.parent)
    assert process.stdout is not None and process.stderr is not None
    found = json.loads(process.stdout.readline())
    yield Running(found["url"], found["port"], found["token"], path.parent, process)
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
        process.wait(timeout=20)
        assert "Traceback" not in process.stderr.read()


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    folder = tmp_path_factory.mktemp("systems")
    (folder / "pump.toml").write_text(source_text("prototype"))
    (folder / "own.toml").write_text('circuit = "own:network"\n[run]\nuntil = "1 s"\n')
    (folder / "own.py").write_text("open('was_run', 'w')\n")
    (folder.parent / "secret.toml").write_text('title = "secret"\n')
    (folder / "link.toml").symlink_to(folder.parent / "secret.toml")
    (folder / "large.toml").write_text("# " + 1_000_000 * "x")
    (folder / "rig.csv").write_text(LOG)
    values = ChannelObject(
        "rig",
        "inlet",
        np.array([6.0, 6.1]),
        properties={"unit_string": "MPa", "wf_increment": 1e-3, "wf_start_offset": 0.0},
    )
    with TdmsWriter(folder / "rig.tdms") as writer:
        writer.write_segment([values])
    (folder / "secret.csv").symlink_to(folder.parent / "secret.toml")
    with serving(folder / "pump.toml") as found:
        yield found
    assert found.process.returncode == 0


@pytest.fixture(scope="module")
def browser(chromium, tmp_path_factory):
    with running(chromium, tmp_path_factory.mktemp("profile")) as page:
        yield page


@pytest.fixture(params=[(1400, "light"), pytest.param((390, "dark"), marks=pytest.mark.thorough)], ids=str)
def page(browser, server, request):
    """The page as it opens, on a wide light screen and on a narrow dark one."""
    width, scheme = request.param
    browser.call("Emulation.setDeviceMetricsOverride", width=width, height=950, deviceScaleFactor=1, mobile=False)
    browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
    browser.visit("about:blank")
    browser.visit(server.url)
    wait_for(browser, COMPLETE)
    yield browser
    assert not browser.named("Runtime.exceptionThrown")
    assert [
        each["entry"]["text"] for each in browser.named("Log.entryAdded") if each["entry"]["level"] == "error"
    ] == []
    hosts = {
        each["request"]["url"].split("/")[2]
        for each in browser.named("Network.requestWillBeSent")
        if each["request"]["url"][:4] == "http"
    }
    assert hosts == {f"127.0.0.1:{server.port}"}
