"""What a person sees: verbs on a real pseudo-terminal of 60, 80 and 120 columns."""

import fcntl
import json
import os
import re
import struct
import subprocess
import sys
import termios
from pathlib import Path

import pytest

import vvdp as package
from vvdp.cli.screen import WIDTH_WITHOUT_TERMINAL

SOURCE = str(Path(package.__file__).parents[1])
COMMANDS = {
    "valve": "valve prototype --flow 40lpm --flow 20lpm --flow 60lpm --temperature 40degC --temperature 55.5degC",
    "run": "run prototype --until 0.05s --no-report --force --out r",
    "map": "map prototype --analytic --no-report --force --out m",
    "show": "show prototype",
    "list of components": "list --components",
    "rig pressure-drop": "rig pressure-drop prototype --no-report --force --out p",
    "check": "check",
}
NUMBER = re.compile(r"(?<![\w./-])[\u2212-]?\d[\d.]*(?:e-?\d+)?(?![\w/])")
VARYING = re.compile(r"(?:\d+ steps )?(?:points run )?in [\d.]+ s|[\d.]+e-\d+|[\d.]+ MB of")


def screen(width, command, folder):
    """The lines that `vvdp command` leaves on a terminal of `width` columns, which breaks what is longer."""
    controller, terminal = os.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 50, width, 0, 0))
    environment = {key: value for key, value in os.environ.items() if key not in ("COLUMNS", "LINES")}
    environment |= {"PYTHONPATH": SOURCE, "TERM": "xterm-256color"}
    process = subprocess.Popen(
        [sys.executable, "-m", "vvdp", *command.split()],
        stdin=terminal, stdout=terminal, stderr=subprocess.DEVNULL, env=environment, cwd=folder,
    )  # fmt: skip
    os.close(terminal)
    received = b""
    try:
        while part := os.read(controller, 65536):
            received += part
    except OSError:  # Linux says so when the last writer has gone
        pass
    os.close(controller)
    assert process.wait() == 0
    lines = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", received.decode()).replace("\r", "").split("\n")
    return [line[at : at + width] for line in lines for at in range(0, max(len(line), 1), width)]


def numbers(lines):
    return {found for line in lines for found in NUMBER.findall(VARYING.sub("", line))}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("terminal")


@pytest.fixture(scope="module")
def wide(folder):
    """The numbers of each command on a terminal on which nothing is wrapped."""
    return {name: numbers(screen(WIDTH_WITHOUT_TERMINAL, command, folder)) for name, command in COMMANDS.items()}


@pytest.mark.thorough
@pytest.mark.parametrize("width", [60, 80, 120])
@pytest.mark.parametrize("name", COMMANDS)
def test_no_number_is_broken(name, width, folder, wide):
    lines = screen(width, COMMANDS[name], folder)
    assert wide[name]
    assert wide[name] - numbers(lines) == set(), "\n".join(lines)


def test_no_word_of_a_list_is_broken(folder):
    words = {word for line in screen(WIDTH_WITHOUT_TERMINAL, "list", folder) for word in line.split()}
    lines = screen(60, "list", folder)
    assert {word for word in words if "─" not in word} <= {word for line in lines for word in line.split()}


@pytest.mark.thorough
@pytest.mark.parametrize("width", [60, 80, 120])
def test_the_screen_has_all_numbers_of_json(width, folder):
    from vvdp.base.display import display_unit, number
    from vvdp.cli.valve_table import COLUMNS

    command = COMMANDS["valve"]
    told = subprocess.run(
        [sys.executable, "-m", "vvdp", *command.split(), "--json"],
        env={**os.environ, "PYTHONPATH": SOURCE}, capture_output=True, text=True, check=True,
    )  # fmt: skip
    found, shown = json.loads(told.stdout), numbers(screen(width, command, folder))
    for _, key, kind in COLUMNS[2:]:
        assert {number(display_unit(kind).from_si(value)) for value in found[key]} <= shown
