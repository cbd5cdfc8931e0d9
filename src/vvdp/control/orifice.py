"""Controller model of the valve of the pressure chamber: the command for a demanded flow.

Source  ours, docs/models/passivity-control.md, where a function names no other.
"""

import numpy as np

from vvdp.base.kinds import FlowCoefficient, Pressure, PressureDifference
from vvdp.base.params import Params
from vvdp.base.rules import field_text, refuse, require_positive
from vvdp.base.select import clip, maximum, select


class ChamberValve(Params):
    """A proportional valve with an edge from the supply to the chamber and one from there to the tank.

    Flow over root of the drop, at a full command, is the `conductance` of either edge. Where a drop is below
    `least_drop` the command is that of `least_drop`, so that it stays finite. Pressures are absolute.
    Raises `ParameterError` where the supply does not exceed the tank, or the valve passes nothing.
    """

    conductance: FlowCoefficient
    supply_pressure: Pressure
    tank_pressure: Pressure
    least_drop: PressureDifference = 1e3

    def check(self) -> None:
        if not self.supply_pressure > self.tank_pressure:
            refuse(self, "supply_pressure", f"must be greater than tank_pressure, {field_text(self, 'tank_pressure')}")
        require_positive(self, "conductance", "least_drop")


def valve_command(flow: float, pressure: float, valve: ChamberValve) -> float:
    """The command [1] that lets a flow into the chamber, from -1 (wide open to the tank) to 1 (to the supply).

    u = Q / (K sqrt(drop)), the drop being P_s - P for a flow in and P - P_T for one out.

    flow      into the chamber; negative: out of it [m^3/s]
    pressure  of the chamber, absolute [Pa]

    Source  wang2017, eq. 5.2, inverted
    """
    drop = select(flow > 0.0, valve.supply_pressure - pressure, pressure - valve.tank_pressure)
    command: float = clip(flow / (valve.conductance * np.sqrt(maximum(drop, valve.least_drop))), -1.0, 1.0)
    return command


def valve_flow(command: float, pressure: float, valve: ChamberValve) -> float:
    """The flow [m^3/s] that a command lets into the chamber; nothing flows against a drop.

    command   from -1 to 1 [1]
    pressure  of the chamber, absolute [Pa]

    Source  wang2017, eq. 5.2
    """
    drop = select(command > 0.0, valve.supply_pressure - pressure, pressure - valve.tank_pressure)
    flow: float = valve.conductance * command * np.sqrt(maximum(drop, 0.0))
    return flow
