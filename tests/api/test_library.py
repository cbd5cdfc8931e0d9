"""What `import vvdp` offers: five lines to a result, values in SI or with units, arrays with units."""

import subprocess
import sys
from dataclasses import replace

import h5py
import numpy as np
import pytest
import xarray
from tests.words import wording

import vvdp
from vvdp.base.errors import ConfigError
from vvdp.evaluation.bench import rotary_bench
from vvdp.runs.tables import node_listing
from vvdp.systems.system import load_system


@pytest.fixture(scope="module")
def run():
    return vvdp.load("prototype", operation={"duty_ratio": 0.4}).run(until="50 ms")


def test_a_first_script(run):
    assert run.summary["duration_s"] == 0.05
    assert "prototype" in repr(run)
    assert len(repr(run).partition("\n")[0]) < 300
    assert rotary_bench(run.system, "test").duty_ratio.base == 0.4


def test_names_are_few_loaded_late_and_listed():
    assert set(vvdp.__all__) <= set(dir(vvdp))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = vvdp.nothing
    code = "import sys, vvdp; print(sorted({'numpy', 'llvmlite', 'h5py', 'matplotlib'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("number", "text"),
    [
        ({"operation": {"duty_ratio": 0.3}}, {"operation": {"duty_ratio": "0.3"}}),
        ({"operation": {"oil_temperature": 323.15}}, {"operation": {"oil_temperature": "50 degC"}}),
        ({"relief_valve": {"cracking_pressure": 101e5}}, {"relief_valve": {"cracking_pressure": "101 bara"}}),
        ({"pump": {"displacement": 1e-5 / (2 * np.pi)}}, {"pump": {"displacement": "10 cc/rev"}}),
        ({"run": {"until": 0.5, "average_from": 0.25}}, {"run": {"until": "500 ms", "average_from": "0.25 s"}}),
        ({"operation": {"pump_speed": 50.0}}, {"operation": {"pump_speed": "50 rad/s"}}),
    ],
)
def test_a_number_is_si_and_a_text_has_its_unit(number, text):
    one, other = (vvdp.load("prototype", **values) for values in (number, text))
    for a, b in zip(one.rows, other.rows, strict=True):
        assert a.key == b.key
        if isinstance(a.value, float):
            assert a.value == pytest.approx(b.value, rel=1e-12)
    assert [row.value for row in one.rows] != [row.value for row in load_system("prototype").rows]


def test_the_axial_position_takes_the_place_of_the_duty_ratio():
    system = vvdp.load("prototype", operation={"axial_position": "2 mm"})
    assert "axial_position" in system.content["operation"]
    assert "duty_ratio" not in system.content["operation"]


def test_every_fault_is_named_at_once():
    with pytest.raises(ConfigError) as problem:
        vvdp.load("prototype", operation={"duty_ratoi": 0.4}, pump={"displacement": "10 bar"})
    assert "duty_ratoi" in str(problem.value)
    assert "--set" not in str(problem.value)
    assert "10 bar" in str(problem.value)


def test_what_the_dataset_has_can_be_drawn_by_its_name(run):
    """Except series of several numbers, and those that are not over time alone."""
    names = [name for name, series in run.to_xarray().items() if series.dims == ("time",)]
    assert "states.inlet" in names and set(names) <= set(run.names)
    (line,) = run.plot("states.inlet").axes[0].lines
    assert np.isclose(line.get_ydata()[0], run.pressure("inlet")[0] / 1e5)


@pytest.mark.parametrize("what", ["state", "output", "command"])
def test_an_unknown_series_is_named(run, what):
    with pytest.raises(ConfigError, match=rf"run: inlett: unknown {what}"):
        getattr(run, what)("inlett")
    with pytest.raises(ConfigError, match="run: inlett: unknown node; did you mean 'inlet'"):
        run.pressure("inlett")


def test_an_unknown_key_of_a_summary_names_the_nearest(run):
    with pytest.raises(ConfigError, match=r"run\.summary: eficiency: unknown key; did you mean .efficiency."):
        run.summary["eficiency"]
    with pytest.raises(KeyError, match=r"docs/keys\.md"):
        run.summary["xqzw"]
    assert run.summary.get("eficiency") is None and "eficiency" not in run.summary


CIRCUIT = """
[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "1 l", start = "10 bar" }

[components]
pump = { type = "flow-source", a = "tank", b = "line", flow = "10 lpm" }
load = { type = "orifice", a = "line", b = "tank", area = "5 mm^2" }

[run]
until = "10 ms"
"""


def test_rounding_is_shown_as_zero_in_the_table_of_nodes():
    """7e-11 Pa is 7e-16 of the reference pressure; 1 Pa is more than the 1e-9 of it that counts as rounding."""
    done = vvdp.loads(CIRCUIT).run()
    small = replace(done, summary=done.summary | {"pressure_min_tank_Pa": -7e-11, "pressure_max_tank_Pa": 1.0})
    (shown,) = (row.values for row in node_listing(small).rows if row.label == "tank, pressure")
    assert shown == (0.0, 0.0, 1.0)


def test_values_of_a_component_may_stand_in_a_table_of_their_own():
    system = vvdp.loads(CIRCUIT)
    one, two, three = (
        system.with_values(components=given)
        for given in (
            {"load.area": "7 mm^2", "pump.flow": {"step": ["1 lpm", "2 lpm"], "at": "5 ms"}},
            {"load": {"area": "7 mm^2"}, "pump": {"flow": {"step": ["1 lpm", "2 lpm"], "at": "5 ms"}}},
            {"load": {"type": "orifice", "a": "line", "b": "tank", "area": "7 mm^2"}, "pump.flow": "1 lpm"},
        )
    )
    assert [row.value for row in one.rows] == [row.value for row in two.rows] != [row.value for row in system.rows]
    assert "load" in three.content["components"]
    assert system.with_values(nodes={"line": {"volume": "2 l"}}).content["nodes"]["line"]["volume"] == "2 l"


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"load": {"aera": "7 mm^2"}}, "components.load.aera: unknown key; did you mean 'area'?"),
        ({"laod": {"area": "7 mm^2"}}, "components.laod: unknown; did you mean 'load'?"),
        ({"x": {"area": "7 mm^2"}}, "components.x: unknown; expected one of load, pump"),
    ],
)
def test_a_wrong_name_in_a_table_is_named_with_its_key(given, message):
    with pytest.raises(ConfigError) as problem:
        vvdp.loads(CIRCUIT).with_values(components=given)
    assert message in str(problem.value)


def test_a_missing_list_is_asked_for_with_a_list():
    text = CIRCUIT + '[programs.gap]\ntype = "table"\nreads = "line.pressure"\nvalues = ["1", "2"]\n'
    with pytest.raises(ConfigError, match=r"missing key 'places', for example \[\"100 bar\", \.\.\.\]"):
        vvdp.loads(text)


def test_the_dataset_has_the_dimension_time_and_units(run):
    data = run.to_xarray()
    assert data.sizes["time"] == run.times.size
    assert data["states.load_line"].dims == ("time",)
    assert data["states.load_line"].attrs["units"] == "Pa"
    assert data["time"].attrs["units"] == "s"
    assert np.array_equal(data["states.load_line"].values, run.state("load_line"))
    recorded = {f"{group}.{path}" for group, members in run.record.groups.items() for path in members}
    assert recorded == set(data.data_vars)


def test_the_table_has_units_in_its_names(run):
    table = run.to_pandas()
    assert table.index.name == "time_s"
    assert np.array_equal(table["states.load_line_Pa"].to_numpy(), run.state("load_line"))


def test_a_saved_run_opens_as_it_was_and_its_file_in_xarray(run, tmp_path):
    directory = run.save(tmp_path / "out", report=False)
    back = vvdp.open(directory)
    assert back.summary.keys() == run.summary.keys()
    assert back.to_xarray().equals(run.to_xarray())
    assert str(directory) in repr(back)
    with xarray.open_dataset(directory / "result.h5", engine="h5netcdf", group="states") as states:
        assert states["load_line"].dims == ("time",)
    with h5py.File(directory / "result.h5") as file:
        assert file.attrs["system"] == "prototype"
    with pytest.raises(ConfigError, match=wording.files.already_exists):
        run.save(tmp_path / "out")


def test_what_is_no_result_is_refused(tmp_path):
    with pytest.raises(ConfigError, match=wording.files.is_no_result):
        vvdp.open(tmp_path)


def test_plots_are_figures_of_charts_or_series(run):
    lines = run.plot("load_pressure_Pa", "load_flow").axes
    assert [axes.get_ylabel() for axes in lines] == ["load pressure [bar]", "load flow [lpm]"]
    assert len(run.plot("speed").axes) == 1
    assert len(run.plot().axes) == 3
    assert {"speed", "load_pressure"} <= set(run.names)
    assert run.result is run.result
    with pytest.raises(ConfigError, match=wording.files.did_you_mean.format(name="load_pressure")):
        run.plot("load_presure")


def test_notebooks_see_a_drawing_and_numbers(run):
    assert "<svg" in run.system._repr_html_()
    assert wording.run.pwm_frequency in run._repr_html_()


def test_a_run_until_a_number_of_seconds_is_that_of_the_text(run):
    system = vvdp.load("prototype", operation={"duty_ratio": 0.4})
    again = system.run(until=0.05)
    assert again.record.states["load_line"].values.tobytes() == run.record.states["load_line"].values.tobytes()


def test_a_number_that_is_not_known_has_its_reason_in_the_warnings():
    """At 0.15 s the load line still fills, so an efficiency would count what is stored."""
    run = vvdp.load("prototype", operation={"duty_ratio": 0.3}).run(until="0.15 s")
    assert np.isnan(run.summary["efficiency"])
    assert any(each.startswith("no efficiency: ") for each in run.warnings)
    assert all(f"warning: {each}" in repr(run) for each in run.warnings)
    settled = vvdp.load("prototype").run(until="0.6 s")
    assert settled.warnings == () and "\n" not in repr(settled)


def test_dir_shows_what_is_public(run):
    """Each name that is shown exists; what the package alone uses is not shown."""
    for each in (vvdp, run, run.system):
        assert all(hasattr(type(each), name) or hasattr(each, name) for name in dir(each))
    assert set(dir(vvdp)) == {*vvdp.__all__, "__version__"}
    assert {"summary", "plot", "to_xarray", "warnings"} <= set(dir(run)) and "fine_from" not in dir(run)
    assert {"run", "with_values"} <= set(dir(run.system)) and "with_tables" not in dir(run.system)


def test_quantities_of_pint_are_texts_with_a_unit():
    """1200 rpm is 125.66 rad/s; what vvdp refuses as a text it refuses as a quantity, in a sentence."""
    import pint

    units = pint.UnitRegistry()
    system = vvdp.load("prototype", operation={"pump_speed": 1200 * units.rpm})
    speed = next(row.value for row in system.rows if row.key == "pump_speed")
    assert speed.base == pytest.approx(1200 * 2 * np.pi / 60, rel=1e-12)
    area = vvdp.load("prototype", load={"area": 12.5 * units.mm**2})
    assert next(row.value for row in area.rows if row.key == "area").base == pytest.approx(12.5e-6, rel=1e-12)
    for wrong in (1200 * units.m, 20 * units.Hz, object(), None):
        with pytest.raises(ConfigError, match="pump_speed") as refused:
            vvdp.load("prototype", operation={"pump_speed": wrong})
        assert "rpm" in str(refused.value)
    assert system.run(until=2 * units.ms).summary["duration_s"] == pytest.approx(2e-3)
