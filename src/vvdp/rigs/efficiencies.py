"""Efficiencies of a pump: against its commanded flow, and as ISO 4409 defines them with the capacity of ISO 8426."""

from collections.abc import Mapping

import numpy as np

from vvdp.base.arrays import Array
from vvdp.rigs.map_axes import Axes
from vvdp.steady.test_stand import Stand

SET = ("duty_ratio", "load_pressure_Pa", "pump_speed_rad_s", "oil_temperature_K")
EFFICIENCIES = (
    "volumetric_efficiency_commanded",
    "hydromechanical_efficiency_commanded",
    "overall_efficiency",
    "volumetric_efficiency_iso",
    "hydromechanical_efficiency_iso",
    "overall_efficiency_iso",
)


def with_efficiencies(stand: Stand, axes: Axes, columns: Mapping[str, Array], capacity: Array) -> dict[str, Array]:
    """`columns` with the operating points before them and the efficiencies and losses that follow from them.

    At duty ratio d the commanded flow is d D omega, the derived one capacity times omega. ISO counts the flow as the
    volume that it has at the outlet, `outlet_flow_m3_s`, and the power as that times the pressure difference. An
    efficiency is nan where nothing is delivered.

    capacity  of the setting of each point [m^3/rad]
    """
    set_ = dict(zip(SET, (np.array(column, float) for column in zip(*axes.points, strict=True)), strict=True))
    speed, rise = set_["pump_speed_rad_s"], set_["load_pressure_Pa"] - stand.tank_pressure
    set_["load_pressure_Pa"] = set_["load_pressure_Pa"] - stand.reference
    power_in = columns["input_power_W"] + np.nan_to_num(columns["spool_motor_power_W"])
    commanded, derived = set_["duty_ratio"] * stand.bench.pump.displacement * speed, capacity * speed
    delivered, outlet, load_power = (
        columns[name] for name in ("delivered_flow_m3_s", "outlet_flow_m3_s", "load_power_W")
    )
    with np.errstate(all="ignore"):
        delivers, gives = delivered > 0.0, (delivered > 0.0) & (load_power > 0.0)
        volumetric = np.where(delivers & (commanded > 0.0), delivered / commanded, np.nan)
        volumetric_iso = np.where(delivers & (derived > 0.0), outlet / derived, np.nan)
        overall = np.where(gives, load_power / power_in, np.nan)
        overall_iso = np.where(gives, outlet * rise / power_in, np.nan)
        return {
            **set_,
            **columns,
            "commanded_flow_m3_s": commanded,
            "derived_capacity_m3_rad": capacity,
            "volumetric_efficiency_commanded": volumetric,
            "hydromechanical_efficiency_commanded": overall / volumetric,
            "overall_efficiency": overall,
            "volumetric_efficiency_iso": volumetric_iso,
            "hydromechanical_efficiency_iso": overall_iso / volumetric_iso,
            "overall_efficiency_iso": overall_iso,
            "loss_total_W": power_in - load_power,
        }
