"""K and C_d of a user's own restriction: by hand, with intervals, and in a circuit that takes them."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from tests.cli.conftest import vvdp  # noqa: F401

from vvdp.base.errors import ParameterError
from vvdp.fitting.fitted import settings
from vvdp.fitting.orifice import WITHOUT_DIAMETER, Restriction, fit_orifice, key_line, restriction_of
from vvdp.fitting.table import read_columns
from vvdp.systems.library_examples import example_text

RHO, AREA = 870.0, 5e-6


def measured(exponent=2.0, scatter=0.0, points=9):
    """Flows of 4 to 24 L/min through C_d 0.65, 5 mm^2."""
    flow = np.linspace(4.0, 24.0, points) / 6e4
    drop = 0.5 * RHO * (flow / (0.65 * AREA)) ** 2 * (flow / flow[-1]) ** (exponent - 2.0)
    return {"flow": flow, "pressure_drop": drop * np.exp(scatter * np.random.default_rng(3).standard_normal(points))}


def test_by_hand():
    """1 L/min at 1 bar, 870 kg/m^3, 1 mm^2: K = 1 L/min/sqrt(bar), C_d = Q/(A sqrt(2 dp/rho)) = 1.0992."""
    flow = np.array([1.0, 2.0, 3.0]) / 6e4
    found = fit_orifice({"flow": flow, "pressure_drop": 1e5 * np.array([1.0, 4.0, 9.0])}, Restriction(RHO, 1e-6))
    k, cd = (found.valve[key].interval.value for key in ("flow_coefficient", "discharge_coefficient"))
    assert k == pytest.approx(1.0 / 6e4 / np.sqrt(1e5), rel=1e-12)
    assert cd == pytest.approx(1.0 / 6e4 / (1e-6 * np.sqrt(2e5 / 870.0)), rel=1e-12) == pytest.approx(1.0992, rel=1e-4)


def test_a_discharge_coefficient_that_no_orifice_has_is_a_warning():
    """1.0992 as above, outside 0.3 to 1: the line for a file is that of K, and no component takes it."""
    flow = np.array([1.0, 2.0, 3.0]) / 6e4
    columns = {"flow": flow, "pressure_drop": 1e5 * np.array([1.0, 4.0, 9.0])}
    found = fit_orifice(columns, Restriction(RHO, 1e-6))
    (said,) = (each for each in found.findings if "C_d" in each.text)
    assert said.text == "The table gives C_d = 1.099, outside 0.3 to 1, with an area of 1 mm²."
    assert key_line(found).startswith("conductance")
    with pytest.raises(ParameterError, match=r"^hole: The table gives C_d = 1\.099"):
        fit_orifice(columns, Restriction(RHO, 1e-6, "mine", "hole", table="components.hole"))
    assert not fit_orifice(columns, Restriction(RHO, 2e-6)).findings


@pytest.mark.parametrize("heading", ["Q [l/min];dp [bar]", "q (lpm);Δp [bar]", "Flow [lpm];pressure drop [bar]"])
def test_usual_headings_of_flow_and_pressure_drop(heading, tmp_path):
    (tmp_path / "bench.csv").write_text(f"{heading}\n5;0,42\n10;1,63\n20;6,4\n", encoding="utf-8")
    columns = read_columns(tmp_path / "bench.csv", WITHOUT_DIAMETER)
    assert columns["flow"] == pytest.approx([5.0 / 6e4, 10.0 / 6e4, 20.0 / 6e4])
    assert columns["pressure_drop"] == pytest.approx([0.42e5, 1.63e5, 6.4e5])


def test_exact_points_give_the_coefficient_without_width():
    value, low, high = fit_orifice(measured(), Restriction(RHO, AREA)).valve["discharge_coefficient"].interval
    assert (value, low, high) == pytest.approx((0.65, 0.65, 0.65), rel=1e-9)


def test_the_interval_holds_the_truth_in_95_percent():
    """Of 400 tables; a count of 95 % scatters by 4.4, four times that is allowed."""
    rng, hits = np.random.default_rng(5), 0
    flow = np.linspace(4.0, 24.0, 9) / 6e4
    for _ in range(400):
        drop = 0.5 * RHO * (flow / (0.65 * AREA)) ** 2 * np.exp(0.03 * rng.standard_normal(9))
        _, low, high = (
            fit_orifice({"flow": flow, "pressure_drop": drop}, Restriction(RHO, AREA))
            .valve["discharge_coefficient"]
            .interval
        )
        hits += low <= 0.65 <= high
    assert abs(hits - 380) <= 18


@pytest.mark.parametrize(("exponent", "warned"), [(2.0, False), (2.05, False), (1.0, True), (1.7, True)])
def test_another_power_is_reported(exponent, warned):
    titles = [each.title for each in fit_orifice(measured(exponent), Restriction(RHO)).findings]
    assert ("The coefficient depends on the flow" in titles) is warned


def test_two_points_are_too_few():
    with pytest.raises(ParameterError, match="a law with 2 coefficients needs more"):
        fit_orifice(measured(points=2), Restriction(RHO))


def system(text):
    from vvdp import loads

    return loads(text)


def test_a_component_takes_what_it_has():
    """An orifice C_d, a valve with a conductance K; a pump neither."""
    orifice = restriction_of(system(example_text("orifice")).circuit.network, "mine", "orifice", "components.orifice")
    assert orifice.area == pytest.approx(5e-6) and 850.0 < orifice.density < 900.0
    line = next(settings(fit_orifice(measured(), orifice), Path("bench.csv"), orifice))
    assert line.startswith('components.orifice.discharge_coefficient={value="0.6')
    valve = restriction_of(
        system(example_text("proportional-valve")).circuit.network,
        "mine",
        "proportional_valve",
        "components.proportional_valve",
    )
    found = fit_orifice(measured(), valve)
    assert valve.area is None and [*found.valve] == ["flow_coefficient"]
    (line,) = settings(found, Path("bench.csv"), valve)
    assert line.startswith("components.proportional_valve.conductance={value=")
    assert key_line(found).startswith('conductance = "1.55') and "m^3/(s*Pa^0.5)" in line
    with pytest.raises(ParameterError, match="pump has neither"):
        restriction_of(system(example_text("pump")).circuit.network, "mine", "pump", "components.pump")


def test_the_verb_writes_a_circuit_that_runs(vvdp, tmp_path, monkeypatch):  # noqa: F811
    monkeypatch.chdir(tmp_path)
    columns = measured()
    rows = [f"{6e4 * q:.6f},{1e-5 * dp:.6f}" for q, dp in zip(*columns.values(), strict=True)]
    Path("bench.csv").write_text("\n".join(["flow [lpm],pressure_drop [bar]", *rows]), "utf-8")
    Path("mine.toml").write_text(example_text("orifice"), "utf-8")
    told = vvdp("fit", "bench.csv", "--law", "orifice", "--area", "5 mm^2", "--density", "870 kg/m^3", "--no-report")
    assert 'in a system file: discharge_coefficient = "0.65"' in told.out
    answer = vvdp(
        "fit", "bench.csv", "--law", "orifice", "--on", "mine.toml", "--component", "orifice", "--density",
        "870 kg/m^3", "--no-report", "--out", "fit", "--json",
    )  # fmt: skip
    assert json.loads(answer.out)["discharge_coefficient"] == pytest.approx(0.65, rel=1e-6)
    written = tomllib.loads(Path("fit/fitted.toml").read_text("utf-8"))["components"]["orifice"]
    assert float(written["discharge_coefficient"]["value"]) == pytest.approx(0.65, rel=1e-6)
    assert vvdp("show", "fit/fitted.toml").code == 0
    assert vvdp("fit", "bench.csv", "--law", "orifice", "--on", "mine.toml").code == 2
    other = vvdp("fit", "bench.csv", "--law", "orifice", "--on", "displacement-control", "--component", "load")
    assert other.code == 2 and other.err.startswith("'load' is no component of displacement-control; it has pilot_")
    assert "feed_a, drain_b, orifice" in vvdp(
        "fit", "bench.csv", "--law", "orifice", "--on", "mine.toml", "--component", "load"
    ).err  # fmt: skip


def test_a_value_under_a_short_path_is_written_there(vvdp, tmp_path, monkeypatch):  # noqa: F811
    """The load of the prototype has its values in a table [load]."""
    monkeypatch.chdir(tmp_path)
    rows = [f"{6e4 * q:.6f},{1e-5 * dp:.6f}" for q, dp in zip(*measured().values(), strict=True)]
    Path("bench.csv").write_text("\n".join(["flow [lpm],pressure_drop [bar]", *rows]), "utf-8")
    options = ("--law", "orifice", "--on", "prototype", "--component", "load", "--no-report", "--out", "fit")
    answer = vvdp("fit", "bench.csv", *options, "--density", "870 kg/m^3", "--set", "load.area=5 mm^2")
    assert answer.code == 0, answer.err
    written = tomllib.loads(Path("fit/fitted.toml").read_text("utf-8"))
    assert float(written["load"]["discharge_coefficient"]["value"]) == pytest.approx(0.65, rel=1e-6)
    assert vvdp("show", "fit/fitted.toml").code == 0
