"""The tables [faults] of a system file: what fails and when, on a duty ratio that is held and on drawn networks."""

import dataclasses
import pickle

import numpy as np
import pytest
from tests.systems.axial_texts import run_of, system_of
from tests.systems.drawn_orifice import ORIFICE
from tests.systems.table_texts import tables_alone
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.base.signal import pulse, signal_stop, signal_value
from vvdp.evaluation.summary import summary
from vvdp.simulation.run import simulate
from vvdp.simulation.values import flat
from vvdp.systems.resolved import resolved_text
from vvdp.systems.system import shipped_systems

pytestmark = pytest.mark.heavy

SHIPPED = shipped_systems()["vvdp-duty-control"]
SHORT = SHIPPED.replace('until = "2.5 s"', 'until = "2.2 s"')
NEVER = {"begin": "1e5 s"}
STAYS = wording.systems.stays.format(program="passivity", output="command", begin="1.6 s", end="1.8 s")


def with_faults(text: str, **faults: dict[str, str]) -> str:
    """A system's text with tables [faults.NAME]."""
    for name, values in faults.items():
        rows = (f"{key} = " + (value if value == "true" else f'"{value}"') for key, value in values.items())
        text += "\n".join(("", f"[faults.{name}]", *rows, ""))
    return text


DISTURBED = {
    "frozen": {"sensor": "axial_observer.pressure", "frozen": "true"},
    "blind": {"sensor": "axial_sensor.instrument", "lost": "true"},
    "dirty": {"sensor": "encoder.encoder", "missed": "20 %"},
    "stuck": {"actuator": "passivity.command", "stuck": "true"},
    "jam": {"jams": "spool", "torque": "5 N*m"},
}
"""Faults that all stand in one text, so that it is compiled once; most never begin."""


def faulty(**windows: tuple[str, str]) -> str:
    """The text with those faults, some of them from when to when."""
    times = {name: dict(zip(("begin", "end"), window, strict=True)) for name, window in windows.items()}
    return with_faults(SHORT, **{name: each | times.get(name, NEVER) for name, each in DISTURBED.items()})


def drive(run) -> np.ndarray:
    """The command that the pilot valve gets."""
    return run.command.passivity.command


def sane(text: str) -> dict:
    """The summary of a run in which nothing is lost: numbers are numbers, books close, pressures stay in bounds."""
    system, run = run_of(text)
    found = summary(system, run)
    assert np.all(np.isfinite(flat(run.final)))
    assert found["trusted"] and abs(found["energy_residual"]) < 1e-6 and abs(found["mass_residual"]) < 1e-6
    for name in ("inlet", "load_line", "pilot_chamber"):
        pressure = getattr(run.state, name)
        assert pressure.min() > 0.0 and pressure.max() < 160e5, name
    return found


def test_a_pulse_by_hand():
    signal = pulse(2.0, 5.0, 1.0, 3.0)
    assert [signal_value(t, signal) for t in (0.0, 1.0, 2.9, 3.0)] == [2.0, 5.0, 5.0, 2.0]
    assert [signal_stop(t, signal) for t in (0.0, 1.0)] == [1.0, 3.0]


def test_without_faults_nothing_is_different():
    """The same text and the same bits: with an empty table, and with a value that is what it was."""
    plain, empty = system_of(SHORT), system_of(SHORT + "\n[faults]\n")
    same = system_of(with_faults(SHORT, air={"value": "oil.air_fraction", "becomes": "1 %"}))
    for other in (empty, same):
        assert other.circuit.text == plain.circuit.text
        assert other.circuit.digest == plain.circuit.digest
        assert other.case == plain.case
    assert "instrument_step" not in plain.circuit.text


@pytest.mark.thorough
def test_faults_that_never_begin_leave_every_bit():
    """Instruments and a brake stand in the text, and change nothing: not the steps, and no number."""
    plain, ready = run_of(SHORT)[1], run_of(faulty())[1]
    assert np.array_equal(plain.times, ready.times)
    assert np.array_equal(plain.state.slide.position, ready.state.slide.position)
    assert np.array_equal(plain.state.spool.speed, ready.state.spool.speed)
    assert np.array_equal(drive(plain), drive(ready))


def test_a_stuck_valve_stays_where_it_is():
    text = faulty(stuck=("1.6 s", "1.8 s"))
    sane(text)
    system, run = run_of(text)
    held = drive(run)[(run.times > 1.6) & (run.times < 1.7995)]
    before = drive(run)[run.times < 1.5995][-1]
    assert np.ptp(held) == 0.0 and abs(held[0] - before) < 0.1
    assert np.ptp(drive(run)[(run.times > 1.801) & (run.times < 1.9)]) > 0.0
    (said,) = (each.sentence for each in system.faults if each.name == "stuck")
    assert said == f"stuck: {STAYS}"


def test_missed_edges_are_those_of_their_time():
    """20 % of the edges for 0.3 s at 24.6 turns/s and 8 sectors: 12 of 59."""
    sane(faulty(dirty=("1.6 s", "1.9 s")))
    run = run_of(faulty(dirty=("1.6 s", "1.9 s")))[1]
    assert np.all(np.isfinite(run.command.estimate.speed))


def test_a_frozen_pressure_and_a_lost_sensor_end():
    """The spool comes back to its place within 0.2 s after both."""
    for name in ("frozen", "blind"):
        text = faulty(**{name: ("1.5 s", "1.7 s")})
        sane(text)
        run = run_of(text)[1]
        late = run.times > 1.95
        error = run.state.slide.position[late] - run.command.axial_reference.value[late]
        assert np.max(np.abs(error)) < 0.1e-3, name


def test_a_jam_stops_the_spool_and_lets_it_go():
    """5 N m against 0.1 N m of the jets: it stands within 5 ms, on a step that ends where the jam begins."""
    text = faulty(jam=("1.6 s", "1.7 s"))
    found = sane(text)
    assert found["loss_jam_W"] >= 0.0
    run = run_of(text)[1]
    speed = np.interp([1.5999, 1.605, 1.6999, 2.1], run.times, run.state.spool.speed)
    assert speed[0] > 140.0 and abs(speed[1]) < 0.1 and abs(speed[2]) < 0.1 and speed[3] > 140.0


def test_what_fails_is_no_part_of_what_programs_believe():
    """30 % of air in the oil, and a pilot supply that fails: the plant has them, the program's settings do not."""
    faults = {
        "air": {"value": "oil.air_fraction", "becomes": "30 %"},
        "pilot": {"value": "pilot.supply_pressure", "becomes": "0 bar", "begin": "1.6 s", "end": "1.8 s"},
    }
    plain, system = system_of(SHORT), system_of(with_faults(SHORT, **faults))
    assert system.circuit.network.oil.air_fraction == 0.3 and plain.circuit.network.oil.air_fraction == 0.01
    assert system.case.settings == plain.case.settings
    assert system.circuit.text == plain.circuit.text
    run = simulate(system.model, system.case, system.stepping)
    assert np.all(np.isfinite(flat(run.final)))
    position = np.interp([1.59, 1.75, 2.15], run.times, run.state.slide.position)
    assert position[1] < 0.5 * position[0] and position[2] == pytest.approx(position[0], abs=0.2e-3)
    assert run.model.stop(1.0, system.case.command, system.case.params) == 1.6


def test_a_system_with_faults_travels():
    """Its text loads to the same case, and so does its pickle."""
    faults = DISTURBED | {"air": {"value": "oil.air_fraction", "becomes": "30 %"}}
    system = system_of(with_faults(SHORT, **faults))
    again = system_of(resolved_text(system))
    assert again.case == system.case and again.faults == system.faults
    assert pickle.loads(pickle.dumps(system)).case == system.case


DRAWN = (
    """
title = "drawn"
[nodes.tank]
type = "tank"
[nodes.line]
type = "volume"
volume = "100 cc"
start = "10 bar"
[components.supply]
type = "flow-source"
a = "tank"
b = "line"
flow = "5 lpm"
"""
    + ORIFICE
    + """[run]
until = "0.2 s"
"""
)


def test_values_of_a_drawn_network():
    """The flow doubles for a while, and with it the pressure fourfold; the orifice is another one all the time."""
    cut = {"value": "components.supply.flow", "becomes": "10 lpm", "begin": "0.1 s", "end": "0.15 s"}
    wide = {"value": "components.load.discharge_coefficient", "becomes": "0.7"}
    system = system_of(with_faults(DRAWN, cut=cut, wide=wide))
    run = simulate(system.model, system.case, system.stepping)
    low, high, again = np.interp([0.099, 0.149, 0.199], run.times, run.state.line) - 101325.0
    assert high / low == pytest.approx(4.0, rel=1e-2)  # the oil's air takes less room
    assert again == pytest.approx(low, rel=2e-3)
    plain = system_of(DRAWN)
    healthy = simulate(plain.model, plain.case, plain.stepping)
    assert low / (healthy.state.line[-1] - 101325.0) == pytest.approx((0.6 / 0.7) ** 2, rel=2e-3)


REFUSED = {
    "sensor": (
        {"sensor": "axial_observer.foo", "frozen": "true"},
        "sensor: " + wording.systems.no_sensor.format(sensor="axial_observer.foo", program="axial_observer"),
    ),
    "program": (
        {"sensor": "axial_sensr.position", "frozen": "true"},
        wording.systems.no_program.format(name="axial_sensr", meant="axial_sensor"),
    ),
    "unit": (
        {"sensor": "axial_sensor.position", "bias": "5 bar"},
        "bias: '5 bar' " + wording.files.is_not_a.format(quantity="a position"),
    ),
    "nothing": ({"sensor": "axial_sensor.position"}, wording.systems.expected_sensor_fault),
    "times": (
        {"sensor": "axial_sensor.position", "frozen": "true", "begin": "2 s", "end": "2 s"},
        "end: " + wording.systems.begins_and_ends.format(begin="2 s", end="2 s"),
    ),
    "time": (
        {"sensor": "axial_sensor.position", "frozen": "true", "begin": "2 bar"},
        "begin: '2 bar' " + wording.files.is_not_a.format(quantity="a time"),
    ),
    "command": (
        {"actuator": "axial_observer.foo", "stuck": "true"},
        "actuator: " + wording.systems.no_command.format(program="axial_observer", output="foo"),
    ),
    "still": ({"actuator": "passivity.command", "frozen": "true"}, wording.systems.expected_actuator_fault),
    "encoder": ({"sensor": "encoder.encoder", "frozen": "true"}, wording.systems.encoder_fault),
    "node": ({"jams": "spol", "torque": "1 N*m"}, "jams: " + wording.systems.jams.format(part="spol", meant="spool")),
    "friction": ({"jams": "spool", "force": "1 N"}, wording.systems.expected_friction),
    "table": (
        {"value": "oill.air_fraction", "becomes": "30 %"},
        "value: 'oill.air_fraction' " + wording.systems.not_in_file,
    ),
    "key": (
        {"value": "oil.air", "becomes": "30 %"},
        "value: 'oil.air' " + wording.systems.not_in_file,
    ),
    "becomes": (
        {"value": "oil.air_fraction", "becomes": "30 bar"},
        "'30 bar' " + wording.files.is_not_a.format(quantity="a volume fraction"),
    ),
    "rigid": (
        {"value": "oil.air_fraction", "becomes": "30 %", "begin": "1 s"},
        wording.systems.cannot_be_drawn + ": table; expected a value that " + wording.files.does_not_change,
    ),
    "drawing": ({"value": "axial_stops.lower_end", "becomes": "30 mm"}, wording.systems.cannot_be_drawn),
    "what": ({"sensr": "axial_sensor.position"}, wording.systems.expected_kind_of_fault.format(key="sensr")),
}


@pytest.mark.parametrize("name", REFUSED)
def test_bad_faults_are_refused_with_their_line(name):
    fault, expected = REFUSED[name]
    text = with_faults(SHORT, own=fault)
    first = text.splitlines().index("[faults.own]") + 1
    with pytest.raises(ConfigError) as refused:
        system_of(text)
    (told,) = refused.value.faults
    assert expected in str(told) and told.key.startswith("faults.own")
    assert first <= told.line <= first + len(fault)


OF_TABLES = {
    "table": ({"value": "oill.air_fraction"}, wording.files.no_table.format(name="oill", meant="oil")),
    "key": ({"value": "oil.air"}, "value: " + wording.systems.table_has_no.format(table="oil", key="air")),
    "rigid": (
        {"value": "oil.air_fraction", "begin": "1 s"},
        "value: " + wording.systems.cannot_change.format(value="oil.air_fraction"),
    ),
}


@pytest.mark.parametrize("name", OF_TABLES)
def test_bad_faults_of_tables_are_refused(name):
    """In a circuit that a function draws from its tables."""
    fault, expected = OF_TABLES[name]
    with pytest.raises(ConfigError) as refused:
        system_of(with_faults(tables_alone("prototype"), own=fault | {"becomes": "30 %"}))
    assert expected in str(refused.value)


def test_what_a_drawn_file_does_not_say_is_refused():
    for path in ("components.lod.area", "run.until"):
        with pytest.raises(ConfigError, match=wording.systems.not_in_file):
            system_of(with_faults(DRAWN, own={"value": path, "becomes": "1"}))


def test_a_fault_that_would_hide_another_is_refused():
    twice = {name: {"sensor": "encoder.encoder", "missed": share} for name, share in (("one", "20 %"), ("two", "50 %"))}
    with pytest.raises(ConfigError, match="faults.two: " + wording.systems.same_thing.format(other="one")):
        system_of(with_faults(SHORT, **twice))


def test_a_taken_name_is_refused():
    with pytest.raises(ConfigError, match=wording.systems.name_taken.format(name="spool")):
        system_of(with_faults(SHORT, spool={"jams": "spool", "torque": "1 N*m"}))


def test_faults_are_told_and_drawn():
    from vvdp.runs.charts import with_faults as chart_with_faults
    from vvdp.runs.findings import warnings
    from vvdp.runs.run import RecordedRun
    from vvdp.simulation.record import record_of

    system, run = run_of(faulty(stuck=("1.6 s", "1.8 s")))
    shown = RecordedRun(system, record_of(run), summary(system, run), {"until_s": 2.2, "relative_tolerance": 1e-6})
    told = [finding.text for finding in warnings(shown) if finding.title == "Fault"]
    assert f"Stuck: {STAYS}." in told
    chart, _ = next(iter(system.extras.charts(shown.record)))
    levels = [each for panel in chart_with_faults(chart, system.faults).panels for each in panel.levels]
    assert {each.value for each in levels if each.label == "stuck" and each.upright} == {1.6, 1.8}


def test_every_fault_of_an_instrument_has_its_time():
    """A bias of 2 from 1 s to 3 s, by hand; and what a lost signal reads is what the fault says."""
    from vvdp.sensing.instrument import ideal_instrument, instrument_start, instrument_step

    settings = dataclasses.replace(
        ideal_instrument(-10.0, 10.0), bias=2.0, bias_begin=1.0, bias_end=3.0,
        dropout_begin=4.0, dropout_end=5.0, dropout_reading=7.0,
    )  # fmt: skip
    memory, shown = instrument_start(settings), []
    for t in range(6):
        memory, reading = instrument_step(memory, float(t), 1.0, settings)
        shown.append(reading)
    assert shown == [1.0, 3.0, 3.0, 1.0, 7.0, 1.0]
