"""The stiff method is used where it pays: a passage that splits a volume in two costs a few times the steps at most."""

import copy
import tomllib
from pathlib import Path

import pytest

from vvdp.base.tables import Table
from vvdp.evaluation.summary import summary
from vvdp.simulation.run import Run, simulate
from vvdp.systems.system import built_system, load_system

CIRCUITS = Path(__file__).parent / "splits"
HALVES = {
    "dead-head": ("rail", ("volume",), {"pump": "outlet", "load": "a"}),
    "lagging-relief": ("rail", ("volume",), {"pump": "outlet", "load": "a"}),
    "rectifier": ("chamber", ("volume",), {"delivery": "a"}),
    "chatter": ("spot", ("volume",), {"pump": "b"}),
    "precharge": ("acc", ("oil_volume", "gas_volume"), {}),
    "regeneration": ("cap", ("volume",), {"pump": "b", "relief": "a"}),
}
"""Of each circuit the volume that is split, what is halved with it, and the ports that join the other half."""


def halved(value: str) -> str:
    number, unit = value.split()
    return f"{float(number) / 2.0:g} {unit}"


def split(circuit: dict, node: str, sizes: tuple[str, ...], moved: dict[str, str]) -> dict:
    """The circuit with a node in two halves that a short passage joins: 0.05 bar at 30 l/min."""
    found = copy.deepcopy(circuit)
    half = found["nodes"][node] = found["nodes"][node] | {size: halved(found["nodes"][node][size]) for size in sizes}
    found["nodes"]["other_half"] = dict(half)
    for component, port in moved.items():
        found["components"][component][port] = "other_half"
    found["components"]["passage"] = {
        "type": "laminar-gap", "a": node, "b": "other_half", "conductance": "1e-7 m^3/(s*Pa)",
    }  # fmt: skip
    return found


def run_of(circuit: dict) -> Run:
    system = built_system(Table("circuit", circuit, {}), "circuit")
    return simulate(system.model, system.case, system.stepping)


@pytest.mark.parametrize("name", HALVES)
def test_a_volume_in_two_halves_costs_five_times_the_steps_at_most(name):
    """The halves of `dead-head` even out at 1e6/s; those of `rectifier` once took 190 times the steps of the whole."""
    whole = tomllib.loads((CIRCUITS / f"{name}.toml").read_text())
    plain, halves = run_of(whole), run_of(split(whole, *HALVES[name]))
    assert plain.finished and halves.finished
    assert halves.steps < 5 * plain.steps


def test_the_stiff_method_is_not_asked_for_over_and_over_where_it_does_not_pay():
    """Its step is cut by an event every two milliseconds: it was tried 2478 times in these 2 s, and lost each time."""
    system = load_system("displacement-control", until="2 s")
    found = simulate(system.model, system.case, system.stepping)
    assert found.switches < 100


@pytest.mark.parametrize(("tolerance", "closes"), [(1e-5, False), (1e-6, True)])
def test_the_default_tolerance_closes_books_that_a_looser_one_does_not(tolerance, closes):
    system = load_system("flow-control-unit", [f"run.relative_tolerance={tolerance}"])
    found = summary(system, simulate(system.model, system.case, system.stepping))
    assert found["trusted"] is closes
