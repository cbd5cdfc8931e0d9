"""Section 2.5: torques of the turbines, friction, and the speed at which they balance."""

import numpy as np
from scipy.optimize import brentq

from vvdp.base.display import with_unit
from vvdp.base.kinds import AREA, FREQUENCY, LENGTH, MEAN_POWER, NUMBER, SPEED, TORQUE
from vvdp.base.units import ATMOSPHERE
from vvdp.fluid.oil import density, dynamic_viscosity
from vvdp.reproduction.chapter_2.computed import kept_or_none, turbine_over
from vvdp.reproduction.chapter_2.drops import CENTRE, CENTRE_INDEX, TURBINE, TURBINE_INDEX
from vvdp.reproduction.chapter_2.valve import DENSITY, FLOW, VISCOSITY, open_frequency, open_speed, stand, valve
from vvdp.reproduction.item import Item, ItemKind, Reproduction, figure_of
from vvdp.results.chart import Colour, Level, Line, Lines, Stroke
from vvdp.results.result import Column, Table
from vvdp.results.verdict import (
    Statement,
    bound_statement,
    digit_statement,
    exact_statement,
    missing_statement,
    number_statement,
)
from vvdp.valve.gap_flow import gap_reynolds_number
from vvdp.valve.torque import (
    equilibrium_speed,
    friction_coefficient,
    inlet_torque,
    outlet_torque,
    pwm_frequency,
    stall_torque,
)

TURN = 2.0 * np.pi
MEASURED = 70.4, 82.0
"""PWM frequencies between which the built valve turned [Hz]."""
WARMEST, COLDEST = 273.15 + 50.0, 273.15 + 30.0
NOZZLES, BLADES = 3, 6
EXPONENT = 0.65
"""Of the jets' torque, while the valve switches; 0 is the other choice."""
FITTED = "the friction area is fitted to these 72 Hz; the text refers to [79] for it"


def torque_table() -> Table:
    """Torques over the speed of the spool at 40 lpm, the valve fully open."""
    speed = np.linspace(0.0, 1.6 * open_speed(), 81)
    inlet = np.full(speed.shape, inlet_torque(FLOW, 1.0, DENSITY, valve()))
    outlet = np.array([outlet_torque(FLOW, float(w), DENSITY, valve()) for w in speed])
    friction = friction_coefficient(VISCOSITY, valve()) * speed
    columns = {
        "speed_rad_s": Column(speed, SPEED, "speed of the spool"),
        "inlet_N_m": Column(inlet, TORQUE, "inlet turbine"),
        "outlet_N_m": Column(outlet, TORQUE, "outlet turbine"),
        "both_N_m": Column(inlet + outlet, TORQUE, "both turbines"),
        "friction_N_m": Column(friction, TORQUE, "friction"),
    }
    return Table(title="Torques over the speed", columns=columns, axes=("speed_rad_s",))


def figure_2_17() -> Reproduction:
    """Torque lines of the turbines and of friction, and where they cross."""
    colours = {
        "inlet_N_m": Colour.INLET,
        "outlet_N_m": Colour.TANK,
        "both_N_m": Colour.LOAD,
        "friction_N_m": Colour.RED,
    }
    lines = tuple(Line(x="speed_rad_s", y=key, colour=colour) for key, colour in colours.items())
    crossing = Level(value=open_speed(), upright=True, stroke=Stroke.DOTTED)
    crossings = tuple(
        digit_statement(what, printed, found, FREQUENCY, tolerance=0.5, calibration=FITTED)
        for what, printed, found in (
            ("PWM frequency where the lines cross", 72.0, open_frequency()),
            ("speed of the spool there", 24.0, open_speed() / TURN),
        )
    )
    statements = (*crossings, *_computed_torques(), _computed_fall())
    return figure_of(
        "figure-2.17",
        "Torques on the spool of the fully open valve at 40 lpm and 40 °C by eqs. 2.6, 2.7 and 2.9.",
        {"torques": torque_table()},
        statements,
        Lines(lines=lines, label="torque", levels=(crossing,), low=0.0),
        height=2.8,
    )


def _computed_torques() -> tuple[Statement, ...]:
    """Torques at rest on the finest grids, beside the laws."""
    chosen = (
        (
            "centre-grids",
            "inlet turbine",
            inlet_torque(FLOW, 1.0, DENSITY, valve()),
            (CENTRE_INDEX, CENTRE),
            "the jets' arm was chosen for a drop",
        ),
        (
            "turbine-grids",
            "outlet turbine",
            outlet_torque(FLOW, 0.0, DENSITY, valve()),
            (TURBINE_INDEX, TURBINE),
            "the channels' arm was chosen so",
        ),
    )
    found = []
    for study, name, law, (share, because), note in chosen:
        kept = kept_or_none(study)
        what, source = f"computed torque of the {name} at rest, 40 lpm", "the formula matches the computed torque"
        if kept is None:
            found.append(missing_statement(what, source, f"the study {study}"))
            continue
        torque = float(kept["torque_N_m"][kept["cells"].argmax()])
        found.append(
            number_statement(what, float(law), torque, TORQUE, share=share, because=because, source=source, note=note)
        )
    return tuple(found)


def _computed_fall() -> Statement:
    """How fast the computed torque of the outlet turbine falls with the speed, beside the swirl of (2.7)."""
    study = turbine_over("speed_rad_s")
    what, law = "fall of the computed outlet torque over the speed [N m s]", DENSITY * valve().outlet_radius ** 2 * FLOW
    if study is None:
        return missing_statement(what, with_unit(law, NUMBER), "a study of the turbine at several speeds")
    at = np.isclose(study["flow_m3_s"], FLOW)
    slope = -float(np.polyfit(study["speed_rad_s"][at], study["torque_N_m"][at], 1)[0])
    note = "the friction of the walls is in it; on a small grid a sliding mesh has a sixth less (docs/models/cfd.md)"
    return number_statement(what, law, slope, NUMBER, share=TURBINE_INDEX, because=TURBINE, note=note)


def equation_2_6() -> Reproduction:
    """The torque of the jets: N nozzles with a share each, or all with the whole."""
    one = NOZZLES * DENSITY * valve().inlet_radius * (FLOW / NOZZLES) ** 2 / (valve().nozzle_area / NOZZLES)
    whole = inlet_torque(FLOW, 1.0, DENSITY, valve())
    printed = DENSITY * valve().inlet_radius * FLOW**2 / (valve().nozzle_area * NOZZLES)
    return Reproduction(
        statements=(
            exact_statement("torque at 40 lpm, A_in one nozzle's area", one, whole, TORQUE),
            exact_statement(
                "the same, A_in the area of all nozzles as in (2.3)",
                printed,
                whole,
                TORQUE,
                inconsistency="with the total area N falls out; left in, it divides by 3",
                contradiction=("(2.3): A_in of all nozzles", "(2.6): N nozzles of A_in each"),
            ),
        )
    )


def equation_2_7() -> Reproduction:
    """The torque of the outlet turbine: blades with a share each, or all with the whole."""
    omega, R, share = open_speed(), valve().outlet_radius, FLOW / BLADES
    area = valve().outlet_effective_area
    blade = DENSITY * share * R * (share / (area / BLADES) - R * omega)
    one_area = BLADES * DENSITY * share * R * (share / area - R * omega)
    whole = outlet_torque(FLOW, omega, DENSITY, valve())
    return Reproduction(
        statements=(
            exact_statement("torque at 40 lpm, A_out of all blades", BLADES * blade, whole, TORQUE),
            exact_statement(
                "the same, A_out near one blade",
                one_area,
                whole,
                TORQUE,
                inconsistency="a sum over blades would leave their number in the result, and there is none",
                contradiction=("2.5: A_out near one blade", "(2.7): a sum over N blades without N"),
            ),
        )
    )


def equation_2_8() -> Reproduction:
    """The torque of a field of forces: the component along the axis of the sum of both parts."""
    rng = np.random.default_rng(8)
    r, pressure, shear = rng.normal(size=(3, 200, 3))
    axial = float(np.sum(np.cross(r, pressure) + np.cross(r, shear), axis=0)[2])
    power = float(np.sum((pressure + shear) * np.cross([0.0, 0.0, 1.0], r)))
    return Reproduction(
        statements=(
            exact_statement(
                "axial component of r × F_p + r × F_v, against the power at unit speed",
                power,
                axial,
                NUMBER,
                note="(2.8) is a vector; its component along the axis turns the spool",
            ),
        )
    )


def equation_2_9() -> Reproduction:
    """Petroff's friction: linear in the speed, laminar in the clearance."""
    k_f, v = friction_coefficient(VISCOSITY, valve()), valve()
    printed = v.friction_area * VISCOSITY / v.radial_clearance * v.spool_radius**2
    return Reproduction(
        statements=(
            exact_statement("friction over speed [N m s]", printed, k_f, NUMBER),
            bound_statement(
                "Reynolds number of the clearance at 24 Hz",
                gap_reynolds_number(open_speed(), DENSITY, VISCOSITY, v),
                NUMBER,
                high=1000.0,
                source="laminar, as Petroff's law takes it",
            ),
        )
    )


def oil_temperature_at(frequency: float) -> float:
    """Oil temperature at which the fully open valve switches at a frequency [K]."""
    oil = stand().bench.oil

    def off(T: float) -> float:
        speed = equilibrium_speed(FLOW, float(density(T, oil)), float(dynamic_viscosity(T, oil)), valve())
        return float(pwm_frequency(speed, valve())) - frequency

    return float(brentq(off, COLDEST, WARMEST))


def averaged_frequency(exponent: float, load: float) -> float:
    """PWM frequency of the switching valve by the average of its torques, jets with an exponent, a load [Pa]: [Hz]."""
    here = stand().with_tables(valve={"jet_exponent": exponent})
    means = here.means(here.set_point._replace(load_pressure=load))
    return float(pwm_frequency(means.spool_speed, here.bench.valve))


def _computed_area() -> Statement:
    """The effective area that the computed torques of the outlet turbine at rest have, by least squares."""
    study, what, printed = kept_or_none("turbine-flows"), "effective area of the outlet turbine, as computed", 61.8e-6
    if study is None:
        return missing_statement(what, with_unit(printed, AREA), "the study turbine-flows")
    rest = study["speed_rad_s"] == 0.0
    Q, torque = study["flow_m3_s"][rest], study["torque_N_m"][rest]
    per_area = float(np.sum(torque * Q**2) / np.sum(Q**4)) / (DENSITY * valve().outlet_radius)
    note = "the channels' arm, by the torque that the momentum has"
    return number_statement(what, printed, 1.0 / per_area, AREA, share=TURBINE_INDEX, because=TURBINE, calibration=note)


def section_2_5() -> Reproduction:
    """Measured frequencies, effective area, clearance, and the power that turns the spool."""
    low, high = (oil_temperature_at(f) for f in MEASURED)
    v, swirl = valve(), DENSITY * valve().outlet_radius ** 2 * FLOW
    power = (stall_torque(FLOW, DENSITY, v) - swirl * open_speed()) * open_speed()
    warmth = bound_statement(
        "oil temperatures at which the open valve turns at 70.4 and 82 Hz",
        high - low,
        NUMBER,
        high=10.0,
        source="70.4 to 82 Hz, depending on the oil temperature",
        because="10 K between measurements (ours)",
        result=f"{low - 273.15:.1f} to {high - 273.15:.1f} °C",
    )
    clearance = number_statement(
        "clearance, a thousandth of the radius", 12.7e-6, v.radial_clearance, LENGTH, share=1e-9, because="as printed"
    )
    area = number_statement(
        "effective area over exit area",
        61.8 / 46.8,
        v.outlet_effective_area / v.outlet_area,
        NUMBER,
        tolerance=0.05 / 46.8 * (1.0 + 61.8 / 46.8),
        because="half of the last digit of both areas",
        source="61.8 mm² beside 46.8 mm²: larger",
    )
    turned = digit_statement("power that turns the spool, of tu2012", 30.0, power, MEAN_POWER, tolerance=0.5)
    return Reproduction(statements=(*_frequency_statements(), warmth, clearance, area, _computed_area(), turned))


def _frequency_statements() -> tuple[Statement, ...]:
    low, high = MEASURED
    chosen = ((0.0, 100e5, "100 bar"), *((EXPONENT, load, f"{load / 1e5:g} bar") for load in (100e5, 50e5, 10e5)))
    return tuple(
        bound_statement(
            f"PWM frequency while it switches, jet exponent {exponent:g}, {words}",
            averaged_frequency(exponent, load + ATMOSPHERE),
            FREQUENCY,
            low=low,
            high=high,
            tolerance=0.05,
            because="half of the last printed digit",
            other=averaged_frequency(EXPONENT - exponent, load + ATMOSPHERE),
            assumption=f"jet exponent {exponent:g}, in the second run {EXPONENT - exponent:g}; a load of {words}, "
            "an ideal relief valve at 120 bar",
        )
        for exponent, load, words in chosen
    )


EQUATION = ItemKind.EQUATION
ITEMS = (
    Item(ItemKind.FIGURE, "2.17", "Torque predicted from CFD and analytical formula", figure_2_17),
    Item(EQUATION, "2.6", "Torque of the inlet turbine", equation_2_6),
    Item(EQUATION, "2.7", "Torque of the outlet turbine", equation_2_7),
    Item(EQUATION, "2.8", "Torque from computed forces", equation_2_8),
    Item(EQUATION, "2.9", "Friction torque", equation_2_9),
    Item(ItemKind.SECTION, "2.5", "Torque and speed", section_2_5),
)
