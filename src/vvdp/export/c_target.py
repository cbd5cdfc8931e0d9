"""Exported code on a microcontroller: the goal `make pil`, which counts its instructions in QEMU."""

import re
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from vvdp.base.errors import RunError
from vvdp.base.kinds import Kind
from vvdp.export.c_parts import Precision

CLOCK = Kind("clock frequency", "Hz", 1e4, 1e10, "168 MHz", units=("Hz", "kHz", "MHz", "GHz"))
TOOLS = ("arm-none-eabi-gcc", "qemu-system-arm", "make")
"""Programs that counting needs."""


class Core(NamedTuple):
    """A processor: its name in files and in words, flags of GCC, and board of QEMU."""

    name: str
    title: str
    flags: str
    machine: str

    @property
    def symbol(self) -> str:
        """Name of the board in `target.ld`."""
        return self.machine.replace("-", "_").upper()


CORES = (
    Core("m4", "Cortex-M4", "-mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard -mthumb", "mps2-an386"),
    Core("m7", "Cortex-M7", "-mcpu=cortex-m7 -mfpu=fpv5-d16 -mfloat-abi=hard -mthumb", "mps2-an500"),
)
"""A Cortex-M4, which calculates in double precision by software, and a Cortex-M7, which has an instruction for it."""

LIBRARY = 1e-9
"""Largest difference, as a share of a number's largest value, that `sin`, `exp` and others of newlib may make [1]."""


def target_files() -> Mapping[str, str]:
    """The files that make a program for a Cortex-M of the test."""
    folder = resources.files("vvdp.export").joinpath("target")
    return {name: folder.joinpath(name).read_text("utf-8") for name in ("target.h", "target.c", "target.ld")}


def target_goal(name: str, precision: Precision) -> str:
    """The goal that replays the vectors in QEMU, on each core."""
    tolerance = max(precision.tolerance, LIBRARY)
    goals = "\n".join(_core_goal(name, core) for core in CORES)
    return f"""\
# The vectors on microcontrollers in QEMU, which counts instructions; the C library may change last bits.
ARM = arm-none-eabi-
QEMU = qemu-system-arm
# Short code with the same bits; small structs are kept in registers.
ARM_SHORT = -Os --param sra-max-scalarization-size-Osize=64
ARM_FLAGS = $(filter-out -W% -O2,$(FLAGS)) $(ARM_SHORT) -DTOLERANCE={tolerance:g} -ffunction-sections

pil: {" ".join(f"pil_{core.name}" for core in CORES)}

{goals}
.PHONY: {" ".join(f"pil_{core.name}" for core in CORES)}

"""


def _core_goal(name: str, core: Core) -> str:
    parts = [name, f"{name}_core"]
    objects = " ".join(f"{each}_{core.name}.o" for each in (*parts, "target"))
    own = " ".join(f"{each}_{core.name}.o" for each in parts)
    return f"""\
pil_{core.name}: {core.name}.elf
\t@echo "{core.title}: code $$($(ARM)size {own} | awk 'NR > 1 {{ s += $$1 }} END {{ print s }}') bytes"
\t@$(QEMU) -machine {core.machine} -display none -monitor none -serial none -icount shift=6 \\
\t\t-semihosting-config enable=on,target=native -kernel $<

{core.name}.elf: test_{name}_{core.name}.o {objects} target.ld
\t$(ARM)gcc {core.flags} -nostartfiles --specs=rdimon.specs -Wl,--gc-sections -Wl,--defsym={core.symbol}=1 \\
\t\t-T target.ld -o $@ $(filter %.o,$^) -lm

%_{core.name}.o: %.c {name}.h {name}_core.h vectors.h target.h
\t$(ARM)gcc {core.flags} $(ARM_FLAGS) -include target.h -c -o $@ $<
"""


class Load(NamedTuple):
    """Needs of a step on a processor: code and stack [bytes], instructions per sample, and the sample with most."""

    core: str
    code: int
    stack: int
    least: int
    most: int
    mean: int
    sample: int


LOAD = re.compile(
    r"(?P<core>\S+): code (?P<code>\d+) bytes\n.*?(?P<least>\d+) to (?P<most>\d+) instructions per sample, "
    r"mean (?P<mean>\d+); most in sample (?P<sample>\d+) of \d+\n[^\n]*stack (?P<stack>\d+) bytes",
    re.DOTALL,
)


def missing_tools() -> list[str]:
    """The programs that counting needs and this machine does not have."""
    return [name for name in TOOLS if shutil.which(name) is None]


def counted_loads(files: Mapping[str, str]) -> list[Load]:
    """Needs of the step of an exported folder on each processor, by its goal `pil`.

    Raises RunError where this goal fails.
    """
    with TemporaryDirectory() as folder:
        for name, text in files.items():
            Path(folder, name).write_text(text, "utf-8")
        done = subprocess.run(["make", "-s", "pil"], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RunError(f"make pil failed: {(done.stderr or done.stdout).strip().splitlines()[-1]}")
    found = (each.groupdict() for each in LOAD.finditer(done.stdout))
    return [Load(each.pop("core"), **{key: int(value) for key, value in each.items()}) for each in found]


def load_text(loads: Sequence[Load], period: float, clock: float) -> str:
    """The section of the README on the time that a step takes on each processor.

    period  between two samples [s]
    clock   frequency of the processor [Hz]
    """
    rows = "".join(
        f"| {load.core} | {load.code} | {load.stack} | {load.mean} | {load.most} | {1e6 * load.most / clock:.3g} |"
        f" {load.most / clock / period:.3g} |\n"
        for load in loads
    )
    return f"""
## Time on a microcontroller

Instructions are counted in QEMU over the samples of the vectors. The time of the worst sample assumes one instruction
per cycle at {clock / 1e6:g} MHz. A Cortex-M4 takes more, for waits, divisions and branches; a Cortex-M7 may execute two
instructions per cycle. The period is {period:g} s.

| processor | code in bytes | stack in bytes | instructions, mean | worst sample | time in us | share of period |
|---|---|---|---|---|---|---|
{rows}"""


def late_cores(loads: Sequence[Load], period: float, clock: float) -> list[str]:
    """A warning for each processor on which the worst sample takes longer than the period [s] at this clock [Hz]."""
    return [
        f"on a {load.core} at {clock / 1e6:g} MHz the worst sample takes {1e3 * load.most / clock:.3g} ms at one "
        f"instruction per cycle, more than the period, {1e3 * period:g} ms: use another processor, single precision, "
        "or a longer period"
        for load in loads
        if load.most / clock > period
    ]
