"""Values of a test rig of the rotary valve that its checks read."""

from dataclasses import dataclass

from vvdp.base.signal import Signal
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.volume import Vessel
from vvdp.valve.rotary import RotaryValve


@dataclass(frozen=True, kw_only=True)
class BenchValues:
    """Values of a pump unit with its load; pressures absolute, `load_line` None where a source is the load.

    duty_ratio           [1], and axial_position [m] that gives it; `is_placed` if the file prescribes the latter
    temperature          of the oil at the start [K]
    reference            from which gauge pressures count [Pa]
    tank_pressure        at the start [Pa]
    cavitation_pressure  below which the oil is held to cavitate [Pa]
    inlet_volume         between pump, relief valve and nozzles [m^3]
    ripple_amplitude     of the pump's flow over its mean [1]
    """

    valve: RotaryValve
    oil: Oil
    load_line: Vessel | None
    duty_ratio: Signal
    axial_position: Signal
    is_placed: bool
    temperature: float
    reference: float
    tank_pressure: float
    cavitation_pressure: float
    inlet_volume: float
    ripple_amplitude: float
