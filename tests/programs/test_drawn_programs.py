"""Programs in a system file: what they read, their units, their order, and what is refused, each with its line."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from vvdp.base.conservation import NOTHING
from vvdp.base.errors import ConfigError
from vvdp.base.kinds import Time
from vvdp.base.tables import parsed_table
from vvdp.network.build import build
from vvdp.programs.pulses import pwm_step
from vvdp.simulation.run import simulate
from vvdp.systems.system import built_system

HEAD = """
title = "Programs"

[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "1 l", start = "20 bar" }

[components]
pump = { type = "flow-source", a = "tank", b = "line", flow = "20 lpm" }
load = { type = "orifice", a = "line", b = "tank", area = "4 mm^2" }

[run]
until = "50 ms"
sample_period = "1 ms"
"""


def system(text, folder=None):
    table = parsed_table(HEAD + text.lstrip(), "mine.toml")
    return built_system(table, "mine", folder) if folder else built_system(table, "mine")


def run(text):
    found = system(text)
    return simulate(found.circuit.model, found.circuit.case, found.stepping)


def faults(text):
    """Line in the text, key and message of each fault."""
    with pytest.raises(ConfigError) as refused:
        system(text)
    begin = HEAD.count("\n")
    return [(fault.line - begin, fault.key, fault.message) for fault in refused.value.faults]


ALL = """
[programs.limited]
type = "limit"
reads = "smooth.value"
lowest = "0 bar"
highest = "30 bar"

[programs.smooth]
type = "low-pass"
reads = "line.pressure"
time_constant = "5 ms"

[programs.ramp]
type = "rate-limit"
reads = { step = ["20 bar", "40 bar"], at = "10 ms" }
rise = "1000 bar/s"
fall = "1000 bar/s"

[programs.path]
type = "reference"
reads = "ramp.value"
filter_rate = "500 1/s"

[programs.error]
type = "sum"
reads = ["path.value", "smooth.value"]
second_weight = -1

[programs.power]
type = "product"
reads = { first = "error.value", second = "pump.flow" }

[programs.map]
type = "table"
reads = "error.value"
places = ["0 bar", "10 bar"]
values = ["0 rpm", "100 rpm"]

[programs.triangle]
type = "cycle"
times = ["0 s", "20 ms", "40 ms"]
values = ["0 lpm", "20 lpm", "0 lpm"]

[programs.law]
type = "pid"
reads = "smooth.value"
reference = "path.value"
feedforward = { from = "triangle.value" }
gain = "1 lpm/bar"
reset_time = "0.1 s"
derivative_time = "1 ms"
highest = "30 lpm"
"""


def test_chains_of_all_programs_run_in_one_instant():
    found = run(ALL)
    command = found.command
    error = command.path.value - command.smooth.value
    assert np.array_equal(command.error.value, error) or np.allclose(command.error.value, error, rtol=1e-14, atol=1e-8)
    assert np.allclose(command.power.value, command.error.value * found.outputs.pump_flow, rtol=1e-12)
    assert np.allclose(command.limited.value[1:], np.clip(command.smooth.value[1:], 101325.0, 3101325.0))
    assert command.triangle.value.max() == pytest.approx(20e-3 / 60.0)
    slope = 100.0 * 2.0 * np.pi / 60.0 / 1e6
    assert np.allclose(command.map.value, slope * np.clip(command.error.value, 0.0, 1e6))
    assert command.law.value.max() <= 30e-3 / 60.0


def test_commands_have_the_quantities_of_what_they_read():
    from vvdp.base.params import field_kinds

    programs = system(ALL).circuit.network.programs
    units = {name: field_kinds(type(each.type.command))["value"].unit for name, each in programs.items()}
    assert units == {
        "limited": "Pa", "smooth": "Pa", "ramp": "Pa", "path": "Pa", "error": "Pa", "power": "W", "map": "rad/s",
        "triangle": "m^3/s", "law": "m^3/s",
    }  # fmt: skip


PWM = """
[components.valve]
type = "two-way-valve"
a = "line"
b = "tank"
command = { from = "pulses.value" }
natural_frequency = "2000 Hz"
stroke = "1 mm"
full_area = "10 mm^2"

[programs.duty]
type = "table"
reads = "line.pressure"
places = ["0 bar", "1 bar"]
values = ["0.3", "0.3"]

[programs.pulses]
type = "pwm"
reads = "duty.value"
frequency = "100 Hz"
"""


def test_the_command_is_on_for_its_share_of_each_period():
    """At 100 Hz and 0.3 edges are at 3, 10, 13, ... ms."""
    found = run(PWM)
    within = (100.0 * found.times) % 1.0
    clear = (np.abs(within - 0.3) > 1e-3) & (np.abs(within - 0.5) < 0.499)
    assert np.array_equal(found.command.pulses.value[clear], (within < 0.3)[clear])


class Edge(NamedTuple):
    time: Time


def note_edge(t, memory, reading, settings):
    return Edge(t), pwm_step(t, NOTHING, reading, settings)[1]


def no_edge(settings):
    return Edge(-1.0)


@pytest.mark.parametrize(("until", "edge"), [(0.0095, 0.003), (0.0125, 0.01), (0.0195, 0.013)])
def test_steps_land_on_the_edges_of_pulses(until, edge):
    """To rounding: the time of the last call."""
    found = system(PWM)
    network = found.circuit.network
    part = network.programs["pulses"]
    kind = replace(part.type, step=note_edge, start=no_edge)
    network.programs["pulses"] = replace(part, type=kind)
    circuit = build(network)
    memory = simulate(circuit.model, circuit.case, replace(found.stepping, until=until)).final_memory["pulses"]
    assert memory.time == pytest.approx(edge, abs=1e-12)


def test_pulses_may_begin_with_a_constant_duty_ratio():
    """From the first instant on."""
    text = PWM.split("[programs.duty]")[0] + '[programs.pulses]\ntype = "pwm"\nreads = "1"\nfrequency = "100 Hz"\n'
    assert np.all(run(text).command.pulses.value == 1.0)


HALF = """
from typing import NamedTuple

from vvdp.base.kinds import Fraction, Time
from vvdp.network.program import ProgramType


class Now(NamedTuple):
    time: Time


class Asked(NamedTuple):
    duty: Fraction


def ask(t, memory, reading, settings):
    return memory, Asked(0.5)


HALF = ProgramType(ask, Now, Asked(0.5))
"""


def test_pulses_begin_with_the_first_command_of_another_program(own):
    """That holds before it is called, at 20 ms: the first pulse is there."""
    (own / "my_control.py").write_text(HALF)
    half = '[programs.half]\ntype = "my_control:HALF"\nperiod = "40 ms"\nphase = "20 ms"\n'
    text = PWM.replace("duty.value", "half.duty").replace("[programs.duty]", f"{half}\n[programs.duty]")
    found = system(text, own)
    run = simulate(found.circuit.model, found.circuit.case, found.stepping)
    within = (100.0 * run.times) % 1.0
    clear = (np.abs(within - 0.5) > 1e-3) & (np.abs(within - 0.5) < 0.499)
    assert np.array_equal(run.command.pulses.value[clear], (within < 0.5)[clear])


def test_a_table_of_the_time_is_a_schedule():
    text = '[programs.plan]\ntype = "table"\nreads = "t"\nplaces = ["10 ms", "30 ms"]\nvalues = ["1 lpm", "5 lpm"]\n'
    found = run(text)
    flows = np.interp(found.times, [0.010, 0.030], [1e-3 / 60, 5e-3 / 60])
    assert np.allclose(found.command.plan.value, flows, atol=2.1e-4 / 60)


# Mistakes


def test_a_loop_names_its_chain_and_its_line():
    text = """
[programs.a]
type = "sum"
reads = ["line.pressure", "b.value"]

[programs.b]
type = "low-pass"
reads = "a.value"
time_constant = "1 ms"
"""
    ((line, key, message),) = faults(text)
    assert (line, key) == (1, "programs.a")
    assert "of the same instant: a -> b -> a; " in message and "`previous = true`" in message
    assert system(text.replace('type = "sum"', 'type = "sum"\nprevious = true'))


def test_programs_that_ask_each_other_for_their_unit():
    text = """
[programs.a]
type = "low-pass"
reads = "b.value"
time_constant = "1 ms"

[programs.b]
type = "low-pass"
reads = "a.value"
time_constant = "1 ms"
"""
    found = faults(text)
    assert [key for _, key, _ in found] == ["programs.a", "programs.b"]
    assert "a -> b -> a" in found[0][2]


LOW_PASS = """
[programs.smooth]
type = "low-pass"
reads = "{reads}"
time_constant = "1 ms"
"""


@pytest.mark.parametrize(
    ("reads", "message"),
    [
        ("line.presure", "'line' has no 'presure'; did you mean 'pressure'?"),
        ("lime.pressure", "'lime.pressure' leads nowhere; did you mean 'line'?"),
        ("other.valu", "'other' has no 'valu'; did you mean 'value'?"),
        ("line", "'line' is the name of a part, not of a quantity"),
    ],
)
def test_what_is_read_leads_nowhere(reads, message):
    other = LOW_PASS.replace("smooth", "other").format(reads="line.pressure")
    ((line, key, said),) = faults(LOW_PASS.format(reads=reads) + other)
    assert (line, key) == (1, "programs.smooth") and message in said


def test_a_true_value_that_no_sensor_measures():
    ((line, key, message),) = faults(LOW_PASS.format(reads="line.enthalpy"))
    assert (line, key) == (1, "programs.smooth") and message == "smooth reads 'line.enthalpy', which no sensor measures"


CONTROL = """
[programs.control]
type = "pi"
reads = "line.pressure"
reference = "{reference}"
gain = "{gain}"
reset_time = "10 ms"
lowest = "{lowest}"
highest = "1"
"""


@pytest.mark.parametrize(
    ("change", "line", "key", "message"),
    [
        ({"reference": "100 lpm"}, 4, "reference", "'100 lpm' is not a pressure level; write for example '100 bar'"),
        ({"reference": "100"}, 4, "reference", "'100' has no unit"),
        ({"lowest": "0 lpm"}, 7, "lowest", "is not a plain number"),
        ({"gain": "0.1 1/bra"}, 5, "gain", "unknown unit '1/bra'"),
        ({"gain": "0.1 lpm/bar"}, 7, "lowest", "'0' has no unit; a volume flow is written"),
        ({"gain": "0.1"}, 7, "lowest", "for example '100 bar'; the command is gain times what is read"),
        (
            {"reference": "pump.flow"},
            4,
            "reference",
            "control.reference is a pressure level [Pa], 'pump.flow' is a volume flow",
        ),
    ],
)
def test_units_of_inputs_and_values(change, line, key, message):
    values = {"reference": "50 bar", "gain": "0.1 1/bar", "lowest": "0", **change}
    found = faults(CONTROL.format(**values))
    assert found[0][:2] == (line, "programs.control" + (f".{key}" if key else ""))
    assert message in found[0][2]


def test_a_limit_that_is_not_given_is_no_assumption():
    text = CONTROL.format(reference="50 bar", gain="0.1 1/bar", lowest="0").replace('lowest = "0"\n', "")
    keys = [row.key for row in system(text).rows if row.table == "programs.control"]
    assert "highest" in keys and "lowest" not in keys


def test_an_input_of_a_component_takes_no_other_unit():
    text = '[programs.flow]\ntype = "limit"\nreads = "pump.flow"\n'
    valve = PWM.split("[programs.duty]")[0].replace("pulses.value", "flow.value")
    ((_, key, message),) = faults(valve + text)
    assert key == "components.valve.command"
    assert "valve.command is a fraction [1], 'flow.value' is a volume flow [m^3/s]" in message


def test_names():
    one = '[programs.line]\ntype = "limit"\nreads = "pump.flow"\n'
    ((line, key, message),) = faults(one)
    assert (line, key) == (1, "programs.line") and "the name 'line' is taken" in message
    with pytest.raises(ConfigError, match="Cannot declare") as refused:
        system(one.replace("line", "twice") + one.replace("line", "twice"))
    assert refused.value.faults[0].line > 0


@pytest.mark.parametrize(
    ("text", "key", "message"),
    [
        ('reads = ["pump.flow"]', "programs.x.second", 'missing; expected what it reads, such as "inlet.pressure"'),
        ('reads = ["pump.flow", "pump.flow"]\nprevious = 1', "programs.x.previous", "1; expected true or false"),
        ('reads = ["pump.flow", "pump.flow"]\nweight = 1', "programs.x.weight", "unknown key"),
    ],
)
def test_keys(text, key, message):
    found = faults(f'[programs.x]\ntype = "sum"\n{text}\n')
    assert any(each[1] == key and message in each[2] for each in found), found


ODD = (
    *("1", "-1", "x.y", "line", "t", "1e400", "0.1 1/bra", "3 K", "", 0, -5, 1.5, True),
    *([], ["1", "x"], [["1"]], {}, {"from": 3}, {"value": {}}),
)
KEYS = [
    (name, key)
    for text in (ALL, PWM)
    for name, part in parsed_table(text, "").content["programs"].items()
    for key in part
]


@pytest.mark.sampled(3)
@pytest.mark.parametrize(("name", "key"), KEYS)
def test_odd_values_are_taken_or_refused(name, key):
    """Nothing but a ConfigError, each with the key's program."""
    text = HEAD + (ALL if f"programs.{name}]" in ALL else PWM).lstrip()
    for odd in ODD:
        table = parsed_table(text, "mine.toml")
        table.content["programs"][name][key] = odd
        try:
            built_system(table, "mine")
        except ConfigError as refused:
            assert all(fault.key.startswith(("programs", "components")) for fault in refused.faults), refused


# Programs of one's own

OWN = """
from typing import NamedTuple

from vvdp.base.kinds import Pressure, PressureDifference
from vvdp.base.params import Params
from vvdp.network.program import ProgramType


class Margin(Params):
    margin: PressureDifference


class Seen(NamedTuple):
    load: Pressure


class Asked(NamedTuple):
    pressure: Pressure


def hold(t, memory, reading, settings):
    return memory, Asked(reading.load + settings.margin)


HOLD = ProgramType(hold, Seen, Asked(1e5), Margin)
"""
NAMED = """
[programs.sensing]
type = "my_control:HOLD"
reads = "line.pressure"
margin = "20 bar"

[programs.smooth]
type = "low-pass"
reads = "sensing.pressure"
time_constant = "1 ms"
"""


@pytest.fixture
def own(tmp_path, monkeypatch):
    monkeypatch.setenv("VVDP_CACHE", str(tmp_path / "cache"))
    (tmp_path / "my_control.py").write_text(OWN)
    return tmp_path


def test_a_program_of_ones_own(own, capsys):
    found = system(NAMED, own)
    assert "code of your own" in capsys.readouterr().err
    assert found.module.name == "my_control"
    run = simulate(found.circuit.model, found.circuit.case, found.stepping)
    assert run.command.sensing.pressure[-1] == pytest.approx(run.state.line[-1] + 2e6, rel=0.1)


@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("my_control:HOLT", "'HOLT' is not there in my_control; did you mean 'HOLD'?"),
        ("my_control:hold", "'hold' is no ProgramType in my_control"),
        ("my_other:HOLD", "no module 'my_other'"),
        ("../my_control:HOLD", "is not the name of a module"),
    ],
)
def test_own_programs_that_are_not_there(own, word, message):
    with pytest.raises(ConfigError) as refused:
        system(NAMED.replace("my_control:HOLD", word), own)
    assert refused.value.faults[0].key == "programs.sensing.type"
    assert message in refused.value.faults[0].message


def test_own_programs_are_of_one_module(own):
    (own / "second.py").write_text(OWN + "\nraise SystemExit('it was run')\n")
    further = NAMED.split("[programs.smooth]")[0].replace("my_control", "second").replace("sensing", "further")
    with pytest.raises(ConfigError, match="programs of your own are in one module"):
        system(NAMED + further, own)


LIMITED = """
from vvdp.base.errors import ParameterError


def refuse_flow(network, name):
    node = network.programs[name].reads["load"].partition(".")[0]
    (pump,) = (part for part in network.parts.values() if part.nodes.get("b") == node)
    if pump.inputs["flow"].extremes[1] > 2e-4:
        raise ParameterError(f"components.{pump.name}.flow: more than {name} can hold")


HOLD = ProgramType(hold, Seen, Asked(1e5), Margin, refuse=refuse_flow)
"""


def test_a_program_refuses_what_the_circuit_cannot_do(own):
    """At the path and line that the file has for it."""
    (own / "my_control.py").write_text(OWN + LIMITED)
    short = '\n[values]\nsupply.flow = "components.pump.flow"\n\n[supply]\nflow = "20 lpm"\n'
    text = HEAD.replace(', flow = "20 lpm"', "") + NAMED + short
    with pytest.raises(ConfigError) as refused:
        built_system(parsed_table(text, "mine.toml"), "mine", own)
    assert [(fault.line, fault.key, fault.message) for fault in refused.value.faults] == [
        (text[: text.index('flow = "20 lpm')].count("\n") + 1, "supply.flow", "more than sensing can hold")
    ]
    assert built_system(parsed_table(text.replace('"20 lpm"', '"10 lpm"'), "mine.toml"), "mine", own)
