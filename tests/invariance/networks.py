"""Random drawn networks, and ways to write the same one differently; nothing of them is compiled."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.tables import Table
from vvdp.systems.system import System, built_system

Entry = dict[str, Any]
UNITS = {"bar": ("Pa", 1e5), "cc": ("l", 1e-3), "mm^2": ("m^2", 1e-6), "lpm": ("m^3/s", 1e-3 / 60.0), "kg": ("g", 1e3)}
TURNED = ("orifice", "laminar-gap", "column")
"""Types of which it does not matter which end is called a."""


class Drawing(NamedTuple):
    """The tables of a drawn network."""

    nodes: dict[str, Entry]
    components: dict[str, Entry]

    def system(self) -> System:
        """The system that they draw."""
        run = {"until": "1 s", "average_from": "0.5 s"}
        content = {"title": "random", "nodes": self.nodes, "components": self.components, "run": run}
        return built_system(Table("random", content, {}), "random")


def random_drawing(seed: int) -> Drawing:
    """A source and a cylinder, and between them volumes joined at random by what takes a pressure drop."""
    rng = np.random.default_rng(seed)

    def of(low: float, high: float, unit: str) -> str:
        return f"{rng.uniform(low, high):.6g} {unit}"

    volumes = [f"volume_{number}" for number in range(rng.integers(3, 6))]
    nodes: dict[str, Entry] = {"tank": {"type": "tank"}}
    for name in volumes:
        nodes[name] = {"type": "volume", "volume": of(20.0, 200.0, "cc"), "start": of(5.0, 100.0, "bar")}
    nodes["gas"] = {
        "type": "vessel", "oil_volume": of(50.0, 100.0, "cc"), "gas_volume": of(100.0, 500.0, "cc"),
        "precharge_pressure": of(20.0, 50.0, "bar"), "start": of(50.0, 90.0, "bar"),
    }  # fmt: skip
    nodes["rod"] = {"type": "rod", "mass": of(10.0, 100.0, "kg"), "position": "10 mm"}
    volumes.append("gas")
    components: dict[str, Entry] = {
        "source": {"type": "flow-source", "a": "tank", "b": volumes[0], "flow": of(5.0, 30.0, "lpm")},
        "cylinder": {
            "type": "cylinder", "a": volumes[1], "b": volumes[2], "rod": "rod", "area_a": of(800.0, 1500.0, "mm^2"),
            "area_b": of(400.0, 700.0, "mm^2"), "stroke": "300 mm", "moving_mass": of(1.0, 5.0, "kg"),
            "leakage_conductance": "1e-13 m^3/(s*Pa)",
        },
        "spring": {"type": "spring", "rod": "rod", "stiffness": "50 kN/m", "preload": "0 N", "rest_position": "0 mm"},
        "relief": {
            "type": "relief-valve", "a": volumes[0], "b": "tank", "cracking_pressure": of(60.0, 120.0, "bar"),
            "override_pressure": of(5.0, 15.0, "bar"), "rated_flow": of(20.0, 40.0, "lpm"),
        },
    }  # fmt: skip
    kinds: dict[str, Any] = {
        "orifice": lambda: {"area": of(2.0, 20.0, "mm^2")},
        "laminar-gap": lambda: {"conductance": f"{rng.uniform(1e-12, 1e-10):.6g} m^3/(s*Pa)"},
        "column": lambda: {"length": of(100.0, 900.0, "mm"), "diameter": of(6.0, 15.0, "mm")},
        "check-valve": lambda: {
            "cracking_pressure": of(0.2, 3.0, "bar"), "rated_drop": of(4.0, 8.0, "bar"), "rated_flow": "40 lpm",
        },
    }  # fmt: skip
    ends = [*volumes, "tank"]
    for number in range(rng.integers(4, 9)):
        kind = list(kinds)[number % len(kinds)]
        a, b = rng.choice(len(ends), 2, replace=False)
        components[f"part_{number}"] = {"type": kind, "a": ends[a], "b": ends[b], **kinds[kind]()}
    return Drawing(nodes, components)


def reordered(drawing: Drawing, seed: int) -> Drawing:
    """The same with nodes and components in another order."""
    rng = np.random.default_rng(seed)

    def shuffled(entries: Mapping[str, Entry]) -> dict[str, Entry]:
        names = list(entries)
        return {names[place]: entries[names[place]] for place in rng.permutation(len(names))}

    return Drawing(shuffled(drawing.nodes), shuffled(drawing.components))


def renamed(drawing: Drawing) -> Drawing:
    """The same with other names, in no order of the alphabet."""
    new = {name: f"{chr(ord('z') - place)}{place * 7919 % 97}" for place, name in enumerate(drawing.nodes)}
    nodes = {new[name]: entry for name, entry in drawing.nodes.items()}
    components = {
        f"{chr(ord('y') - place)}_part": {key: new.get(str(value), value) for key, value in entry.items()}
        for place, entry in enumerate(drawing.components.values())
    }
    return Drawing(nodes, components)


def in_other_units(drawing: Drawing) -> Drawing:
    """The same with its values in other units."""

    def converted(entry: Entry) -> Entry:
        found = {}
        for key, text in entry.items():
            number, _, unit = text.partition(" ")
            found[key] = f"{float(number) * UNITS[unit][1]!r} {UNITS[unit][0]}" if unit in UNITS else text
        return found

    return Drawing(*({name: converted(entry) for name, entry in entries.items()} for entries in drawing))


def turned(drawing: Drawing) -> tuple[Drawing, set[str]]:
    """The same with a and b of all that is alike from both sides exchanged, and the names of these."""
    names = {name for name, entry in drawing.components.items() if entry["type"] in TURNED}
    components = {
        name: {**entry, "a": entry["b"], "b": entry["a"]} if name in names else entry
        for name, entry in drawing.components.items()
    }
    return Drawing(drawing.nodes, components), names
