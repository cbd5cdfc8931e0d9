"""The bench with an orifice load against the same right-hand side and stepper written by hand in C."""

import ctypes
import subprocess
import tempfile
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from benchmarks.bare import ROWS, bare_run
from benchmarks.measure import HERE, compiled, interleaved, ratios, report, run_as_command, spread
from vvdp.evaluation.bench import rotary_bench
from vvdp.evaluation.unit_rig import unit_on_rig
from vvdp.generator.kinds import INT
from vvdp.numerics.tableaus import TSIT5_A, TSIT5_C, TSIT5_E
from vvdp.simulation import loop, places
from vvdp.simulation.layout import command_parts, members, slots
from vvdp.simulation.prepare import Prepared, free_rates, prepare
from vvdp.systems.system import System, load_system

UNTIL = 0.5
DOUBLES = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")


def unwatched(name: str) -> System:
    """A bench whose spool nothing watches: the circuit alone."""
    return rotary_bench(unit_on_rig(load_system(name), "benchmark"), "benchmark").hold().system


def layout(system: System, ready: Prepared) -> str:
    """The C header with the place of every value in the flat vectors."""
    lines = [f"#define STATES {ready.vectors.state.size}", f"#define ACTIVE {ready.pattern.group.size}"]
    for prefix, value in {"P": system.case.params, "Y": system.case.state, "U": system.case.command.held}.items():
        place = 0
        for path, part in members(value, prefix):  # of a signal it is the base, which comes first
            lines.append(f"#define {path.replace('.', '_')} {place}")
            place += slots(part)
    for name, values in (("TSIT5_A", TSIT5_A), ("TSIT5_C", TSIT5_C), ("TSIT5_E", TSIT5_E)):
        lines.append(f"#define {name} " + repr(values.tolist()).replace("[", "{").replace("]", "}"))
    return "\n".join(lines) + "\n"


def library(folder: Path, header: str, *options: str) -> Any:
    """The C program as a library."""
    (folder / "layout.h").write_text(header)
    place = folder / f"bench{'-'.join(options)}.so"
    source = str(HERE / "bench.c")
    command = ["gcc", "-O3", *options, "-shared", "-fPIC", f"-I{folder}", source, "-o", str(place), "-lm"]
    subprocess.run(command, check=True)
    c = ctypes.CDLL(str(place))
    double, long = ctypes.c_double, ctypes.c_long
    c.rates.argtypes = [double, *[DOUBLES] * 4]
    c.rates.restype = None
    c.conditions.argtypes = [DOUBLES] * 2
    c.conditions.restype = None
    c.evaluations.argtypes = [DOUBLES, long, long, *[DOUBLES] * 3]
    c.evaluations.restype = double
    c.run.argtypes = [
        *[DOUBLES] * 5,
        double,
        double,
        double,
        long,
        *[DOUBLES] * 4,
        np.ctypeslib.ndpointer(ctypes.c_long),
    ]
    return c


def random_states(ready: Prepared, count: int) -> np.ndarray:
    """States all over the range that a run can reach, shape (count, n)."""
    rng = np.random.default_rng(1)
    states = rng.uniform(-1.0, 1.0, (count, ready.vectors.state.size))
    states[:, :2] = rng.uniform(2e4, 1.3e7, (count, 2))  # of load line and inlet
    states[:, 2:4] = rng.uniform(0.0, 1e3, (count, 2))  # angles of pump shaft and spool
    states[:, 4] = rng.uniform(-50.0, 500.0, count)
    states[:, 5:7] = rng.uniform(0.0, 1.0, (count, 2))  # openings
    return states


def c_run(c: Any, ready: Prepared, until: float) -> tuple[np.ndarray, np.ndarray]:
    """Final state and counts of the same run in C: attempted steps, refused ones, marks."""
    y, u, counts = ready.vectors.state.copy(), ready.vectors.command.copy(), np.zeros(3, ctypes.c_long)
    status = c.run(
        *(y, u, ready.vectors.params, ready.atol, ready.rtol, 1e-6, 1e-3, until),
        *(ROWS, np.zeros(ROWS), np.zeros((ROWS, y.size)), y.copy(), y.copy(), counts),
    )
    assert status == 0
    return y, counts


def evaluations(rates: Any, states: Any, rounds: Any, u: Any, p: Any, dy: Any) -> None:
    """As many evaluations as asked over the rows of a table of states."""
    for _ in range(rounds):
        for row in range(states.shape[0]):
            rates(0.1, states[row], u, p, dy)


EVALUATIONS = (loop.RATES, loop.MATRIX, INT, loop.VECTOR, loop.VECTOR, loop.VECTOR)


def main(short: bool) -> None:
    """Compares values, then times."""
    until, rounds = (0.02, 3) if short else (UNTIL, 31)
    system = unwatched("prototype")
    ready = prepare(system.model, system.case, system.stepping)
    # The stepper in C knows no events, and needs this tolerance for parts as exact as ours at the default.
    before = prepare(system.model, system.case, replace(system.stepping, relative_tolerance=1e-9))
    command, params = ready.vectors.command, ready.vectors.params
    with tempfile.TemporaryDirectory() as folder:
        header = layout(system, ready)
        c, native = library(Path(folder), header), library(Path(folder), header, "-march=native")
        states = random_states(ready, 1000)
        theirs = np.zeros_like(states)
        found = np.zeros_like(command)
        c.conditions(params, found)
        held = command_parts(system.case)["held"]  # C knows no programs, so it writes the conditions alone
        worst_condition = np.max(np.abs(found - command)[held] / np.maximum(np.abs(command[held]), 1e-300))
        report("conditions, largest relative difference", f"{worst_condition:.1e}", "1e-12", worst_condition <= 1e-12)
        for row, state in enumerate(states):
            c.rates(0.1, state, command, params, theirs[row])
        # C has no modes: each state is met anew, with none that holds on.
        ours = np.array([free_rates(ready)(0.1, state) for state in states])
        worst = np.max(np.abs(ours - theirs) / np.maximum(np.abs(ours).max(axis=0), 1e-300))
        report("rates, largest relative difference", f"{worst:.1e} over 1000 random states", "1e-12", worst <= 1e-12)
        finer = replace(system.stepping, relative_tolerance=1e-11)
        fine, _, _ = bare_run(prepare(system.model, system.case, finer), until)
        (final, clock, _), (c_final, counts) = bare_run(ready, until), c_run(c, before, until)
        weight = ready.scale + np.abs(fine)
        error, c_error = (np.max(np.abs(a - fine) / weight) for a in (final, c_final))
        report("final states, largest weighted difference to one at 1e-11", f"{error:.1e}; in C {c_error:.1e}")
        report("attempted steps", f"{int(clock[places.STEPS])} and in C {counts[0]}")

        (_, _, table), dy = (
            bare_run(ready, 0.05, np.arange(0.0, 0.05, 2e-5)),
            np.zeros(ready.vectors.state.size + len(system.case.command.modes)),
        )
        arguments, evaluate = (table, len(table), 10, command, params, dy), compiled(evaluations, EVALUATIONS)
        times = interleaved(
            {
                "vvdp": lambda: evaluate(ready.linked.rates, table, 10, command, params, dy),
                "C": lambda: c.evaluations(*arguments),
                "C native": lambda: native.evaluations(*arguments),
            },
            rounds,
        )
        for name, found in times.items():
            report(f"one evaluation, {name}", spread(found, "ns", 1e8 / len(table)), listed=True)
        show("one evaluation", times)
        times = interleaved(
            {
                "vvdp": lambda: bare_run(ready, until),
                "C": lambda: c_run(c, before, until),
                "C native": lambda: c_run(native, before, until),
            },
            rounds,
        )
        for name, found in times.items():
            report(f"run of {until:g} s, {name}", spread(found, "ms", 1e3))
        show("run", times)


def show(what: str, times: dict[str, list[float]]) -> None:
    """The ratios, by neighbours and by the least disturbed of all."""
    for name in ("C", "C native"):
        found = ratios(times, "vvdp", name)
        best = min(times["vvdp"]) / min(times[name])
        target = ("1.2", median(found) <= 1.2) if name == "C" else ()
        report(f"{what}, vvdp over {name}", f"{spread(found, 'times')}; of the shortest {best:.3f}", *target)


if __name__ == "__main__":
    run_as_command(main)
