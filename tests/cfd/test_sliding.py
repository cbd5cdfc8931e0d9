"""The outlet turbine with a mesh that slides, beside the frame that turns."""

import math

import pytest

from vvdp.cfd.balance import openings, read_torques
from vvdp.cfd.boundary import MOVING
from vvdp.cfd.case import Fluid, phase_files, start_files
from vvdp.cfd.numerics import PASSING, SECOND_ORDER, UPWIND
from vvdp.cfd.section import cut_sections
from vvdp.cfd.sliding import RING_PATCHES
from vvdp.cfd.solve import solve
from vvdp.cfd.turbine import TurbineOrder, sliding_case, turbine_case, turned_turbine
from vvdp.geometry.shape_tables import given_shape
from vvdp.systems.system import load_system

SPEED = 48.0 * math.pi
STEPS = 120
"""For a channel to take the place of the next one."""


@pytest.fixture(scope="module")
def frozen():
    """The turbine at 24 turns a second, in its frame, on a mesh that is parted; settled enough for its torque."""
    system = load_system("prototype")
    valve = system.case.params.valve
    order = TurbineOrder(
        valve=valve,
        shape=given_shape(valve, None, ["geometry.outlet_arm=7.2 mm"], system.lengths)[0],
        fluid=Fluid(876.0, 0.0387),
        flow=40.0 / 60e3,
        speed=SPEED,
        position=0.5 * valve.helix_length,
        grid=4.0,
        phases=(UPWIND, SECOND_ORDER._replace(most=100)),
    )
    return turbine_case(order, turned_turbine(order), parted=True)


@pytest.fixture(scope="module")
def sliding(frozen):
    phase = PASSING._replace(most=2 * STEPS, window=STEPS)
    return sliding_case(frozen, SPEED, phase, 2.0 * math.pi / 6.0 / STEPS / SPEED)


def test_the_ring_has_two_sides_that_see_each_other(frozen):
    baffles = frozen.mesh_files["system/createBafflesDict"]
    assert "name ring1;" in baffles
    assert "neighbourPatch ring2;" in baffles
    assert {frozen.patches[name].kind for name in RING_PATCHES} == {"cyclicAMI"}
    assert "ring1 ring2 )" in frozen.further_files["constant/MRFProperties"]


def test_what_turns_moves_and_time_goes_on(frozen, sliding):
    assert sliding.mesh_files == frozen.mesh_files
    assert sliding.identity != frozen.identity
    moving = [name for name, patch in sliding.patches.items() if patch.conditions["U"] == MOVING]
    assert set(moving) == {"spool", "chamber", "channels"}
    assert list(sliding.further_files) == ["constant/dynamicMeshDict"]
    assert "movingWallVelocity" in start_files(sliding)["0/U"]
    files = phase_files(sliding, sliding.phases[0], 240)
    assert "application pimpleFoam;" in files["system/controlDict"]
    assert f"endTime {240 * sliding.step!r};" in files["system/controlDict"]
    assert "default Euler;" in files["system/fvSchemes"]
    # A channel takes the place of the next one in half of the steps.
    assert sliding.step * STEPS * SPEED == pytest.approx(math.pi / 3.0)


@pytest.mark.slow
def test_the_frame_that_turns_has_the_torque_of_the_mesh_that_slides(frozen, sliding, openfoam, tmp_path):
    """On two machines, whose meshes differ: forces 0.0540 and 0.0451, 0.0661 and 0.0539 N m, channels two cells wide.

    Angular momentum, which knows of no walls: 0.0427 and 0.0462, 0.0424 and 0.0455 N m.
    """
    found = []
    for case, name in ((frozen, "case"), (sliding, "case-2")):
        mesh_of = tmp_path / "case" if found else None
        solved = solve(case, tmp_path / name, openfoam, 1, lambda progress: None, mesh_of)
        cut_sections({}, openings(case), tmp_path / name, openfoam)
        found.append(read_torques(case, tmp_path / name, len(solved.history.iterations)))
    still, moving = found
    assert moving.momentum == pytest.approx(0.0458, rel=0.03)
    assert still.momentum == pytest.approx(moving.momentum, rel=0.1)
    assert still.forces / moving.forces == pytest.approx(1.21, rel=0.05)
    # It hardly matters where the channels stand.
    assert moving.spread < 0.02 * moving.forces
