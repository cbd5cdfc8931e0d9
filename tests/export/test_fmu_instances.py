"""Many instances of an FMU, from a host in C: in threads, made and freed again and again, under Valgrind."""

import re
import subprocess

import pytest
from tests.conftest import required_program
from tests.export.builds import made
from tests.export.fmi_host import token_of
from tests.export.test_fmu import pytestmark
from tests.generator.c_way import compilers

__all__ = ["pytestmark"]
SAID = re.compile(r"(\d+) of (\d+) threads have the same bytes; (-?\d+) kB more after \d+ cycles\n")


@pytest.fixture
def command(tmp_path):
    """The words that start the host with `prototype`, before the number of steps."""
    one = made("prototype", 3)
    for name, content in one.entries.items():
        if name.startswith(("sources/fmi3", "binaries/x86_64-linux")):
            (tmp_path / name.rpartition("/")[2]).write_bytes(content)
    (library,) = tmp_path.glob("*.so")
    source = str(__file__).replace("test_fmu_instances.py", "fmi_threads.c")
    warnings = ("-Wall", "-Wextra", "-Werror", "-g", "-O1")
    words = [compilers()[0], "-std=c99", *warnings, f"-I{tmp_path}", source, "-o", "host", "-ldl", "-pthread"]
    subprocess.run(words, cwd=tmp_path, check=True)
    return [str(tmp_path / "host"), str(library), token_of(one), "1e-3"]


def said(words):
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    found = SAID.fullmatch(done.stdout)
    return tuple(map(int, found.groups())), done.stderr


def test_threads_have_the_same_bits_and_cycles_take_no_memory(command):
    """8 instances in 8 threads; 10 000 times made, reset and freed."""
    (same, threads, more), _ = said([*command, "100", "8", "10000"])
    assert same == threads == 8
    assert more <= 64


def test_a_state_continues_in_another_process(command, tmp_path):
    """Half of the steps in one process, the others in another: the bytes of a run in one."""
    for _ in range(2):  # the first call writes the state, the second one reads it
        (same, threads, _), _ = said([*command, "60", "1", "0", str(tmp_path / "state")])
        assert same == threads == 1
    assert (tmp_path / "state").stat().st_size > 1000


@pytest.mark.thorough
@pytest.mark.parametrize("tool", ["memcheck", "helgrind"])
def test_valgrind_finds_nothing(tool, command):
    """No use of memory that is not owned or not set, none left over, and no race between threads."""
    valgrind = required_program("valgrind")
    checks = ["--leak-check=full", "--errors-for-leak-kinds=all"] if tool == "memcheck" else []
    words = [valgrind, f"--tool={tool}", "--error-exitcode=9", *checks, *command, "20", "8", "20"]
    (same, threads, _), told = said(words)
    assert same == threads == 8
    assert "ERROR SUMMARY: 0 errors" in told
