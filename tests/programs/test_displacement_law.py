"""Displacement control as a program: the law of the control package, and a drawn machine that follows its reference."""

import re
from pathlib import Path

import numpy as np
import pytest

import vvdp
from vvdp.base.select import maximum
from vvdp.control.capacities import CircuitPressures
from vvdp.control.displacement import CylinderSeen, displacement_start, displacement_step, idle_demand
from vvdp.control.reference import Reference
from vvdp.programs.displacement_law import CylinderTask, displacement_program_step
from vvdp.systems.library_examples import FOLDER

PAGE = Path(__file__).parents[2] / "docs" / "programs.md"
FILE = FOLDER / "programs" / "displacement-control.toml"


@pytest.fixture(scope="module")
def machine():
    return vvdp.load(str(FILE))


@pytest.fixture(scope="module")
def rows(machine):
    return machine.run().to_xarray()


def task(means=(0.0, 0.0, 0.0), released=1.0):
    return CylinderTask(
        reference=0.1,
        reference_velocity=0.05,
        reference_acceleration=0.0,
        reference_jerk=0.0,
        position=0.0995,
        velocity=0.048,
        load_force=-1000.0,
        pressure_a=13e5,
        pressure_b=15e5,
        line_pressure=14e5,
        mean_pressure_a=means[0],
        mean_pressure_b=means[1],
        mean_line_pressure=means[2],
        released=released,
    )


def law_of(machine, fast, slow):
    """The demand of the control package, and its settings."""
    settings = machine.circuit.network.programs["law"].settings
    seen = CylinderSeen(0.0995, 0.048, -1000.0, CircuitPressures(*fast), CircuitPressures(*slow), 0.0)
    _, demand = displacement_step(displacement_start(settings), seen, Reference(0.1, 0.05, 0.0, 0.0), settings)
    return settings, demand


def assert_shows(command, demand):
    """The command has what is asked for, and load and mass as they are believed before anything is learned."""
    shown = {name for name in command._fields if name in demand._fields}
    assert {name: getattr(command, name) for name in shown} == {name: getattr(demand, name) for name in shown}
    assert {*command._fields} - shown == {"load_force", "moving_mass"}
    assert (command.load_force, command.moving_mass) == (-1000.0, 100.0)


@pytest.mark.parametrize("means", [(0.0, 0.0, 0.0), (12e5, 16e5, 14.5e5)])
def test_the_program_is_the_law(machine, means):
    """Where no average is connected, the measured pressures act in split and modes too."""
    fast = (13e5, 15e5, 14e5)
    settings, demand = law_of(machine, fast, means if means[0] else fast)
    _, command = displacement_program_step(0.0, displacement_start(settings), task(means), settings)
    assert_shows(command, demand)
    assert command.direction == 1.0 and 0.0 < command.opening < 1.0 and command.flow > 0.0


def test_nothing_is_asked_for_before_it_is_released(machine):
    settings = machine.circuit.network.programs["law"].settings
    memory, _ = displacement_program_step(0.0, displacement_start(settings), task(), settings)
    memory, command = displacement_program_step(0.001, memory, task(released=0.0), settings)
    assert_shows(command, idle_demand())
    assert memory == displacement_start(settings)


def test_the_flow_and_the_opening_are_those_of_the_motion(rows):
    """On the way in, 54 mm/s push 3.490 L/min into chamber b, which is fed, and 6.564 L/min out of chamber a through
    1.2e-7 m^3/(s Pa^0.5) times the opening. The pump is asked for what the line lacks to 15 bar as well, 1 L/min per
    bar; the split adds the few per cent by which its estimate trails the swing of the effort."""
    way = slice(3000, 3900)
    flow = 6e4 * rows["commands.law.flow"].values[way].mean()
    opening, head = rows["commands.law.opening"].values[way], rows["states.head"].values[way]
    lack = maximum(0.0, 15.0 - 1e-5 * (rows["commands.mean_line.value"].values[way] - 101325.0)).mean()
    assert np.mean(6e4 * 1.2e-7 * opening * np.sqrt(head - 101325.0)) == pytest.approx(6.564, rel=0.01)
    assert flow - lack == pytest.approx(3.490, rel=0.05)


def test_the_cylinder_follows_as_the_page_says(rows):
    time = rows["time"].values
    error = 1e3 * (rows["commands.smooth.value"].values - rows["states.cylinder_rod.position"].values)[time > 0.0]
    assert f"writes a file of {len(FILE.read_text().splitlines())} lines" in PAGE.read_text("utf-8")
    (largest, rms) = re.search(r"within ([\d.]+) mm, ([\d.]+) mm rms", PAGE.read_text("utf-8")).groups()
    assert f"{np.abs(error).max():.2f}" == largest and f"{np.sqrt(np.mean(error[time[1:] > 1.0] ** 2)):.3f}" == rms


def test_a_volume_that_is_used_up_is_refused_with_its_line(tmp_path):
    """0.3 l less 10.77 cm^2 times 300 mm leave nothing of chamber b."""
    path = tmp_path / "machine.toml"
    path.write_text(FILE.read_text().replace('oil_volume_b = "0.8 l"', 'oil_volume_b = "0.3 l"'))
    with pytest.raises(vvdp.VvdpError, match=r"machine.toml:\d+: programs.law.*oil_volume_b"):
        vvdp.load(str(path))
