"""A program in a process of its own, in the loop with its system.

Use: `python -m vvdp.export.closed_loop SYSTEM PART COMMAND`.

At each sample the simulated system hands the reading to the process and waits for its answer. A frame to the process
holds the time and the reading, a frame from it the memory and the command, all as doubles of this machine. Everything
that a run records is loop_difference with a run in which vvdp's own code is the program.
"""

import argparse
import ctypes
import itertools
import linecache
import struct
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import is_dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, Fault, RunError, VvdpError
from vvdp.base.tables import nearest
from vvdp.export.c_structs import Classes, store_lines, value_text
from vvdp.generator.kinds import stand_in
from vvdp.simulation.exchange import OUTSIDE, SYMBOL, Partner, exchange, refuse_partners
from vvdp.simulation.model import Case, Model, Program
from vvdp.simulation.parts import example_reading
from vvdp.simulation.run import Run, simulate
from vvdp.simulation.stepping import Stepping
from vvdp.simulation.values import flat
from vvdp.systems.system import System, load_system

_Call = ctypes.CFUNCTYPE(
    ctypes.c_double, *[ctypes.c_double] * 3, *[ctypes.c_void_p, ctypes.c_int64] * 2,
)  # fmt: skip


class Process:
    """A process that answers samples; `trouble` is why it no longer does."""

    def __init__(self, command: Sequence[str]) -> None:
        """Begins it. Raises OSError where the command cannot be started."""
        self.child = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.trouble, self.samples = "", 0

    def answer(self, t: float, given: int, n: int, found: int, m: int) -> None:
        """Hands over the n numbers at an address and puts the m of the answer to another; NaN if there is none."""
        answer, size = b"", 8 * m
        assert self.child.stdin and self.child.stdout
        try:
            if not self.trouble:
                self.child.stdin.write(struct.pack("d", t) + ctypes.string_at(given, 8 * n))
                self.child.stdin.flush()
                answer = self.child.stdout.read(size)
        except OSError:
            answer = b""
        if len(answer) < size:
            self.trouble = self.trouble or f"the process ended at t = {t:.6g} s"
            answer = np.full(m, np.nan).tobytes()
        ctypes.memmove(found, answer, size)
        self.samples += 1

    def close(self) -> int:
        """Ends the input of the process and waits for its end; its exit status."""
        assert self.child.stdin
        with suppress(OSError):
            self.child.stdin.close()
        return self.child.wait(10.0)


class Recorder:
    """Answers samples by a step of this process, and keeps their times and readings."""

    trouble = ""

    def __init__(self, step: Callable[[float, Array], Array]) -> None:
        """`step(t, reading)` gives memory and command as a vector."""
        self.step, self.rows = step, list[tuple[float, Array]]()

    def answer(self, t: float, given: int, n: int, found: int, m: int) -> None:
        """Keeps the n numbers at an address and puts the m of the answer to another."""
        reading = np.frombuffer(ctypes.string_at(given, 8 * n)).copy()
        self.rows.append((t, reading))
        ctypes.memmove(found, self.step(t, reading).tobytes(), 8 * m)


_asked: list[Process | Recorder] = []
"""The processes that answer, the current one last: compiled code is remembered, and calls the same function for all."""


def _answer(_: float, handle: float, *sample: Any) -> float:
    _asked[-1].answer(*sample)
    return handle


_CALL = _Call(_answer)


def outside_program(model: Model, case: Case, name: str, process: Process | Recorder) -> Program:
    """A program whose step is taken by a process, say; its memory and command are what is answered."""
    program, classes, place = model.programs[name], Classes(), itertools.count()
    reading, memory = example_reading(model, program, case), case.memory[name]
    size = flat(memory).size + flat(program.command).size
    answers = [value_text(value, "answer", place, classes) for value in (memory, program.command)]
    lines = [f"given, answer = np.zeros({flat(reading).size}), np.zeros({size})"]
    lines += store_lines(reading, "reading", "given")
    lines += ["exchange(0.0, 1.0, t, given, answer)", f"return {', '.join(answers)}"]
    text = "\n".join(["def step(t, memory, reading, settings):", *(f"    {line}" for line in lines)]) + "\n"
    file = f"<step of {name} in a process {abs(hash(text))}>"
    linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)
    known: dict[str, Any] = {"np": np, "exchange": exchange, "__name__": __name__}
    known |= {word: stand_in(cls) if is_dataclass(cls) else cls for cls, word in classes.names.items()}
    exec(compile(text, file, "exec"), known)
    partner = Partner(lambda _: False, lambda _: process.trouble, lambda _: None)
    return replace(program, step=known["step"], partner=partner)


class Difference(NamedTuple):
    """How many numbers of how many differ between the two runs, and how many samples the process has answered."""

    differing: int
    numbers: int
    samples: int


def loop_difference(system: System, name: str, command: Sequence[str], samples: int) -> Difference:
    """A run of so many sample periods with a program in a process, loop_difference with the same run without it.

    Raises ConfigError where there is no such program or the process cannot be started; RunError where it ends early,
    and for a system with a foreign FMU.
    """
    model, case, stepping = system.model, system.case, system.stepping
    refuse_partners(model.partners, "a loop with a process")
    if name not in model.programs:
        raise ConfigError([Fault("PART", 0, name, f"unknown{nearest(name, tuple(model.programs))}")])
    period = stepping.sample_period
    until = stepping.begin + samples * period
    stepping = replace(stepping, until=until, record_interval=period, window=0.0, average_from=None)
    expected = simulate(model, case, stepping)
    try:
        process = Process(command)
    except OSError as problem:
        raise ConfigError([Fault("COMMAND", 0, command[0], f"cannot be started ({problem.strerror})")]) from None
    try:
        run = _outside_run(model, case, name, stepping, process)
    finally:
        process.close()
    if process.trouble:
        raise RunError(process.trouble)
    names = ("times", "states", "commands", "memories", "mark_times", "mark_states")
    pairs = [(getattr(expected, each), getattr(run, each)) for each in names]
    differing = sum(
        int(np.sum(a.view(np.int64) != b.view(np.int64))) if a.shape == b.shape else max(a.size, b.size)
        for a, b in pairs
    )
    return Difference(differing, sum(a.size for a, _ in pairs), process.samples)


def _outside_run(model: Model, case: Case, name: str, stepping: Stepping, asked: Process | Recorder) -> Run:
    """The run in which the samples of a program are answered by what is `asked`."""
    programs = {**model.programs, name: outside_program(model, case, name, asked)}
    OUTSIDE[SYMBOL] = lambda: ctypes.cast(_CALL, ctypes.c_void_p).value or 0
    _asked.append(asked)
    try:
        return simulate(replace(model, programs=programs), case, stepping)
    finally:
        OUTSIDE.pop(SYMBOL)
        _asked.pop()


def recorded_readings(
    system: System, name: str, samples: int, step: Callable[[float, Array], Array]
) -> list[tuple[float, Array]]:
    """Time and reading of the first `samples` of a program in a run; of events, those within as many periods.

    step  step(t, reading) -> memory and command of the program as a vector
    """
    recorder, program, stepping = Recorder(step), system.model.programs[name], system.stepping
    period = program.period or stepping.sample_period
    until = stepping.begin + program.phase + samples * period
    stepping = replace(stepping, until=until, record_interval=period, window=0.0, average_from=None)
    _outside_run(system.model, system.case, name, stepping, recorder)
    return recorder.rows[:samples]


def main() -> int:
    """Compares, and prints what differs; 1 where anything does or the process fails."""
    words = argparse.ArgumentParser(prog="python -m vvdp.export.closed_loop", description=__doc__.partition("\n")[0])
    words.add_argument("system")
    words.add_argument("part")
    words.add_argument("command", nargs="+")
    words.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    words.add_argument("--samples", type=int, default=1000, metavar="N")
    given = words.parse_args()
    try:
        found = loop_difference(load_system(given.system, given.set), given.part, given.command, given.samples)
    except VvdpError as problem:
        print(problem, file=sys.stderr)
        return 1
    print(f"{found.samples} samples by the process: {found.differing} of {found.numbers} numbers differ from vvdp run")
    return int(found.differing > 0)


if __name__ == "__main__":
    sys.exit(main())
