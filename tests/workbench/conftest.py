"""The workbench as a process of its own, asked over real sockets."""

import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from http.client import HTTPConnection
from typing import Any, NamedTuple

import pytest

from vvdp.systems.system import source_text


class Running(NamedTuple):
    url: str
    port: int
    token: str
    folder: Any

    def ask(self, method: str, path: str, body: Any = None, **headers: str) -> tuple[int, Any, dict[str, str]]:
        """Status, JSON or text, and headers of an answer; with the token unless other headers are given."""
        connection = HTTPConnection("127.0.0.1", self.port, timeout=60)
        sent = {
            "Authorization": f"Bearer {self.token}",
            **{key.replace("_", "-"): text for key, text in headers.items()},
        }
        content = body if isinstance(body, bytes | None) else json.dumps(body).encode()
        connection.request(method, path, content, {key: text for key, text in sent.items() if text})
        answer = connection.getresponse()
        text = answer.read().decode()
        found = dict(answer.getheaders())
        connection.close()
        return answer.status, json.loads(text) if found.get("content-type") == "application/json" else text, found


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    folder = tmp_path_factory.mktemp("systems")
    (folder / "pump.toml").write_text(source_text("prototype"))
    (folder / "own.toml").write_text('circuit = "own:network"\n[run]\nuntil = "1 s"\n')
    (folder / "own.py").write_text("open('was_run', 'w')\n")
    (folder.parent / "secret.toml").write_text('title = "secret"\n')
    (folder / "link.toml").symlink_to(folder.parent / "secret.toml")
    (folder / "large.toml").write_text("# " + 1_000_000 * "x")
    command = [sys.executable, "-m", "vvdp", "workbench", str(folder / "pump.toml"), "--json", "--no-browser"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=folder)
    assert process.stdout is not None and process.stderr is not None
    found = json.loads(process.stdout.readline())
    yield Running(found["url"], found["port"], found["token"], folder)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=20) == 0
    assert "Traceback" not in process.stderr.read()
