"""Tables of the rival circuits that are values of no component."""

from vvdp.base.kinds import Conductance, Flow, FlowSignal, PressureSignal, SpeedSignal
from vvdp.base.params import Params
from vvdp.base.rules import require_positive


class PumpDrive(Params):
    """What turns a fixed pump."""

    speed: SpeedSignal


class VariablePump(Params):
    """An ideal variable pump but for what leaks back: it gives any flow up to `largest_flow`."""

    largest_flow: Flow
    leakage_conductance: Conductance

    def check(self) -> None:
        require_positive(self, "largest_flow", why="the rod would never move")


class ChargeSupply(Params):
    """A charge pump's constant `flow`; what is not needed goes over the charge relief valve."""

    flow: FlowSignal


class Reservoir(Params):
    """The tank of an open circuit, under `pressure` so that the low side fills."""

    pressure: PressureSignal
