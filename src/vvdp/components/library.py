"""The library by the names that a system file uses."""

from collections.abc import Mapping

from vvdp.base.kinds import (
    AirFraction,
    BulkModulus,
    Density,
    KinematicViscosity,
    Polytropic,
    Pressure,
    ThermalExpansion,
)
from vvdp.components.accumulators import GAS_ACCUMULATOR, PISTON_ACCUMULATOR, SPRING_ACCUMULATOR
from vvdp.components.balanced_valves import (
    BRAKE_VALVE,
    CARTRIDGE_VALVE,
    COUNTERBALANCE_VALVE,
    DOWNSTREAM_COMPENSATOR,
    PRIORITY_VALVE,
    SEQUENCE_VALVE,
    UPSTREAM_COMPENSATOR,
)
from vvdp.components.controlled_valves import (
    COMPENSATED_THROTTLE,
    DUMP_VALVE,
    METERING_VALVE,
    PROPORTIONAL_VALVE,
    SERIES_THROTTLES,
    UNLOADING_VALVE,
)
from vvdp.components.cylinders import CUSHION, TELESCOPIC_CYLINDER
from vvdp.components.delay_lines import DELAY_LINE
from vvdp.components.directed_flows import DIRECTED_RETURN, DIRECTED_SOURCE
from vvdp.components.directional_valves import (
    DIRECTIONAL_VALVE,
    THREE_WAY_PROPORTIONAL_VALVE,
    THROTTLED_DIRECTIONAL_VALVE,
)
from vvdp.components.drives import DRIVE_COUPLING
from vvdp.components.flow_control_units import UNIT_VALVE
from vvdp.components.flow_sources import FLOW_SOURCE
from vvdp.components.four_way_valves import FOUR_WAY_VALVE, LOAD_SENSING_VALVE, SIX_WAY_VALVE
from vvdp.components.gerotor_drives import CALIBRATED_GEROTOR_DRIVE, GEROTOR_DRIVE
from vvdp.components.lines import COLUMN, LINE
from vvdp.components.linkages import ARM, DRUM, GEAR, LEVER, ROAD_LOAD, STICK_FRICTION, WHEEL
from vvdp.components.machines import CONTROLLED_PUMP, MOTOR, PUMP
from vvdp.components.oil_care import COOLER, FILTER, TANK_WITH_LEVEL
from vvdp.components.pipes import LAYERED_PIPE, PIPE
from vvdp.components.prime_movers import DIESEL_ENGINE, ELECTRIC_MOTOR
from vvdp.components.pump_compensators import PUMP_COMPENSATOR
from vvdp.components.resistances import LAMINAR_GAP, ORIFICE
from vvdp.components.rods import CYLINDER, END_STOP, LOAD_FORCE, PLUNGER, ROD_BRAKE, ROD_FRICTION, SPRING, WEIGHT
from vvdp.components.rotary_valve import ROTARY_VALVE
from vvdp.components.self_acting_valves import (
    CHECK_VALVE,
    FLOW_CONTROL_VALVE,
    LOAD_RELIEF_VALVE,
    PILOT_CHECK_VALVE,
    PILOT_CLOSED_CHECK_VALVE,
    POPPET_VALVE,
    REDUCING_VALVE,
    RELIEF_VALVE,
    SHOCK_VALVE,
    SHUTTLE_VALVE,
)
from vvdp.components.shafts import LOAD_TORQUE, ROTOR, SHAFT_BRAKE, SHAFT_FRICTION, TORSION_SPRING
from vvdp.components.switching_valves import (
    MODULATED_SWITCHING_VALVE,
    MODULATED_TWO_WAY_VALVE,
    PULSED_SWITCHING_VALVE,
    PULSED_TWO_WAY_VALVE,
    SWITCHING_VALVE,
    TWO_WAY_VALVE,
)
from vvdp.components.variable_machines import MEASURED_MOTOR, MEASURED_PUMP, VARIABLE_MOTOR, VARIABLE_PUMP
from vvdp.fluid.oil import Oil
from vvdp.network.assembly import Assembly
from vvdp.network.component import Component


class UsualOil(Oil):
    """A mineral oil of viscosity grade 46 with 1 % of free air, where a file gives no other values.

    Source  wang2017, section 2.3.1 (density, viscosity at 40 degC); the others are usual values, assumed
    """

    density: Density = 876.0
    thermal_expansion: ThermalExpansion = 7e-4
    viscosity_40: KinematicViscosity = 44.1780822e-6
    viscosity_100: KinematicViscosity = 6.65e-6
    liquid_bulk_modulus: BulkModulus = 1.4e9
    air_fraction: AirFraction = 0.01
    polytropic_exponent: Polytropic = 1.4
    reference_pressure: Pressure = 101325.0


def _by_name(*components: Component | Assembly) -> Mapping[str, Component | Assembly]:
    return {component.name.replace("_", "-"): component for component in components}


COMPONENTS = _by_name(
    ARM,
    BRAKE_VALVE,
    CALIBRATED_GEROTOR_DRIVE,
    CARTRIDGE_VALVE,
    CHECK_VALVE,
    COLUMN,
    COMPENSATED_THROTTLE,
    CONTROLLED_PUMP,
    COOLER,
    COUNTERBALANCE_VALVE,
    CUSHION,
    CYLINDER,
    DELAY_LINE,
    DIESEL_ENGINE,
    DIRECTED_RETURN,
    DIRECTED_SOURCE,
    DIRECTIONAL_VALVE,
    DOWNSTREAM_COMPENSATOR,
    DRIVE_COUPLING,
    DRUM,
    DUMP_VALVE,
    ELECTRIC_MOTOR,
    END_STOP,
    FILTER,
    FLOW_CONTROL_VALVE,
    FLOW_SOURCE,
    FOUR_WAY_VALVE,
    GAS_ACCUMULATOR,
    GEAR,
    GEROTOR_DRIVE,
    LAMINAR_GAP,
    LAYERED_PIPE,
    LEVER,
    LINE,
    LOAD_FORCE,
    LOAD_RELIEF_VALVE,
    LOAD_SENSING_VALVE,
    LOAD_TORQUE,
    MEASURED_MOTOR,
    MEASURED_PUMP,
    METERING_VALVE,
    MODULATED_SWITCHING_VALVE,
    MODULATED_TWO_WAY_VALVE,
    MOTOR,
    ORIFICE,
    PILOT_CHECK_VALVE,
    PILOT_CLOSED_CHECK_VALVE,
    PIPE,
    PISTON_ACCUMULATOR,
    PLUNGER,
    POPPET_VALVE,
    PRIORITY_VALVE,
    PROPORTIONAL_VALVE,
    PULSED_SWITCHING_VALVE,
    PULSED_TWO_WAY_VALVE,
    PUMP,
    PUMP_COMPENSATOR,
    REDUCING_VALVE,
    RELIEF_VALVE,
    ROAD_LOAD,
    ROD_BRAKE,
    ROD_FRICTION,
    ROTARY_VALVE,
    ROTOR,
    SEQUENCE_VALVE,
    SERIES_THROTTLES,
    SHAFT_BRAKE,
    SHAFT_FRICTION,
    SHOCK_VALVE,
    SHUTTLE_VALVE,
    SIX_WAY_VALVE,
    SPRING,
    SPRING_ACCUMULATOR,
    STICK_FRICTION,
    SWITCHING_VALVE,
    TANK_WITH_LEVEL,
    TELESCOPIC_CYLINDER,
    THREE_WAY_PROPORTIONAL_VALVE,
    THROTTLED_DIRECTIONAL_VALVE,
    TORSION_SPRING,
    TWO_WAY_VALVE,
    UNIT_VALVE,
    UNLOADING_VALVE,
    UPSTREAM_COMPENSATOR,
    VARIABLE_MOTOR,
    VARIABLE_PUMP,
    WEIGHT,
    WHEEL,
)
"""Components that a system file can name, by their type."""
