"""FMUs for co-simulation, called from a host in Python: bits of `vvdp run`, free parameters, states, wrong input."""

import ctypes
import importlib.util
import re
import shutil
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.export.builds import built, made, model_of
from tests.export.fmi_host import ERROR, OK, Host
from tests.generator.c_way import compilers

from vvdp.base.errors import ConfigError
from vvdp.export.fmu import fmu
from vvdp.export.fmu_binary import compile_binary
from vvdp.export.fmu_model import FIXED, INPUT, TUNABLE, Guest, fmu_model
from vvdp.export.fmu_sources import source_files
from vvdp.export.fmu_units import display_name, unit_lines
from vvdp.generator.binding import is_fused
from vvdp.programs.foreign.platforms import this_platform
from vvdp.simulation.run import simulate
from vvdp.simulation.values import leaves
from vvdp.systems.system import load_system

pytestmark = [
    pytest.mark.skipif(not is_fused(), reason="a run has other bits on a processor without fused operations"),
    pytest.mark.skipif(not compilers() and not importlib.util.find_spec("ziglang"), reason="no C compiler"),
]
PERIOD = 1e-3


@pytest.fixture
def host(tmp_path):
    """A function that makes an initialised host of a system."""
    hosts = []

    def make(name="prototype", fmi=3, values=None, begins=True):
        hosts.append(Host(made(name, fmi), tmp_path / str(len(hosts))))
        assert hosts[-1].put(values or {}) == OK, hosts[-1].said
        if begins:
            assert hosts[-1].begin() == OK, hosts[-1].said
        return hosts[-1]

    yield make
    for each in hosts:
        each.close()


def run_of(name, until, settings=(), **others):
    system = load_system(name, settings)
    stepping = replace(system.stepping, until=until, record_interval=PERIOD, window=0.0, average_from=None, **others)
    return simulate(system.model, system.case, stepping)


def paths_of(system):
    return [path for path, _, _ in leaves(system.case.state) if not path.startswith("books.")]


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("name", ["prototype", "accumulator-charging"])
def test_states_have_the_bits_of_a_run(name, fmi, host):
    """At steps of 1 and 5 ms, over 0.1 s."""
    run = run_of(name, 0.1)
    paths = paths_of(load_system(name))
    for every in (1, 5):
        one = host(name, fmi)
        rows = [one.get(*paths)]
        for _ in range(100 // every):
            assert one.step(every * PERIOD) == OK, one.said
            rows.append(one.get(*paths))
        assert np.array(rows).tobytes() == run.states[::every, : len(paths)].tobytes()


def test_commands_and_outputs_are_those_in_force(host):
    """A row of a run at a sample has the command that held until then, the next row the one that was given there."""
    system = load_system("prototype")
    run, one = run_of("prototype", 0.02), host()
    names = ["estimate.angle", "estimate.speed"]
    places = [[path for path, _, _ in leaves(system.case.command)].index(name) for name in names]
    for number in range(1, 20):
        assert one.step(PERIOD) == OK
        assert one.get(*names).tobytes() == run.commands[number + 1, places].tobytes()
    flow = one.get("pump_flow", "load_flow")
    assert (flow > 1e-5).all()


def test_the_clock_ticks_at_the_first_event_after_each_period(tmp_path):
    """One communication step of 0.2 s with early returns: the ends of the periods are those of the run to the bit."""
    run, model = run_of("prototype", 0.2), made("prototype", 3).model
    one = Host(made("prototype", 3), tmp_path / "events", has_events=True)
    clock = 1 + len(model.variables)
    assert one.begin() == OK
    ticks, coming = [one.pass_event(clock)[0]], PERIOD
    for number in range(1, 201):
        assert one.step(0.2 - one.time) == OK
        assert (one.time, one.needs_event, one.is_early) == (coming, True, number < 200)
        ticked, coming = one.pass_event(clock)
        ticks.append(ticked)
        if ticked:
            assert one.get(clock + 1)[0] == run.mark_times[sum(ticks) - 1]
    assert sum(ticks) == len(run.mark_times) > 5
    passed = np.searchsorted(run.mark_times, np.arange(201) * PERIOD, side="right")
    assert ticks == [False, *(np.diff(passed) > 0)]
    paths = paths_of(model.system)
    assert one.get(*paths).tobytes() == run.final[: len(paths)].tobytes()
    one.close()


def test_a_state_between_a_sample_and_its_event_is_kept(tmp_path):
    """Saved before the event: another instance shows the command before it, and after it the new one."""
    hosts = [Host(made("prototype", 3), tmp_path / name, has_events=True) for name in "ab"]
    clock = 1 + len(made("prototype", 3).model.variables)
    for one in hosts:
        assert one.begin() == OK
    one, other = hosts
    for _ in range(20):
        assert one.step(PERIOD) == OK
        if one.time < 19.5 * PERIOD:
            one.pass_event(clock)
    assert other.restore(one.state()) == OK
    other.time = one.time
    found = []
    for each in hosts:
        before = each.get("estimate.angle")
        each.pass_event(clock)
        found.append([*before, *each.get("estimate.angle")])
        assert each.call("GetClock", (ctypes.c_uint32 * 1)(1), ctypes.c_size_t(1), None) == ERROR
        each.close()
    assert found[0] == found[1]
    assert found[0][0] != found[0][1]


def test_event_mode_is_refused_where_it_was_not_asked_for(host):
    one = host()
    assert one.call("EnterEventMode") == ERROR
    assert "without event mode" in one.said[-1]


SETTINGS = {
    "operation.oil_temperature": ("60 degC", 333.15),
    "operation.duty_ratio": ("0.4", 0.4),
    "operation.pump_speed": ("1500 rpm", 1500 * 2 * np.pi / 60),
    "load.area": ("4 mm^2", 4e-6),
    "initial.load_pressure": ("80 bar", 80e5 + 101325.0),
    "valve.spool_mass": ("0.6 kg", 0.6),
    "spool_filter.edge_variance": ("0.004 rad^2", 0.004),
    "encoder.noise": ("0.1", 0.1),
}


@pytest.mark.parametrize("key", SETTINGS)
def test_a_value_that_is_set_has_the_bits_of_a_run_with_set(key, host):
    text, number = SETTINGS[key]
    row = next(row for row in load_system("prototype", [f'{key}="{text}"']).rows if row.setting == key)
    assert row.nominal == pytest.approx(number, rel=1e-12)
    run, plain = run_of("prototype", 0.05, [f'{key}="{text}"']), run_of("prototype", 0.05)
    one = host(fmi=2, values={key: row.nominal})
    for _ in range(50):
        assert one.step(PERIOD) == OK
    paths = paths_of(load_system("prototype"))
    assert one.get(*paths).tobytes() == run.final[: len(paths)].tobytes()
    command = [path for path, _, _ in leaves(run.case.command)].index("estimate.angle")
    assert one.get("estimate.angle")[0] == run.reached.command[command]
    ends = [[each.final.tobytes(), each.reached.memory.tobytes()] for each in (run, plain)]
    assert ends[0] != ends[1]


def test_steps_beside_the_samples_stay_near_the_run(host):
    """A step of the integration ends where a communication step ends: within the tolerance that the issue asks for."""
    run, one = run_of("prototype", 0.3), host()
    while one.time < 0.2996:
        assert one.step(0.37e-3) == OK
    assert one.step(0.3 - one.time) == OK
    paths = ["inlet", "spool.angle"]
    places = [paths_of(load_system("prototype")).index(path) for path in paths]
    off = abs(one.get(*paths) - run.final[places])
    assert 0.0 < off[0] < 500.0
    assert 0.0 < off[1] < 5e-5


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_state_continues_in_another_instance(fmi, host):
    one, other = host(fmi=fmi), host(fmi=fmi)
    for _ in range(7):
        one.step(PERIOD)
    kept = one.state()
    for _ in range(9):
        assert one.step(PERIOD) == OK
    assert other.restore(kept) == OK
    assert other.get("spool.angle")[0] != one.get("spool.angle")[0]
    other.time = 7 * PERIOD
    for _ in range(9):
        assert other.step(PERIOD) == OK
    assert other.state() == one.state()
    for wrong in (kept[:-8], b"x" + kept[1:], host("accumulator-charging", fmi).state()):
        assert other.restore(wrong) == ERROR
        assert "none of this FMU" in other.said[-1]
    assert other.state() == one.state()


@pytest.mark.parametrize("fmi", [2, 3])
def test_an_instance_is_reset_and_used_beside_others(fmi, host):
    one = host(fmi=fmi, values={"load.area": 4e-6})
    other = host(fmi=fmi)
    for _ in range(5):
        one.step(PERIOD)
        other.step(PERIOD)
    assert one.get("load_line")[0] != other.get("load_line")[0]
    assert one.call("Reset") == OK
    one.time = 0.0
    assert one.begin() == OK
    for _ in range(5):
        one.step(PERIOD)
    assert one.state() == other.state()


def wrong_values(model):
    """Variables with values that they cannot have, and words of the reason."""
    output = next(each.name for each in model.outputs)
    return [
        ({"load.area": float("nan")}, "is outside"),
        ({"load.area": float("inf")}, "is outside"),
        ({"load.area": -1e-6}, "load.area: -1e-06 is outside 0 to 1"),
        ({"operation.oil_temperature": 500.0}, "is outside 223.15 to 423.15"),
        ({"load.area": 4e-6, output: 1.0}, "is an output and cannot be set"),
        ({99_999: 1.0}, "no variable"),
        ({"initial.load_pressure": 5e6}, "before the first step only"),
    ]


@pytest.mark.parametrize("fmi", [2, 3])
def test_wrong_values_are_refused_and_change_nothing(fmi, host):
    one = host(fmi=fmi)
    assert one.step(PERIOD) == OK
    before = one.state()
    for values, words in wrong_values(made("prototype", fmi).model):
        assert one.put(values) == ERROR
        assert words in one.said[-1]
    for size, time in ((0.0, None), (-PERIOD, None), (float("nan"), None), (PERIOD, 0.5), (float("inf"), None)):
        assert one.step(size, time) == ERROR
    assert one.state() == before
    assert one.put({"load.area": 4e-6}) == OK
    assert one.step(PERIOD) == OK


@pytest.mark.parametrize("fmi", [2, 3])
def test_wrong_calls_are_refused(fmi, host, tmp_path):
    one = host(fmi=fmi, begins=False)
    assert one.step(PERIOD) == ERROR
    assert "initialised" in one.said[-1]
    assert one.begin(start=1.0) == ERROR
    assert any("start time must be 0 s" in words for words in one.said)
    for tolerance in (-1e-6, 1.0, float("nan")):
        assert one.call("Reset") == OK
        assert one.begin(tolerance=tolerance) == ERROR
        assert any("tolerance must be between 0 and 1" in words for words in one.said[-3:])
    assert one.call("Reset") == OK
    assert one.begin(tolerance=1e-4) == OK
    assert one.begin() == ERROR
    stranger = Host(made("prototype", fmi), tmp_path / "x", token="another")
    assert stranger.instance is None
    assert "another FMU" in stranger.said[-1]
    ended = host(fmi=fmi)
    assert ended.call("Terminate") == OK
    assert ended.step(PERIOD) == ERROR
    assert ended.put({"load.area": 4e-6}) == ERROR


ABILITIES = {
    "modelIdentifier": "test_nothing_is_wrong_and_no_state_differs",
    "canGetAndSetFMUState": "test_a_state_continues_in_another_instance",
    "canSerializeFMUState": "test_a_state_continues_in_another_process",
    "canHandleVariableCommunicationStepSize": "test_steps_beside_the_samples_stay_near_the_run",
    "hasEventMode": "test_the_clock_ticks_at_the_first_event_after_each_period",
    "needsCompletedIntegratorStep": "test_states_that_cannot_be_are_refused",
    "providesDirectionalDerivatives": "test_they_are_differences_of_the_rates",
}
"""By what a description declares, in the spelling of FMI 3, a test that uses it."""


@pytest.mark.parametrize("fmi", [2, 3])
def test_all_that_is_declared_has_a_test(fmi):
    text = "".join(each.read_text("utf-8") for each in Path(__file__).parent.glob("test_*.py"))
    known = {name.lower().rstrip("s") for name in ABILITIES}
    guest = made("accumulator-charging", fmi, guest=Guest())
    for one in (made("prototype", fmi), guest):
        root = ET.fromstring(one.entries["modelDescription.xml"])
        declared = {
            name for kind in ("CoSimulation", "ModelExchange") for each in root.iter(kind) for name in each.attrib
        }
        assert {name.lower().rstrip("s") for name in declared} <= known
        assert len(declared) >= 4
    assert [test for test in ABILITIES.values() if f"def {test}(" not in text] == []


def test_a_run_that_cannot_go_on_says_why(host):
    """Pressures far below what the shaft draws: the oil is pulled below absolute zero."""
    one = host("accumulator-charging", 3)
    kept = bytearray(one.state())
    first = made("accumulator-charging", 3).model.machine.content["state"].tobytes()
    place = kept.index(first[:16])
    kept[place : place + 8] = np.array([np.nan]).tobytes()
    assert one.restore(bytes(kept)) == OK
    assert one.step(PERIOD) == ERROR
    assert re.search(r"the run cannot go on at t = \S+ s: a rate is no longer finite", one.said[-1])
    assert one.step(PERIOD) == ERROR


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_description_has_all_variables_with_units(fmi):
    root = ET.fromstring(made("prototype", fmi).entries["modelDescription.xml"])
    model = made("prototype", fmi).model
    units = {each.get("name"): each for each in root.iter("Unit")}
    assert units["Pa"].find("BaseUnit").attrib == {"kg": "1", "m": "-1", "s": "-2"}
    assert units["rad/s"].find("BaseUnit").attrib == {"s": "-1", "rad": "1"}
    assert units["m^3/rad"].find("BaseUnit").attrib == {"m": "3", "rad": "-1"}
    gauge = units["Pa"].find("DisplayUnit[@name='bar (gauge)']")
    assert float(gauge.get("factor")) * 101325.0 + float(gauge.get("offset")) == pytest.approx(0.0, abs=1e-12)
    found = {each.get("name"): each for each in root.iter("Float64" if fmi == 3 else "ScalarVariable")}
    assert [each.name for each in model.variables] == [name for name in found if name not in ("time", "pwm_period_end")]
    area = found["load.area"] if fmi == 3 else found["load.area"].find("Real")
    assert (area.get("unit"), area.get("displayUnit")) == ("m^2", "mm²")
    assert float(area.get("start")) == pytest.approx(3.041e-6, rel=1e-15)
    roles = {each.name: each.role for each in model.settables}
    assert {roles["load.area"], roles["valve.spool_mass"], roles["initial.load_pressure"]} == {INPUT, TUNABLE, FIXED}
    assert "operation.tank_pressure" in model.inputs
    assert "spool.angle" in found


def test_no_parameter_without_effect_is_shown():
    """Each has a number of the machine that follows it; what is fixed has a reason."""
    model = made("prototype", 3).model
    assert all(each.followers for each in model.settables)
    reasons = dict(model.fixed)
    assert "whole number" in reasons["encoder.counter_bits"]
    assert reasons["motor.rated_power"] == "nothing that is simulated follows it"
    assert not reasons.keys() & {each.key for each in model.settables}
    assert {row.setting for row in model.system.rows} == reasons.keys() | {each.key for each in model.settables}


def test_the_guide_shows_what_the_command_prints():
    """One signal is chosen as the input; all other values that can be set are free parameters."""
    model = model_of("prototype")
    free = len(model.settables) - 1
    guide = (Path(__file__).parents[2] / "docs" / "command-line.md").read_text("utf-8")
    line = f"1 inputs, {len(model.outputs)} outputs, {free} free parameters, {len(model.fixed)} fixed"
    assert f"FMI 2: {line} values\n" in guide


def test_inputs_and_outputs_are_chosen_and_renamed():
    system, small = load_system("prototype"), load_system("buck-converter")
    model = fmu_model(system, ["load.area=area"], ["spool.angle=angle", "load_flow"])
    assert model.inputs == ["area"]
    assert [each.name for each in model.outputs] == ["angle", "load_flow"]
    assert "operation.pump_speed" in [each.name for each in model.settables if each.role == TUNABLE]
    for asked, wrong, words in (
        (system, (["load.areas"], []), "did you mean 'load.area'"),
        (system, (["valve.spool_mass"], []), "no value over time"),
        (small, ([], ["tube.flo"]), "did you mean 'tube.flow'"),
        (small, ([], ["node=a", "tube.flow=a"]), "two variables have this name"),
        (system, (["load.area=<a>"], []), "a name consists of"),
        (system, (["load.area", "load.area"], []), "given twice"),
    ):
        with pytest.raises(ConfigError, match=re.escape(words)):
            fmu_model(asked, *wrong)
    moving = load_system("prototype", ['load.area={ sine = "3 mm^2", amplitude = "1 mm^2", frequency = "2 Hz" }'])
    with pytest.raises(ConfigError, match="set it to a number first"):
        fmu_model(moving, ["load.area"])
    assert dict(fmu_model(moving).fixed)["load.area"] == "it is a course over time"


def test_the_same_system_gives_the_same_file():
    again = fmu(fmu_model(load_system("accumulator-charging")), 3)
    assert again.content == made("accumulator-charging", 3).content
    other = fmu_model(load_system("accumulator-charging", ['oil.density="870 kg/m^3"']))
    tokens = {
        each.entries["modelDescription.xml"].partition(b'instantiationToken="')[2][:34]
        for each in (again, built(other, 3))
    }
    assert len(tokens) == 2


def test_without_a_compiler_there_are_the_sources(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setattr("vvdp.export.fmu_binary.has_zig", lambda: False)
    bare = fmu(made("accumulator-charging", 3).model, 3)
    assert bare.compiler == ""
    assert not [name for name in bare.entries if name.startswith("binaries/")]
    assert bare.entries["sources/fmi3.c"] == made("accumulator-charging", 3).entries["sources/fmi3.c"]
    assert b"-ffp-contract=off" in bare.entries["sources/buildDescription.xml"]


@pytest.mark.parametrize("fmi", [pytest.param(2, marks=pytest.mark.thorough), 3])
def test_the_sources_have_no_warning(fmi, monkeypatch):
    """With the warnings that other exported text passes, as errors."""
    model = made("accumulator-charging", fmi).model
    warnings = ("-Wall", "-Wextra", "-pedantic", "-Wshadow", "-Wconversion", "-Werror")
    for compiler in compilers():
        monkeypatch.setenv("CC", compiler)
        used, binary = compile_binary(
            source_files(model, fmi, "{x}"), (*model.machine.flags, *warnings), this_platform()
        )
        assert binary
        assert used in compiler


@pytest.mark.skipif(not importlib.util.find_spec("ziglang"), reason="ziglang is not installed")
def test_a_binary_by_zig_has_the_same_bits(monkeypatch, tmp_path):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    other = fmu(made("accumulator-charging", 2).model, 2)
    monkeypatch.undo()
    assert other.compiler == "ziglang"
    found = []
    for number, each in enumerate((other, made("accumulator-charging", 2))):
        one = Host(each, tmp_path / str(number))
        assert one.begin() == OK
        for _ in range(30):
            assert one.step(PERIOD) == OK
        found.append(one.get(*[output.name for output in each.model.outputs]).tobytes())
        one.close()
    assert found[0] == found[1]


def test_a_display_unit_is_left_out_where_it_is_the_unit():
    system = load_system("prototype")
    kinds = {row.key: row.kind for row in system.rows}
    assert display_name(kinds["density"]) == ""
    assert display_name(kinds["duty_ratio"]) == ""
    assert not [line for line in unit_lines([kinds["duty_ratio"], None]) if "<" in line]
