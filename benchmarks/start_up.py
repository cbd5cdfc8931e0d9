"""Waiting times: the help, a first run with an empty cache, a later run, a run after a change.

`--json` prints the processor times of a first run and of runs after a change, as whole processes.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from statistics import median

from benchmarks.measure import ROUNDS, empty_caches, in_new_process, report, run_as_command, spread

PRESS = """
title = "A small press"

[nodes]
tank = {{ type = "tank" }}
rail = {{ type = "volume", volume = "100 cc", start = "0 bar" }}

[components]
pump = {{ type = "flow-source", a = "tank", b = "rail", flow = "20 lpm" }}
load = {{ type = "orifice", a = "rail", b = "tank", area = "4 mm^2" }}
{more}
[run]
until = "0.8 s"
"""
DRAIN = """
[nodes]
line = { type = "volume", volume = "1 l", start = "50 bar" }
tank = { type = "tank" }

[components]
drain = { type = "laminar-gap", a = "line", b = "tank", conductance = "1e-12 m^3/(s*Pa)" }

[run]
until = "0.1 s"
"""
PROGRAM = """
import json
from typing import NamedTuple

from vvdp.base.conservation import NOTHING
from vvdp.base.kinds import Flow, Pressure
from vvdp.base.params import Params
from vvdp.fluid.mixture import fluid_state
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.volume import closed_volume_rate
from vvdp.simulation.model import Case, Model, Program
from vvdp.simulation.run import Stepping, simulate
from vvdp.systems.system import load_system

CONDUCTANCE = {constant}


class State(NamedTuple):
    rail: Pressure


class Seen(NamedTuple):
    rail: Pressure


class Flows(NamedTuple):
    flow: Flow


class Command(NamedTuple):
    law: Flows


class Values(Params):
    oil: Oil


def measure(t, state, outputs, params):
    return Seen(state.rail)


def step(t, memory, seen, settings):
    return memory, Flows(CONDUCTANCE * (120e5 - seen.rail))


def rail(t, s, u, p):
    rate = closed_volume_rate(u.law.flow - 1e-11 * s.rail, 0.0, 1e-3, fluid_state(s.rail, p.oil))
    return State(rate), Flows(u.law.flow)


model = Model(rail, programs={{"law": Program(measure, step, command=Flows(0.0))}})
values = Values(oil=load_system("prototype").case.params.oil)
case = Case(State(50e5), values, Command(Flows(0.0)), {{"law": NOTHING}}, {{"law": NOTHING}})
run = simulate(model, case, Stepping(until=0.1))
print(json.dumps({{"steps": run.steps}}))
"""

RUN = """
from vvdp.cli.main import main
try:
    main(["run", {system!r}, {more} "--force", "--out", {folder!r} + "/out"])
except SystemExit as end:
    assert not end.code, end.code
print("{{}}")
"""
BARE = '"--no-report", "--no-ranges",'

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


oil = load_system("prototype").case.params.oil
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


def whole_run(system: str, environment: Mapping[str, str], folder: str, more: str = BARE) -> float:
    """Processor time [s] of `vvdp run SYSTEM`, in a process of its own; by default without report and ranges."""
    text = RUN.format(system=system, folder=folder, more=more)
    return in_new_process(text, environment)["processor"]


def cold_times(kept: Mapping[str, str]) -> dict[str, float]:
    """Processor times [s] of whole processes: with an empty cache, and after a change of what is compiled."""
    found: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        press, drain, own = (Path(folder, name) for name in ("press.toml", "drain.toml", "own.py"))
        drain.write_text(DRAIN)
        for name, system in (("machine", "displacement-control"), ("prototype", "prototype"), ("press", str(press))):
            press.write_text(PRESS.format(more=""))
            with empty_caches(kept) as environment:
                found[f"cold_{name}_s"] = whole_run(system, environment, folder)
                if name != "press":
                    continue
                found["unchanged_s"] = whole_run(system, environment, folder)
                press.write_text(PRESS.format(more=MORE))
                found["changed_component_s"] = whole_run(system, environment, folder)
                found["second_circuit_s"] = whole_run(str(drain), environment, folder)
                in_new_process(_program(own, 1e-10), environment)
                found["changed_program_s"] = in_new_process(_program(own, 2e-10), environment)["processor"]
        with empty_caches(kept) as environment:
            found["make_run_s"] = whole_run("prototype", environment, folder, more="")
    return found


MORE = 'bleed = { type = "orifice", a = "rail", b = "tank", area = "0.1 mm^2" }'


def _program(own: Path, constant: float) -> str:
    """A process that runs the module with this constant in its program; functions are read from a file."""
    own.write_text(PROGRAM.format(constant=constant))
    return f"import runpy; runpy.run_path({str(own)!r})"


def main(short: bool) -> None:
    """The first run ever a few times, everything else more often; the short form with the caches that are there.

    Byte code of the libraries is kept, as an installation keeps it, and made before the clock starts.
    """
    if short:
        _later(dict(os.environ), 1)
        return
    with tempfile.TemporaryDirectory() as byte_code:
        kept = _with_byte_code(byte_code)
        every = [cold_times(kept) for _ in range(3)]
        for name, target in COLD_TARGETS.items():
            taken = [found[name] for found in every]
            report(WORDS[name], spread(taken, "s"), f"{target:g} s", median(taken) < target)
        more = [found["changed_component_s"] - found["unchanged_s"] for found in every]
        report("one more component, beyond an unchanged run", spread(more, "s"), "1 s", median(more) < 1.0)
        with empty_caches(kept) as environment:
            _later(environment, ROUNDS)
            compiled = [own_compiled(i, environment) for i in range(5)]
        report("new circuit of 32 states, compiled", spread(compiled, "s"), "2 s", median(compiled) < 2.0)


COLD_TARGETS = {
    "cold_press_s": 4.0,
    "cold_prototype_s": 7.0,
    "cold_machine_s": 14.0,
    "second_circuit_s": 2.5,
    "changed_program_s": 2.0,
}
WORDS = {
    "cold_press_s": "press.toml, empty cache",
    "cold_prototype_s": "prototype, empty cache",
    "cold_machine_s": "displacement-control, empty cache",
    "second_circuit_s": "a second drawn circuit",
    "changed_program_s": "a changed constant of a program",
}


def _with_byte_code(folder: str) -> dict[str, str]:
    """The environment with byte code kept in `folder`, where that of all libraries is made now."""
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    kept["PYTHONPYCACHEPREFIX"] = folder
    with empty_caches(kept) as environment, tempfile.TemporaryDirectory() as elsewhere:
        whole_run("prototype", environment, elsewhere, more="")
    helped(kept)
    return kept


def _later(environment: Mapping[str, str], rounds: int) -> None:
    """Reports what a run costs whose code is compiled, and the next one in the same process."""
    presses, helps, runs, again = [], [], [], []
    with tempfile.TemporaryDirectory() as folder:
        press = Path(folder, "press.toml")
        press.write_text(PRESS.format(more=""))
        for system in ("prototype", str(press)):
            whole_run(system, environment, folder)
        for _ in range(rounds):
            presses.append(whole_run(str(press), environment, folder))
            helps.append(helped(environment))
            runs.append(whole_run("prototype", environment, folder))
            again.append(in_new_process(AGAIN, environment)["beside"])
    report("press.toml, compiled, processor time", spread(presses, "s"), "1 s", median(presses) < 1.0)
    report("prototype, compiled, processor time", spread(runs, "s"), "1.3 s", median(runs) < 1.3)
    report("second simulate, beside the loop", spread(again, "ms", 1e3), "3 ms", min(again) < 3e-3)
    report("vvdp --help", spread(helps, "s"), "0.4 s", median(helps) < 0.4)


if __name__ == "__main__":
    if "--json" in sys.argv:
        with tempfile.TemporaryDirectory() as byte_code:
            print(json.dumps(cold_times(_with_byte_code(byte_code)), indent=2))
    else:
        run_as_command(main)
