"""From a name or a file to a system, and everything that can be wrong with it told at once."""

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.base.signal import signal_value
from vvdp.base.tables import parsed_table
from vvdp.evaluation.bench import rotary_bench
from vvdp.evaluation.summary import summary
from vvdp.simulation.run import Method, simulate
from vvdp.systems.system import built_system, load_system, shipped_systems, source_text


@pytest.mark.parametrize("name", shipped_systems())
def test_every_shipped_system_loads(name):
    system = load_system(name)
    assert system.name == name
    assert system.title
    assert system.circuit
    assert 0.0 < system.average_from < system.stepping.until
    stated = {row.status for row in system.rows if row.table != "run"}
    assert stated <= {"measured", "published", "derived", "assumed"}
    for row in system.rows:
        if row.status == "published":
            assert row.source and row.where, f"{row.table}.{row.key} is published nowhere"


def test_there_are_both_benches():
    assert set(shipped_systems()) >= {"prototype", "prototype-constant-load"}


@pytest.mark.parametrize("name", shipped_systems())
def test_file_is_read_as_the_shipped_system_is(name, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(source_text(name), encoding="utf-8")
    a, b = load_system(str(path)), load_system(name)
    assert (a.case, a.stepping) == (b.case, b.stepping)


def test_published_values_arrive_in_si():
    bench = rotary_bench(load_system("prototype"), "test")
    assert bench.valve.nozzle_area == pytest.approx(36.5e-6)
    assert bench.pump.displacement == pytest.approx(22.8e-6 / (2.0 * np.pi))
    assert bench.relief_valve.cracking_pressure == pytest.approx(120e5 + 101325.0)
    assert signal_value(0.0, bench.operation.pump_speed) == pytest.approx(60.0 * np.pi)
    assert signal_value(0.0, bench.operation.oil_temperature) == pytest.approx(313.15)
    assert signal_value(0.0, bench.axial_position) == pytest.approx(0.5 * 20.32e-3)


def test_setting_replaces_a_value_and_its_origin():
    system = load_system("prototype", ["pump.ripple_amplitude=0.05", "run.method=stiff"])
    assert system.case.params.pump.ripple_amplitude == 0.05
    assert next(r for r in system.rows if (r.table, r.key) == ("pump", "ripple_amplitude")).status == "given"
    assert system.stepping.method is Method.STIFF


def test_until_keeps_the_share_of_the_run_that_is_averaged():
    whole, short = load_system("prototype"), load_system("prototype", until="0.2 s")
    assert short.stepping.until == 0.2
    assert short.average_from / 0.2 == pytest.approx(whole.average_from / whole.stepping.until)


def test_duty_ratio_is_an_axial_position():
    """d L = 0.3 times 20.32 mm, whatever its course over time."""
    system = load_system("prototype", ['operation.duty_ratio={step=["0.3","0.6"],at="0.1 s"}'])
    bench = rotary_bench(system, "test")
    L = bench.valve.helix_length
    for t, duty in ((0.0, 0.3), (0.0999, 0.3), (0.1, 0.6), (1.0, 0.6)):
        assert signal_value(t, bench.axial_position) == pytest.approx(duty * L)


def faults(*args, **kwargs) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        load_system(*args, **kwargs)
    return [str(fault) for fault in caught.value.faults]


def test_all_faults_are_told_at_once():
    found = faults(
        "prototype",
        [
            "pump.speed=3 rpm",
            "oil.density=8 kg/m^3",
            "inlet.volume=12.7",
            "relief_valve.cracking_pressure=5 Hz",
            "rum.x=1",
        ],
    )
    text = "\n".join(found)
    assert len(found) == 5
    for word in ("pump.speed", "oil.density", "inlet.volume", "relief_valve.cracking_pressure", "rum"):
        assert word in text


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        (
            ["operation.axial_position=5 mm", "operation.duty_ratio=0.2"],
            "operation.duty_ratio: " + wording.files.contradicts.format(key="axial_position"),
        ),
        (["engine.speed=3 rpm"], wording.files.unknown_table),
        (["operation.oil_temperature=warm"], "oil_temperature"),
        (["operation.pump_speed=30 Hz"], "1800 rpm"),
        (
            ["relief_valve.override_pressure=0 bar", "relief_valve.opening_time=2 ms"],
            "opening_time: 2 ms " + wording.files.must_be_zero_if.format(key="override_pressure"),
        ),
        (["valve.sections=2.5"], wording.systems.whole_number),
        (["valve.lap_ratio=8"], wording.systems.do_not_fit),
        (["run.method=magic"], "automatic, explicit, stiff"),
        (["run.average_from=2 s"], "average_from"),
        (["run.relative_tolerance=0.5"], "relative_tolerance"),
        (["run.window_interval=1 ns"], wording.systems.at_most.format(limit="2e7")),
        (["pump"], "table.key"),
        (["oil.air_fraction=60 %"], "outside"),
        (["oil.viscosity_40=5 cSt"], "must be greater than viscosity_100"),
    ],
)
def test_fault_says_what_was_expected(settings, told):
    assert told in "\n".join(faults("prototype", settings))


def test_until_that_is_no_time():
    assert "--until" in faults("prototype", until="3 bar")[0]


def test_name_that_is_none():
    text = faults("prototpye")[0]
    assert "prototype" in text and wording.files.no_system in text


def broken(tmp_path, old: str, new: str) -> list[str]:
    path = tmp_path / "mine.toml"
    text = source_text("prototype")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    return faults(str(path))


def test_fault_in_a_file_has_its_line(tmp_path):
    found = broken(tmp_path, 'volume = { value = "12.7 cc"', 'volume = { value = "12.7 bar"')
    lines = source_text("prototype").splitlines()
    line = next(i for i, text in enumerate(lines, 1) if text.startswith("volume ="))
    assert found[0].startswith(f"{tmp_path / 'mine.toml'}:{line}: inlet.volume")


def test_missing_key_and_missing_table(tmp_path):
    assert any(
        wording.files.missing_key.format(key="volume") in fault
        for fault in broken(tmp_path, "volume = {", "volumes = {")
    )
    with pytest.raises(ConfigError, match="gains: " + wording.files.missing_table) as told:
        parsed = parsed_table(source_text("displacement-control").replace("[gains]", "[gain]"), "mine.toml")
        built_system(parsed, "mine")
    assert "gain: unknown table; did you mean 'gains'?" in str(told.value)
    found = broken(tmp_path, "[motor]", "[engine]")
    assert [fault for fault in found if "engine" in fault and wording.files.unknown_table in fault]
    assert any("components.load: " in fault for fault in broken(tmp_path, "[load]\n", "[loads]\n"))


def test_a_file_that_draws_its_circuit_names_none(tmp_path):
    (told,) = broken(tmp_path, "[nodes]\n", 'circuit = "some:function"\n[nodes]\n')
    assert told.endswith("mine.toml:16: circuit: this file draws its circuit; remove this line")


def test_axial_position_on_the_command_line_replaces_the_duty_ratio():
    placed = load_system("prototype", ["operation.axial_position=5.08 mm"])
    expected = load_system("prototype", ["operation.duty_ratio=0.25"])  # 0.25 * 20.32 mm
    found, other = (rotary_bench(system, "test") for system in (placed, expected))
    assert found.is_placed and not other.is_placed
    assert found.axial_position.base == pytest.approx(other.axial_position.base, rel=1e-14)
    assert found.duty_ratio.base == pytest.approx(other.duty_ratio.base, rel=1e-14)


FLOODED = """
[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "1 l", start = "2 bar" }
[components]
throttle = { type = "orifice", a = "line", b = "tank", area = "1 mm^2", discharge_coefficient = "0.61", transition_pressure = "0.1 bar" }
[run]
until = "2 ms"
"""  # noqa: E501


def test_a_drawn_file_sets_its_own_bound_for_cavitation(tmp_path):
    """2 bar gauge and falling: below a bound of 5 bar, above the usual one of 0.3 bar absolute."""
    path, watched = tmp_path / "free.toml", tmp_path / "watched.toml"
    path.write_text(FLOODED, encoding="utf-8")
    watched.write_text(FLOODED + '[limits]\ncavitation_pressure = "5 bara"\n', encoding="utf-8")
    found = []
    for file in (path, watched):
        system = load_system(str(file))
        found.append(summary(system, simulate(system.model, system.case, system.stepping))["cavitation_volume"])
    assert found == [False, True]


def test_faults_of_a_drawing_and_of_its_run_are_told_together(tmp_path):
    path = tmp_path / "wrong.toml"
    path.write_text(FLOODED.replace('"1 l"', '"1 bar"').replace('"2 ms"', '"2"'), encoding="utf-8")
    found = faults(str(path))
    assert [fault.split(": ")[1] for fault in found] == ["run.until", "nodes.line.volume"]
