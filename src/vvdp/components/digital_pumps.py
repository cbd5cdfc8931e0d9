"""Pump whose pistons deliver or idle one by one."""

from typing import NamedTuple

from vvdp.base.kinds import Flow, Fraction, Power, Ratio, Torque
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.digital_pump import DigitalPump, actuation_power, breathing_torque, stroke_share
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.ports import ShaftState
from vvdp.hydraulics.pump import against, delivery, pump_friction_power
from vvdp.network.component import Component


class PistonLosses(NamedTuple):
    """Powers that a pump with enabled pistons dissipates: in leaks, by friction, where chambers meet another pressure,
    in its inlet valves, and to close them."""

    leakage: Power
    friction: Power
    compression: Power
    breathing: Power
    actuation: Power


class PistonEffect(NamedTuple):
    """Effect of the pump on its ports, its losses, the power that closes its valves, the tank volumes that leak back,
    and its flow over the mean flow of all pistons."""

    inlet: Flow
    outlet: Flow
    shaft: Torque
    losses: PistonLosses
    supplied: Power
    leakage_flow: Flow
    share: Ratio


def digital_pump(
    inlet: FluidState,
    outlet: FluidState,
    shaft: ShaftState,
    cosine: Ratio,
    sine: Ratio,
    enabled: Fraction,
    actuated: Fraction,
    values: DigitalPump,
) -> PistonEffect:
    """Piston pump of which some pistons are `enabled`, by the sums over them; its leakage is in proportion to their
    share.

    What the dead volumes held more is spread over the strokes as their flow is.
    """
    share = stroke_share(shaft.angle, cosine, sine, values)
    displacement, unused = delivery(shaft.angle, inlet, outlet, values)
    q = share * displacement * shaft.speed
    leak = passage(enabled * values.leakage_conductance * (outlet.pressure - inlet.pressure), outlet, inlet)
    breathing, valves = breathing_torque(shaft.speed, enabled, values), actuation_power(shaft.speed, actuated, values)
    hindrance = against(values.friction_torque + share * unused + breathing, shaft.speed)
    return PistonEffect(
        inlet=leak.flow - q,
        outlet=q - leak.flow,
        shaft=-share * displacement * (outlet.enthalpy - inlet.enthalpy) - hindrance,
        losses=PistonLosses(
            leakage=leak.loss,
            friction=pump_friction_power(shaft.speed, values),
            compression=share * unused * abs(shaft.speed),
            breathing=breathing * abs(shaft.speed),
            actuation=valves,
        ),
        supplied=valves,
        leakage_flow=leak.flow,
        share=share,
    )


DIGITAL_PUMP = Component(digital_pump, symbol="variable_pump", averages=("leakage_flow", "share"))
