"""The cylinder, oil and gains of chapter 6 as far as the specification fills them in, and random states around them."""

import numpy as np

from vvdp.control.adaptation import Adaptation
from vvdp.control.capacities import CircuitPressures, CylinderModel, SupplyLine
from vvdp.control.cylinder_force import ForceGains
from vvdp.control.direction import DirectionSettings
from vvdp.control.displacement import CylinderSeen, DisplacementSettings, SupplySupport
from vvdp.control.flow_split import FlowSplit
from vvdp.control.pressure_modes import PressureBounds
from vvdp.control.reference import Reference

ATMOSPHERE = 101325.0
BAR = 1e5
LPM = 1e-3 / 60.0
NO_LINE = SupplyLine(oil_volume=0.0, hose_compliance=0.0, gas_volume=0.0, precharge_pressure=0.0, gas_exponent=1.3)


def settings_of_chapter_6(**changes) -> DisplacementSettings:
    """Those of the nominal case, without line, feedforward, support and adaptation."""
    parts = {
        "cylinder": CylinderModel(
            area_a=20.26e-4,
            area_b=10.77e-4,
            oil_volume_a=1.0e-3,
            oil_volume_b=1.2e-3,
            lowest_position=0.0,
            highest_position=0.35,
            moving_mass=100.0,
            viscous_friction=2000.0,
            bulk_modulus=7e8,
            line=NO_LINE,
            return_conductance=0.8e-7,
            tank_pressure=ATMOSPHERE,
        ),
        "gains": ForceGains(error_rate=10.0, position_gain=4e4, velocity_gain=6e3, pressure_rate=28.0),
        "direction": DirectionSettings(hysteresis=1e4),
        "split": FlowSplit(
            mean_opening=0.8,
            flow_rate=2.0,
            flow_deviation=1.5e-4,
            opening_deviation=0.2,
            largest_flow=6.667e-4,
            least_return_flow=1e-5,
            expected_flow=5.0 * LPM,
            feeds_forward=0.0,
        ),
        "bounds": PressureBounds(
            lowest_pressure=1.0 * BAR + ATMOSPHERE,
            highest_pressure=80.0 * BAR + ATMOSPHERE,
            transition_band=0.5 * BAR,
            low_margin=0.3,
            supply_margin=0.3,
            return_margin=1.2,
            boost_flow=0.5 * LPM,
        ),
        "support": SupplySupport(),
        "adaptation": Adaptation(),
        "sample_period": 1e-3,
    }
    return DisplacementSettings(**{**parts, **changes})


def random_sample(rng: np.random.Generator) -> tuple[CylinderSeen, Reference]:
    """What may be seen, averaged pressures as measured, and what is wanted, near to it."""
    x, v = float(rng.uniform(0.05, 0.3)), float(rng.uniform(-0.1, 0.1))
    fast = CircuitPressures(*(ATMOSPHERE + rng.uniform(0.0, 90.0, 3) * BAR).tolist())
    seen = CylinderSeen(
        position=x,
        velocity=v,
        load_force=float(rng.uniform(-5e3, 5e3)),
        fast=fast,
        slow=fast,
        delivered_flow=float(rng.uniform(0.0, 3e-4)),
    )
    off = rng.normal(size=4) * (1e-3, 0.02, 0.1, 1.0)
    return seen, Reference(x + off[0], v + off[1], off[2], off[3])


def numbers(result) -> list[float]:
    """All numbers of nested tuples and arrays."""
    if isinstance(result, np.ndarray):
        return result.ravel().tolist()
    return [x for part in result for x in numbers(part)] if isinstance(result, tuple) else [float(result)]
