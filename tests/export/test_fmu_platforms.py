"""Binaries of an FMU for other machines: run by a host in C, natively and under an emulator where there is one."""

import importlib.util
import shutil
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from tests.export.fmi_host import OK, Host, token_of

from vvdp.base.errors import ConfigError
from vvdp.export.fmu import fmu
from vvdp.export.fmu_binary import PLATFORMS, TARGETS, platforms_named
from vvdp.export.fmu_model import fmu_model
from vvdp.export.zig import run_zig
from vvdp.generator.binding import is_fused
from vvdp.programs.foreign.platforms import Platform, this_platform
from vvdp.systems.system import load_system

HERE = Path(__file__).parent
SYSTEM, PERIOD, STEPS = "prototype", 1e-3, 100
MAGIC = {"linux": b"\x7fELF", "windows": b"MZ", "darwin": b"\xcf\xfa\xed\xfe"}
"""How a library begins: ELF, PE, and Mach-O of 64 bits."""
MACHINE = {"x86_64-linux": (18, 62), "aarch64-linux": (18, 183), "x86_64-darwin": (4, 7), "aarch64-darwin": (4, 12)}
"""Where the number of the processor stands in a library, and its lower byte."""
EMULATORS = {
    "aarch64-linux": ("qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"),
    "x86_64-windows": ("wine",),
}
zig = pytest.mark.skipif(not importlib.util.find_spec("ziglang"), reason="ziglang is not installed")


@cache
def made():
    return fmu(fmu_model(load_system(SYSTEM)), 3, tuple({*PLATFORMS, this_platform()}))


def run_by_host(folder, target, emulator):
    """Numbers of all outputs after each step, of the FMU's own binary for a machine."""
    end = ".exe" if target.system == "windows" else ""
    for name, content in made().entries.items():
        if name.startswith(f"binaries/{target}/"):
            (folder / f"fmu{target.end}").write_bytes(content)
        elif name.endswith(".h"):
            (folder / Path(name).name).write_bytes(content)
    shutil.copy(HERE / "fmi_host.c", folder)
    aim = f"{target.processor}-{TARGETS[target.system]}"
    libraries = [] if end else ["-ldl"]
    run_zig(folder, ["cc", "-target", aim, "-std=gnu99", "-O1", "-o", f"host{end}", "fmi_host.c", *libraries])
    model = made().model
    numbers = [str(each) for each in (PERIOD, STEPS, 1 + len(model.settables), len(model.outputs))]
    command = [*emulator, str(folder / f"host{end}"), str(folder / f"fmu{target.end}"), token_of(made()), *numbers]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    bits = np.array([int(line, 16) for line in done.stdout.split()], np.uint64)
    return bits.view(float).reshape(STEPS, -1)


def run_here(folder):
    """The same numbers of this machine's binary, from the host in Python."""
    one = Host(made(), folder)
    assert one.begin() == OK
    rows = []
    for _ in range(STEPS):
        assert one.step(PERIOD) == OK
        rows.append(one.get(*[each.name for each in made().model.outputs]))
    return np.array(rows)


@zig
@pytest.mark.thorough
def test_each_machine_has_its_binary():
    for target in PLATFORMS:
        (name,) = [each for each in made().entries if each.startswith(f"binaries/{target}/")]
        content = made().entries[name]
        assert name.endswith(target.end) and content.startswith(MAGIC[target.system])
        if str(target) in MACHINE:
            place, number = MACHINE[str(target)]
            assert content[place] == number
        assert b"fmi3InstantiateCoSimulation" in content


@zig
@pytest.mark.thorough
@pytest.mark.skipif(not is_fused(), reason="a run has other bits on a processor without fused operations")
@pytest.mark.parametrize("name", ["this", *EMULATORS])
def test_a_host_in_c_has_the_numbers_of_the_host_in_python(name, tmp_path):
    """Every output over 0.1 s of the prototype: to the bit where the C library is the same, elsewhere to its tolerance.

    The library of Windows rounds exp, log, pow and sine otherwise, which moves the ends of steps.
    """
    emulator = EMULATORS.get(name, ())
    if emulator and not shutil.which(emulator[0]):
        pytest.skip(f"{emulator[0]} is not installed")
    target = this_platform() if name == "this" else Platform(*name.split("-"))
    found, expected = run_by_host(tmp_path, target, emulator), run_here(tmp_path / "here")
    if target.system == this_platform().system:
        assert found.tobytes() == expected.tobytes()
    tolerance = made().model.system.stepping.relative_tolerance
    assert (np.abs(found - expected) <= tolerance * np.abs(expected).max(axis=0)).all()


def test_platforms_that_cannot_be_are_told(monkeypatch):
    def told(names, fmi):
        with pytest.raises(ConfigError) as caught:
            platforms_named(names, fmi)
        return str(caught.value)

    assert platforms_named((), 3) == (this_platform(),)
    assert "expected one of x86_64-linux, aarch64-linux" in told(["x86_64-amiga"], 3)
    assert "choose one of them, or --fmi 3" in told(["x86_64-darwin", "aarch64-darwin"], 2)
    monkeypatch.setattr("vvdp.export.fmu_binary.has_zig", lambda: False)
    assert "pip install 'vvdp[fmi-cross]'" in told(["x86_64-windows", "aarch64-darwin"], 3)
