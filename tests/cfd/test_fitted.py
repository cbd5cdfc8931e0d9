"""One system out of several computations: each takes the file of the one before, and no law is lost on the way."""

import numpy as np
import pytest
from tests.cfd.conftest import say

from vvdp.cfd import rail
from vvdp.cfd.kept import kept_study
from vvdp.cli.cfd_place import Method, write_fitted
from vvdp.geometry.shape_tables import given_shape
from vvdp.systems.system import load_system
from vvdp.valve.torque import equilibrium_speed, inlet_torque, pwm_frequency

NOTE = "fitted to computed flow"
LAWS = (
    {"nozzle_discharge_coefficient": "0.62"},
    {
        "inlet_area_ratio": "0.945",
        "centre_flow_exponent": "1.95",
        "centre_diameter_exponent": "3.3",
        "centre_coefficient": "1.2e-6 SI",
    },
    {
        "outlet_effective_area": "60 mm^2",
        "outlet_discharge_coefficient": "0.7",
        "rail_coefficient": "4.7e10 Pa*s^2/m^6",
    },
)
"""What sweep, centre and turbine write."""


def settings(laws):
    return [f'valve.{key}={{value="{text}", status="derived", note="{NOTE}"}}' for key, text in laws.items()]


def test_one_after_the_other_gives_one_system_with_its_shape(tmp_path):
    system, own = "prototype", ["geometry.nozzle_arm=9.2 mm"]
    for place, laws in enumerate(LAWS):
        folder = tmp_path / str(place)
        folder.mkdir()
        write_fitted(folder, system, Method(shape=None if place else "rail-b", settings=own), settings(laws))
        system, own = str(folder / "fitted.toml"), []
    loaded, plain = load_system(system), load_system("prototype")
    found = {row.key: (row.status, row.note) for row in loaded.rows if row.note == NOTE}
    assert found == {key: ("derived", NOTE) for laws in LAWS for key in laws}
    valve = loaded.case.params.valve
    assert (valve.inlet_area_ratio, valve.centre_coefficient) == (0.945, 1.2e-6)
    assert valve.outlet_effective_area == pytest.approx(60e-6)
    assert valve.spool_mass == plain.case.params.valve.spool_mass
    shape = given_shape(plain.case.params.valve, "rail-b", ["geometry.nozzle_arm=9.2 mm"]).shape
    assert given_shape(valve, None, [], loaded.lengths).shape == shape


def frequency(ratio):
    valve = load_system("prototype-constant-load", [f"valve.inlet_area_ratio={ratio!r}"]).case.params.valve
    return pwm_frequency(equilibrium_speed(40.0 / 60e3, 876.0, 0.0387, valve), valve)


def test_another_arm_of_the_nozzles_is_another_pwm_frequency():
    """Two arms computed on one grid. The jets make 63 % of the torque of open ports, the outlet turbine the rest."""
    study = kept_study("centre-arms")
    valve, ratios = load_system("prototype").case.params.valve, []
    for arm in (8.7e-3, 9.2e-3):
        rows = np.isclose(study["nozzle_arm_m"], arm)
        law = np.array([inlet_torque(flow, 1.0, 876.0, valve) for flow in study["flow_m3_s"][rows]])
        ratios.append(float(law @ law / (law @ study["torque_N_m"][rows])))
    slow, fast = (frequency(ratio) for ratio in ratios)
    jets, turbine = 12.7e-3 / 36.5e-6, 12.7e-3 / 61.8e-6
    torques = [jets / ratio + turbine for ratio in ratios]
    assert fast / slow == pytest.approx(torques[1] / torques[0], rel=1e-6)
    assert fast / slow > 1.06


@pytest.mark.slow
def test_computed_laws_of_all_parts_run(openfoam, tmp_path, monkeypatch):
    """The smallest grid, one part after the other, on the file that the last one wrote."""
    monkeypatch.setattr(rail, "GRIDS", {"coarse": 4.0})
    system, words = "prototype", ["--set", "geometry.nozzle_arm=9.2 mm"]
    for verb, flow in (
        ("sweep", ["20 lpm", "60 lpm", "3"]),
        ("centre", ["20 lpm", "60 lpm", "3"]),
        ("turbine", ["40 lpm"]),
    ):
        folder = tmp_path / verb
        said = say(system, "--flow", *flow, *words, "--cores", "1", "--out", str(folder), "--no-report", verb=verb)
        assert said.code == 0, said.err
        system, words = str(folder / "fitted.toml"), []
    loaded = load_system(system)
    found = {row.key for row in loaded.rows if row.note.startswith(NOTE)}
    assert found == {key for laws in LAWS for key in laws}
    assert loaded.lengths == {"nozzle_arm": {"value": "9.2 mm", "status": "given"}}
    assert loaded.case.params.valve.inlet_area_ratio == pytest.approx(0.945, rel=0.02)
