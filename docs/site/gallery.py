"""Writes the gallery: every shipped system with its circuit and three numbers. `python docs/site/gallery.py`"""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from vvdp.base.kinds import (
    FLOW,
    FRACTION,
    FREQUENCY,
    LENGTH,
    POSITION,
    POWER,
    PRESSURE_DIFFERENCE,
    SPEED,
    VELOCITY,
    Kind,
)
from vvdp.base.units import in_unit
from vvdp.evaluation.summary import summary
from vvdp.report.circuit import graph_of
from vvdp.report.diagram import diagram
from vvdp.simulation.run import simulate
from vvdp.systems.system import System, load_system, shipped_systems

DOCS = Path(__file__).parents[1]
PICTURES = Path("images") / "systems"
HEAD = """# Gallery of systems

Every system that comes with vvdp, its circuit and three numbers of its run. `vvdp run NAME` simulates one and writes
its report; `vvdp new mine --from NAME` makes a file of it to edit. Pressures are gauge. Twelve
[circuits from practice](practice.md) are on a page of their own.
"""


class Number(NamedTuple):
    """One number of a run and how it is shown."""

    label: str
    key: str
    kind: Kind
    unit: str


class Entry(NamedTuple):
    """What the gallery says of a system."""

    text: str
    numbers: tuple[Number, Number, Number]


PUMP_NUMBERS = (
    Number("PWM frequency", "pwm_frequency_Hz", FREQUENCY, "Hz"),
    Number("mean flow to the load", "mean_load_flow_m3_s", FLOW, "lpm"),
    Number("efficiency, pump shaft to load", "efficiency", FRACTION, "%"),
)
HELD_NUMBERS = (
    Number("position against the reference, rms", "spool_position_error_rms_m", LENGTH, "um"),
    Number("error of the estimate, rms", "spool_estimate_error_rms_m", LENGTH, "um"),
    Number("periodic sensor error of the sensor, rms", "pollution_rms_m", LENGTH, "um"),
)
MACHINE_NUMBERS = (
    Number("largest error against the filtered reference", "tracking_error_max_m", LENGTH, "mm"),
    Number("PWM frequency", "pwm_frequency_Hz", FREQUENCY, "Hz"),
    Number("power of the pump", "pump_power_mean_W", POWER, "kW"),
)
DRAWN = Number("mean power of the pump", "power_pump_W", POWER, "W")
HIGHEST_B = Number("highest pressure in chamber B", "pressure_max_chamber_b_Pa", PRESSURE_DIFFERENCE, "bar")
LOWEST_B = Number("lowest pressure in chamber B", "pressure_min_chamber_b_Pa", PRESSURE_DIFFERENCE, "bar")
CHARGE = Number("mean power of the charge pump", "power_charge_pump_W", POWER, "W")
ENTRIES: Mapping[str, Entry] = {
    "prototype": Entry(
        "The published prototype on its test rig. A rotary valve, kept spinning by its own flow, switches a fixed "
        "pump between the load and the tank. [Details](models/rotary-valve.md)",
        PUMP_NUMBERS,
    ),
    "prototype-constant-load": Entry(
        "The same pump unit against a load of constant pressure, as a large accumulator would be.",
        PUMP_NUMBERS,
    ),
    "buck-converter": Entry(
        "Steps a pressure down without throttling: while the valve is closed, the oil in the tube keeps moving and is "
        "drawn from the tank. [By hand](examples.md#buck-converter)",
        (
            Number("mean flow to the load", "flow_mean_tube_m3_s", FLOW, "lpm"),
            Number("mean flow from the supply", "flow_mean_valve_m3_s", FLOW, "lpm"),
            Number("power from the supply", "power_supply_W", POWER, "kW"),
        ),
    ),
    "boost-converter": Entry(
        "Raises a pressure without a pump: oil that is moving in a tube is stopped and pushes through a check valve. "
        "[By hand](examples.md#boost-converter)",
        (
            Number("mean load pressure", "pressure_mean_load_Pa", PRESSURE_DIFFERENCE, "bar"),
            Number("mean flow to the load", "flow_mean_load_orifice_m3_s", FLOW, "lpm"),
            Number("power from the supply", "power_supply_W", POWER, "kW"),
        ),
    ),
    "accumulator-charging": Entry(
        "A pump charges an accumulator and is unloaded while it is full. A program that events call keeps the two "
        "pressures. [By hand](examples.md#accumulator-charging)",
        (
            Number("highest pressure in the accumulator", "pressure_max_accumulator_Pa", PRESSURE_DIFFERENCE, "bar"),
            Number("mean flow to the consumer", "flow_mean_consumer_m3_s", FLOW, "lpm"),
            Number("mean power at the shaft", "power_shaft_W", POWER, "kW"),
        ),
    ),
    "cylinder-stops": Entry(
        "A cylinder lifts 300 kg against its upper end stop and drives them back onto the lower one. "
        "[By hand](examples.md#cylinder-stops)",
        (
            Number("highest position of the rod", "position_max_rod_m", POSITION, "mm"),
            Number("fastest downward speed", "velocity_min_rod_m_s", VELOCITY, "m/s"),
            Number("highest pressure in the pump line", "pressure_max_pump_line_Pa", PRESSURE_DIFFERENCE, "bar"),
        ),
    ),
    "axial-chamber": Entry(
        "One chamber against a spring moves the spool of a rotary valve along its axis. Without current the spring "
        "takes it to its stop. [Details](models/axial-drives.md)",
        (
            Number("highest position of the spool", "position_max_drive_slide_m", POSITION, "mm"),
            Number("position that the supply holds", "axial_reach_m", POSITION, "mm"),
            Number("highest pressure in it", "pressure_max_drive_pilot_chamber_Pa", PRESSURE_DIFFERENCE, "bar"),
        ),
    ),
    "axial-gerotor": Entry(
        "A gerotor pump between both ends moves the spool of a rotary valve along its axis, to the duty ratio that is "
        "asked, past a dead band and an optical sensor that every turn pollutes. [Details](models/gerotor-control.md)",
        HELD_NUMBERS,
    ),
    "vvdp-duty-control": Entry(
        "The pump unit with its duty ratio held: a pressure chamber moves the spool against a spring. "
        "[Details](models/axial-control.md)",
        HELD_NUMBERS,
    ),
    "vvdp-duty-control-gerotor": Entry(
        "The same with the gerotor pump of the first axial drive. [Details](models/gerotor-control.md)",
        HELD_NUMBERS,
    ),
    "displacement-chapter6": Entry(
        "A cylinder goes up and down while a slow pump and a fast return valve share what its controller asks for. "
        "[Details](models/displacement-chapter6.md)",
        (
            Number("largest error against the filtered reference", "tracking_error_max_m", LENGTH, "mm"),
            Number("highest pressure under control", "pressure_max_Pa", PRESSURE_DIFFERENCE, "bar"),
            Number("opening of the return valve, mean", "return_opening_mean", FRACTION, "%"),
        ),
    ),
    "displacement-control": Entry(
        "The whole machine moves a cylinder: fixed pump, self-spinning rotary valve with its axial drive, encoder and "
        "observers, directional valve and throttled return, from homing to control. [Details](models/whole-machine.md)",
        MACHINE_NUMBERS,
    ),
    "displacement-control-gerotor": Entry(
        "The same with the gerotor pump as axial drive, and a dump valve. [Details](models/whole-machine.md)",
        MACHINE_NUMBERS,
    ),
    "throttle-control": Entry(
        "A rival of the machine: a fixed pump at its relief valve, and a 4/3 proportional valve. "
        "[Compared](circuits-compared.md)",
        (
            Number("mean power of the pump", "power_pump_shaft_W", POWER, "kW"),
            Number("highest pressure of the supply", "pressure_max_supply_Pa", PRESSURE_DIFFERENCE, "bar"),
            HIGHEST_B,
        ),
    ),
    "flow-control-unit": Entry(
        "The machine's circuit with five on/off valves in parallel instead of the rotary one: 32 flows. "
        "[When it pays](when-switching-pays.md)",
        (
            Number("mean power of the pump", "power_pump_shaft_W", POWER, "kW"),
            Number("highest pressure of the line", "pressure_max_supply_Pa", PRESSURE_DIFFERENCE, "bar"),
            HIGHEST_B,
        ),
    ),
    "linear-valves": Entry(
        "The machine's circuit with fast linear on/off valves at 75 Hz instead of the rotary one. "
        "[When it pays](when-switching-pays.md)",
        (
            Number("mean power of the pump", "power_pump_shaft_W", POWER, "kW"),
            Number("highest pressure of the line", "pressure_max_supply_Pa", PRESSURE_DIFFERENCE, "bar"),
            HIGHEST_B,
        ),
    ),
    "ideal-pump-control": Entry(
        "A pump that delivers what the cylinder takes, at the pressure that it has; the return is throttled. "
        "[Compared](circuits-compared.md)",
        (
            DRAWN,
            Number("highest pressure of the supply", "pressure_max_supply_Pa", PRESSURE_DIFFERENCE, "bar"),
            HIGHEST_B,
        ),
    ),
    "measured-pump-control": Entry(
        "The same by an axial piston pump with the losses of a measured one. [Compared](circuits-compared.md)",
        (
            Number("mean power of the pump", "power_pump_shaft_W", POWER, "W"),
            Number("lost by friction of the pump", "loss_pump_friction_W", POWER, "W"),
            HIGHEST_B,
        ),
    ),
    "digital-pump-control": Entry(
        "The same by a digital displacement pump: twelve pistons deliver or idle one by one. "
        "[Compared](circuits-compared.md)",
        (
            Number("mean power of the pump", "power_pump_shaft_W", POWER, "W"),
            Number("lost over its inlet valves", "loss_pump_breathing_W", POWER, "W"),
            HIGHEST_B,
        ),
    ),
    "bleed-off-control": Entry(
        "A fixed pump at the pressure of its load: a throttle beside the cylinder lets to the tank what that does not "
        "take. [Compared](circuits-compared.md)",
        (
            Number("mean power of the pump", "power_pump_shaft_W", POWER, "W"),
            Number("lost over the throttle", "loss_bleed_valve_W", POWER, "W"),
            HIGHEST_B,
        ),
    ),
    "load-sensing": Entry(
        "A variable pump 20 bar above the highest load, for one to three cylinders behind pressure compensators. "
        "[Compared](circuits-compared.md)",
        (
            Number("mean power of the pump", "power_pump_shaft_W", POWER, "W"),
            Number("mean pressure of the pump", "pressure_mean_pump_line_Pa", PRESSURE_DIFFERENCE, "bar"),
            Number("mean pressure behind the throttle", "pressure_mean_supply_Pa", PRESSURE_DIFFERENCE, "bar"),
        ),
    ),
    "independent-valves": Entry(
        "Independent metering: a variable pump 10 bar above the chamber that is fed, four proportional valves at the "
        "cylinder. [Compared](circuits-compared.md)",
        (
            Number("mean power of the pump", "power_pump_shaft_W", POWER, "W"),
            Number("mean pressure of the pump", "pressure_mean_pump_line_Pa", PRESSURE_DIFFERENCE, "bar"),
            HIGHEST_B,
        ),
    ),
    "independent-units": Entry(
        "The same with four digital flow control units, five on/off valves each. [Compared](circuits-compared.md)",
        (
            Number("mean power of the pump", "power_pump_shaft_W", POWER, "W"),
            Number("mean pressure of the pump", "pressure_mean_pump_line_Pa", PRESSURE_DIFFERENCE, "bar"),
            HIGHEST_B,
        ),
    ),
    "shuttle-circuit": Entry(
        "A closed circuit: an overcentre pump between both chambers, a shuttle valve joins the low side to a charge "
        "pump. [Compared](circuits-compared.md)",
        (DRAWN, CHARGE, LOWEST_B),
    ),
    "pilot-check-circuit": Entry(
        "The same with pilot-operated check valves in place of the shuttle valve. [Compared](circuits-compared.md)",
        (DRAWN, CHARGE, LOWEST_B),
    ),
    "four-valve-circuit": Entry(
        "An open circuit: four 2-way valves join an overcentre pump to either chamber. "
        "[Compared](circuits-compared.md)",
        (DRAWN, HIGHEST_B, LOWEST_B),
    ),
    "long-hose": Entry(
        "Two pumps feed a hose of 10 m from both ends. An orifice at one end is halved, and the wave runs to and fro. "
        "[By hand](examples.md#long-hose)",
        (
            Number("highest pressure on the left", "pressure_max_left_Pa", PRESSURE_DIFFERENCE, "bar"),
            Number("highest pressure on the right", "pressure_max_right_Pa", PRESSURE_DIFFERENCE, "bar"),
            Number("mean flow through the orifice", "flow_mean_orifice_m3_s", FLOW, "lpm"),
        ),
    ),
    "hydrostatic-transmission": Entry(
        "A closed circuit with charge pump, shock valves and case leakage drives a shaft under load. "
        "[By hand](examples.md#hydrostatic-transmission)",
        (
            Number("mean speed of the motor", "speed_mean_motor_shaft_rad_s", SPEED, "rpm"),
            Number("mean pressure on the high side", "pressure_mean_high_Pa", PRESSURE_DIFFERENCE, "bar"),
            Number("mean power at the pump shaft", "power_pump_shaft_W", POWER, "kW"),
        ),
    ),
    "two-cylinders": Entry(
        "Two cylinders with different loads on one motor, each with a pump unit of its own, built from two shipped "
        "[parts](parts.md#an-example).",
        (
            Number("mean power at the motor shaft", "power_motor_W", POWER, "kW"),
            Number("mean loss of the pump unit for the heavy load", "loss_lift_unit_W", POWER, "kW"),
            Number("mean loss of the pump unit for the light load", "loss_swing_unit_W", POWER, "kW"),
        ),
    ),
    "shared-supply": Entry(
        "Two cylinders take turns on one pump unit, a proportional valve and a directional valve each, built from "
        "shipped [parts](parts.md).",
        (
            Number("mean power at the motor shaft", "power_motor_W", POWER, "kW"),
            Number("mean loss of the pump unit", "loss_unit_W", POWER, "kW"),
            Number("PWM frequency of the unit", "unit_pwm_frequency_Hz", FREQUENCY, "Hz"),
        ),
    ),
    "transmission-speed-control": Entry(
        "A PI controller holds the speed of a motor by the axial position of the rotary valve, while the load doubles. "
        "Built from a shipped [part](parts.md) and [programs](programs.md).",
        (
            Number("mean speed of the motor", "speed_mean_flywheel_rad_s", SPEED, "rpm"),
            Number("mean power at the pump shaft", "power_drive_W", POWER, "kW"),
            Number("mean loss of the pump unit", "loss_unit_W", POWER, "kW"),
        ),
    ),
}


def section(name: str, system: System) -> str:
    """What the page shows of one system, after a run of it."""
    found = summary(system, simulate(system.model, system.case, system.stepping))
    entry = ENTRIES[name]
    values = [in_unit(float(found[number.key]), number.kind, number.unit) for number in entry.numbers]
    rows = [f"| {n.label} | {value:#.4g} {n.unit} |" for n, value in zip(entry.numbers, values, strict=True)]
    return "\n".join(
        [
            f"## {system.title}\n",
            f"{entry.text}\n",
            f"![Circuit of {name}]({(PICTURES / name).as_posix()}.svg)\n",
            f"| `vvdp run {name}` | |",
            "| --- | --- |",
            *rows,
            "",
        ]
    )


def circuit(system: System) -> str:
    """The picture of a system's circuit as SVG."""
    return diagram(graph_of(system.circuit.network, system.title))


def main(folder: Path = DOCS) -> None:
    """Writes the page and the pictures below `folder`, those of the circuits from practice as well.

    Raises KeyError for a shipped system without an entry.
    """
    systems = {name: load_system(name) for name in sorted(shipped_systems(), key=list(ENTRIES).index)}
    practice = {name: load_system(name) for name in shipped_systems("practice")}
    (folder / PICTURES).mkdir(parents=True, exist_ok=True)
    for name, system in (systems | practice).items():
        (folder / PICTURES / f"{name}.svg").write_text(circuit(system), "utf-8")
    page = "\n".join([HEAD, *(section(name, system) for name, system in systems.items())])
    (folder / "gallery.md").write_text(page, "utf-8")


if __name__ == "__main__":
    main()
