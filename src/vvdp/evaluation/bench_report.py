"""What a test rig of a rotary valve adds to the results of a run, and what any system adds."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from vvdp.evaluation.bench import RotaryBench
from vvdp.evaluation.bench_overview import ANALYTIC, OVERVIEW, OVERVIEW_NOTE, QUANTITIES
from vvdp.evaluation.bench_parts import SOFTENING, is_bench
from vvdp.evaluation.bench_validity import bench_bounds, bench_warnings, efficiency, transition_loss
from vvdp.evaluation.port_cavitation import lowest_cavitation_number
from vvdp.evaluation.valve_forms import unit_forms, unit_limits
from vvdp.fluid.oil import density
from vvdp.simulation.outcome import Outcome
from vvdp.simulation.values import as_value, flat, leaves
from vvdp.systems.bound import Bound
from vvdp.systems.extras import Extras, Summary
from vvdp.systems.program_reports import ReportedPrograms, program_reports
from vvdp.systems.system import System
from vvdp.valve.losses import full_open_loss


def additions(system: System) -> Extras | None:
    """What a system adds to its results; None where that is nothing."""
    return BenchReport(system) if is_bench(system) else system.extras


class BenchReport(ReportedPrograms):
    """The numbers, closed forms and warnings of a test rig, with those of its programs."""

    PERIOD = "PWM period"
    IS_ALL = True
    OVERVIEW_NOTE = OVERVIEW_NOTE
    CLOSED_FORMS = ANALYTIC

    def __init__(self, system: System) -> None:
        super().__init__(system, program_reports(system, system.stepping.sample_period))
        self.bench = RotaryBench(system)
        self.STEADY = True
        self.QUANTITIES = {**QUANTITIES, **self.QUANTITIES}
        self.OVERVIEW = (*OVERVIEW, *self.OVERVIEW)
        self.HEADLINE = ("efficiency", "pwm_frequency_Hz", "pressure_max_inlet_Pa", "loss_total_W")

    def simulation_numbers(self, run: Outcome, found: Summary) -> Summary:
        """The numbers of a bench that its simulation gives, beside those that any circuit has."""
        bench, window = self.bench, run.window
        span = window.end - window.begin
        mean = as_value(run.case.state.books, (window.last - window.first)[-flat(run.case.state.books).size :] / span)
        totals, valve, supplied = mean.totals, mean.spent.valve, mean.supplied
        pump_flow = totals.pump_flow + totals.pump_leakage_flow
        rho, delivered = density(bench.unit.temperature, bench.oil), totals.pump_flow
        open_loss = full_open_loss(delivered, rho, bench.valve) if delivered > 0.0 else 0.0
        shaft, motor = supplied.pump_shaft, getattr(supplied, "spool_motor", 0.0)
        load_power = mean.spent.load if bench.makes_pressure else -supplied.load_line - supplied.tank
        drops = valve.nozzle + valve.centre_section + valve.outlet_turbine + _beside(mean.spent)
        place = [path for path, _, _ in leaves(run.case.state)].index("spool.angle")
        extremes = run.low[place], run.high[place]
        return {
            "pwm_frequency_Hz": float(found["speed_mean_spool_rad_s"]) * bench.valve.sections / (2.0 * np.pi),
            "mean_pump_flow_m3_s": pump_flow,
            "mean_load_flow_m3_s": _load_flow(totals),
            "mean_tank_flow_m3_s": totals.valve_tank_flow - totals.valve_leakage,
            "mean_leakage_flow_m3_s": totals.valve_leakage,
            "load_flow_fraction": _ratio(_load_flow(totals), pump_flow),
            "mean_load_opening": totals.valve_load_opening,
            "cavitation_port_share": min(max(totals.valve_cavitating, 0.0), 1.0),
            "cavitation_number_lowest": lowest_cavitation_number(bench.values, found, extremes),
            "input_power_W": shaft,
            "spool_motor_power_W": motor,
            "load_power_W": load_power,
            "efficiency": efficiency(load_power, shaft + motor, float(found["stored_power_W"])),
            "motor_rated_power_W": bench.rated_power,
            "motor_overloaded": bool(shaft > bench.rated_power),
            "loss_nozzle_W": valve.nozzle,
            "loss_centre_section_W": valve.centre_section,
            "loss_outlet_turbine_W": valve.outlet_turbine,
            "loss_spool_friction_W": valve.spool_friction,
            "spool_shaft_power_W": -valve.to_spool,
            "loss_full_open_W": open_loss,
            "loss_transition_W": transition_loss(drops + mean.spent.relief_valve - open_loss, shaft + motor),
            "loss_total_W": shaft + motor - load_power,
            "steady": bench.is_steady,
            **super().simulation_numbers(run, found),
        }

    def closed_forms(self, found: Mapping[str, float | bool]) -> Summary:
        """The analytic results at the mean load pressure, to stand beside the simulated ones in `found`.

        There are none without flow or load, with anything prescribed that changes over time, with a driven spool, nor
        where `closed_form_limits` says why. They take as long to calculate as a short run.
        """
        if not self._is_analytic(found) or any(self.closed_form_limits(found)):
            return {}
        return unit_forms(self.bench.unit, self._load_pressure(found))

    def closed_form_limits(self, found: Mapping[str, float | bool]) -> Iterator[str]:
        """Why the closed forms do not describe a run of the kind that they could, a sentence each; none where they do.

        found  the numbers of a run
        """
        if self._is_analytic(found):
            yield from unit_limits(self.bench.unit, self._load_pressure(found), self.bench.values, found)

    def bounds(self, found: Mapping[str, float | bool]) -> Iterator[Bound]:
        """The bounds of the laws of valve and spool at what a run has `found`."""
        return bench_bounds(self.bench.values, found)

    def warnings(self, found: Mapping[str, float | bool]) -> Iterator[str]:
        """Warnings to read before the numbers of a bench, in sentences."""
        yield from bench_warnings(self.bench.values, found, self.closed_form_limits(found))
        yield from self.program_warnings(found)

    def program_warnings(self, found: Mapping[str, float | bool]) -> Iterator[str]:
        """The warnings of its programs alone."""
        return super().warnings(found)

    def _is_analytic(self, found: Mapping[str, float | bool]) -> bool:
        """Whether a run is of the kind that closed forms describe: steady, spun by the flow alone, against a load."""
        bench = self.bench
        loaded = self._load_pressure(found) > bench.tank_pressure
        return bench.is_steady and not bench.is_driven and bench.unit.nominal_flow > 0.0 and loaded

    def _load_pressure(self, found: Mapping[str, float | bool]) -> float:
        """The mean pressure at the load [Pa, absolute]."""
        return float(found["pressure_mean_load_line_Pa"]) + self.bench.reference


def _beside(spent: Any) -> float:
    """Losses of the components of soft switching [W]; none without them."""
    return float(sum(getattr(spent, name, 0.0) for name in SOFTENING))


def _load_flow(totals: Any) -> float:
    """Mean flow to the load [m^3/s], with what a check valve past its port carries."""
    return float(totals.valve_load_flow + getattr(totals, "bypass_flow", 0.0))


def _ratio(a: float, b: float) -> float:
    return a / b if b else 0.0
