"""Numbers that docs/models/axial-drives.md spells out, worked out for `axial-chamber` and `axial-gerotor`.

Times of the emergency stop are measured in tests/components/test_axial_drive.py.
"""

from pathlib import Path

import numpy as np
import pytest

from vvdp.fluid.mixture import fluid_state
from vvdp.hydraulics.chamber_drive import holding_pressure, oil_stiffness, spring_frequency, static_reach
from vvdp.hydraulics.gerotor_drive import gerotor_effort
from vvdp.systems.system import load_system

PAGE = " ".join((Path(__file__).parents[2] / "docs" / "models" / "axial-drives.md").read_text("utf-8").split())
CHAMBER, GEROTOR = load_system("axial-chamber").circuit.network, load_system("axial-gerotor").circuit.network
PISTON, SPRING = (CHAMBER.parts[f"drive_axial_{name}"].values[0] for name in ("piston", "spring"))
OIL = CHAMBER.oil
P0, PSI = OIL.reference_pressure, 6894.757


@pytest.mark.parametrize(
    ("psi", "words"), [(190.0, "190 psi ends at 6.34 mm"), (220.0, "220 psi at 20.2 mm"), (230.0, "230 psi at 24.8 mm")]
)
def test_reach_of_a_supply_on_the_page(psi, words):
    assert words in PAGE
    reach = static_reach(P0 + psi * PSI, P0, PISTON, SPRING)
    assert f"{1e3 * reach:.3g} mm" in words


def test_pressures_of_positions():
    length = CHAMBER.programs["drive_observer"].settings.observer.pollution.helix_length
    zero, full = (holding_pressure(x, P0, PISTON, SPRING) - P0 for x in (0.0, 1.3 * length))
    assert f"Position 0 takes {zero / 1e5:.2f} bar" in PAGE
    assert f"takes {full / 1e5:.2f} bar, {full / PSI:.0f} psi" in PAGE


def test_frequencies_of_the_chamber_drive():
    mass = PISTON.moving_mass
    assert f"{spring_frequency(mass, SPRING) / (2.0 * np.pi):.3f} Hz" in PAGE
    oil = oil_stiffness(CHAMBER.nodes["drive_pilot_chamber"].values.volume, fluid_state(14e5, OIL).bulk_modulus, PISTON)
    shut = np.sqrt((SPRING.stiffness + oil) / mass) / (2.0 * np.pi)
    assert f"at 14 bar {oil / SPRING.stiffness:.0f} times as stiff, {shut:.0f} Hz" in PAGE


def test_effort_of_the_gerotor_drive():
    drive, characteristic = GEROTOR.parts["drive_gerotor"].values
    flow = characteristic.largest_flow
    velocity = flow / drive.area
    effort = gerotor_effort(flow, velocity, drive)
    power = effort.passages + effort.friction
    assert f"At the largest flow that is {effort.pressure_difference / 1e5:.2f} bar and {power:.1f} W" in PAGE
    assert f"at {1e3 * velocity:.0f} mm/s holds {1e3 * 0.5 * 0.5 * velocity**2:.1f} mJ" in PAGE
