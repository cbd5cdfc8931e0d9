"""What an FMU costs: its size, the time of a run beside that of the loop, and the time of its export."""

import re
import resource
import shutil
import sys
import time
import zlib
from dataclasses import replace
from pathlib import Path

import pytest
from tests.export.builds import made
from tests.export.fmi_host import OK, Host
from tests.export.test_fmu import pytestmark

from vvdp.export.fmu import fmu
from vvdp.export.fmu_model import fmu_model
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system

__all__ = ["pytestmark"]
PAGE = " ".join((Path(__file__).parents[2] / "docs" / "fmu-export.md").read_text("utf-8").split())


def told(words):
    """The number that stands on the page for N in some words."""
    (found,) = re.findall(re.escape(words).replace("N", r"([\d.]+)"), PAGE)
    return float(found)


@pytest.mark.skipif(shutil.which("gcc") is None or sys.platform != "linux", reason="sizes are those of gcc for Linux")
def test_it_is_as_small_as_the_page_says(monkeypatch):
    """An unpacked binary of at most 110 kB is asked for."""
    monkeypatch.setenv("CC", "gcc")
    one = made("prototype", 3)
    packed = {name: len(zlib.compress(content, 9)) for name, content in one.entries.items()}
    text, binary = packed["sources/prototype_machine_core.c"], packed["binaries/x86_64-linux/prototype.so"]
    extras = 7_000  # icon, reference result and diagram, see `test_fmu_extras`
    assert len(one.content) + extras < 1000 * told("FMU of `prototype` has less than N kB")
    assert text < 1000 * told("circuit, program and loop takes less than N kB")
    assert binary < 1000 * told("the binary less than N kB")
    assert one.facts["binary_bytes"] < 1000 * told("for Linux: less than N kB unpacked") <= 110_000


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("prototype", "run of `prototype` takes at most N times"),
        ("long-hose", "longer (`long-hose`: at most N times"),
    ],
)
def test_a_run_takes_the_time_of_the_loop(name, words, tmp_path):
    """Over 200 sample periods with a row at each; the least of seven, by turns."""
    system = load_system(name)
    period = system.stepping.sample_period
    stepping = replace(system.stepping, until=200 * period, record_interval=period, window=0.0, average_from=None)
    one, loop, own = Host(made(name, 3), tmp_path), list[float](), list[float]()
    for _ in range(7):
        began = time.process_time()
        simulate(system.model, system.case, stepping)
        loop.append(time.process_time() - began)
        assert one.call("Reset") == OK
        one.time = 0.0
        assert one.begin() == OK
        began = time.process_time()
        for _ in range(200):
            assert one.step(period) == OK
        own.append(time.process_time() - began)
    one.close()
    assert min(own) < told(words) * min(loop)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "alone", "with_compiler"),
    [
        ("prototype", "takes less than N s of processor time besides the compiler", "and less than N s with it"),
        ("displacement-control", "takes less than N s besides the compiler", ""),
    ],
)
def test_an_export_takes_the_time_that_the_page_says(name, alone, with_compiler):
    """Processor time of this process, and with that of the compiler."""
    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    before = [resource.getrusage(kind) for kind in kinds]
    fmu(fmu_model(load_system(name)), 3)
    after = [resource.getrusage(kind) for kind in kinds]
    spent = [b.ru_utime + b.ru_stime - a.ru_utime - a.ru_stime for a, b in zip(before, after, strict=True)]
    assert spent[0] < told(f"`{name}` {alone}")
    if with_compiler:
        assert sum(spent) < told(with_compiler)
