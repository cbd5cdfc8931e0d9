"""The whole machine led by the position loop of its rivals, in place of the laws of chapter 6.

Source  ours, docs/circuits-compared.md
"""

from vvdp.base.params import Params
from vvdp.control.displacement import DisplacementDemand, idle_demand
from vvdp.control.pressure_modes import Guards
from vvdp.programs.machine.loop import (
    MachineCommand,
    MachineLoop,
    MachineMemory,
    MachinePlace,
    carried_out,
    machine_start,
    machine_view,
)
from vvdp.programs.machine.phases import orders_of
from vvdp.programs.position_loop import (
    Joint,
    LoopMemory,
    LoopTable,
    OneWay,
    PositionLaw,
    Pressures,
    loop_gain,
    one_way_actuation,
)


class CommonLoop(Params):
    """What the program works with: the machine with its stages and its flow map, and the law of the position loop."""

    machine: MachineLoop
    law: PositionLaw

    @property
    def command_range(self) -> dict[str, tuple[float, float]]:
        """That of the machine."""
        return self.machine.command_range


def common_law(machine: MachineLoop, table: LoopTable) -> PositionLaw:
    """The law of a rival with the cylinder, the throttle and the pump that the machine's control takes for granted."""
    model, split = machine.law.cylinder, machine.law.split
    return PositionLaw(
        table=table,
        position_gain=loop_gain(model.viscous_friction, model.moving_mass, table.gain_margin),
        area_a=model.area_a,
        area_b=model.area_b,
        reference_pressure=model.tank_pressure,
        largest_flow=split.largest_flow,
        valve_conductance=model.return_conductance,
    )


def common_start(settings: CommonLoop) -> MachineMemory:
    """The memory before the first sample."""
    return machine_start(settings.machine)


def common_step(
    t: float, memory: MachineMemory, place: MachinePlace, settings: CommonLoop
) -> tuple[MachineMemory, MachineCommand]:
    """Program: one sample of the machine's outer loop; while the cylinder is controlled, as `one_way_step`.

    Pressures are averages over a PWM period, where the rivals have a first-order filter.
    """
    view = machine_view(memory, place, settings.machine)
    demand = idle_demand()
    if orders_of(view.phase.number).controlled > 0.0:
        side = memory.direction if memory.direction != 0.0 else settings.machine.first_direction
        slow = view.seen.slow
        known = LoopMemory(
            view.reference, Pressures(slow.pressure_a, slow.pressure_b, slow.line_pressure), Joint(side, side)
        )
        demand = asked_of(one_way_actuation(known, place.position, settings.law))
    return carried_out(memory, view, memory.law, demand, settings.machine)


def asked_of(found: OneWay) -> DisplacementDemand:
    """What a position loop asks of the drives, as a demand: no bound of a pressure acts, no effort is shared."""
    return DisplacementDemand(
        direction=found.side,
        opening=found.opening,
        flow=found.flow,
        effort=0.0,
        force_error=0.0,
        mode=1.0,
        guards=Guards(0.0, 0.0, 0.0, 0.0),
        saturated=0.0,
        split_flow=found.flow,
    )
