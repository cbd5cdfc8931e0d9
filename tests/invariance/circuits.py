"""Three drawn circuits without periods: what is compiled for the tests of this folder, once each."""

from dataclasses import replace
from typing import Any

import numpy as np

from vvdp.base.tables import parsed_table, with_settings
from vvdp.evaluation.accuracy import moves
from vvdp.evaluation.quantities import summary_units
from vvdp.evaluation.summary import summary
from vvdp.simulation.run import Run, simulate
from vvdp.systems.extras import Summary
from vvdp.systems.system import System, built_system

CHARGING = """
title = "An accumulator behind a 2/2 valve, three volumes and a check valve"

[nodes]
tank = { type = "tank" }
pump_line = { type = "volume", volume = "80 cc", start = "20 bar" }
first = { type = "volume", volume = "40 cc", start = "20 bar" }
second = { type = "volume", volume = "40 cc", start = "20 bar" }
third = { type = "volume", volume = "40 cc", start = "20 bar" }

[nodes.accumulator]
type = "vessel"
oil_volume = "60 cc"
gas_volume = "150 cc"
precharge_pressure = "30 bar"
start = "40 bar"

[components]
pump = { type = "flow-source", a = "tank", b = "pump_line", flow = { step = ["20 lpm", "12 lpm"], at = "0.45 s" } }
near = { type = "orifice", a = "first", b = "second", area = "20 mm^2" }
far = { type = "orifice", a = "second", b = "third", area = "12 mm^2" }
consumer = { type = "orifice", a = "accumulator", b = "tank", area = "2.5 mm^2" }

[components.relief_valve]
type = "relief-valve"
a = "pump_line"
b = "tank"
cracking_pressure = "120 bar"
override_pressure = "10 bar"
rated_flow = "40 lpm"

[components.valve]
type = "proportional-valve"
a = "pump_line"
b = "first"
command = { table = [["0 s", "1"], ["0.35 s", "1"], ["0.35 s", "0"], ["0.5 s", "0"], ["0.5 s", "1"]] }
conductance = "3e-7 m^3/(s*Pa^0.5)"
leakage_conductance = "1e-13 m^3/(s*Pa)"
transition_pressure = "0.5 bar"
lag = "10 ms"

[components.check_valve]
type = "check-valve"
a = "third"
b = "accumulator"
cracking_pressure = "0.5 bar"
rated_drop = "3 bar"
rated_flow = "40 lpm"

[run]
until = "0.9 s"
average_from = "0.25 s"
window = "10 ms"
"""

CLAMPING = """
title = "A pump clamps a part through a 3/2 valve against a spring"

[nodes]
tank = { type = "tank" }
pump_line = { type = "volume", volume = "80 cc", start = "60 bar" }
chamber = { type = "volume", volume = "40 cc", start = "5 bar" }
back = { type = "volume", volume = "40 cc", start = "1 bar" }
shaft = { type = "driven-shaft", speed = "1500 rpm" }
rod = { type = "rod", mass = "20 kg", position = "9 mm" }

[nodes.accumulator]
type = "vessel"
oil_volume = "60 cc"
gas_volume = "150 cc"
precharge_pressure = "30 bar"
start = "60 bar"

[components]
vent = { type = "orifice", a = "back", b = "tank", area = "40 mm^2" }
consumer = { type = "orifice", a = "accumulator", b = "tank", area = "1.5 mm^2" }
spring = { type = "spring", rod = "rod", stiffness = "60 kN/m", preload = "500 N", rest_position = "0 mm" }

[components.pump]
type = "pump"
inlet = "tank"
outlet = "pump_line"
shaft = "shaft"
displacement = "10 cc/rev"
leakage_conductance = "2e-13 m^3/(s*Pa)"
friction_torque = "0.5 N*m"

[components.relief_valve]
type = "relief-valve"
a = "pump_line"
b = "tank"
cracking_pressure = "100 bar"
override_pressure = "10 bar"
rated_flow = "40 lpm"

[components.check_valve]
type = "check-valve"
a = "pump_line"
b = "accumulator"
cracking_pressure = "0.5 bar"
rated_drop = "3 bar"
rated_flow = "40 lpm"

[components.valve]
type = "switching-valve"
pressure = "chamber"
first = "accumulator"
second = "tank"
command = { table = [["0 s", "0"], ["0.15 s", "0"], ["0.15 s", "1"], ["0.55 s", "1"], ["0.55 s", "0"]] }
natural_frequency = "60 Hz"
stroke = "4 mm"
full_area = "6 mm^2"

[components.cylinder]
type = "cylinder"
a = "chamber"
b = "back"
rod = "rod"
area_a = "1256 mm^2"
area_b = "640 mm^2"
stroke = "300 mm"
moving_mass = "2 kg"
leakage_conductance = "1e-13 m^3/(s*Pa)"

[components.friction]
type = "rod-friction"
rod = "rod"
viscous_friction = "1500 N*s/m"
coulomb_friction = "100 N"
breakaway_friction = "100 N"
stribeck_velocity = "20 mm/s"
coulomb_velocity = "1 mm/s"

[run]
until = "0.9 s"
average_from = "0.25 s"
window = "10 ms"
"""

LOWERING = """
title = "A 4/3 valve moves a mass from stop to stop, fed by an accumulator"

[nodes]
tank = { type = "tank" }
chamber_a = { type = "volume", volume = "60 cc", start = "40 bar" }
chamber_b = { type = "volume", volume = "60 cc", start = "60 bar" }
rod = { type = "rod", mass = "80 kg", position = "40 mm" }

[nodes.accumulator]
type = "vessel"
oil_volume = "0.3 l"
gas_volume = "1 l"
precharge_pressure = "60 bar"
start = "120 bar"

[components]
pump = { type = "flow-source", a = "tank", b = "accumulator", flow = "6 lpm" }

[components.valve]
type = "directional-valve"
pressure = "accumulator"
tank = "tank"
a = "chamber_a"
b = "chamber_b"
command = { table = [["0 s", "0"], ["0.1 s", "0"], ["0.1 s", "1"], ["0.6 s", "1"], ["0.6 s", "-1"]] }
conductance = "1.2e-7 m^3/(s*Pa^0.5)"
overlap = "0.1"
transition_pressure = "0.5 bar"
lag = "20 ms"

[components.cylinder]
type = "cylinder"
a = "chamber_a"
b = "chamber_b"
rod = "rod"
area_a = "1256 mm^2"
area_b = "640 mm^2"
stroke = "100 mm"
moving_mass = "2 kg"
leakage_conductance = "1e-13 m^3/(s*Pa)"

[components.stop]
type = "end-stop"
rod = "rod"
lower_end = "0 mm"
upper_end = "100 mm"
stop_stiffness = "2e7 N/m"
stop_damping = "10 s/m"

[run]
until = "0.9 s"
average_from = "0.25 s"
window = "10 ms"
"""

CIRCUITS = {"charging": CHARGING, "clamping": CLAMPING, "lowering": LOWERING}


def drawn(name: str, *settings: str) -> System:
    """One of the circuits, with settings of the form table.key=value."""
    return built_system(with_settings(parsed_table(CIRCUITS[name], name), list(settings)), name)


VARIED = {
    "charging": {
        "nodes.pump_line.volume": (80.0, "cc"),
        "nodes.first.volume": (40.0, "cc"),
        "nodes.accumulator.gas_volume": (150.0, "cc"),
        "components.near.area": (20.0, "mm^2"),
        "components.consumer.area": (2.5, "mm^2"),
        "components.relief_valve.cracking_pressure": (120.0, "bar"),
    },
    "clamping": {
        "nodes.pump_line.volume": (80.0, "cc"),
        "nodes.rod.mass": (20.0, "kg"),
        "components.spring.preload": (500.0, "N"),
        "components.valve.full_area": (6.0, "mm^2"),
        "components.consumer.area": (1.5, "mm^2"),
        "components.pump.displacement": (10.0, "cc/rev"),
    },
    "lowering": {
        "nodes.chamber_a.volume": (60.0, "cc"),
        "nodes.rod.mass": (80.0, "kg"),
        "nodes.accumulator.gas_volume": (1.0, "l"),
        "components.valve.lag": (20.0, "ms"),
        "components.pump.flow": (6.0, "lpm"),
        "components.cylinder.area_b": (640.0, "mm^2"),
    },
}

IMPACT = 5e-4
"""What an impact on an elastic stop loses is known this well at the usual tolerance: its milliseconds are few steps."""


def varied(name: str, seed: int) -> list[str]:
    """Settings that make each of some values of a circuit up to 30 % smaller or larger."""
    rng = np.random.default_rng(seed)
    return [f"{key}={value * rng.uniform(0.7, 1.3):.6g} {unit}" for key, (value, unit) in VARIED[name].items()]


def found(system: System, run: Run) -> Summary:
    """All numbers of a run but for how long it took."""
    return {key: value for key, value in summary(system, run).items() if key != "wall_time_s"}


def numbers(name: str, *settings: str, **stepping: Any) -> Summary:
    """The numbers of a circuit with these settings and changes of the stepping."""
    system = drawn(name, *settings)
    return found(system, simulate(system.model, system.case, replace(system.stepping, **stepping)))


def changes(name: str, one: Summary, other: Summary, limit: float) -> list[str]:
    """What of two summaries differs by more than `limit` of itself, or of a thousandth of the largest of its unit."""
    limits = {"loss_stop_W": max(limit, IMPACT)}
    return [
        f"{each.key}: {each.change:.2g}"
        for each in moves(one, other, summary_units(drawn(name)))
        if each.change > limits.get(each.key, limit)
    ]
