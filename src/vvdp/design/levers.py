"""Levers that lower the loss of a valve's transitions: each at its best in closed form, and simulated."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.extras import require
from vvdp.design.optimise import optimise
from vvdp.design.problem import Bound, Limit, Point, Problem
from vvdp.design.quantities import Quantities, Setup, quantities, setup, switching_condition
from vvdp.design.soft_switching import Softening, best_chamber, soft_quantities, soft_rig, usual_bypass
from vvdp.design.variables import VARIABLES, value_in, with_variables
from vvdp.evaluation.bench import rotary_bench
from vvdp.evaluation.unit_rig import STIFF_COUPLING, unit_on_rig
from vvdp.hydraulics.soft_switching import SwitchChamber
from vvdp.simulation.link import quiet
from vvdp.simulation.values import names
from vvdp.steady.steady_states import Steady, steady_states
from vvdp.steady.test_stand import Stand, stand
from vvdp.systems.system import System
from vvdp.valve.losses import range_warnings
from vvdp.valve.torque import pwm_frequency

LOAD_SHARES = (0.4, 0.6, 0.8)
"""Load pressures, over the relief setting."""
STARTS = 5
"""Random starts of each optimum."""
ROUNDS = 2
"""Times that a valve and the relief settings it works with are found in turn."""
STIFF = {"liquid_bulk_modulus": 1e12, "air_fraction": 0.0}
"""Oil as the closed forms take it."""
SIZES = ("spool_radius", "nozzle_area", "outlet_area")


class Lever(NamedTuple):
    """Something to be changed: variables of the valve, all its lengths times `scale`, whether the relief setting
    follows the load, whether a motor turns the spool at the PWM frequency that the valve had, and whether a check
    valve past the load port, and a chamber beside it, switch it softly."""

    name: str
    variables: tuple[str, ...] = ()
    scale: float = 1.0
    follows: bool = False
    is_driven: bool = False
    has_bypass: bool = False
    has_chamber: bool = False


LEVERS = (
    Lever("as it is"),
    Lever("a valve of 0.8 times the size", scale=0.8),
    Lever("a valve of 1.25 times the size", scale=1.25),
    Lever("underlap", ("lap_ratio",)),
    Lever("relief setting follows the load", follows=True),
    Lever("spool and areas", SIZES),
    Lever("driven spool, radius and areas", SIZES, is_driven=True),
    Lever("check valve past the load port", has_bypass=True),
    Lever("soft switching", has_bypass=True, has_chamber=True),
    Lever("underlap, relief setting follows", ("lap_ratio",), follows=True),
    Lever("underlap, spool and areas", ("lap_ratio", *SIZES)),
    Lever("underlap, areas, relief follows, driven", ("lap_ratio", *SIZES), follows=True, is_driven=True),
    Lever("soft switching, spool and areas", SIZES, has_bypass=True, has_chamber=True),
)


@dataclass(frozen=True)
class Pulled:
    """A lever at its best: variables [SI], and at each load the closed form, or the average with `soft` switching, what
    is simulated in stiff oil and in the oil as it is."""

    lever: Lever
    values: Mapping[str, float]
    points: tuple[Setup, ...]
    closed: tuple[Quantities, ...]
    soft: Softening | None = None
    stiff: tuple[Steady, ...] = ()
    real: tuple[Steady, ...] = ()


def levers(
    system: System,
    *,
    simulated: bool = True,
    cores: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    say: Callable[[str], None] = quiet,
) -> tuple[Pulled, ...]:
    """Every lever of `LEVERS` at its least mean loss over `LOAD_SHARES`, and its periodic states at each load.

    The PWM frequency of the open valve is at least what it was. Raises ParameterError where the closed form of the
    transition loss does not hold for the system as it is.
    """
    require("casadi", "opt", "an optimum")
    bench, points = rotary_bench(system, "design levers"), _points(system)
    if bench.is_softened:
        raise ParameterError(f"{system.name}: is switched softly already; take its tables [bypass] and [chamber] away")
    for at in points:
        if told := range_warnings(at.duty_ratio, switching_condition(at), at.valve):
            raise ParameterError(f"{system.name}: {told[0]}")
    found = []
    for lever in LEVERS:
        found.append(_best(system, lever, points))
        if progress:
            progress(len(found), len(LEVERS))
    return _simulate(system, found, cores, say) if simulated else tuple(found)


def valve_loss(q: Quantities) -> float:
    """Losses of valve, relief valve and the spool's motor, without compression [W]."""
    return float(q.loss_full_open + q.loss_transition + q.loss_leakage + q.spool_drive_power)


def limit_loss(q: Quantities) -> float:
    """The part of them that remains with transitions that lose nothing [W]."""
    return float(q.loss_full_open + q.loss_leakage + q.spool_drive_power)


def simulated_loss(state: Steady) -> float:
    """The same of a periodic state [W], by component; nan where there is none."""
    parts = ("valve", "relief_valve", "coupling", "bypass", "mouth")
    return sum(float(state.summary.get(f"loss_{part}_W", 0.0)) for part in parts) if state.summary else np.nan


def _points(system: System) -> tuple[Setup, ...]:
    """The system at each of the loads."""
    bench, here = rotary_bench(system, "design levers"), setup(system)
    rise = here.relief_pressure - here.tank_pressure
    loads = [float(here.tank_pressure + share * rise) for share in LOAD_SHARES]
    return tuple(here._replace(load_pressure=p, flow=bench.unit.delivered_flow(p)) for p in loads)


def _best(system: System, lever: Lever, points: Sequence[Setup]) -> Pulled:
    """The lever at its best in closed form."""
    frequency = float(np.mean([quantities(at).pwm_frequency for at in points]))
    taken, values = list(points), dict[str, float]()
    if lever.is_driven:
        speed = 2.0 * np.pi * frequency / points[0].valve.sections
        taken = [at._replace(coupling=STIFF_COUPLING, spool_motor_speed=speed) for at in taken]
    if lever.scale != 1.0:
        values = _scale_valve(points[0], lever.scale)
    objective = "loss_full_open" if lever.has_chamber else "loss_total"
    for _ in range(ROUNDS if lever.follows and lever.variables else 1):
        if lever.follows:
            taken = [_with_best_relief(system, at, values) for at in taken]
        if lever.variables:
            bounds = [_bound(name, points[0]) for name in lever.variables]
            values = _solve(system, taken, bounds, frequency, objective)
    there = [with_variables(at, values) for at in taken]
    soft = _softening(lever, there)
    closed = [quantities(at) if soft is None else soft_quantities(at, soft) for at in there]
    return Pulled(lever, values, tuple(taken), tuple(_plain(q) for q in closed), soft)


def _softening(lever: Lever, points: Sequence[Setup]) -> Softening | None:
    """The check valve and chamber of a lever, the chamber with its best precharge."""
    if not lever.has_bypass:
        return None
    bypass = usual_bypass(float(points[0].flow))
    return Softening(bypass, best_chamber(points[len(points) // 2], bypass) if lever.has_chamber else None)


def _scale_valve(at: Setup, scale: float) -> dict[str, float]:
    """A valve whose lengths are `scale` times as large and areas its square; clearance and end lands as they were."""
    lengths = {name: scale * value_in(at, name) for name in ("spool_radius", "helix_length")}
    return lengths | {name: scale * scale * value_in(at, name) for name in ("nozzle_area", "outlet_area")}


def _plain(q: Quantities) -> Quantities:
    return Quantities(**{name: float(value) for name, value in q._asdict().items()})


def _bound(name: str, at: Setup) -> Bound:
    variable, now = VARIABLES[name], value_in(at, name)
    return Bound(variable, variable.lowest * now, variable.highest * now)


def _with_best_relief(system: System, at: Setup, values: Mapping[str, float]) -> Setup:
    """A load with the relief setting that loses least there, which opens with no port fully open."""
    here = with_variables(at, values)
    open_drop = float(quantities(here).pressure_drop_total)
    low, high = at.load_pressure + open_drop, 2.0 * at.load_pressure + 4.0 * open_drop
    found = _solve(system, [here], [Bound(VARIABLES["relief_pressure"], low, high)], 0.0)
    return at._replace(relief_pressure=found["relief_pressure"])


def _solve(
    system: System,
    points: Sequence[Setup],
    bounds: Sequence[Bound],
    frequency: float,
    objective: str = "loss_total",
) -> dict[str, float]:
    """The values of least mean loss; transitions as long as the duty ratio lets both ports open fully."""
    duty = float(points[0].duty_ratio)
    limits = [Limit("transition_fraction", at_least=False, value=min(duty, 1.0 - duty))]
    if frequency > 0.0:
        limits.append(Limit("pwm_frequency", at_least=True, value=frequency, over_the_points=True))
    asked = Problem(
        system=system,
        objective=objective,
        limits=tuple(limits),
        bounds=tuple(bounds),
        points=tuple(Point(1.0, system, at) for at in points),
    )
    return dict(optimise(asked, starts=STARTS, globally=False).values)


def _simulate(
    system: System, found: Sequence[Pulled], cores: int | None, say: Callable[[str], None]
) -> tuple[Pulled, ...]:
    """The same with the periodic states of every lever at every load, in stiff oil and in the oil as it is; those of
    one circuit together."""
    done: dict[str, Pulled] = {}
    for has_bypass, has_chamber in ((False, False), (True, False), (True, True)):
        alike = [e for e in found if (e.lever.has_bypass, e.lever.has_chamber) == (has_bypass, has_chamber)]
        held = _stand_with(system, has_bypass=has_bypass, has_chamber=has_chamber)
        pairs = []
        for each in alike:
            for oil in (STIFF, {}):
                for at in each.points:
                    point = held.set_point._replace(load_pressure=at.load_pressure)
                    pairs.append((_changed_stand(held, each, at, oil), point))
        states = steady_states(pairs, cores=cores, say=say)
        size = len(LOAD_SHARES)
        parts = [tuple(states[k : k + size]) for k in range(0, len(states), size)]
        for each, stiff, real in zip(alike, parts[::2], parts[1::2], strict=True):
            done[each.lever.name] = replace(each, stiff=stiff, real=real)
    return tuple(done[each.lever.name] for each in found)


def _stand_with(system: System, *, has_bypass: bool, has_chamber: bool) -> Stand:
    """The system on a test rig, with the components of soft switching."""
    rig = unit_on_rig(system, "design levers")
    chamber = SwitchChamber(precharge_pressure=1.5e6) if has_chamber else None
    soft = Softening(usual_bypass(float(setup(system).flow)), chamber)
    return stand(soft_rig(rig, soft) if has_bypass else rig, "design levers")


def _changed_stand(held: Stand, each: Pulled, at: Setup, oil: Mapping[str, float]) -> Stand:
    valve, changed = held.bench.valve, with_variables(at, each.values).valve
    changes = {
        "valve": {
            name: getattr(changed, name) for name in names(valve) if getattr(changed, name) != getattr(valve, name)
        },
        "relief_valve": {"cracking_pressure": float(at.relief_pressure)},
    }
    if each.soft and each.soft.chamber:
        changes["chamber"] = {"precharge_pressure": each.soft.chamber.precharge_pressure}
    made = held.with_tables(**{name: table for name, table in {**changes, "oil": oil}.items() if table})
    return made.with_motor(float(pwm_frequency(at.spool_motor_speed, valve))) if each.lever.is_driven else made
