"""What a run comes to: means over whole PWM periods, losses by component, extremes, balances, in plain numbers."""

import numpy as np

from vvdp.base.signal import Signal, signal_value
from vvdp.fluid.oil import density
from vvdp.simulation.balance import balance_between
from vvdp.simulation.outcome import Outcome, outcome
from vvdp.simulation.results import shown
from vvdp.simulation.run import Run
from vvdp.simulation.values import as_value, flat, leaves, names
from vvdp.systems.system import System
from vvdp.systems.watching import SETTLED, estimate_errors
from vvdp.valve.losses import full_open_loss
from vvdp.valve.operating_point import OperatingPoint, operating_point

Summary = dict[str, float | bool]

ANALYTIC = (
    "analytic_pwm_frequency_Hz",
    "analytic_pwm_frequency_full_open_Hz",
    "analytic_loss_full_open_W",
    "analytic_loss_transition_W",
    "analytic_loss_leakage_W",
    "analytic_loss_compressibility_W",
    "analytic_loss_total_W",
    "analytic_load_flow_m3_s",
)
"""Keys of the analytic results, in the order of `analytic_summary`."""

UNITS = {
    "_m3_s": "m^3/s",
    "_rad_s": "rad/s",
    "_Pa": "Pa gauge",
    "_Hz": "Hz",
    "_W": "W",
    "_rad": "rad",
    "_s": "s",
}


def summary_unit(key: str) -> str:
    """The unit that a key of a summary ends with, `1` where there is none."""
    return next((unit for ending, unit in UNITS.items() if key.endswith(ending)), "1")


def analytic_point(system: System, load_pressure: float) -> OperatingPoint:
    """The valve's analytic drops, speeds and losses at the start of the run, against `load_pressure` [Pa, absolute]."""
    supply = system.case.params.supply
    operation = supply.operation
    return operating_point(
        supply.pump.displacement * signal_value(0.0, operation.pump_speed),
        signal_value(0.0, operation.oil_temperature),
        signal_value(0.0, operation.axial_position) / supply.valve.helix_length,
        load_pressure,
        supply.relief_valve.cracking_pressure,
        supply.inlet.volume,
        supply.oil,
        supply.valve,
    )


def summary(system: System, run: Run) -> Summary:
    """All results of a run as one flat table, SI units at the end of each key.

    Flows are counted in tank volumes; pressures are gauge, against the oil's reference pressure; the keys are
    described in docs/keys.md.
    """
    simulated = simulated_summary(outcome(run, system.average_from), system)
    return simulated | watching_summary(run) | analytic_summary(simulated, system)


def simulated_summary(run: Outcome, system: System) -> Summary:
    """The part of a summary that the simulation alone gives, of a recorded run or of a case in a batch."""
    window = run.window
    span = window.end - window.begin
    mean = as_value(run.case.state.books, (window.last - window.first)[-flat(run.case.state.books).size :] / span)
    supply, totals = run.case.params.supply, mean.totals
    reference = supply.oil.reference_pressure
    spent = {path.rpartition(".")[2]: float(value) for path, value, _ in leaves(mean.spent)}
    books, valve_power = balance_between(run.model, run.case, flat(run.case.state), run.final), mean.spent.valve
    over_window = balance_between(run.model, run.case, window.first, window.last)
    drops = valve_power.nozzle + valve_power.centre_section + valve_power.outlet_turbine
    temperature = signal_value(0.0, supply.operation.oil_temperature)
    rho = density(temperature, supply.oil)
    open_loss = full_open_loss(mean.taken_in, rho, supply.valve) if mean.taken_in > 0.0 else 0.0
    shaft = run.case.state.supply.spool._fields.index("speed")
    speed = [path for path, _, _ in leaves(run.case.state)].index("supply.spool.speed")
    turns = (window.last[speed - shaft] - window.first[speed - shaft]) / span
    low = {path: x for (path, _, _), x in zip(leaves(run.case.state), run.low, strict=True)}
    high = {path: x for (path, _, _), x in zip(leaves(run.case.state), run.high, strict=True)}
    lowest = low["supply.inlet_pressure"]
    limits, motor = system.tables["limits"], system.tables["motor"]
    found: Summary = {
        "duration_s": run.end,
        "finished": run.finished,
        "averaged_from_s": window.begin,
        "averaged_to_s": window.end,
        "averaged_periods": float(window.periods),
        "settled": window.settled,
        "pwm_frequency_Hz": turns * supply.valve.sections / (2.0 * np.pi),
        "spool_speed_mean_rad_s": turns,
        "spool_speed_min_rad_s": low["supply.spool.speed"],
        "spool_speed_max_rad_s": high["supply.spool.speed"],
        "mean_pump_flow_m3_s": mean.taken_in,
        "mean_load_flow_m3_s": totals.load_flow,
        "mean_tank_flow_m3_s": totals.tank_flow,
        "mean_relief_flow_m3_s": totals.relief_flow,
        "mean_leakage_flow_m3_s": totals.leakage_flow,
        "load_flow_fraction": totals.load_flow / mean.taken_in if mean.taken_in else 0.0,
        "mean_load_opening": totals.load_opening,
        "mean_inlet_pressure_Pa": totals.inlet_pressure - reference,
        "mean_load_pressure_Pa": totals.load_pressure - reference,
        "inlet_pressure_min_Pa": lowest - reference,
        "inlet_pressure_max_Pa": high["supply.inlet_pressure"] - reference,
        "input_power_W": mean.supplied.pump_shaft,
        "spool_motor_power_W": mean.supplied.spool_motor,
        "load_power_W": mean.spent.load,
        "efficiency": _ratio(mean.spent.load, mean.supplied.pump_shaft + mean.supplied.spool_motor),
        "motor_rated_power_W": motor.rated_power,
        "motor_overloaded": bool(mean.supplied.pump_shaft > motor.rated_power),
        "cavitation": bool(min(lowest, low.get("load_pressure", lowest)) < limits.cavitation_pressure),
        **{f"loss_{name}_W": power for name, power in spent.items() if name not in ("load", "to_spool")},
        "spool_shaft_power_W": -valve_power.to_spool,
        "loss_full_open_W": open_loss,
        "loss_transition_W": drops + valve_power.relief_valve - open_loss,
        "loss_total_W": mean.supplied.pump_shaft + mean.supplied.spool_motor - mean.spent.load,
        "steady": is_steady(system),
    }
    if "load_pressure" in low:
        found |= {
            "load_pressure_min_Pa": low["load_pressure"] - reference,
            "load_pressure_max_Pa": high["load_pressure"] - reference,
        }
    if books and over_window:
        found |= {
            "stored_power_W": over_window.energy_stored / span,
            "energy_residual": books.energy_residual,
            "mass_residual": books.mass_residual,
            "trusted": books.is_trusted,
        }
    found |= {
        "steps": float(run.steps),
        "rejected_steps": float(run.rejected),
        "evaluations": float(run.evaluations),
        "stiff_method": run.stiff,
        "wall_time_s": run.seconds,
    }
    return {key: bool(value) if isinstance(value, bool | np.bool_) else float(value) for key, value in found.items()}


def watching_summary(run: Run) -> Summary:
    """How far the estimate of a watched spool was off, from `SETTLED` on; empty for a shorter run, or no encoder.

    Root means square over time, by the trapezoidal rule over the recorded rows.
    """
    estimate = {path: values for path, (values, _) in shown(run).items()}
    late = run.times >= SETTLED
    if not estimate or np.count_nonzero(late) < 2:
        return {}
    spool = run.state.supply.spool
    errors = estimate_errors(run.times, spool.angle, spool.speed, estimate)
    t = run.times[late]
    angle, speed = (float(np.sqrt(np.trapezoid(e[late] ** 2, t) / (t[-1] - t[0]))) for e in errors)
    return {
        "spool_angle_error_rms_rad": angle,
        "spool_speed_error_rms_rad_s": speed,
        "spool_missed_edges": float(estimate["missed_edges"][-1]),
    }


def is_steady(system: System) -> bool:
    """Whether all that is prescribed stays as it is."""
    params = system.case.params
    prescribed = [getattr(part, name) for part in (params.supply.operation, params.load) for name in names(part)]
    return all(value.is_constant for value in prescribed if isinstance(value, Signal))


def _ratio(a: float, b: float) -> float:
    return a / b if b else 0.0


def analytic_summary(simulated: Summary, system: System) -> Summary:
    """The analytic results at the mean load pressure, to stand beside the `simulated` ones.

    There are none where they do not describe the run: without flow or load, with anything prescribed that changes over
    time, or with a driven spool. They take as long to work out as a short run.
    """
    supply = system.case.params.supply
    if not is_steady(system) or supply.spool_drive.coupling > 0.0:
        return {}
    load_pressure = simulated["mean_load_pressure_Pa"] + supply.oil.reference_pressure
    pump_flow = supply.pump.displacement * signal_value(0.0, supply.operation.pump_speed)
    if pump_flow <= 0.0 or load_pressure <= supply.oil.reference_pressure:
        return {}
    point = analytic_point(system, load_pressure)
    values = (
        point.averaged_pwm_frequency,
        point.full_open_pwm_frequency,
        point.full_open_loss,
        point.transition_loss,
        point.leakage_loss,
        point.compressibility_loss,
        point.total_loss,
        point.cycle.load_flow,
    )
    return {key: float(value) for key, value in zip(ANALYTIC, values, strict=True)}
