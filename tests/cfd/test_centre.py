"""`vvdp cfd centre`: what is watched, laws of the drop, and the file it ends in."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from tests.cfd.conftest import QUALITY, say
from tests.words import wording

from vvdp.base.errors import ParameterError
from vvdp.cfd import rail
from vvdp.cfd.case import Fluid
from vvdp.cfd.centre import CentreOrder, centre_case, read_total_drop, scale_radially, turned_centre
from vvdp.cfd.centre_result import centre_result, fitted_settings
from vvdp.cfd.centre_study import CentreRun
from vvdp.cfd.convergence import Judgement
from vvdp.cfd.kept import kept_study
from vvdp.cfd.rail_result import Told
from vvdp.geometry.shape import perpendicular_area
from vvdp.geometry.shape_tables import given_shape
from vvdp.systems.system import load_system
from vvdp.valve.branch import turbulent_drops
from vvdp.valve.geometry import nozzle_length, nozzle_width

FLOWS = np.array([15.0, 30.0, 60.0]) / 60e3


@pytest.fixture(scope="module")
def shaped():
    system = load_system("prototype")
    valve = system.case.params.valve
    return valve, *given_shape(valve, None, [], system.lengths)


@pytest.fixture(scope="module")
def order(shaped) -> CentreOrder:
    valve, shape, _ = shaped
    return CentreOrder(valve, shape, Fluid(876.0, 0.0387), 40.0 / 60e3, 0.0, 0.5 * valve.helix_length, 8.0)


def test_every_patch_has_its_conditions(order):
    domain = turned_centre(order)
    case = centre_case(order, domain)
    assert set(case.patches) == set(domain.mesh.names)
    assert case.patches["nozzles"].conditions["U"] == {"type": "slip"}
    assert case.patches["inlet2"].conditions["U"]["volumetricFlowRate"] == pytest.approx(order.flow / 3.0)


def test_shut_nozzles_are_refused(order):
    with pytest.raises(ParameterError, match=wording.cfd.nozzles_shut):
        turned_centre(order._replace(angle=np.pi / 3.0))


def test_a_total_drop_has_the_dynamic_pressure_on_the_areas_of_the_mesh(tmp_path):
    """rho (p + (Q/A)^2/2): 876 (300 + (2e-4/1e-5)^2/2) = 438 kPa, the mean of one stub."""
    for name, value in (("pressure-inlet1", 300.0), ("flow-inlet1", -2e-4), ("flow-outlet", 2e-4)):
        folder = tmp_path / "postProcessing" / name / "0"
        folder.mkdir(parents=True)
        (folder / "surfaceFieldValue.dat").write_text(f"# Area : 1e-05\n1 {value}\n2 {value}\n")
    found = read_total_drop(("inlet1",), ("outlet",), 876.0, tmp_path)
    assert found.value == pytest.approx([438e3, 438e3])
    assert found.flows["outlet"].tolist() == [2e-4, 2e-4]


def made_up(order, rows, share):
    """The result of runs that have never been: the law of the system, times `share`."""
    runs = []
    for flow in FLOWS:
        law = turbulent_drops(float(flow), 1.0, 876.0, order.valve).centre_section
        total = share * law + 0.5 * 876.0 * (flow / perpendicular_area(order.shape, order.valve)) ** 2
        solved = SimpleNamespace(
            judgement=Judgement(160, total, 300.0, 0.0, 1e-5),
            settled=True,
            quality=QUALITY,
            mesh=SimpleNamespace(cells=22765),
        )
        runs.append(CentreRun(order._replace(flow=float(flow)), solved, 0.1, 27.5e-6, 1.0))
    return centre_result(runs, Told("prototype", "coarse", "oil", rows))


def test_the_law_of_the_system_comes_back(order, shaped):
    result = made_up(order, shaped[2], 1.0)
    found = {key: each.value for key, each in result.numbers.items()}
    assert found["flow_exponent"] == pytest.approx(order.valve.centre_flow_exponent, rel=1e-4)
    assert found["centre_coefficient"] == pytest.approx(order.valve.centre_coefficient, rel=1e-3)
    assert found["flow_exponent"] < found["total_exponent"] < 2.0
    valve = load_system("prototype", fitted_settings(result)).case.params.valve
    assert valve.centre_flow_exponent == pytest.approx(found["flow_exponent"], rel=1e-5)
    assert valve.centre_coefficient == pytest.approx(found["centre_coefficient"], rel=1e-5)


def test_a_static_drop_that_the_mesh_has_lost_is_told(order, shaped):
    result = made_up(order, shaped[2], -0.5)
    assert any(wording.cfd.too_coarse in finding.text for finding in result.findings)
    (torque,) = fitted_settings(result)
    assert torque.startswith("valve.inlet_area_ratio=")


def test_a_drop_steeper_than_the_valve_takes_is_met_in_the_middle(order, shaped):
    """Exponent 2.03, and the valve takes 2 at most: in the mean of the logarithms the written law has the drops."""
    runs = []
    for flow in FLOWS.tolist():
        jet = 0.5 * 876.0 * (flow / perpendicular_area(order.shape, order.valve)) ** 2
        judgement = Judgement(160, 0.8e5 * (flow / FLOWS[1]) ** 2.03 + jet, 300.0, 0.0, 1e-5)
        solved = SimpleNamespace(judgement=judgement, settled=True, quality=QUALITY, mesh=SimpleNamespace(cells=22765))
        runs.append(CentreRun(order._replace(flow=flow), solved, 0.1, 27.5e-6, 1.0))
    result = centre_result(runs, Told("prototype", "coarse", "oil", shaped[2]))
    valve = load_system("prototype", fitted_settings(result)).case.params.valve
    assert valve.centre_flow_exponent == 2.0
    laws = [turbulent_drops(flow, 1.0, 876.0, valve).centre_section for flow in FLOWS.tolist()]
    assert np.log(laws / result.tables["runs"]["static_drop_Pa"]).mean() == pytest.approx(0.0, abs=1e-5)


def test_every_key_of_a_centre_section_is_described(order, shaped, keys_as_described):
    keys_as_described("cfd centre", {**made_up(order, shaped[2], 1.0).flat, "out": "results"})


@pytest.mark.slow
def test_the_centre_section_is_solved(openfoam, tmp_path, monkeypatch):
    """On the coarsest of three grids, whose total drop is kept."""
    kept = kept_study("centre-grids")
    monkeypatch.setattr(rail, "GRIDS", {"coarse": 4.0 * np.sqrt(2.0)})
    words = ("--flow", "15 lpm", "65 lpm", "3", "--cores", "1", "--out", str(tmp_path / "centre"), "--json")
    said = say("prototype", *words, verb="centre")
    assert said.code == 0, said.err
    told = json.loads(said.out)
    assert told["total_drop_Pa"][1] == pytest.approx(kept["pressure_drop_Pa"][0], rel=0.02)
    assert told["torque_N_m"][1] == pytest.approx(kept["torque_N_m"][0], rel=0.03)
    assert told["total_exponent"] == pytest.approx(2.0, abs=0.03)
    assert max(told["mass_imbalance"]) < 1e-3
    assert (tmp_path / "centre" / "report.html").is_file()


def test_a_section_of_another_diameter_is_the_same_stretched_across_its_axis(order):
    """Its volume goes with the square of the diameter, the jets' section with the diameter; axial lengths stay."""
    wide = scale_radially(order, 1.25 * 25.4e-3)
    assert turned_centre(wide).volume / turned_centre(order).volume == pytest.approx(1.25**2, rel=2e-3)
    areas = [perpendicular_area(each.shape, each.valve) for each in (wide, order)]
    assert areas[0] / areas[1] == pytest.approx(1.25)
    assert nozzle_length(wide.valve) == pytest.approx(nozzle_length(order.valve))
    assert nozzle_width(wide.valve) == pytest.approx(1.25 * nozzle_width(order.valve))
    assert scale_radially(order, 25.4e-3) == order


def test_the_law_of_several_diameters_comes_back(order, shaped):
    """Drops of the published exponents, whose jets' dynamic pressure is added and taken off again."""
    runs = []
    for diameter in (20.32e-3, 25.4e-3, 31.75e-3):
        wide = scale_radially(order, diameter)
        for flow in FLOWS.tolist():
            law = turbulent_drops(flow, 1.0, 876.0, wide.valve).centre_section
            total = law + 0.5 * 876.0 * (flow / perpendicular_area(wide.shape, wide.valve)) ** 2
            solved = SimpleNamespace(
                judgement=Judgement(160, total, 300.0, 0.0, 1e-5),
                settled=True,
                quality=QUALITY,
                mesh=SimpleNamespace(cells=22765),
            )
            runs.append(CentreRun(wide._replace(flow=flow), solved, 0.1, 27.5e-6, 1.0))
    result = centre_result(runs, Told("prototype", "coarse", "oil", shaped[2]))
    found = {key: each.value for key, each in result.numbers.items()}
    assert found["flow_exponent"] == pytest.approx(1.91, abs=1e-3)
    assert found["diameter_exponent"] == pytest.approx(3.22, abs=1e-3)
    assert found["centre_coefficient"] == pytest.approx(1.45e-6, rel=5e-3)
    valve = load_system("prototype", fitted_settings(result)).case.params.valve
    assert valve.centre_diameter_exponent == pytest.approx(found["diameter_exponent"], rel=1e-5)
