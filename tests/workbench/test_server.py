"""What the server answers, and to whom."""

import contextlib
import json
import re
import secrets
import shlex
import struct
import subprocess
import sys

import numpy as np
import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from vvdp.systems.system import source_text


def socket_of(server, **headers):
    given = {"Authorization": f"Bearer {server.token}", **headers}
    origin = f"http://127.0.0.1:{server.port}"
    return connect(
        f"ws://127.0.0.1:{server.port}/ws", additional_headers=given, max_size=None, origin=given.pop("Origin", origin)
    )


def described(packet):
    (size,) = struct.unpack_from("<Q", packet)
    return json.loads(packet[8 : 8 + size])


@pytest.mark.parametrize(
    "change", [{"Authorization": ""}, {"Authorization": "Bearer wrong"}, {"Cookie": "a=b; ;;=", "Authorization": ""}]
)
def test_without_the_token_nothing_is_answered(server, change):
    for method, path in (("GET", "/"), ("GET", "/workbench.js"), ("GET", "/api/systems"), ("POST", "/api/run")):
        assert server.ask(method, path, {}, **change)[0] == 401


@pytest.mark.parametrize(
    "change", [{"Host": "evil.example"}, {"Host": "127.0.0.1:1"}, {"Origin": "http://evil.example"}, {"Origin": "null"}]
)
def test_foreign_hosts_and_origins_are_refused(server, change):
    assert server.ask("GET", "/api/systems", **change)[0] == 403
    assert server.ask("POST", "/api/run", {"system": "prototype"}, **change)[0] == 403


def test_web_sockets_are_guarded_too(server):
    for change in ({"Authorization": ""}, {"Origin": "http://evil.example"}):
        with pytest.raises(InvalidStatus):
            socket_of(server, **change)


def test_the_token_becomes_a_cookie(server):
    status, _, headers = server.ask("GET", f"/?token={server.token}", Authorization="")
    assert status == 303
    cookie = headers["set-cookie"]
    assert "HttpOnly" in cookie and "SameSite=strict" in cookie
    status, page, headers = server.ask("GET", "/", Authorization="", Cookie=cookie.partition(";")[0])
    assert status == 200
    assert "unsafe-eval" not in headers["content-security-policy"]
    assert "script-src 'self';" in headers["content-security-policy"]
    assert "<script>" not in page


@pytest.mark.parametrize(
    "name",
    ["../secret.toml", "..%2fsecret.toml", "..\\secret.toml", "link.toml", "large.toml", "/etc/passwd", "", "own.py"],
)
def test_only_system_files_of_the_folder_are_opened(server, name):
    for path in ("/api/text", "/api/run", "/api/save"):
        status, found, _ = server.ask("POST", path, {"system": name, "text": 'title = "x"', "before": ""})
        assert status == 422 and found["faults"][0]["message"]
    assert server.ask("GET", f"/{name}")[0] in (404, 200 if not name else 404)
    assert "secret" in (server.folder.parent / "secret.toml").read_text()


def test_python_is_not_run_from_the_page(server):
    for message in (
        {"system": "own.toml"},
        {"system": "pump.toml", "text": 'circuit = "own:network"\n[run]\nuntil = "1 s"'},
    ):
        status, found, _ = server.ask("POST", "/api/run", message)
        assert status == 422 and "is Python code" in found["faults"][0]["message"]
    assert not (server.folder / "was_run").exists()


def test_the_first_page_is_small(server):
    assert sum(len(server.ask("GET", path)[1]) for path in ("/", "/workbench.js", "/workbench.css")) < 200_000


def test_systems_are_listed(server):
    found = server.ask("GET", "/api/systems")[1]
    names = {each["name"]: each["title"] for each in found["systems"]}
    assert {"pump.toml", "prototype", "buck-converter"} <= set(names)
    assert "link.toml" not in names and "large.toml" not in names


@pytest.mark.parametrize(
    "message",
    [
        {"system": "prototype", "set": ["operation.duty_ratio=0.3"], "until": "0.1 s"},
        {"system": "buck-converter", "set": [], "until": "0.05 s"},
    ],
)
def test_numbers_are_those_of_the_command_line(server, message, tmp_path):
    status, found, _ = server.ask("POST", "/api/run", message)
    assert status == 200
    words = [word for setting in message["set"] for word in ("--set", setting)]
    line = ["run", message["system"], *words, "--until", message["until"], "--no-ranges", "--json", "--no-report"]
    command = [sys.executable, "-m", "vvdp", *line, "--out", str(tmp_path / "run")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)  # 3: a run too short to be settled
    printed = json.loads(done.stdout)
    measured = {key: printed[key] for key in ("out", "wall_time_s")}
    assert found | measured == printed
    with socket_of(server) as page:
        page.send(json.dumps({"n": 1, "kind": "whole", **message}))
        *_, last = answers(page, "numbers")
    shown = described(last)["result"]
    assert shown | {key: printed[key] for key in ("out", "wall_time_s")} == printed


@pytest.mark.parametrize(
    ("message", "key", "words"),
    [
        ({"system": "prototype", "set": ["operation.duty_ratio=7"]}, "operation.duty_ratio", "7"),
        ({"system": "prototype", "set": ["pump.nonsense=7"]}, "pump.nonsense", "unknown"),
        ({"system": "prototype", "until": "-1 s"}, "", "-1 s"),
        ({"system": 3}, "", "expected"),
        ({"system": "prototype", "text": "x = ="}, "", "TOML"),
    ],
)
def test_invalid_values_are_told_with_their_keys(server, message, key, words):
    status, found, _ = server.ask("POST", "/api/run", message)
    assert status == 422
    assert key in found["faults"][0]["key"] and words in found["faults"][0]["message"]


@pytest.mark.parametrize("body", [b"", b"{", b"[]", b"[" * 100_000, b"\xff", b"x" * 1_300_000])
def test_bodies_that_are_no_request(server, body):
    assert server.ask("POST", "/api/run", body)[0] == 422


def test_a_text_is_drawn_and_its_faults_have_lines(server):
    text = source_text("buck-converter")
    assert server.ask("POST", "/api/draw", {"text": text})[1]["svg"].startswith("<svg")
    broken = text + '\n[components.other]\ntype = "check-valve"\na = "nowhere"\nb = "tank"\n'
    status, found, _ = server.ask("POST", "/api/draw", {"text": broken})
    assert status == 422 and found["faults"][0]["line"] > len(text.splitlines())


def test_a_change_on_the_disk_is_not_overwritten(server):
    text = server.ask("POST", "/api/text", {"system": "pump.toml"})[1]["text"]
    changed = text + "# mine\n"
    assert server.ask("POST", "/api/save", {"system": "pump.toml", "text": changed, "before": text})[0] == 200
    status, found, _ = server.ask("POST", "/api/save", {"system": "pump.toml", "text": text, "before": text})
    assert status == 422 and "changed on the disk" in found["faults"][0]["message"]
    assert (server.folder / "pump.toml").read_text() == changed
    assert server.ask("POST", "/api/save", {"system": "prototype", "text": text, "before": text})[0] == 422


def columns_of(packet, head, *names):
    """Columns of a packet by their places."""
    (size,) = struct.unpack_from("<Q", packet)
    found = []
    for place in names:
        at, count, width = head["columns"][place]
        found.append(np.frombuffer(packet, "<f8" if width == 8 else "<f4", count, 8 + size + at))
    return found


def channel_of(server, **asked):
    status, content, _ = server.ask("POST", "/api/channel", asked)
    assert status == 200, content
    head = described(content)
    return head["channel"], columns_of(content, head, head["channel"]["x"], head["channel"]["y"])


def test_measured_channels_come_in_the_units_of_the_scopes(server):
    assert server.ask("GET", "/api/systems")[1]["logs"] == ["rig.csv", "rig.tdms"]
    known = server.ask("POST", "/api/log", {"log": "rig.csv"})[1]["channels"]
    assert known == [{"name": "p_in", "unit": "bar"}, {"name": "q", "unit": "L/min"}, {"name": "x", "unit": ""}]
    of_pressure, (times, values) = channel_of(server, log="rig.csv", channel="p_in")
    assert of_pressure["unit"] == "bar"
    assert times[:2] == pytest.approx([0.9, 0.9001]) and values[:3] == pytest.approx([60.0, 62.0, 64.0])
    of_flow, (_, values) = channel_of(server, log="rig.csv", channel="q")
    assert of_flow["unit"] == "lpm" and values[10] == pytest.approx(21.0)
    _, (times, values) = channel_of(server, log="rig.tdms", channel="inlet")  # 6.1 MPa is 61 bar; 1 kHz
    assert values[1] == pytest.approx(61.0) and times[1] - times[0] == pytest.approx(1e-3)
    _, (_, values) = channel_of(server, log="rig.csv", channel="x", unit="bara")
    assert values[2] == pytest.approx(2.0 - 1.01325)


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"log": "rig.csv", "channel": "x"}, "has no unit"),
        ({"log": "rig.csv", "channel": "x", "unit": "kg"}, "no scope shows"),
        ({"log": "rig.csv", "channel": "nonsense"}, "no channel"),
        ({"log": "rig.csv", "channel": "q", "unit": "bar"}, "as the file says"),
        ({"log": "secret.csv"}, "is no log"),
        ({"log": "../rig.csv"}, "is no log"),
        ({"log": 3}, "is no log"),
    ],
)
def test_logs_that_cannot_be_laid_over(server, asked, words):
    status, found, _ = server.ask("POST", "/api/channel", asked)
    assert status == 422 and words in found["faults"][0]["message"]


def answers(page, kind):
    """The packets of a page up to the first of a kind."""
    while True:
        packet = page.recv(timeout=120)
        yield packet
        if described(packet)["kind"] in (kind, "faults"):
            return


def test_a_draft_has_only_what_is_on_view(server):
    asked = {"n": 1, "kind": "draft", "system": "prototype", "set": []}
    with socket_of(server) as page:
        sizes = {}
        for charts in (None, ["cycle-time", "spectrum"], ["cycle-time"], []):
            page.send(json.dumps({**asked, "charts": charts}))
            *_, packet = answers(page, "draft")
            names = [each["name"] for each in described(packet).get("charts", [])]
            assert charts is None or names == charts
            sizes[str(charts)] = len(packet)
        assert sizes["[]"] < 5000 < sizes["['cycle-time']"] < sizes["['cycle-time', 'spectrum']"] < sizes["None"]
        page.send(json.dumps({**asked, "charts": [], "moves": True}))
        *_, packet = answers(page, "draft")
        assert {"times", "nodes", "flows", "openings"} <= described(packet)["course"].keys()


def test_series_are_added_by_name(server):
    """Series of one unit share a panel, pressures are gauge; of a whole run the scope comes without another run."""
    asked = {"system": "prototype", "set": [], "until": "0.2 s"}
    names = ["inlet_pressure", "load_flow", "load_pressure", "states.inlet", "nonsense"]
    with socket_of(server) as page:
        page.send(json.dumps({**asked, "n": 1, "kind": "whole"}))
        *_, last = answers(page, "numbers")
        known = dict(described(last)["series"])
        assert known["load_flow"] == "to load" and set(names[:-1]) < set(known) and "amplitude" not in known
        page.send(json.dumps({**asked, "n": 2, "kind": "series", "series": names}))
        (packet,) = answers(page, "series")
        head = described(packet)
        (scope,) = head["charts"]
        pressures, flows = (panel["lines"] for panel in scope["panels"])
        assert [len(pressures), len(flows)] == [3, 1] and {line["unit"] for line in pressures} == {"bar"}
        times, shown, state = columns_of(packet, head, pressures[0]["x"], pressures[0]["y"], pressures[2]["y"])
        assert times[-1] == pytest.approx(0.2, rel=1e-12)
        assert np.array_equal(shown, state) and shown.max() > 50.0
        page.send(json.dumps({**asked, "n": 3, "kind": "draft", "series": names, "charts": ["series"]}))
        *_, packet = answers(page, "draft")
        assert [chart["name"] for chart in described(packet)["charts"]] == ["series"]
        page.send(json.dumps({**asked, "n": 4, "kind": "series", "series": ["nonsense"]}))
        (packet,) = answers(page, "series")
        assert "charts" not in described(packet)


def test_compiling_says_how_long_it_takes(server):
    name = f"node{secrets.token_hex(4)}"  # a circuit that no cache knows
    text = re.sub(r"\bnode\b", name, source_text("buck-converter"))
    with socket_of(server) as page:
        page.send(json.dumps({"n": 1, "kind": "whole", "system": "buck-converter", "text": text, "until": "0.05 s"}))
        found = [described(packet) for packet in answers(page, "numbers")]
    assert [each["kind"] for each in found] == ["words", "figures", "numbers"]
    assert re.fullmatch(r"compiling .* about \d+ s", found[0]["words"])


def test_four_pages_have_values_of_their_own(server):
    with contextlib.ExitStack() as open_pages:
        pages = [open_pages.enter_context(socket_of(server)) for _ in range(4)]
        for n, page in enumerate(pages):
            asked = {"kind": "draft", "system": "prototype", "set": [f"operation.duty_ratio=0.{3 + n}"]}
            page.send(json.dumps({"n": 0, **asked}))
            page.send(json.dumps({"n": 1, **asked, "kind": "whole", "until": "0.2 s"}))
        flows = []
        for n, page in enumerate(pages):
            *_, last = answers(page, "numbers")
            assert f"duty_ratio=0.{3 + n} " in described(last)["line"]
            flows.append(described(last)["result"]["load_flow_fraction"])
        pages[0].send(json.dumps({"n": 2, "kind": "whole", "system": "prototype", "set": [], "until": "9 s"}))
    assert flows == sorted(flows) and len(set(flows)) == 4
    with socket_of(server) as page:  # closed while it ran; the server goes on
        page.send(json.dumps({"n": 1, "kind": "draw", "system": "prototype", "set": []}))
        *_, last = answers(page, "drawing")
        assert described(last)["kind"] == "drawing"


def test_the_last_of_many_requests_wins(server):
    """200 changes at once leave nothing waiting: few drafts, and the whole run has the last value."""
    with socket_of(server) as page:
        for n in range(200):
            duty = 0.3 + 0.001 * n
            page.send(
                json.dumps({"n": n, "kind": "draft", "system": "prototype", "set": [f"operation.duty_ratio={duty}"]})
            )
        page.send(
            json.dumps(
                {
                    "n": 200,
                    "kind": "whole",
                    "system": "prototype",
                    "until": "0.2 s",
                    "set": ["operation.duty_ratio=0.5"],
                }
            )
        )
        found = [described(page.recv(timeout=60))]
        while found[-1]["kind"] != "numbers":
            found.append(described(page.recv(timeout=60)))
    assert len(found) < 60
    assert [each["kind"] for each in found[-2:]] == ["figures", "numbers"]
    assert "--set operation.duty_ratio=0.5 --until '0.2 s'" in found[-1]["line"]
    words = shlex.split(found[-1]["line"])
    assert words[:3] == ["vvdp", "run", "prototype"]
    assert all("numbers" not in each and "result" not in each for each in found if each["kind"] == "draft")


def test_a_stopped_run_keeps_its_results(server):
    with socket_of(server) as page:
        page.send(json.dumps({"n": 1, "kind": "whole", "system": "prototype", "until": "60 s"}))
        with pytest.raises(TimeoutError):
            page.recv(timeout=1.5)
        page.send(json.dumps({"kind": "stop"}))
        assert described(page.recv(timeout=60))["finished"] is False
        found = described(page.recv(timeout=60))
    assert found["finished"] is False and 0.0 < found["result"]["duration_s"] < 60.0
