"""What a run comes to: means over whole PWM periods, losses by component, extremes, balances, in plain numbers."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vvdp.base.signal import signal_value
from vvdp.fluid.oil import density
from vvdp.numerics.tableaus import Array
from vvdp.simulation.balance import balance
from vvdp.simulation.run import Run
from vvdp.simulation.values import as_value, flat, leaves
from vvdp.systems.system import System
from vvdp.valve.losses import full_open_loss
from vvdp.valve.operating_point import OperatingPoint, operating_point

SETTLED = 1e-3
"""Change of the mean PWM frequency between the halves of the averaging window above which a run is not settled."""

Summary = dict[str, float | bool]


@dataclass(frozen=True)
class Window:
    """The part of a run over which means are taken: whole PWM periods where there are any."""

    begin: float
    end: float
    first: Array
    last: Array
    periods: int
    settled: bool


def averaging_window(run: Run, average_from: float) -> Window:
    """From the first mark after `average_from` [s] to the last; without two marks, the plain time.

    A run that was stopped before `average_from` is averaged over its second half.
    """
    begin = average_from if run.end > average_from else 0.5 * run.end
    inside = np.flatnonzero(run.mark_times >= begin)
    if inside.size < 2:
        row = min(int(np.searchsorted(run.times, begin)), run.times.size - 1)
        return Window(float(run.times[row]), run.end, run.states[row], run.final, 0, False)
    i, j = int(inside[0]), int(inside[-1])
    t, middle = run.mark_times, (i + j) // 2
    early = (middle - i) / (t[middle] - t[i]) if middle > i else np.nan
    late = (j - middle) / (t[j] - t[middle])
    settled = bool(abs(late / early - 1.0) < SETTLED)
    return Window(float(t[i]), float(t[j]), run.mark_states[i], run.mark_states[j], j - i, settled)


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
    window = averaging_window(run, system.average_from)
    span = window.end - window.begin
    mean = as_value(run.case.state.books, (window.last - window.first)[-flat(run.case.state.books).size :] / span)
    supply, totals = run.case.params.supply, mean.totals
    reference = supply.oil.reference_pressure
    spent = {path.rpartition(".")[2]: float(value) for path, value, _ in leaves(mean.spent)}
    books, valve_power = balance(run), mean.spent.valve
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
        "cavitation": bool(lowest < limits.cavitation_pressure),
        **{f"loss_{name}_W": power for name, power in spent.items() if name not in ("load", "to_spool")},
        "spool_shaft_power_W": -valve_power.to_spool,
        "loss_full_open_W": open_loss,
        "loss_transition_W": drops + valve_power.relief_valve - open_loss,
        "loss_total_W": mean.supplied.pump_shaft + mean.supplied.spool_motor - mean.spent.load,
    }
    if "load_pressure" in low:
        found |= {
            "load_pressure_min_Pa": low["load_pressure"] - reference,
            "load_pressure_max_Pa": high["load_pressure"] - reference,
        }
    if books:
        found |= {
            "energy_residual": books.energy_residual,
            "mass_residual": books.mass_residual,
            "trusted": books.is_trusted,
        }
    found |= dict(_analytic(system, totals.load_pressure)) | dict(_effort(run))
    return {key: bool(value) if isinstance(value, bool | np.bool_) else float(value) for key, value in found.items()}


def _ratio(a: float, b: float) -> float:
    return a / b if b else 0.0


def _analytic(system: System, load_pressure: float) -> Iterator[tuple[str, float]]:
    """The analytic losses at the mean load pressure, beside the simulated ones."""
    supply = system.case.params.supply
    if signal_value(0.0, supply.operation.pump_speed) <= 0.0 or load_pressure <= supply.oil.reference_pressure:
        return
    point = analytic_point(system, load_pressure)
    yield "analytic_pwm_frequency_Hz", point.averaged_pwm_frequency
    yield "analytic_pwm_frequency_full_open_Hz", point.full_open_pwm_frequency
    yield "analytic_loss_full_open_W", point.full_open_loss
    yield "analytic_loss_transition_W", point.transition_loss
    yield "analytic_loss_leakage_W", point.leakage_loss
    yield "analytic_loss_compressibility_W", point.compressibility_loss
    yield "analytic_loss_total_W", point.total_loss
    yield "analytic_load_flow_m3_s", point.cycle.load_flow


def _effort(run: Run) -> Iterator[tuple[str, float | bool]]:
    yield "steps", float(run.steps)
    yield "rejected_steps", float(run.rejected)
    yield "evaluations", float(run.evaluations)
    yield "stiff_method", run.stiff
    yield "wall_time_s", run.seconds
