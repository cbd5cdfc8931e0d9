"""`vvdp cfd sleeve` and `vvdp cfd valve`: the whole beside its parts."""

import json
import math
from types import SimpleNamespace

import pytest
from tests.cfd.conftest import QUALITY, say

from vvdp.cfd import rail
from vvdp.cfd.balance import Torques
from vvdp.cfd.case import Fluid, start_files
from vvdp.cfd.centre import CentreOrder
from vvdp.cfd.convergence import Judgement
from vvdp.cfd.parts_result import sleeve_parts, sleeve_result, valve_parts, valve_result
from vvdp.cfd.parts_study import PartRun
from vvdp.cfd.rail import RailOrder
from vvdp.cfd.rail_result import Told
from vvdp.cfd.turbine import TurbineOrder
from vvdp.geometry.shape import perpendicular_area
from vvdp.geometry.shape_tables import given_shape
from vvdp.systems.system import load_system
from vvdp.valve.branch import turbulent_drops
from vvdp.valve.torque import inlet_torque, outlet_torque

OIL, FLOW, SPEED = Fluid(876.0, 0.0387), 40.0 / 60e3, 150.0


@pytest.fixture(scope="module")
def shaped():
    system = load_system("prototype")
    valve = system.case.params.valve
    return valve, *given_shape(valve, None, [], system.lengths)


@pytest.fixture(scope="module")
def orders(shaped):
    valve, shape, _ = shaped
    middle = 0.5 * valve.helix_length
    return (
        RailOrder(valve, shape, OIL, FLOW, 4.0),
        CentreOrder(valve, shape, OIL, FLOW, 0.0, middle, 4.0, speed=SPEED),
        TurbineOrder(valve, shape, OIL, FLOW, SPEED, middle, 4.0),
    )


def run(name, drop, torque=math.nan):
    solved = SimpleNamespace(
        judgement=Judgement(160, drop, 0.0, 0.0, 1e-5),
        settled=True,
        quality=QUALITY,
        mesh=SimpleNamespace(cells=1000),
    )
    return PartRun(name, solved, Torques(torque, 0.0, torque), 1.0)


def test_the_sleeve_without_spool_has_both_collectors_and_no_spool(orders):
    whole, alone = sleeve_parts(orders[0])
    assert {"bore", "collector", "outlet-load", "outlet-tank"} < set(whole.case.patches)
    assert set(alone.case.patches) == {"inlet", "rail", "nozzles", "outlet1", "outlet2", "outlet3"}
    assert whole.case.further_files == {}


def test_the_spool_turns_in_every_part_that_has_one(orders):
    for part in valve_parts(*orders):
        turns = any("spool" in name for name in part.case.patches)
        assert ("constant/MRFProperties" in part.case.further_files) == turns
        assert ("topoSet",) in part.case.mesh_programs or not turns
        if turns:
            frame, fields = part.case.further_files["constant/MRFProperties"], start_files(part.case)["0/U"]
            assert f"omega {SPEED!r};" in frame
            turning = {"spool", "windows", "chamber", "channels"} & set(part.case.patches)
            assert fields.count("rotatingWallVelocity") == len(turning)
            words = frame[frame.index("nonRotatingPatches") :].partition(";")[0].split()
            assert set(words[2:-1]) == set(part.case.patches) - turning


@pytest.fixture(scope="module")
def whole(orders, shaped):
    """Of runs that have never been: sections that obey the laws, and a valve that has a tenth more."""
    valve, shape, rows = shaped
    drops, jet = turbulent_drops(FLOW, 1.0, 876.0, valve), FLOW / perpendicular_area(shape, valve)
    torques = inlet_torque(FLOW, 1.0, 876.0, valve), outlet_torque(FLOW, SPEED, 876.0, valve)
    centre = drops.centre_section + 438.0 * jet**2
    runs = [
        run("whole valve", 1.1 * sum(drops), 1.1 * sum(torques)),
        run("rail and nozzles", drops.nozzle),
        run("centre section", centre, torques[0]),
        run("outlet turbine", drops.outlet_turbine, torques[1]),
    ]
    return valve_result(orders[2], runs, Told("prototype", "coarse", "oil", rows))


def test_sections_that_obey_the_laws_come_to_their_sum(whole):
    found = {key: each.value for key, each in whole.numbers.items()}
    assert found["parts_drop_Pa"] == pytest.approx(found["laws_drop_Pa"])
    assert found["parts_torque_N_m"] == pytest.approx(found["laws_torque_N_m"])
    assert found["pressure_drop_Pa"] == pytest.approx(1.1 * found["parts_drop_Pa"])
    assert found["drop_difference_Pa"] == pytest.approx(0.1 * found["parts_drop_Pa"])
    assert any("10 % off" in each.text for each in whole.findings)


@pytest.mark.slow
def test_the_whole_valve_takes_less_than_its_sections(openfoam, tmp_path, monkeypatch):
    """On a small grid: measured 6.67 and 7.26 bar, 0.171 and 0.178 N m, 0.184 N m by angular momentum."""
    monkeypatch.setattr(rail, "GRIDS", {"coarse": 4.0})
    words = ("--flow", "40 lpm", "--cores", "1", "--out", str(tmp_path / "valve"), "--json")
    said = say("prototype", *words, verb="valve")
    assert said.code == 0, said.err
    told = json.loads(said.out)
    assert told["pressure_drop_Pa"] == pytest.approx(6.67e5, rel=0.03)
    assert told["parts_drop_Pa"] == pytest.approx(7.26e5, rel=0.03)
    assert told["whole_torque_N_m"] == pytest.approx(0.171, rel=0.05)
    assert told["parts_torque_N_m"] == pytest.approx(0.178, rel=0.05)
    assert told["whole_momentum_torque_N_m"] == pytest.approx(told["whole_torque_N_m"], rel=0.12)
    assert max(told["mass_imbalance"]) < 0.01
    assert (tmp_path / "valve" / "report.html").is_file()


def test_every_key_is_described(whole, orders, shaped, keys_as_described):
    keys_as_described("cfd valve", {**whole.flat, "out": "results"})
    runs = [run("sleeve without spool", 5e5), run("rail and nozzles", 4.9e5)]
    result = sleeve_result(orders[0], runs, Told("prototype", "coarse", "oil", shaped[2]))
    assert result.numbers["drop_difference_Pa"].value == pytest.approx(0.1e5)
    keys_as_described("cfd sleeve", {**result.flat, "out": "results"})
