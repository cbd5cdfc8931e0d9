"""The pump unit of a rotary valve taken out of a circuit and put on a test rig: against the pressure of a source, or
with the line that it feeds and an orifice that holds its pressure.

The rig is a system like any other: a text with the values that the file of the circuit gives, with origin and range.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

from vvdp.base.errors import ConfigError, Fault
from vvdp.base.kinds import ANGLE, AREA, COUPLING, DUTY_RATIO, POWER, PRESSURE_LEVEL, SPEED, TEMPERATURE, VOLUME, Kind
from vvdp.base.params import Params, default_values, field_kinds, field_names
from vvdp.base.tables import Table
from vvdp.evaluation.bench import Operation
from vvdp.evaluation.bench_parts import is_bench
from vvdp.evaluation.rig_drawing import drawing, full_path
from vvdp.evaluation.valve_numbers import PlacedValve
from vvdp.evaluation.valve_unit import ValveUnit, at_start, chosen_valve, neighbour, start_numbers, valve_unit
from vvdp.fluid.oil import Oil, density
from vvdp.geometry.shape_tables import NAME as SHAPE
from vvdp.hydraulics.check_valve import CheckPoppet, CheckValve
from vvdp.hydraulics.orifice import Orifice, orifice_area_for
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.hydraulics.spool_drive import SpoolDrive
from vvdp.hydraulics.volume import Vessel
from vvdp.network.component import Component
from vvdp.network.network import Part
from vvdp.network.nodes import Chamber, DrivenShaft, Node, OilVolume
from vvdp.simulation.values import names
from vvdp.systems.changed import exact_text
from vvdp.systems.fault_tables import FAULTS
from vvdp.systems.part_scopes import Entries
from vvdp.systems.short_paths import with_full_paths
from vvdp.systems.system import System, built_system

STIFF_COUPLING = 1.0
"""Of a motor that holds the spool at its own speed [N m s]."""
HALF = 0.5
"""Duty ratio of a unit whose circuit starts with a port closed; share of the relief setting if it has no load then;
share of the pump flow through the orifice if the circuit has none. All assumed."""


def unit_on_rig(system: System, verb: str, part: str = "") -> System:
    """A test rig with the pump unit of a rotary valve; the system itself if it is one.

    The rig prescribes what the file of the circuit does. Otherwise it holds what the circuit has at the start of its
    run: oil temperature, tank pressure, pump speed (the rated one if the motor stands then), load pressure (half the
    relief setting if there is none) and duty ratio (a half if a port is closed).

    verb  that needs the rig, for messages
    part  name of the valve where there are several, or of the part that it is alone in

    Raises ConfigError if there is none, or if its inlet or spool joins what a rig does not have.
    """
    placed = chosen_valve(system, verb, part)
    if _is_rig(system):
        return system
    rig = _Rig(system, placed, valve_unit(system, verb, placed.name))
    rig.refuse_others(verb)
    name = system.name if is_bench(system) else f"{system.name}-{placed.name}"
    return built_system(Table(system.name, rig.content, {}), name, system.folder)


def _is_rig(system: System) -> bool:
    """Whether a system is a rig already: without programs, and with the paths of rigs in its file."""
    network, known = system.circuit.network, {row.setting for row in system.rows}
    if not is_bench(system) or network.programs or "coupling" not in network.parts:
        return False
    short = with_full_paths(system.table, []).short
    asked = {f"operation.{name}" for name in Operation._fields}
    return known >= asked and all(full_path(outer, network) == full for full, outer in short.items())


def is_meter(component: Component) -> bool:
    """Whether a component only measures: it acts on none of its nodes."""
    acts = {"flow", *component.ports} & set(names(component.result))
    return not acts and component.walls is None and component.stored is None and component.inertia is None


class _File(NamedTuple):
    """Values of oil, nodes and components in the file of a circuit, each with its full path."""

    system: System
    content: Entries

    def component(self, part: Part, values: Params) -> Entries:
        """Of the values of a component: in its own table, or in one of the circuit's."""
        shared = next((name for name, table in self.system.tables.items() if table is values), "")
        return self.table("components", part.name) or self.table(shared)

    def node(self, name: str) -> Entries:
        """Of a node."""
        return self.table("nodes", name) or self.table(name)

    def oil(self, node: str) -> Entries:
        """Of the oil in a node."""
        return self.table("oils", self.node(node).get("oil", "")) or self.table("oil")

    def table(self, *names: str) -> Entries:
        """A table by its path; empty if there is none."""
        found: Any = self.content
        for name in names:
            found = found.get(name, {})
        return {**found}


class _Rig:
    """Sources of the text of a rig: a unit, and the circuit that it is taken from."""

    def __init__(self, system: System, placed: PlacedValve, unit: ValveUnit) -> None:
        full = with_full_paths(system.table, []).table.content
        self.system, self.placed, self.unit, self.file = system, placed, unit, _File(system, full)
        self.network, self.nodes = system.circuit.network, placed.part.nodes
        self.start, self.line = start_numbers(system), _line(self.network.nodes[self.nodes["load"]])
        inlet, spool = self.nodes["inlet"], self.nodes["spool"]
        poppet = next(each for each in placed.part.values if isinstance(each, CheckPoppet))
        bypass = neighbour(self.network, CheckValve, "a", inlet)
        found: dict[str, tuple[Part, Params] | None] = {
            "pump": neighbour(self.network, Pump, "outlet", inlet),
            "relief_valve": neighbour(self.network, ReliefValve, "a", inlet),
            "valve": (placed.part, unit.valve),
            "check_valve": (placed.part, poppet),
            "spool_drive": neighbour(self.network, SpoolDrive, "spool", spool),
            "bypass": bypass if bypass and bypass[0].nodes["b"] == self.nodes["load"] else None,
        }
        self.parts = {name: each for name, each in found.items() if each is not None}
        self.pump_speed = _pump_speed(self)

    def refuse_others(self, verb: str) -> None:
        """Raises ConfigError if more than meters is joined to inlet and spool beside what the rig has."""
        own, ends = {part.name for part, _ in self.parts.values()}, {self.nodes["inlet"], self.nodes["spool"]}
        own |= {each.name for each in self.system.faults} if is_bench(self.system) else set()
        others = [
            part.name
            for part in self.network.parts.values()
            if part.name not in own and ends & {*part.nodes.values()} and not is_meter(part.component)
        ]
        if others:
            message = (
                f"`vvdp {verb}` puts the pump unit of {self.placed.name!r} on a test rig, which has no place for "
                f"{', '.join(others)} at its inlet or its spool"
            )
            raise ConfigError([Fault(self.system.name, 0, "", message)])

    @property
    def content(self) -> Entries:
        """The tables of the rig."""
        given, unit, system = self.system.content, self.unit, self.system
        title = f"{system.title}: pump unit of {self.placed.name.replace('_', ' ')} on a test rig"
        cavitation = at_start(self.placed.part.inputs["cavitation_pressure"], self.start)
        inlet = self.file.node(self.nodes["inlet"]).get(
            "volume", _value(unit.inlet_volume, VOLUME, "as in the circuit")
        )
        return {
            "title": system.title if is_bench(system) else title,
            **drawing({"coupling", *self.parts}, has_line=self.line is not None),
            "oil": _entries(unit.oil, self.file.oil(self.nodes["inlet"]), Oil),
            "spool_drive": {"coupling": _coupling(self)},
            **{
                name: _entries(values, self.file.component(part, values), type(values))
                for name, (part, values) in self.parts.items()
            },
            "motor": {"rated_power": self._rated_power},
            "inlet": {"volume": inlet},
            **_load(self),
            "operation": _operation(self),
            "limits": {"cavitation_pressure": _at_start(cavitation, PRESSURE_LEVEL), **given.get("limits", {})},
            **{name: given[name] for name in (SHAPE, *([FAULTS] if is_bench(system) else [])) if name in given},
            "run": given["run"],
        }

    @property
    def _rated_power(self) -> Any:
        """The entry of the rated power of the pump's motor; without one that of the pump flow at the relief setting."""
        unit, shaft = self.unit, self.parts["pump"][0].nodes["shaft"]
        rated = unit.pump.displacement * self.pump_speed * (unit.relief_valve.cracking_pressure - unit.tank_pressure)
        usual = _value(rated, POWER, "the whole pump flow at the setting of the relief valve")
        return self.file.node(shaft).get("rated_power", usual)

    def entry(self, node: str, key: str, otherwise: Entries) -> Any:
        """The entry of what the file prescribes at a node over time; another one if it says nothing or a path."""
        entry = self.file.node(node).get(key, otherwise)
        return otherwise if isinstance(entry, Mapping) and "from" in entry else entry


def _operation(rig: _Rig) -> Entries:
    """What the rig holds: as the file has it where it states it, else as at the start."""
    unit, drive = rig.unit, rig.parts.get("spool_drive")
    turning = drive[0].nodes["motor"] if drive else rig.nodes["spool"]
    node, pump = rig.network.nodes[turning], rig.parts["pump"][0].nodes["shaft"]
    motor = _at_start(at_start(node.speed, rig.start) if isinstance(node, DrivenShaft) else 0.0, SPEED)
    speed, own = _at_start(rig.pump_speed, SPEED), rig.system.content.get("operation", {})
    return {
        "pump_speed": speed if rig.pump_speed != unit.pump_speed else rig.entry(pump, "speed", speed),
        "oil_temperature": own.get("oil_temperature", _at_start(unit.temperature, TEMPERATURE)),
        **_position(rig),
        "spool_motor_speed": rig.entry(turning, "speed", motor) if isinstance(node, DrivenShaft) else motor,
        "tank_pressure": rig.entry(rig.nodes["tank"], "pressure", _at_start(unit.tank_pressure, PRESSURE_LEVEL)),
    }


def _position(rig: _Rig) -> Entries:
    """The entry of the duty ratio or of the axial position: of the file, else as at the start; a half if a port is
    closed then."""
    given = rig.file.table("components", rig.placed.part.name)
    if not 0.0 < rig.unit.duty_ratio < 1.0:
        return {"duty_ratio": _value(HALF, DUTY_RATIO, "a port is closed when the circuit's run starts", "assumed")}
    for key in ("duty_ratio", "axial_position"):
        if key in given and not (isinstance(given[key], Mapping) and "from" in given[key]):
            return {key: given[key]}
    asked = rig.system.content.get("operation", {}).get("duty_ratio")
    return {"duty_ratio": asked or _at_start(rig.unit.duty_ratio, DUTY_RATIO)}


def _coupling(rig: _Rig) -> Entries:
    """Coupling of the spool to its motor where the circuit has no drive with one."""
    if isinstance(rig.network.nodes[rig.nodes["spool"]], DrivenShaft):
        return _value(STIFF_COUPLING, COUPLING, "holds the spool at the speed of its shaft", "assumed")
    return _value(0.0, COUPLING, "the flow alone turns the spool")


def _pump_speed(rig: _Rig) -> float:
    """The speed of the pump's shaft at the start; the rated one of its motor if that still stands [rad/s]."""
    shaft = rig.network.nodes[rig.parts["pump"][0].nodes["shaft"]]
    source = shaft.speed if isinstance(shaft, DrivenShaft) else None
    motor = rig.network.parts.get(source.partition(".")[0]) if isinstance(source, str) else None
    stands = rig.unit.pump_speed == 0.0 and motor is not None and "rated_speed" in motor.inputs
    return at_start(motor.inputs["rated_speed"], rig.start) if motor and stands else rig.unit.pump_speed


def _load(rig: _Rig) -> Entries:
    """The tables of the load, and of the start: that of the circuit, with a load pressure above that of the tank."""
    unit, start, key = rig.unit, _start(rig), "pressure" if rig.line is None else "start"
    pressure = unit.load_pressure
    held = rig.entry(rig.nodes["load"], key, _at_start(pressure, PRESSURE_LEVEL))
    if not pressure > unit.tank_pressure:
        pressure = unit.tank_pressure + HALF * (unit.relief_valve.cracking_pressure - unit.tank_pressure)
        held = _value(pressure, PRESSURE_LEVEL, "half the setting of the relief valve: no load at the start", "assumed")
    if rig.line is None:
        return {"load": {"pressure": held}, "initial": start}
    return {
        "load_line": _entries(rig.line, rig.file.node(rig.nodes["load"]), Vessel),
        "load": _orifice(rig, pressure),
        "initial": {**start, "load_pressure": held},
    }


def _line(node: Node) -> Vessel | None:
    """The volume that a unit feeds; None if a source or the end of a pipe holds the pressure there."""
    values = node.values if isinstance(node, OilVolume) else None
    if isinstance(values, Chamber):
        return Vessel(
            oil_volume=values.volume, hose_compliance=0.0, gas_volume=0.0, precharge_pressure=0.0, gas_exponent=1.0
        )
    return values if isinstance(values, Vessel) else None


def _orifice(rig: _Rig, pressure: float) -> Entries:
    """The orifice from line to tank: that of the circuit, else one that passes what the unit delivers."""
    unit, own = rig.unit, neighbour(rig.network, Orifice, "a", rig.nodes["load"])
    if own is not None and own[0].nodes["b"] == rig.nodes["tank"] and "area" in (given := rig.file.component(*own)):
        return {"area": given["area"], **_entries(own[1], given, Orifice)}
    density_there = float(density(unit.temperature, unit.oil))
    delivered = HALF * unit.pump.displacement * rig.pump_speed
    area = orifice_area_for(delivered, pressure - unit.tank_pressure, density_there, Orifice())
    note = "passes half the pump flow at the load pressure: the circuit has no orifice there"
    return {"area": _value(area, AREA, note, "assumed")}


def _start(rig: _Rig) -> Entries:
    """Where the run of the rig starts, but for its load: as that of the circuit."""
    inlet, spool = rig.nodes["inlet"], rig.nodes["spool"]
    speed, angle = (rig.start.get(f"{spool}.{key}", 0.0) for key in ("speed", "angle"))
    return {
        "inlet_pressure": rig.entry(inlet, "start", _at_start(rig.start[inlet], PRESSURE_LEVEL)),
        "spool_speed": rig.entry(spool, "speed", _at_start(speed, SPEED)),
        "spool_angle": rig.entry(spool, "angle", _at_start(angle, ANGLE)),
    }


def _entries(values: Params, written: Entries, cls: type[Params]) -> Entries:
    """The entries of a table of a class: as the file has them, and the usual values that it leaves out."""
    defaults = default_values(cls)
    usual = {name: value for name in field_names(cls) if (value := getattr(values, name)) != defaults.get(name)}
    return {
        name: written[name] if name in written else _value(usual[name], kind, "usual value", "assumed")
        for name, kind in field_kinds(cls).items()
        if kind is not None and (name in written or name in usual)
    }


def _at_start(value: float, kind: Kind) -> dict[str, str]:
    return _value(value, kind, "at the start of the circuit's run")


def _value(value: float, kind: Kind, note: str, status: str = "derived") -> dict[str, str]:
    """An entry with a value [SI] and where it comes from."""
    return {"value": exact_text(float(value), kind), "status": status, "note": note}
