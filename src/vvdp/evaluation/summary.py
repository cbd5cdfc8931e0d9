"""Summary of a run: means, losses by component, extremes, balances, in plain numbers by the names of the circuit."""

from collections.abc import Iterator, Mapping
from operator import attrgetter

import numpy as np

from vvdp.base.signal import Signal
from vvdp.evaluation.bench_report import additions
from vvdp.evaluation.control_stages import waiting_numbers
from vvdp.evaluation.heat_numbers import heat_numbers, temperature_numbers
from vvdp.evaluation.pipe_waves import wave_numbers
from vvdp.evaluation.tank_levels import level_numbers
from vvdp.evaluation.validity import broken_bounds, cavitation_pressure, lowest_pressure
from vvdp.evaluation.valve_forms import placed_forms
from vvdp.evaluation.valve_numbers import driven_spools, valve_numbers
from vvdp.network.network import Part
from vvdp.network.nodes import (
    DrivenShaft,
    HydraulicNode,
    Junction,
    OilVolume,
    PressureSource,
    Rod,
    Shaft,
    Tank,
    can_boil,
    free_air_name,
    has_free_air,
)
from vvdp.network.paths import actual_flows, flows_of, moving_parts
from vvdp.simulation.balance import LIMIT, balance_between
from vvdp.simulation.outcome import SETTLED, Outcome, outcome
from vvdp.simulation.run import Run
from vvdp.simulation.values import as_value, flat, leaves
from vvdp.systems.extras import Summary as Summary
from vvdp.systems.system import System


def summary(system: System, run: Run) -> Summary:
    """All results of a run as one flat table, SI units at the end of each key.

    Flows are counted in tank volumes; pressures are gauge, against the oil's reference pressure; the keys are
    described in docs/keys.md. It is what `run_summary` gives at once with the `closed_forms`, which take longer.
    """
    found = run_summary(system, run)
    return found | closed_forms(system, found)


def run_summary(system: System, run: Run) -> Summary:
    """The part of a summary that the run itself gives: all but the closed forms, in a tenth of the time."""
    simulated = simulated_summary(outcome(run), system)
    own = additions(system)
    recorded: Summary = {} if own is None else own.record_numbers(run)
    seen = wave_numbers(system, run) | temperature_numbers(system, run) | junction_numbers(system, run)
    return simulated | recorded | seen | (validity(system, simulated | seen) if seen else {})


def closed_forms(system: System, found: Mapping[str, float | bool]) -> Summary:
    """The analytic results to stand beside those of a run in `found`; empty where a system has none."""
    own = additions(system)
    return {**placed_forms(system, found), **({} if own is None else own.closed_forms(found))}


def simulated_summary(run: Outcome, system: System) -> Summary:
    """The part of a summary that the simulation alone gives, of a recorded run or of a case in a batch."""
    window, means = run.window, _means(run)
    found: Summary = {
        "duration_s": run.end,
        "finished": run.finished,
        "averaged_from_s": window.begin,
        "averaged_to_s": window.end,
        "averaged_periods": float(window.periods),
        "settled": window.settled,
        **node_numbers(run, system, means),
        **part_numbers(system, means),
        **level_numbers(run, system),
        **heat_numbers(run, system),
        **waiting_numbers(run, system),
    }
    balances = _balances(run)
    found |= valve_numbers(system, means, found | balances)
    if own := additions(system):
        found |= own.simulation_numbers(run, found | balances)
    found |= balances
    found["settled"] = window.settled and not is_filling(found)
    found |= validity(system, found)
    found |= {
        "steps": float(run.steps),
        "rejected_steps": float(run.rejected),
        "evaluations": float(run.evaluations),
        "stiff_method": run.stiff,
        "wall_time_s": run.seconds,
    }
    return {key: bool(value) if isinstance(value, bool | np.bool_) else float(value) for key, value in found.items()}


def validity(system: System, found: Mapping[str, float | bool]) -> Summary:
    """Whether the laws hold at what a run has `found`, and whether it is then to be trusted."""
    valid = not broken_bounds(system, found)
    low = lowest_pressure(system, found)[1] < cavitation_pressure(system)
    flags: Summary = {"cavitation_volume": low, "within_validity": valid}
    if "second_law" in found:
        flags["trusted"] = bool(is_closed(found) and found["second_law"] and valid)
    return flags


def is_filling(found: Mapping[str, float | bool]) -> bool:
    """Whether more than `SETTLED` of the input power enters or leaves the stored energy, which ends some day.

    It shows a drift too slow to show in the means. Without input power they show all.
    """
    put_in = sum(max(value, 0.0) for key, value in found.items() if key.startswith("power_"))
    return bool(put_in > 0.0 and abs(found.get("stored_power_W", 0.0)) > SETTLED * put_in)


def is_closed(found: Mapping[str, float | bool]) -> bool:
    """Whether both balances of a run close."""
    return bool(max(abs(found["energy_residual"]), abs(found["mass_residual"])) <= LIMIT)


def _means(run: Outcome) -> dict[str, float]:
    """Means over the window of all that the books add up, by its path in them."""
    window, size = run.window, flat(run.case.state.books).size
    mean = as_value(run.case.state.books, (window.last - window.first)[-size:] / (window.end - window.begin))
    return {path: float(value) for path, value, _ in leaves(mean)}


def node_numbers(run: Outcome, system: System, means: Mapping[str, float]) -> Summary:
    """Pressures, speeds and positions: means over the window, extremes over every step."""
    window = run.window
    paths = [path for path, _, _ in leaves(run.case.state)]
    low, high = (dict(zip(paths, values, strict=True)) for values in (run.low, run.high))
    found = Summary()
    for name, node in system.circuit.network.nodes.items():
        if isinstance(node, HydraulicNode):
            reference = node.oil.reference_pressure
            if isinstance(node, OilVolume):
                bounds = low[name], high[name]
            else:
                bounds = _prescribed_bounds(node, run, system, means)
            mean = bounds[0] if bounds[0] == bounds[1] else means[f"totals.{name}_pressure"]
            found[f"pressure_mean_{name}_Pa"] = mean - reference
            found[f"pressure_min_{name}_Pa"] = bounds[0] - reference
            found[f"pressure_max_{name}_Pa"] = bounds[1] - reference
            if can_boil(node):
                found[f"vapour_mean_{name}_m3"] = means[f"totals.{name}_vapour"]
            if has_free_air(node):
                found[f"free_air_mean_{name}"] = means[f"totals.{free_air_name(name)}"]
                found[f"loss_{free_air_name(name)}_W"] = means[f"spent.{free_air_name(name)}"]
        elif isinstance(node, Shaft | Rod):
            place, rate, unit = ("angle", "speed", "rad") if isinstance(node, Shaft) else ("position", "velocity", "m")
            at = paths.index(f"{name}.{place}")
            found[f"{rate}_mean_{name}_{unit}_s"] = (window.last[at] - window.first[at]) / (window.end - window.begin)
            found[f"{rate}_min_{name}_{unit}_s"] = low[f"{name}.{rate}"]
            found[f"{rate}_max_{name}_{unit}_s"] = high[f"{name}.{rate}"]
            if isinstance(node, Rod):
                found[f"position_min_{name}_m"] = low[f"{name}.position"]
                found[f"position_max_{name}_m"] = high[f"{name}.position"]
    for name, shaft in driven_spools(system.circuit.network).items():
        at = paths.index(name)
        mean = (window.last[at] - window.first[at]) / (window.end - window.begin)
        bounds = _driven_bounds(shaft, run, system, mean)
        keys = (f"speed_{which}_{name}_rad_s" for which in ("mean", "min", "max"))
        found |= dict(zip(keys, (mean, *bounds), strict=True))
    for name in moving_parts(system.circuit.network):
        found[f"position_min_{name}_m"] = low[f"{name}.position"]
        found[f"position_max_{name}_m"] = high[f"{name}.position"]
    return found


def _driven_bounds(node: DrivenShaft, run: Outcome, system: System, mean: float) -> tuple[float, float]:
    """Bounds of a prescribed speed [rad/s], as the case has it; its mean where it is a connection."""
    if not isinstance(node.speed, Signal):
        return mean, mean
    given: Signal = attrgetter(system.circuit.place(node.speed))(run.case.params)
    return given.extremes


def _prescribed_bounds(
    node: Tank | PressureSource | Junction, run: Outcome, system: System, means: Mapping[str, float]
) -> tuple[float, float]:
    """Bounds of a pressure that is no state [Pa, absolute], as the case prescribes it; its mean where nothing does."""
    if not isinstance(node, Junction) and isinstance(node.pressure, Signal):
        given: Signal = attrgetter(system.circuit.place(node.pressure))(run.case.params)
        return given.extremes
    mean = means[f"totals.{node.name}_pressure"]
    return mean, mean


def junction_numbers(system: System, run: Run) -> Summary:
    """The lowest and the highest pressure of each junction over the records of a run, by key."""
    return {
        f"pressure_{which}_{name}_Pa": float(extreme(getattr(run.outputs, f"{name}_pressure")))
        - node.oil.reference_pressure
        for name, node in system.circuit.network.nodes.items()
        if isinstance(node, Junction)
        for which, extreme in (("min", np.min), ("max", np.max))
    }


def part_numbers(system: System, means: Mapping[str, float]) -> Summary:
    """Mean flows, losses and powers by component, and what its sources give."""
    found = Summary()
    nodes = system.circuit.network.nodes
    hydraulic = {f"totals.{name}_pressure" for name, node in nodes.items() if isinstance(node, HydraulicNode)}
    for path, value in means.items():
        group, _, name = path.partition(".")
        if group == "totals" and path not in hydraulic and name.endswith("_flow"):
            found[f"flow_mean_{name.removesuffix('_flow')}_m3_s"] = value
        elif group == "supplied":
            found[f"power_{name}_W"] = value
    for part in system.circuit.network.parts.values():
        first, *others = flows_of(part) or [""]
        if others:
            into_others = (means[f"totals.{part.name}_{name}"] for name in others)
            found[f"flow_mean_{part.name}_{first.removesuffix('_flow')}_m3_s"] = -sum(into_others)
        found |= _actual_numbers(part, means)
        losses = dict(_losses(part.name, means))
        if losses:
            found[f"loss_{part.name}_W"] = sum(losses.values())
        if "" not in losses:
            found |= {f"loss_{part.name}_{loss}_W": value for loss, value in losses.items()}
    for whole, chain in system.circuit.network.groups.items():
        found[f"flow_mean_{whole}_m3_s"] = found[f"flow_mean_{chain.parts[-1]}_m3_s"]
        found[f"flow_actual_mean_{whole}_m3_s"] = found[f"flow_actual_mean_{chain.parts[-1]}_m3_s"]
        found[f"loss_{whole}_W"] = sum(found[f"loss_{part}_W"] for part in chain.parts)
    for circuit in system.circuit.network.circuits:
        inside = system.circuit.network.parts_inside(circuit)
        found[f"loss_{circuit}_W"] = sum(found.get(f"loss_{part}_W", 0.0) for part in inside)
    return found


def _actual_numbers(part: Part, means: Mapping[str, float]) -> Summary:
    """Mean flows of a component at the pressure of the port that they enter."""
    keys = {name: f"{part.name}_{name}".removesuffix("_actual").removesuffix("_flow") for name in actual_flows(part)}
    return {f"flow_actual_mean_{key}_m3_s": means[f"totals.{part.name}_{name}"] for name, key in keys.items()}


def _losses(name: str, means: Mapping[str, float]) -> Iterator[tuple[str, float]]:
    if f"spent.{name}" in means:
        yield "", means[f"spent.{name}"]
    for path, value in means.items():
        if path.startswith(f"spent.{name}."):
            yield path.removeprefix(f"spent.{name}."), value


def _balances(run: Outcome) -> Summary:
    books = balance_between(run.model, run.case, flat(run.case.state), run.final, (run.low, run.high))
    window = run.window
    over_window = balance_between(run.model, run.case, window.first, window.last)
    if books is None or over_window is None:
        return {}
    return {
        "stored_power_W": over_window.energy_stored / (window.end - window.begin),
        "energy_residual": books.energy_residual,
        "mass_residual": books.mass_residual,
        "second_law": books.is_possible,
    }
