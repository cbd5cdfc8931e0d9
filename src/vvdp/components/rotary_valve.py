"""The self-spinning rotary on/off valve: two branches, its leakage, a check valve in the load branch, its spool."""

from typing import NamedTuple

from vvdp.base.kinds import (
    Conductance,
    Coupling,
    DutyRatio,
    ExchangedPower,
    Flow,
    Fraction,
    Inertia,
    Kink,
    Position,
    Power,
    Pressure,
    Ratio,
    Torque,
)
from vvdp.base.modes import side
from vvdp.base.select import maximum, minimum, select
from vvdp.fluid.mixture import FluidState
from vvdp.fluid.oil import Oil, film_ratios
from vvdp.hydraulics.check_valve import CheckPoppet, check_opening, check_opening_rate, check_side
from vvdp.hydraulics.flow import Passage, passage
from vvdp.hydraulics.ports import Medium, ShaftState
from vvdp.network.component import Component
from vvdp.valve.branch import BranchFlow, BranchLaw, branch_law, choked_flow, choking_ratio, law_flow
from vvdp.valve.geometry import JetSkews, Openings, PortShape, jet_skews, port_edges, port_shape, shape_openings
from vvdp.valve.leakage import leakage_conductance
from vvdp.valve.rotary import RotaryValve
from vvdp.valve.torque import SpoolTorque, friction_coefficient, pwm_frequency, spool_inertia, spool_torque
from vvdp.valve.validity import CAVITATION_NUMBER, CAVITATION_PRESSURE


class RotaryValveState(NamedTuple):
    """Opening of the check valve in the load branch."""

    check_opening: Ratio


class RotaryValveHeld(NamedTuple):
    """Values that depend on the oil's temperature alone; leakage and friction at its reference pressure."""

    leakage_conductance: Conductance
    friction_coefficient: Coupling
    branch: BranchLaw
    ports: PortShape


class RotaryValveLosses(NamedTuple):
    """Power dissipated. The three drops are counted in full; the shaft work that the spool takes from them is
    subtracted in `to_spool`, negative, and dissipates as friction."""

    nozzle: Power
    centre_section: Power
    outlet_turbine: Power
    leakage: Power
    spool_friction: Power
    to_spool: ExchangedPower


class RotaryValveFlow(NamedTuple):
    """Flows, torque, losses and modes of a rotary valve at an instant."""

    inlet: Flow
    load: Flow
    tank: Flow
    spool: Torque
    losses: RotaryValveLosses
    rates: RotaryValveState
    leakage: Flow
    load_opening: Fraction
    tank_opening: Fraction
    cavitating: Fraction
    load_near: Kink
    load_far: Kink
    tank_near: Kink
    tank_far: Kink
    load_choke: Kink
    tank_choke: Kink
    check: Kink


def rotary_valve_held(medium: Medium, oil: Oil, valve: RotaryValve) -> RotaryValveHeld:
    """Values of a rotary valve that are calculated once per sample."""
    return RotaryValveHeld(
        leakage_conductance=leakage_conductance(medium.viscosity, valve),
        friction_coefficient=friction_coefficient(medium.viscosity, valve),
        branch=branch_law(medium.density, valve, oil.vapour_pressure),
        ports=port_shape(valve),
    )


def rotary_valve_start(valve: RotaryValve) -> RotaryValveState:
    """Its first state: the check valve open."""
    return RotaryValveState(1.0)


def duty_position(duty_ratio: DutyRatio, valve: RotaryValve) -> Position:
    """Axial position of the spool [m] that gives a duty ratio: x = d L."""
    return duty_ratio * valve.helix_length


class Branch(NamedTuple):
    """One branch at an instant: its flow at the pressure it comes from, what passes in tank volumes, and on which side
    of choking its nozzles are."""

    law: BranchFlow
    passage: Passage
    choke: Kink


def branch(inlet: FluidState, outlet: FluidState, opening: float, law: BranchLaw) -> Branch:
    """Flow of one branch between two volumes.

    opening  open fraction of its ports [1]

    Source  wang2017, eqs. 2.3 to 2.5; derived in docs/models/rotary-valve.md
    """
    free = law_flow(inlet.pressure - outlet.pressure, opening, law)
    choking = choking_ratio(free, inlet.pressure, law)
    flow = choked_flow(free, choking, law)
    return Branch(flow, passage(flow.flow, inlet, outlet), side(choking - 1.0))


def branch_cavitates(
    inlet: FluidState, outlet: FluidState, opening: float, law: BranchFlow, cavitation_pressure: float
) -> float:
    """Whether oil evaporates at the nozzles of a branch: 1 where their cavitation number is below the limit, else 0.

    The number is that of the nozzles' own drop, whichever way oil flows. A port that is closed has none; one that is
    nearly closed takes nearly the whole drop, and however little flows through it evaporates.

    opening              open fraction of its ports [1]
    cavitation_pressure  absolute [Pa]

    Source  merritt1967, flow through orifices; docs/design.md, "Cavitation number"
    """
    behind = inlet.pressure - law.nozzle_share * (inlet.pressure - outlet.pressure)
    drop = abs(inlet.pressure - behind)
    low = minimum(inlet.pressure, behind) - cavitation_pressure
    cavitates = select(low < CAVITATION_NUMBER * drop, 1.0, 0.0)
    open_only: float = select(opening > 0.0, cavitates, 0.0)
    return open_only


def valve_losses(
    load: Branch, tank: Branch, leak: Passage, torque: SpoolTorque, spool_speed: float
) -> RotaryValveLosses:
    """The power that each part of the valve dissipates [W].

    spool_speed  [rad/s]

    Source  ours, docs/models/rotary-valve.md
    """
    to_load, to_tank = load.passage.loss, tank.passage.loss
    return RotaryValveLosses(
        nozzle=to_load * load.law.nozzle_share + to_tank * tank.law.nozzle_share,
        centre_section=to_load * load.law.centre_share + to_tank * tank.law.centre_share,
        outlet_turbine=to_load * load.law.outlet_share + to_tank * tank.law.outlet_share,
        leakage=leak.loss,
        spool_friction=torque.friction * spool_speed,
        to_spool=-torque.turbine * spool_speed,
    )


def rotary_valve(
    inlet: FluidState,
    load: FluidState,
    tank: FluidState,
    spool: ShaftState,
    axial_position: Position,
    state: RotaryValveState,
    held: RotaryValveHeld,
    medium: Medium,
    oil: Oil,
    valve: RotaryValve,
    check: CheckPoppet,
    cavitation_pressure: Pressure = CAVITATION_PRESSURE,
) -> RotaryValveFlow:
    """Flows, torque on the spool and losses of a rotary valve at one spool angle and `axial_position` [m].

    Source  wang2017, ch. 2 and 3; derived in docs/models/rotary-valve.md
    """
    ports = shape_openings(spool.angle, axial_position, held.ports)
    edges = port_edges(spool.angle, axial_position, held.ports)
    load_drop = inlet.pressure - load.pressure
    lift = select(check.opening_time > 0.0, state.check_opening, check_opening(load_drop, check))
    openings = Openings(ports.load * lift, ports.tank)
    skew = jet_skews(spool.angle, axial_position, valve.jet_asymmetry, held.ports)
    to_load = branch(inlet, load, openings.load, held.branch)
    to_tank = branch(inlet, tank, openings.tank, held.branch)
    film = film_ratios(load.pressure, tank.pressure, oil)
    leak = passage(held.leakage_conductance * film.fluidity * (load.pressure - tank.pressure), load, tank)
    k_f = held.friction_coefficient * film.viscosity
    skews = JetSkews(skew.load * lift, skew.tank)
    torque = spool_torque(to_load.law, to_tank.law, openings, skews, spool.speed, medium.density, k_f, valve)
    return RotaryValveFlow(
        inlet=-to_load.passage.flow - to_tank.passage.flow,
        load=to_load.passage.flow - leak.flow,
        tank=to_tank.passage.flow + leak.flow,
        spool=torque.turbine - torque.friction,
        losses=valve_losses(to_load, to_tank, leak, torque, spool.speed),
        rates=RotaryValveState(check_opening_rate(load_drop, state.check_opening, check)),
        leakage=leak.flow,
        load_opening=openings.load,
        tank_opening=openings.tank,
        cavitating=maximum(
            branch_cavitates(inlet, load, openings.load, to_load.law, cavitation_pressure),
            branch_cavitates(inlet, tank, openings.tank, to_tank.law, cavitation_pressure),
        ),
        load_near=edges.load_near,
        load_far=edges.load_far,
        tank_near=edges.tank_near,
        tank_far=edges.tank_far,
        load_choke=to_load.choke,
        tank_choke=to_tank.choke,
        check=check_side(load_drop, check),
    )


def rotary_valve_inertia(valve: RotaryValve) -> Inertia:
    """Moment of inertia of its spool [kg m^2]."""
    return spool_inertia(valve)


def rotary_valve_periods(spool: ShaftState, valve: RotaryValve) -> float:
    """PWM periods since the spool's angle was zero [1]."""
    return pwm_frequency(spool.angle, valve)


ROTARY_VALVE = Component(
    rotary_valve,
    symbol="rotary-valve",
    held=rotary_valve_held,
    start=rotary_valve_start,
    inertia=rotary_valve_inertia,
    mark=rotary_valve_periods,
    averages=("leakage", "load_opening", "cavitating"),
    given_by={"axial_position": duty_position},
)
