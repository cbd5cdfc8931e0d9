"""Numbers that docs/models/rotary-valve.md and docs/design.md spell out, worked out for `prototype-constant-load`."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from vvdp.design.optimise import optimise
from vvdp.design.problem import problem
from vvdp.design.quantities import quantities, setup
from vvdp.design.temperature import over_temperature
from vvdp.geometry.shape import (
    nozzle_reach,
    perpendicular_area,
    rail_volume,
    spool_volume,
    stations,
    travel,
)
from vvdp.geometry.shape_tables import given_shape, valve_shape
from vvdp.steady.cycle_means import ANGLES as FEWER_ANGLES
from vvdp.systems.spool_travel import duty_travel
from vvdp.systems.system import load_system
from vvdp.valve.branch import branch_drops, branch_flow
from vvdp.valve.condition import Condition
from vvdp.valve.flow_map import ANGLES, averaged_spool_speed, quasi_steady_mean
from vvdp.valve.geometry import nozzle_width, pitch
from vvdp.valve.losses import compressibility_loss, full_open_drop, full_open_loss, transition_loss
from vvdp.valve.torque import equilibrium_speed, pwm_frequency

DOCS = Path(__file__).parents[2] / "docs"
VALVE_PAGE, DESIGN_PAGE = (
    " ".join((DOCS / name).read_text("utf-8").split()) for name in ("models/rotary-valve.md", "design.md")
)
SYSTEM = load_system("prototype-constant-load")
VALVE, OIL = SYSTEM.case.params.valve, SYSTEM.case.params.oil
Q, RHO, MU, TANK = 4e-2 / 60.0, 876.0, 0.0387, 101325.0
AT = Condition(flow=Q, load_pressure=1e7 + TANK, relief_pressure=1.2e7 + TANK, tank_pressure=TANK, density=RHO)


@pytest.mark.parametrize(("m", "words"), [(1.91, "1e-15 for $m = 1.91$"), (1.75, "below 1e-12"), (1.7, "1e-10 for")])
def test_the_branch_law_is_inverted_to_rounding(m, words):
    """30 000 random points, with k so that the drop at 40 lpm stays."""
    assert words in VALVE_PAGE
    rng = np.random.default_rng(0)
    valve = replace(VALVE, centre_flow_exponent=m, centre_coefficient=VALVE.centre_coefficient * Q ** (m - 1.91))
    flow = 10.0 ** rng.uniform(-7.0, np.log10(2e-3), 30_000) * rng.choice([-1.0, 1.0], 30_000)
    opening = 10.0 ** rng.uniform(-4.0, 0.0, 30_000)
    back = branch_flow(sum(branch_drops(flow, opening, RHO, valve)), opening, RHO, valve).flow
    assert np.max(np.abs(back / flow - 1.0)) < float(re.search(r"1e-\d+", words)[0]) * 1.1


def test_frequencies_of_the_valve():
    jets = [replace(VALVE, jet_exponent=s) for s in (0.0, 0.65, 1.0)]
    averaged = [pwm_frequency(averaged_spool_speed(0.5, AT, MU, valve), valve) for valve in jets]
    told = [f"{f:.1f} Hz $(s = {valve.jet_exponent:g})$" for f, valve in zip(averaged, jets, strict=True)]
    assert f"{told[0]}, {told[1]} or {told[2]}" in VALVE_PAGE
    assert f"against {pwm_frequency(equilibrium_speed(Q, RHO, MU, VALVE), VALVE):.1f} Hz fully open" in VALVE_PAGE


def test_reynolds_number_in_a_pocket():
    """rho R omega h/mu, for pockets of 2.5 to 4.5 mm."""
    ends = [RHO * VALVE.spool_radius * 150.8 * h / MU for h in (2.5e-3, 4.5e-3)]
    assert "is 100 to 200" in VALVE_PAGE
    assert 100.0 < ends[0] < ends[1] < 200.0


def test_the_centre_section_as_quadratic_changes_the_loss_little():
    """The loss of both ports' ramps with the centre section's own exponent, opening by opening."""
    drops = full_open_drop(Q, RHO, VALVE)
    n, c, o = drops.nozzle, drops.centre_section, drops.outlet_turbine

    def ramp(pressure):
        H = AT.relief_pressure - pressure

        def drop(share, a):
            return n * (share / a) ** 2 + c * share**1.91 + o * share * share

        def lost(a):
            if drop(1.0, a) <= H:
                return n * (1.0 / a**2 - 1.0)
            share = brentq(lambda x: drop(x, a) - H, 0.0, 1.0)
            return share * H + (1.0 - share) * (AT.relief_pressure - TANK) - (n + c + o)

        edge = np.sqrt(n / (H - c - o))
        return sum(quad(lost, low, high, epsrel=1e-9)[0] for low, high in ((1e-9, edge), (edge, 1.0)))

    loss = 2.0 * nozzle_width(VALVE) / pitch(VALVE) * Q * (ramp(AT.load_pressure) + ramp(TANK))
    assert "changes the total by less than 1e-4" in VALVE_PAGE
    assert 0.0 < abs(loss - transition_loss(AT, VALVE).loss) < 1e-4 * (loss + Q * (n + c + o))


def test_loss_with_an_override():
    """10 bar at 40 lpm: closed form, and averaged over the period."""
    with_override = AT._replace(relief_override=1e6, relief_rated_flow=Q)
    open_loss = full_open_loss(Q, RHO, VALVE)
    watts = [open_loss + transition_loss(at, VALVE).loss for at in (AT, with_override)]
    assert f"grows from {watts[0]:.0f} to {watts[1]:.0f} W" in VALVE_PAGE
    assert quasi_steady_mean(0.5, with_override, VALVE).loss == pytest.approx(watts[1], rel=2e-4)
    assert f"at {ANGLES} angles of half a period" in VALVE_PAGE
    assert f"does the same at {FEWER_ANGLES} angles" in VALVE_PAGE


def test_two_ways_of_counting():
    found = quantities(setup(SYSTEM))
    slower = pwm_frequency(averaged_spool_speed(0.5, AT, MU, VALVE), VALVE)
    lower = compressibility_loss(slower, 12.7e-6, AT.load_pressure, TANK, OIL)
    assert f"the fully open valve, {found.loss_compressibility:.1f} W" in DESIGN_PAGE
    assert f"the switching valve settles, {lower:.1f} W" in DESIGN_PAGE
    without = found.efficiency + found.loss_compressibility / found.input_power
    assert f"counts compressibility as lost ({found.efficiency:.3f})" in DESIGN_PAGE
    assert f"an analytic map leaves it out ({without:.3f})" in DESIGN_PAGE


def test_checks_over_temperature():
    columns = over_temperature(SYSTEM, coldest=313.15, hottest=315.15).columns
    assert f"it is {columns['eccentricity'][0]:.4f} at 40 degC" in DESIGN_PAGE
    assert f"{columns['radial_force'][0]:.2f} N at 40 lpm" in DESIGN_PAGE
    assert f"{columns['sheared_temperature_rise'][0]:.2f} K" in DESIGN_PAGE
    assert f"{columns['carried_temperature_rise'][0]:.0f} K; the truth lies between" in DESIGN_PAGE
    leakage, friction = 1.5 * 0.3**2, 1.0 / np.sqrt(1.0 - 0.3**2) - 1.0
    assert f"{100.0 * leakage:.1f} % more leakage, {100.0 * friction:.0f} % more friction" in DESIGN_PAGE


FAST, FREE = "pwm_frequency >= 72 Hz", "radial_clearance <= 22.5 um"
OPTIMA = {
    "radius and clearance of the prototype": ([FAST], ["spool_radius = 12.7 mm", "radial_clearance = 12.7 um"]),
    "clearance at most 12.7 um": ([FAST], ["radial_clearance <= 12.7 um"]),
    "clearance at most 22.5 um": ([FAST], [FREE]),
    "the same, transition fraction at most 0.3, clearance at most 25 um": (
        [FAST, "transition_fraction <= 0.3"], ["radial_clearance <= 25 um"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("bounds", OPTIMA)
def test_published_optimum(bounds):
    """Drop, radius, nozzles, outlet and transition fraction, to the digits of the page."""
    page = (DOCS / "design.md").read_text("utf-8")
    cells = re.search(rf"^\| {bounds} \|(.*)\|$", page, re.MULTILINE)[1].replace("*", "").split("|")
    limits, sides = OPTIMA[bounds]
    found = optimise(problem(SYSTEM, "pressure_drop_total", limits, sides), starts=3, globally=False)
    values, kappa = found.values, found.after[0].transition_fraction
    numbers = (
        1e-5 * found.objective,
        1e3 * values["spool_radius"],
        1e6 * values["nozzle_area"],
        1e6 * values["outlet_area"],
        kappa,
    )
    for cell, value in zip(cells, numbers, strict=True):
        last = 10.0 ** -len(cell.strip().partition(".")[2])
        assert float(cell) == pytest.approx(value, abs=0.51 * last)


def test_stroke_and_rail_designs():
    """Lengths, weight and reach of the solids with the full stroke, and the volumes of the five rails."""
    page = " ".join((DOCS / "models" / "geometry.md").read_text("utf-8").split())
    wide, at = given_shape(VALVE, "full-stroke", ()).shape, duty_travel(VALVE)
    low, high = travel(wide, VALVE)
    length = 2.0 * stations(wide, VALVE).spool_end - VALVE.helix_length
    mass = wide.spool_density * spool_volume(wide, VALVE)
    assert f"= {1e3 * (at.high - at.low):.2f} mm, from {1e3 * at.low:.2f} to {1e3 * at.high:.2f} mm" in page
    assert f"a ratio of {wide.stroke_ratio:.2f}, {1e3 * low:.2f} to {1e3 * high:.2f} mm" in page
    assert f"becomes {1e3 * length:.0f} mm long and {mass:.2f} kg heavy" in page
    for name in ("a", "b", "c", "d", "final"):
        held = 1e6 * rail_volume(given_shape(VALVE, f"rail-{name}", ()).shape, VALVE)
        row = page[page.index(f"| `rail-{name}` |") :]
        assert row.split("|")[3].strip() == f"{held:.2f} cm³"


def test_inertia_of_the_oil():
    """The table of passages from the lengths of the solids, and what follows from its sum."""
    shape = valve_shape(VALVE)[0]
    R, N = VALVE.spool_radius, VALVE.sections
    chamber = shape.chamber_outer_radius**2 - shape.chamber_inner_radius**2
    arm = shape.outlet_arm
    passages = {
        "nozzles, across the jet": (
            nozzle_reach(shape, VALVE) - 0.5 * shape.rail_diameter, perpendicular_area(shape, VALVE),
        ),
        "pockets, half of the annulus": (VALVE.helix_length, 0.5 * np.pi * (R**2 - shape.hub_radius**2)),
        "windows": (shape.window_length, N * shape.window_half_angle * chamber),
        "turbine's chamber": (shape.ring_length + shape.outlet_height, np.pi * chamber),
        "turbine's channels": (
            np.sqrt(R**2 - arm**2) - np.sqrt(shape.chamber_outer_radius**2 - arm**2), VALVE.outlet_area,
        ),
        "outlet rail, a quarter of its ring": (
            0.5 * np.pi * shape.collector_radius, 0.25 * np.pi * shape.collector_diameter**2,
        ),
        "port": (shape.port_length, 0.25 * np.pi * shape.collector_port_diameter**2),
    }  # fmt: skip
    page = (DOCS / "models" / "rotary-valve.md").read_text("utf-8")
    for name, (length, area) in passages.items():
        row = f"| {name} | {1e3 * length:.1f} | {1e6 * area:.1f} | {length / area:.0f} |"
        assert row in page
    inertance = RHO * sum(length / area for length, area in passages.values())
    assert f"Together {inertance / RHO:.0f} /m" in VALVE_PAGE
    assert f"{inertance / 1e5:.1f} \\cdot 10^5$ kg/m⁴" in VALVE_PAGE
    drops = full_open_drop(Q, RHO, VALVE)
    slope = (2.0 * (drops.nozzle + drops.outlet_turbine) + 1.91 * drops.centre_section) / Q
    ramp, energy = nozzle_width(VALVE) / pitch(VALVE) / 70.0, 0.5 * inertance * Q * Q
    loss = transition_loss(AT, VALVE).loss + Q * (drops.nozzle + drops.centre_section + drops.outlet_turbine)
    for words in (
        f"in {1e3 * ramp:.2f} ms",
        f"takes {1e-5 * inertance * Q / ramp:.1f} bar",
        f"{1e3 * inertance / slope:.2f} ms in the open valve",
        f"$I Q^2/2 = {energy:.2f}$ J",
        f"it would be {140.0 * energy:.0f} W at 70 Hz, {100.0 * 140.0 * energy / loss:.1f} % of the {loss:.0f} W",
        f"200 Hz it would be {400.0 * energy:.0f} W, and a ramp of {1e3 * ramp * 70.0 / 200.0:.2f} ms",
    ):
        assert words in VALVE_PAGE, words
