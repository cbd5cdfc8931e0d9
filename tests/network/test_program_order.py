"""Programs that read each other at one instant: their order, loops, and commands of the last call."""

from itertools import permutations
from typing import Any, NamedTuple

import numpy as np
import pytest

from vvdp.base.errors import NetworkError
from vvdp.base.kinds import Number
from vvdp.base.signal import step
from vvdp.components.resistances import ORIFICE
from vvdp.network.build import build
from vvdp.network.network import Network
from vvdp.network.program import ProgramType
from vvdp.network.program_order import ordered_programs
from vvdp.simulation.run import Stepping, simulate


class Shown(NamedTuple):
    value: Number
    further: Number = 0.0


class Counted(NamedTuple):
    value: Number


def add_one(t: float, memory: Any, reading: Shown, settings: Any) -> tuple[Any, Counted]:
    return memory, Counted(reading.value + reading.further + 1.0)


ADD_ONE = ProgramType(add_one, Shown, Counted(0.0))
STEPPING = Stepping(until=5e-3, sample_period=1e-3, record_interval=1e-3)


@pytest.fixture
def network(oil, of):
    def draw(programs: dict[str, str], **options: dict[str, Any]) -> Network:
        net = Network(oil)
        net.tank("tank")
        net.volume("line", of.chamber, start=2e6)
        net.add("load", ORIFICE, of.orifice, a="line", b="tank", area=1e-6)
        for name, source in programs.items():
            net.program(name, ADD_ONE, reads={"value": source}, **options.get(name, {}))
        return net

    return draw


def last(net: Network) -> dict[str, float]:
    circuit = build(net)
    command = simulate(circuit.model, circuit.case, STEPPING).command
    return {name: float(getattr(command, name).value[-1]) for name in net.programs}


CHAIN = {"first": "t", "second": "first.value", "third": "second.value"}


@pytest.mark.parametrize("names", list(permutations(CHAIN)))
def test_a_chain_takes_one_instant_however_it_is_written(network, names):
    """The last call is that of 4 ms: 0.004 + 1, + 2, + 3."""
    found = last(network({name: CHAIN[name] for name in names}))
    assert [found[name] for name in CHAIN] == pytest.approx([1.004, 2.004, 3.004], abs=1e-12)


def test_the_order_is_that_of_adding_where_nothing_else_is_asked(network):
    net = network({"c": "t", "a": "b.value", "b": "t", "d": "c.value"})
    assert [program.name for program in ordered_programs(net)] == ["c", "b", "a", "d"]


def test_a_loop_is_refused_with_its_chain(network):
    """In the order in which the commands go round."""
    net = network({"a": "c.value", "b": "a.value", "c": "b.value"})
    with pytest.raises(NetworkError, match=r"each other's command of the same instant: a -> b -> c -> a; .*previous"):
        build(net)


def test_a_program_that_reads_itself_is_a_loop(network):
    with pytest.raises(NetworkError, match="a -> a"):
        build(network({"a": "a.value"}))


@pytest.mark.parametrize("names", list(permutations("ab")))
def test_a_loop_with_previous_counts(network, names):
    """a = b before + 1, b = a + 1: at the n-th of the calls 0 to 4 a = 2 n + 1 and b = 2 n + 2."""
    sources = {"a": "b.value", "b": "a.value"}
    assert last(network({name: sources[name] for name in names}, a={"previous": True})) == {"a": 9.0, "b": 10.0}


def test_a_program_may_read_its_own_last_command(network):
    assert last(network({"a": "a.value"}, a={"previous": True})) == {"a": 5.0}


def test_two_that_both_read_the_last_call_are_refused(network):
    with pytest.raises(NetworkError, match="no other"):
        build(network({"a": "b.value", "b": "a.value"}, a={"previous": True}, b={"previous": True}))


def test_a_command_that_acts_later_closes_no_loop(network):
    """b acts one period later: a sees the b of the sample before."""
    assert last(network({"a": "b.value", "b": "a.value"}, b={"latency": 1e-3})) == {"a": 9.0, "b": 8.0}


def test_a_program_reads_a_value_over_time_and_leaves_an_input_open(network):
    net = network({})
    net.program("jump", ADD_ONE, reads={"value": step(2.0, 5.0, 2.5e-3)})
    net.program("number", ADD_ONE, reads={"value": 7.0, "further": "jump.value"})
    circuit = build(net)
    command = simulate(circuit.model, circuit.case, STEPPING).command
    assert np.array_equal(np.unique(command.jump.value[1:]), [3.0, 6.0])
    assert np.array_equal(np.unique(command.number.value[1:]), [11.0, 14.0])


@pytest.mark.parametrize("seed", range(200))
def test_any_set_of_programs_without_loops_has_an_order(network, seed):
    """Each behind what it reads, before what it reads of the last call; as often as one asks."""
    rng = np.random.default_rng(seed)
    names = [f"p{i}" for i in range(8)]
    hidden = list(rng.permutation(names))
    net = network({})
    for name in rng.permutation(names):
        before = hidden[: hidden.index(name)]
        source = f"{rng.choice(before)}.value" if before and rng.random() < 0.8 else "t"
        further = {"further": f"{rng.choice(before)}.value"} if before and rng.random() < 0.5 else {}
        net.program(str(name), ADD_ONE, reads={"value": source, **further})
    order = [program.name for program in ordered_programs(net)]
    assert sorted(order) == names
    for program in net.programs.values():
        for source in program.reads.values():
            other = source.partition(".")[0]
            assert other == "t" or order.index(other) < order.index(program.name)
