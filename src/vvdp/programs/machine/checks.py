"""Duties that a machine cannot fulfil, reported with numbers before it is run.

Source  ours, docs/models/whole-machine.md
"""

from typing import Any, NamedTuple, TypeVar

from vvdp.base.errors import ParameterError
from vvdp.base.params import Params, field_names
from vvdp.base.signal import Signal
from vvdp.hydraulics.cylinder import Cylinder
from vvdp.hydraulics.friction import RodFriction
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.hydraulics.rod import EndStop, Weight, weight_force
from vvdp.hydraulics.volume import Vessel
from vvdp.network.network import Network
from vvdp.programs.machine.cycle import fastest
from vvdp.programs.machine.loop import MachineLoop

V = TypeVar("V", bound=Params)


class CylinderDuty(NamedTuple):
    """Duty of a cylinder: least and greatest force on its rod, in the direction of the position [N], and the speed
    [m/s]; its return valve is open by `opening` [1]."""

    least_force: float
    greatest_force: float
    speed: float
    opening: float


class WorkingPressures(NamedTuple):
    """Supply pressures that extending and retracting take, over the tank's [Pa]."""

    extending: float
    retracting: float


def working_pressures(
    duty: CylinderDuty, cylinder: Cylinder, friction: RodFriction, return_conductance: float
) -> WorkingPressures:
    """Supply pressures at the most that a cylinder needs to move steadily [Pa], none below zero.

    P_s A_s = F + b v + F_c + P_r A_r with the return at P_r = (A_r v / (u K_r))^2, F the load in that direction.

    return_conductance  K_r of the return valve, fully open [m^3/(s Pa^0.5)]

    >>> duty = CylinderDuty(-1000.0, -1000.0, 0.054, 0.8)
    >>> print([round(pressure / 1e5, 1) for pressure in working_pressures(duty, cylinder, friction, 1.2e-7)])  # bar
    [7.4, 16.1]
    """
    resistance = friction.viscous_friction * duty.speed + friction.coulomb_friction

    def supply(load: float, area: float, other: float) -> float:
        back = (other * duty.speed / (duty.opening * return_conductance)) ** 2
        return max((load + resistance + back * other) / area, 0.0)

    return WorkingPressures(
        extending=supply(-duty.least_force, cylinder.area_a, cylinder.area_b),
        retracting=supply(duty.greatest_force, cylinder.area_b, cylinder.area_a),
    )


class Values(NamedTuple):
    """A component of one type that is joined to a node: its name, and its values."""

    name: str
    values: Any


def values_at(network: Network, node: str, cls: type[V]) -> list[Values]:
    """The values of a class of all components at a node."""
    parts = (part for part in network.parts.values() if node in part.nodes.values())
    return [Values(part.name, each) for part in parts for each in part.values if isinstance(each, cls)]


def refuse_machine(network: Network, name: str) -> None:
    """Raises ParameterError where end stops let the cylinder leave its stroke, the load takes more than the relief
    valve allows with the return fully open, or the accumulator is charged above all pressures at which the line is to
    work; what the circuit does not have is not checked."""
    program = network.programs[name]
    loop = machine_loop_of(program.settings)
    rod, line = (str(program.reads[each]).partition(".")[0] for each in ("position", "line_pressure"))
    cylinders, frictions = values_at(network, rod, Cylinder), values_at(network, rod, RodFriction)
    returns, reliefs = return_conductances(network, line), _relief_valves(network)
    if len(cylinders) != 1 or len(frictions) != 1 or len(returns) != 1:
        return
    cylinder: Cylinder = cylinders[0].values
    for stops in values_at(network, rod, EndStop):
        refuse_stops(cylinder, stops)
    forces = [
        p for p in network.parts.values() if rod in p.nodes.values() and isinstance(p.inputs.get("force"), Signal)
    ]
    pull = sum(weight_force(each.values) for each in values_at(network, rod, Weight))
    ends: list[Any] = [part.inputs["force"] for part in forces]
    least, greatest = (pull + sum(force.extremes[n] for force in ends) for n in (0, 1))
    speed, tank = fastest(loop.points), loop.law.cylinder.tank_pressure

    def pressures(opening: float) -> WorkingPressures:
        duty = CylinderDuty(least, greatest, speed, opening)
        return working_pressures(duty, cylinder, frictions[0].values, returns[0])

    if reliefs and forces:
        refuse_load(f"components.{forces[0].name}.force", pressures(1.0), max(reliefs) - tank)
    support = loop.law.support
    supported = support.support_pressure - tank if support.support_conductance > 0.0 else 0.0
    vessel = getattr(network.nodes[line], "values", None)
    if isinstance(vessel, Vessel):
        refuse_precharge(line, max(*pressures(loop.law.split.mean_opening), supported), vessel, tank)


def machine_loop_of(settings: Any) -> MachineLoop:
    """The values of the stages and laws of a machine, whatever leads its cylinder."""
    return settings if isinstance(settings, MachineLoop) else settings.machine


def return_conductances(network: Network, line: str) -> list[float]:
    """Those of the meter-out throttles of valves at a line [m^3/(s Pa^0.5)]."""
    return [each.values.return_conductance for each in values_at(network, line, Params) if _is_throttled(each.values)]


def _is_throttled(values: Params) -> bool:
    return "return_conductance" in field_names(type(values))


def _relief_valves(network: Network) -> list[float]:
    """The cracking pressures of all relief valves, absolute [Pa]."""
    values = (each for part in network.parts.values() for each in part.values)
    return [each.cracking_pressure for each in values if isinstance(each, ReliefValve)]


def refuse_load(key: str, pressures: WorkingPressures, limit: float) -> None:
    """Raises ParameterError where the load takes more than the relief valve lets the pump give.

    key    path of the force
    limit  of the relief valve, over the tank's pressure [Pa]
    """
    for name, pressure in pressures._asdict().items():
        if pressure >= limit:
            raise ParameterError(
                f"{key}: {name} takes {pressure / 1e5:.4g} bar in the supply; the relief valve opens at "
                f"{limit / 1e5:.4g} bar"
            )


def refuse_precharge(name: str, working_pressure: float, line: Vessel, tank_pressure: float) -> None:
    """Raises ParameterError where an accumulator is charged above all that the line ever works at: it would stay
    closed.

    name              of the line
    working_pressure  highest of the line, over the tank's [Pa]
    tank_pressure     absolute [Pa]
    """
    precharge = line.precharge_pressure - tank_pressure
    if line.gas_volume > 0.0 and precharge >= working_pressure:
        raise ParameterError(
            f"nodes.{name}.precharge_pressure: {precharge / 1e5:.4g} bar; the line works at "
            f"{working_pressure / 1e5:.4g} bar at most, at which no oil would enter the accumulator"
        )


def refuse_stops(cylinder: Cylinder, stops: Values) -> None:
    """Raises ParameterError where end stops let a cylinder leave its stroke."""
    ends = stops.values
    if ends.lower_end < 0.0 or ends.upper_end > cylinder.stroke:
        raise ParameterError(
            f"components.{stops.name}.upper_end: from {1e3 * ends.lower_end:.4g} to {1e3 * ends.upper_end:.4g} mm; the "
            f"stroke of the cylinder is {1e3 * cylinder.stroke:.4g} mm"
        )
