"""A system file that runs for each component and program of the library, and the values that it gives."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

from vvdp.base.tables import parsed_table
from vvdp.components.library import COMPONENTS
from vvdp.network.assembly import Assembly
from vvdp.network.component import Component, Role
from vvdp.systems.short_paths import with_full_paths

FOLDER = resources.files("vvdp.systems") / "examples"
TANK = "tank"


@dataclass(frozen=True)
class Surroundings:
    """Parts that an example joins to a port: lines of [nodes] and of [components]; NODE stands for the node at the
    port."""

    nodes: tuple[str, ...] = ()
    components: tuple[str, ...] = ()


SURROUNDINGS = {
    TANK: Surroundings(),
    "supplied": Surroundings(
        (
            'supply = { type = "pressure-source", pressure = "100 bar" }',
            'NODE = { type = "volume", volume = "0.5 l", start = "50 bar" }',
        ),
        ('feed_NODE = { type = "orifice", a = "supply", b = "NODE", area = "10 mm^2" }',),
    ),
    "used": Surroundings(
        ('NODE = { type = "volume", volume = "0.5 l", start = "10 bar" }',),
        ('drain_NODE = { type = "orifice", a = "NODE", b = "tank", area = "5 mm^2" }',),
    ),
    "held": Surroundings(('NODE = { type = "pressure-source", pressure = "120 bar" }',)),
    "kept": Surroundings(
        ('NODE = { type = "volume", volume = "5 l", start = "120 bar" }',),
        ('drain_NODE = { type = "orifice", a = "NODE", b = "tank", area = "5 mm^2" }',),
    ),
    "chamber": Surroundings(('NODE = { type = "volume", volume = "0.2 l", start = "50 bar" }',)),
    "other_chamber": Surroundings(('NODE = { type = "volume", volume = "0.2 l", start = "60 bar" }',)),
    "pilot": Surroundings(('NODE = { type = "pressure-source", pressure = "30 bar" }',)),
    "driven": Surroundings(('NODE = { type = "driven-shaft", speed = "1500 rpm" }',)),
    "turning": Surroundings(('NODE = { type = "shaft", inertia = "0.05 kg*m^2", speed = "100 rpm" }',)),
    "moving": Surroundings(('NODE = { type = "rod", mass = "100 kg", position = "50 mm", velocity = "0.1 m/s" }',)),
    "hung": Surroundings(
        ('NODE = { type = "rod", mass = "100 kg" }',),
        ('load_NODE = { type = "load-force", rod = "NODE", force = "-1000 N" }',),
    ),
    "loaded": Surroundings(
        ('NODE = { type = "rod", mass = "100 kg" }',),
        ('load_NODE = { type = "load-force", rod = "NODE", force = "-9815 N" }',),
    ),
}
"""The surroundings that examples may name for a port."""

USUAL_BY_ROLE = {Role.SHAFT: "turning", Role.SHAFT_SPEED: "turning", Role.ROD: "moving"}
USUAL_BY_NAME = {TANK: TANK, "pilot": "pilot", "pressure": "supplied", "inlet": "supplied"}
"""Surroundings of hydraulic ports by name; of the others, the first is supplied and the rest are used."""


@cache
def _component_tables() -> Mapping[str, Mapping[str, Any]]:
    """The examples of the components, as written."""
    return parsed_table((FOLDER / "components.toml").read_text("utf-8"), "components.toml").content


@cache
def _program_files() -> Mapping[str, str]:
    """The text of the first file in which each program is used, by its type: an example, else a shipped system."""
    found: dict[str, str] = {}
    for folder in (FOLDER / "programs", resources.files("vvdp.systems") / "data"):
        for file in sorted(folder.iterdir(), key=lambda file: file.name):
            text = file.read_text("utf-8")
            for program in parsed_table(text, file.name).content.get("programs", {}).values():
                found.setdefault(program["type"], text)
    return found


def example_values(kind: str) -> Mapping[str, object]:
    """Inputs and values of the example of a component or program, as a file gives them; empty where there is none."""
    if kind in COMPONENTS:
        return {
            key: value
            for key, value in _component_tables().get(kind, {}).items()
            if key not in _ports(COMPONENTS[kind])
        }
    if kind not in _program_files():
        return {}
    full = with_full_paths(parsed_table(_program_files()[kind], kind), []).table
    return _plain(next(each for each in full.content["programs"].values() if each["type"] == kind))


def _plain(given: Mapping[str, Any]) -> dict[str, Any]:
    """Values without their origin, in all tables."""
    return {key: each.get("value", _plain(each)) if isinstance(each, Mapping) else each for key, each in given.items()}


def example_text(kind: str, more: Mapping[str, object] | None = None) -> str | None:
    """A system file that shows a component or program of the library and runs; None where there is none.

    `more` are further inputs and values of a component.
    """
    if kind not in COMPONENTS:
        return _program_files().get(kind)
    if kind not in _component_tables():
        return None
    given = _component_tables()[kind]
    joined = {port: given.get(port, usual) for port, usual in _ports(COMPONENTS[kind]).items()}
    values = {key: value for key, value in given.items() if key not in joined} | dict(more or {})
    return "\n".join(_lines(kind, joined, values)) + "\n"


def _ports(component: Component | Assembly) -> dict[str, str]:
    """The ports and what each is usually joined to."""
    if isinstance(component, Assembly):
        return dict(zip(component.ports, ("supplied", "used"), strict=True))
    hydraulic = component.hydraulic_ports
    usual = {port: USUAL_BY_NAME.get(port, "used" if n else "supplied") for n, port in enumerate(hydraulic)}
    return {port: usual.get(port) or USUAL_BY_ROLE[role] for port, role in component.ports.items()}


def _lines(kind: str, joined: Mapping[str, str], values: Mapping[str, object]) -> Iterator[str]:
    """The file: nodes, what surrounds the component, the component, the run."""
    names = {port: TANK if at == TANK else port for port, at in joined.items()}
    around = {names[port]: SURROUNDINGS[at] for port, at in joined.items()}
    nodes = [line.replace("NODE", name) for name, each in around.items() for line in each.nodes]
    beside = [line.replace("NODE", name) for name, each in around.items() for line in each.components]
    if not any("volume" in line for line in nodes):
        beside += [line.replace("NODE", "line") for line in SURROUNDINGS["used"].components]
        nodes += [line.replace("NODE", "line") for line in SURROUNDINGS["used"].nodes]
    yield from (f'title = "Example: {kind}"', "", "[nodes]", 'tank = { type = "tank" }', *dict.fromkeys(nodes), "")
    yield from ("[components]", *beside, "", f"[components.{kind.replace('-', '_')}]", f'type = "{kind}"')
    yield from (f'{port} = "{name}"' for port, name in names.items())
    yield from (f"{key} = {toml_text(value)}" for key, value in values.items())
    yield from ("", "[run]", 'until = "0.2 s"')


def toml_text(value: Any) -> str:
    """A value of a TOML file as it is written there."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {toml_text(each)}" for key, each in value.items()) + " }"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return "[" + ", ".join(map(toml_text, value)) + "]"
    return json.dumps(value, ensure_ascii=False)
