"""Variables of a design, where they stand in a system, and what changes along with them."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from vvdp.base.kinds import COUNT, PRESSURE_LEVEL, SPEED, VOLUME, Kind
from vvdp.base.params import field_kinds
from vvdp.base.tables import Table, copy_tables
from vvdp.base.units import in_unit
from vvdp.design.quantities import Setup, loose_copy
from vvdp.evaluation.bench import rotary_bench
from vvdp.systems.system import System
from vvdp.valve.rotary import RotaryValve


@dataclass(frozen=True)
class Variable:
    """A value of a system that a design may change; `setting` is its table and key.

    Unless said otherwise it lies between `lowest` and `highest` times what it was. It is free where `usual`, or where
    a bound is given.
    """

    name: str
    label: str
    setting: str
    kind: Kind
    lowest: float
    highest: float
    usual: bool = False

    @property
    def of_valve(self) -> bool:
        """Whether it is one of the valve itself."""
        return self.setting.startswith("valve.")

    @property
    def whole(self) -> bool:
        """Whether only whole numbers make sense."""
        return self.kind is COUNT


def _of_valve(name: str, label: str, lowest: float, highest: float, usual: bool = False) -> Variable:
    kind = field_kinds(RotaryValve)[name]
    assert kind
    return Variable(
        name=name,
        label=label,
        setting=f"valve.{name}",
        kind=kind,
        lowest=lowest,
        highest=highest,
        usual=usual,
    )


def _around(name: str, label: str, setting: str, kind: Kind, span: tuple[float, float]) -> Variable:
    return Variable(name=name, label=label, setting=setting, kind=kind, lowest=span[0], highest=span[1])


VARIABLES: Mapping[str, Variable] = {
    each.name: each
    for each in (
        _of_valve("spool_radius", "spool radius", 0.6, 1.6, usual=True),
        _of_valve("nozzle_area", "nozzle area", 0.4, 3.3, usual=True),
        _of_valve("outlet_area", "outlet turbine area", 0.3, 3.2, usual=True),
        _of_valve("radial_clearance", "radial clearance", 0.4, 2.0, usual=True),
        _of_valve("helix_length", "helix length", 0.5, 2.0),
        _of_valve("lap_ratio", "lap ratio", 0.3, 2.0),
        _of_valve("sections", "nozzle count", 0.6, 2.0),
        _around("relief_pressure", "relief setting", "relief_valve.cracking_pressure", PRESSURE_LEVEL, (0.8, 2.0)),
        _around("inlet_volume", "inlet volume", "inlet.volume", VOLUME, (0.25, 2.0)),
        _around("spool_motor_speed", "speed of the spool's motor", "operation.spool_motor_speed", SPEED, (0.25, 4.0)),
    )
}


def value_in(at: Setup, name: str) -> float:
    """The value of a variable [SI]."""
    return float(getattr(at.valve if VARIABLES[name].of_valve else at, name))


def with_variables(at: Setup, values: Mapping[str, Any]) -> Setup:
    """`at` with the variables at `values` [SI], which may be arrays or symbols, and what follows from them.

    The radii of the jets and the friction area go with the spool radius, the spool's mass with its square, and the
    effective outlet area with the outlet area: the outlet turbine keeps its blade angles, the lands their lengths.
    """
    valve = loose_copy(at.valve)
    for name, value in values.items():
        if VARIABLES[name].of_valve:
            setattr(valve, name, value)
    for name, value in _followers(at.valve, values):
        setattr(valve, name, value)
    around = {name: value for name, value in values.items() if not VARIABLES[name].of_valve}
    return at._replace(valve=valve, **around)


def _followers(valve: RotaryValve, values: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    if "spool_radius" in values:
        scale = values["spool_radius"] / valve.spool_radius
        for name in ("inlet_radius", "outlet_radius", "friction_area"):
            yield name, scale * getattr(valve, name)
        yield "spool_mass", scale * scale * valve.spool_mass
    if "outlet_area" in values:
        yield "outlet_effective_area", values["outlet_area"] / valve.outlet_area * valve.outlet_effective_area


FOLLOWS = {
    "inlet_radius": "goes with the spool radius",
    "outlet_radius": "goes with the spool radius",
    "friction_area": "goes with the spool radius",
    "spool_mass": "goes with the square of the spool radius",
    "outlet_effective_area": "goes with the outlet area",
}


def redesign(system: System, values: Mapping[str, float], note: str, title: str) -> System:
    """`system` with the variables at `values` [SI] and what follows from them; `note` says where they come from.

    Raises ConfigError where the values cannot be made.
    """
    content = copy_tables(system.content)
    for setting, (value, kind) in design_settings(system, values).items():
        table, _, key = setting.partition(".")
        content[table][key] = _entry(setting_text(value, kind), FOLLOWS.get(key, note))
    return system.read_from(Table(system.name, {**content, "title": title}, {}))


def design_settings(system: System, values: Mapping[str, float]) -> dict[str, tuple[float, Kind]]:
    """The variables at `values` [SI] and what follows from them, each with its kind, by table and key."""
    found = {VARIABLES[name].setting: (float(value), VARIABLES[name].kind) for name, value in values.items()}
    kinds = field_kinds(RotaryValve)
    for name, value in _followers(rotary_bench(system, "design").valve, values):
        kind = kinds[name]
        assert kind
        found[f"valve.{name}"] = float(value), kind
    return found


def _entry(value: str, note: str) -> dict[str, str]:
    return {"value": value, "status": "derived", "note": note}


def setting_text(value: float, kind: Kind) -> str:
    """`value` [SI] as a system file has it, to ten digits; a pressure level absolute."""
    if kind is PRESSURE_LEVEL:
        return f"{value / 1e5:.10g} bara"
    if kind.unit == "1":
        return f"{value:.10g}"
    if kind.unit == "SI":
        return f"{value:.10g} SI"
    return f"{in_unit(value, kind, kind.display_unit):.10g} {kind.display_unit}"
