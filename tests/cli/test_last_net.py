"""What ends a command from outside or by a mistake: Ctrl-C at any instant, too little memory, an error of vvdp."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import vvdp as package

SOURCE = str(Path(package.__file__).parents[1])
ENVIRONMENT = {**os.environ, "PYTHONPATH": SOURCE}
COMMAND = (sys.executable, "-m", "vvdp")


def test_a_mistake_of_vvdp_is_one_line_and_a_report(vvdp, here, monkeypatch):
    monkeypatch.setenv("VVDP_CACHE", str(here / "cache"))

    def broken(*_):
        raise KeyError("a mistake\nof two lines")

    monkeypatch.setattr("vvdp.systems.system.load_system", broken)
    answer = vvdp("show", "prototype")
    assert answer.code == 70 and not answer.out
    (line,) = answer.err.splitlines()
    assert line.startswith("vvdp: unexpected error, a mistake of vvdp: KeyError: ")
    (report,) = (here / "cache" / "errors").iterdir()
    assert f"the full report is in {report}; please send it" in line
    text = report.read_text()
    assert "Traceback (most recent call last)" in text and "in broken" in text and "Python 3." in text
    assert report.parent.stat().st_mode & 0o77 == 0


def test_the_report_is_kept_elsewhere_if_the_cache_cannot_be_written(vvdp, here, monkeypatch):
    (here / "file").write_text("")
    (here / "tmp").mkdir()
    monkeypatch.setenv("VVDP_CACHE", str(here / "file" / "below"))
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(here / "tmp"))
    monkeypatch.setattr("vvdp.systems.system.load_system", lambda *_: 1 / 0)
    answer = vvdp("show", "prototype")
    assert answer.code == 70
    (report,) = (here / "tmp").iterdir()
    assert str(report) in answer.err


@pytest.mark.parametrize("end", [KeyboardInterrupt, SystemExit])
def test_an_end_is_no_mistake(vvdp, here, monkeypatch, end):
    def ended(*_):
        raise end

    monkeypatch.setenv("VVDP_CACHE", str(here / "cache"))
    monkeypatch.setattr("vvdp.systems.system.load_system", ended)
    answer = vvdp("show", "prototype")
    told = (130, ["interrupted"]) if end is KeyboardInterrupt else (0, [])
    assert (answer.code, answer.err.split()) == told
    assert not (here / "cache").exists()


@pytest.mark.parametrize(("arguments", "code"), [(("run", "prototype"), 1), (("show", "buck-converter"), 0)])
def test_too_little_memory_is_the_cause_that_is_reported(here, arguments, code):
    limited = f"ulimit -v 262144; exec {sys.executable} -m vvdp {' '.join(arguments)}"
    answer = subprocess.run(["sh", "-c", limited], env=ENVIRONMENT, capture_output=True, text=True, check=False)
    assert answer.returncode == code, answer.stderr
    if code:
        assert answer.stderr.splitlines() == [
            "vvdp: the memory limit of this shell is 268 MB (ulimit -v 262144), below the 700 MB that simulating "
            "needs; raise it, for example: ulimit -v unlimited"
        ]
        assert list(here.iterdir()) == []


def interrupted(folder: Path, after: float) -> tuple[int, str, list[str]]:
    """Exit code, stderr and what is left of a long run that Ctrl-C ends so many seconds after its start."""
    folder.mkdir()
    arguments = ("run", "buck-converter", "--until", "2000 s", "--no-report", "--out", "out",
                 "--set", "run.record_interval=1 s", "--set", "run.window=0.01 s")  # fmt: skip
    with subprocess.Popen([*COMMAND, *arguments], cwd=folder, env=ENVIRONMENT, text=True,
                          stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as running:  # fmt: skip
        time.sleep(after)
        running.send_signal(signal.SIGINT)
        _, told = running.communicate(timeout=100)
    return running.returncode, told, [path.name for path in folder.iterdir()]


def is_clean(ended: tuple[int, str, list[str]]) -> bool:
    code, told, left = ended
    return code == 130 and "interrupted" in told and "Traceback" not in told and left in ([], ["out"])


def test_an_early_ctrl_c_while_modules_are_loaded(tmp_path):
    """From 0.2 s on: before, it is Python itself that starts."""
    for k, after in enumerate((0.2, 0.35, 0.6)):
        ended = interrupted(tmp_path / str(k), after)
        assert is_clean(ended), (after, ended)


@pytest.mark.thorough
def test_an_early_ctrl_c_at_any_instant(tmp_path, monkeypatch):
    """Also while circuit and loop are compiled: the cache is empty each time."""
    instants = random.Random(31)
    for k in range(12):
        monkeypatch.setitem(ENVIRONMENT, "VVDP_CACHE", str(tmp_path / f"cache-{k}"))
        after = instants.uniform(0.2, 12.0)
        ended = interrupted(tmp_path / str(k), after)
        assert is_clean(ended), (after, ended)


def test_an_interrupt_in_a_callback_is_not_lost():
    """In a destructor Python drops a KeyboardInterrupt; the process of the command line raises it again."""
    code = (
        "import signal, sys, time\n"
        "from vvdp.__main__ import _interrupt_again\n"
        "sys.unraisablehook = _interrupt_again\n"
        "class Ended:\n    def __del__(self): signal.raise_signal(signal.SIGINT)\n"
        "try:\n    Ended(); time.sleep(5)\n"
        "except KeyboardInterrupt: print('again')\n"
    )
    answer = subprocess.run([sys.executable, "-c", code], env=ENVIRONMENT, capture_output=True, text=True, check=False)
    assert (answer.stdout, answer.stderr) == ("again\n", "")


@pytest.mark.thorough
def test_names_that_are_not_utf_8(here):
    """Written with backslash escapes, on the screen and in the results, which are kept."""
    text = (Path(package.__file__).parent / "systems" / "data" / "buck-converter.toml").read_bytes()
    for name in (b"gr\xf6.toml", "grün.toml".encode()):
        Path(os.fsdecode(name)).write_bytes(text)
        out = Path(os.fsdecode(name[:-5] + b"-out"))
        plain = {**ENVIRONMENT, "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
        for environment, force in ((ENVIRONMENT, []), (plain, ["--force"])):
            arguments = ["run", os.fsdecode(name), "--until", "0.02 s", "--out", str(out), "--no-ranges", *force]
            answer = subprocess.run([*COMMAND, *arguments], env=environment, capture_output=True, check=False)
            assert answer.returncode == 0, answer.stderr.decode("utf-8", "replace")
            assert b"Traceback" not in answer.stderr
        assert (out / "report.html").is_file()
        page = (out / "report.html").read_text("utf-8")
        assert ("gr\\xf6" if b"\xf6" in name else "grün") in page
