"""What a person waits for: the help, the first run ever, a later run, a circuit that was never compiled."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from statistics import median

from benchmarks.measure import ROUNDS, empty_caches, in_new_process, report, run_as_command, spread

UNTIL_IT_STARTS = """
import json, time
began = {began!r}
from vvdp.simulation.run import Stepping, compiled_loop, prepare
from vvdp.systems.system import load_system
heard = []
system = load_system("prototype")
prepare(system.model, system.case, system.stepping, say=heard.append)
linked = time.time()
compiled_loop(heard.append)
print(json.dumps({{"start": time.time() - began, "linked": linked - began, "compiled": len(heard)}}))
"""

RUN = """
from vvdp.cli.main import main
try:
    main(["run", "prototype", "--no-report", "--force", "--out", {folder!r} + "/out"])
except SystemExit as end:
    assert not end.code, end.code
print("{{}}")
"""

AGAIN = """
import json, time
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system
system, beside = load_system("prototype", until="0.05 s"), []
for _ in range(10):
    began = time.process_time()
    run = simulate(system.model, system.case, system.stepping)
    beside.append(time.process_time() - began - run.seconds)
print(json.dumps({"beside": min(beside[1:])}))
"""

COMPILE_OWN = """
import json, sys, time
sys.path.insert(0, {folder!r})
from vvdp.simulation.run import Stepping, compiled_loop, prepare
import numba
from own import case, model
began = time.perf_counter()
prepare(model, case, Stepping(until=1.0))
print(json.dumps({{"compile": time.perf_counter() - began}}))
"""

OWN = """
from typing import NamedTuple
from vvdp.base.kinds import Flow, Pressure
from vvdp.base.params import Params
from vvdp.fluid.mixture import fluid_state
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.line import Line, line_flow_rate
from vvdp.hydraulics.volume import closed_volume_rate
from vvdp.simulation.model import Case, Model
from vvdp.systems.system import load_system


class State(NamedTuple):
{fields}


class Outputs(NamedTuple):
    flow: Flow


class Values(Params):
    oil: Oil
    line: Line


def chain(t, s, u, p):
    rho, mu = p.oil.density, 0.04
    tank = fluid_state(p.oil.reference_pressure, p.oil)
{fluids}
    return State(
{rates}
    ), Outputs(s.q{last})


oil = load_system("prototype").tables["oil"]
model = Model(chain)
case = Case(State(*[1e6] * {volumes}, *[1e-4] * {volumes}), Values(oil=oil, line=Line(length=1.0, diameter=0.02)))
"""


def own_circuit(volumes: int, constant: float) -> str:
    """The text of a chain of volumes and lines with twice as many states; `constant` makes it a new one."""
    count = range(volumes)
    flows = [repr(1e-4 + 1e-9 * constant), *(f"s.q{i}" for i in count)]
    states = [*(f"f{i}" for i in count), "tank"]
    pressures = [f"        closed_volume_rate({flows[i]} - s.q{i}, 0.0, 1e-4, f{i})," for i in count]
    lines = [f"        line_flow_rate(s.q{i}, {states[i]}, {states[i + 1]}, rho, mu, p.line)," for i in count]
    return OWN.format(
        fields="\n".join([f"    p{i}: Pressure" for i in count] + [f"    q{i}: Flow" for i in count]),
        fluids="\n".join(f"    f{i} = fluid_state(s.p{i}, p.oil)" for i in count),
        rates="\n".join(pressures + lines),
        last=volumes - 1,
        volumes=volumes,
    )


def started(environment: Mapping[str, str]) -> dict[str, float]:
    """How long a new process takes until the simulation starts."""
    return in_new_process(UNTIL_IT_STARTS.format(began=time.time()), environment)


def helped(environment: Mapping[str, str]) -> float:
    """How long `vvdp --help` takes."""
    began = time.perf_counter()
    subprocess.run([sys.executable, "-m", "vvdp", "--help"], check=True, capture_output=True, env=environment)
    return time.perf_counter() - began


def own_compiled(number: int, environment: Mapping[str, str]) -> float:
    """How long a new circuit of 32 states takes to compile."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "own.py").write_text(own_circuit(16, number + time.time()))
        in_folder = {**environment, "VVDP_CACHE": f"{folder}/circuits"}
        return in_new_process(COMPILE_OWN.format(folder=folder), in_folder)["compile"]


def whole_run(environment: Mapping[str, str], folder: str) -> float:
    """Processor time [s] of `vvdp run prototype --no-report`."""
    return in_new_process(RUN.format(folder=folder), environment)["processor"]


def main(short: bool) -> None:
    """The first run ever a few times, everything else more often; the short form with the caches that are there.

    Byte code of the libraries is kept, as an installation keeps it, and made before the clock starts.
    """
    if short:
        _later(dict(os.environ), 1)
        return
    with tempfile.TemporaryDirectory() as byte_code:
        kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
        kept["PYTHONPYCACHEPREFIX"] = byte_code
        started(kept), helped(kept)
        first = []
        for _ in range(3):
            with empty_caches(kept) as environment:
                first.append(started(environment))
        report("first run ever, until it starts", spread([x["start"] for x in first], "s"), listed=True)
        report("of which the loop", spread([x["start"] - x["linked"] for x in first], "s"), listed=True)
        with empty_caches(kept) as environment:
            _later(environment, ROUNDS)
            compiled = [own_compiled(i, environment) for i in range(5)]
        report("new circuit of 32 states, compiled", spread(compiled, "s"), "6 s", median(compiled) < 6.0)


def _later(environment: Mapping[str, str], rounds: int) -> None:
    """Tells what a run costs whose code is compiled, and the next one in the same process."""
    starts, helps, runs, again = [], [], [], []
    with tempfile.TemporaryDirectory() as folder:
        whole_run(environment, folder)
        for _ in range(rounds):
            starts.append(started(environment)["start"])
            helps.append(helped(environment))
            runs.append(whole_run(environment, folder))
            again.append(in_new_process(AGAIN, environment)["beside"])
    report("later run, until it starts", spread(starts, "s"), "1.5 s", median(starts) < 1.5)
    report("vvdp run --no-report, processor time", spread(runs, "s"), "1.3 s", min(runs) < 1.3)
    report("second simulate, beside the loop", spread(again, "ms", 1e3), "3 ms", min(again) < 3e-3)
    report("vvdp --help", spread(helps, "s"), "0.4 s", median(helps) < 0.4)


if __name__ == "__main__":
    run_as_command(main)
