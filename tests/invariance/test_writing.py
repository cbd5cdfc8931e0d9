"""The same network written differently has the same laws: names, order, units and the ends of a symmetric component.

Held at random states of random networks, in plain Python: what is compiled is the same text, and the loop does not
know which circuit it carries. `slow` runs the drawn circuits themselves.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import pytest
from tests.invariance.circuits import CIRCUITS, changes, drawn, found
from tests.invariance.networks import Drawing, in_other_units, random_drawing, renamed, reordered, turned

from vvdp.base.kinds import PRESSURE_LEVEL
from vvdp.simulation.run import simulate
from vvdp.simulation.values import as_value, flat, leaves
from vvdp.systems.system import System

SEEDS = [*range(12), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(12, 200))]
ROUNDING = 1e-9
"""Of the largest number of its unit: sums in another order."""


class Laws(NamedTuple):
    """What a network says of a state: rates and outputs by their paths, what it holds, and where it starts."""

    rates: Mapping[str, float]
    outputs: Mapping[str, float]
    held: Mapping[str, float]
    start: Mapping[str, float]


def by_path(value: Any) -> dict[str, float]:
    return {path: float(number) for path, number, _ in leaves(value)}


def random_state(system: System, seed: int) -> dict[str, float]:
    """A state by its paths: pressures up to 150 bar, all else near its start."""
    rng = np.random.default_rng(seed)
    return {
        path: rng.uniform(5e5, 1.5e7)
        if kind is PRESSURE_LEVEL
        else value + (kind.scale if kind else 1.0) * rng.normal()
        for path, value, kind in leaves(system.case.state)
    }


def laws(system: System, numbers: list[float]) -> Laws:
    """The laws at the state of these `numbers`, with the modes that hold there."""
    case, model = system.case, system.model
    state, command = as_value(case.state, np.array(numbers)), case.command
    for _ in range(3):
        rates, outputs, *modes = model.circuit(0.0, state, command, case.params)
        if modes:
            command = command._replace(modes=as_value(command.modes, np.floor(flat(modes[0]))))
    held = model.stored(state, case.params)
    return Laws(by_path(rates), by_path(outputs), by_path(held), by_path(model.start(case.params)))


def agree(one: Mapping[str, float], other: Mapping[str, float], signs: Callable[[str], float] = lambda _: 1.0) -> None:
    """Holds the numbers of two by their paths against each other, within the rounding of the largest of each group."""
    assert one.keys() == other.keys()
    groups: dict[str, float] = {}
    for path, value in one.items():
        group = path.rpartition("_")[2] if "_" in path else path.rpartition(".")[2]
        groups[group] = max(groups.get(group, 0.0), abs(value))
    for path, value in one.items():
        group = path.rpartition("_")[2] if "_" in path else path.rpartition(".")[2]
        size = max(groups[group], abs(value))
        assert other[path] * signs(path) == pytest.approx(value, rel=1e-9, abs=ROUNDING * size), path


def laws_of(drawing: Drawing, state: Mapping[str, float]) -> Laws:
    """The laws of a drawing at a state by its paths."""
    system = drawing.system()
    return laws(system, [state[path] for path, _, _ in leaves(system.case.state)])


@pytest.fixture(params=SEEDS)
def network(request: pytest.FixtureRequest) -> tuple[Drawing, dict[str, float], Laws]:
    """A random drawing, a state of it, and its laws there."""
    drawing = random_drawing(request.param)
    state = random_state(drawing.system(), request.param)
    return drawing, state, laws_of(drawing, state)


def test_the_order_of_nodes_and_components(network):
    drawing, state, plain = network
    for one, other in zip(plain, laws_of(reordered(drawing, len(state)), state), strict=True):
        agree(one, other)


def test_the_names(network):
    """Which stand in the paths: the numbers are compared in their order."""
    drawing, state, plain = network
    other = laws(renamed(drawing).system(), list(state.values()))
    for ours, theirs in zip(plain, other, strict=True):
        agree(ours, dict(zip(ours, theirs.values(), strict=True)))


def test_the_units(network):
    drawing, state, plain = network
    for one, other in zip(plain, laws_of(in_other_units(drawing), state), strict=True):
        agree(one, other)


def test_the_ends_of_what_is_alike_from_both(network):
    """Their flows change sign, and nothing else but flows at the pressure of the end that they now enter."""
    drawing, state, plain = network
    mirrored, names = turned(drawing)

    def sign(path: str) -> float:
        return (
            -1.0
            if any(path in (f"{name}_flow", f"{name}.flow", f"books.totals.{name}_flow") for name in names)
            else 1.0
        )

    seen = laws_of(mirrored, {path: value * sign(path) for path, value in state.items()})
    entered = {f"books.totals.{name}_flow_actual" for name in names}
    for one, other in zip(plain, seen, strict=True):
        common = [{path: law[path] for path in law if path not in entered} for law in (one, other)]
        agree(*common, sign)
    assert names


def test_the_states_tell_different_networks_apart():
    """Else none of the above could fail."""
    drawing = random_drawing(1)
    state = random_state(drawing.system(), 1)
    drawing.components["part_0"]["area"] = "30 mm^2"
    with pytest.raises(AssertionError):
        agree(laws_of(random_drawing(1), state).rates, laws_of(drawing, state).rates)


@pytest.mark.slow
@pytest.mark.parametrize("name", CIRCUITS)
@pytest.mark.parametrize("rewritten", ["order", "names", "ends"])
def test_the_runs_of_a_circuit_written_differently(name, rewritten):
    """Means, losses and extremes; compiled again for each."""
    plain = drawn(name)
    drawing = Drawing(dict(plain.content["nodes"]), dict(plain.content["components"]))
    mirrored, names = turned(drawing)
    other = {"order": reordered(drawing, 5), "names": renamed(drawing), "ends": mirrored}[rewritten].system()
    one, two = (found(each, simulate(each.model, each.case, plain.stepping)) for each in (plain, other))
    if rewritten == "names":
        two = dict(zip(one, two.values(), strict=True))
    if rewritten == "ends":
        two |= {f"flow_mean_{each}_m3_s": -two[f"flow_mean_{each}_m3_s"] for each in names}
    assert not changes(name, one, two, 1e-6)
