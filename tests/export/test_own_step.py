"""A step of a user's file as C: exported like any other, and refused with file, line and what to write instead."""

import ctypes
import re
import subprocess
from pathlib import Path

import pytest
from tests.cli.conftest import here, vvdp  # noqa: F401
from tests.conftest import required_program
from tests.export.test_c_export import make

PAGE = (Path(__file__).parents[2] / "docs" / "howto" / "replace-a-controller.md").read_text("utf-8")
BODY = "    return memory, Command(min(max(0.4 + 2e-6 * (reading.reads - reading.reference), 0.0), 1.0))"
REFUSED = {
    "a dictionary": ('    gains = {"a": 2e-6}', "use a NamedTuple"),
    "`try`": (
        "    try:\n        t = 1.0 / t\n    except ZeroDivisionError:\n        t = 0.0",
        "check values with `if`",
    ),
    "a lambda": ("    t = (lambda x: x)(t)", "define a function with `def` at the top level"),
    "`.hex` of a float": ("    t = t.hex()", "use functions of numbers"),
}


@pytest.fixture
def own(vvdp, here, monkeypatch):  # noqa: F811
    """Writes the system of the page with a controller of its own; a line may stand before the result of its step."""
    monkeypatch.syspath_prepend(str(here))
    assert vvdp("new", "hold", "--from", "pi").code == 0
    (code,) = re.findall(r"`my_control.py`:\n\n```python\n(.*?)```", PAGE, re.DOTALL)
    (script,) = re.findall(r"```python\n(from pathlib.*?)```", PAGE, re.DOTALL)
    exec(script, {})

    def write(module, line=""):
        assert code.count(BODY) == 1
        (here / f"{module}.py").write_text(code.replace(BODY, f"{line}\n{BODY}" if line else BODY), "utf-8")
        text = (here / "own.toml").read_text("utf-8").replace("my_control", module)
        (here / f"{module}.toml").write_text(text, "utf-8")
        return here

    return write


def test_a_step_of_a_file_is_exported(own, vvdp):  # noqa: F811
    """By hand: 2 bar above the setpoint ask for a duty ratio of 0.4 + 2e-6 * 2e5 = 0.8."""
    folder = own("my_control")
    answer = vvdp("export", "c", "my_control.toml", "--part", "controller", "--samples", "50", "--out", "own_c")
    assert answer.code == 0, answer.err
    done = make(folder / "own_c", "test")
    assert (done.stderr, done.stdout.count("50 of 50 samples have the same bits")) == ("", 1)
    (source,) = (folder / "own_c").glob("*_core.c")
    words = " ".join(source.read_text("utf-8").split())
    assert re.search(
        r"More duty ratio, the higher the pressure is above its setpoint;[^*]* my_control\.py:\d+ \*/", words
    )
    files = [source.name, source.name.replace("_core", "")]
    flags = ["-std=c99", "-ffp-contract=off", "-fPIC", "-shared", "-o", "own.so"]
    subprocess.run([required_program("cc"), *flags, *files, "-lm"], cwd=folder / "own_c", check=True)
    step = ctypes.CDLL(str(folder / "own_c" / "own.so")).my_control_controller_step
    memory, settings, command = (ctypes.c_double * 1)(), (ctypes.c_double * 1)(), (ctypes.c_double * 1)()
    assert step(ctypes.c_double(0.0), memory, (ctypes.c_double * 2)(52e5, 50e5), settings, command) == 0
    assert command[0] == pytest.approx(0.8, rel=1e-15)


@pytest.mark.parametrize("construct", REFUSED)
def test_a_step_outside_the_language_is_refused(own, vvdp, construct):  # noqa: F811
    line, instead = REFUSED[construct]
    module = f"refused_{list(REFUSED).index(construct)}"
    folder = own(module, line)
    number = (folder / f"{module}.py").read_text("utf-8").splitlines().index(line.splitlines()[0]) + 1
    answer = vvdp("export", "c", f"{module}.toml", "--part", "controller", "--out", "refused")
    assert answer.code != 0
    assert f"{module}.py:{number}" in answer.err
    assert construct in answer.err
    assert instead in answer.err
    assert not (folder / "refused").exists()
