"""Laws that every network keeps, however it is drawn; connections, oils, start values."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from tests.network.drawn_unit import Moves, add_unit, prototype_unit
from tests.words import wording

from vvdp.base.errors import NetworkError
from vvdp.base.kinds import Flow, Force, Fraction, Power
from vvdp.base.select import maximum
from vvdp.base.signal import constant, sine
from vvdp.components.flow_sources import FLOW_SOURCE
from vvdp.components.library import UsualOil
from vvdp.components.lines import LINE
from vvdp.components.machines import MOTOR, PUMP
from vvdp.components.pipes import add_pipe
from vvdp.components.resistances import LAMINAR_GAP, ORIFICE, LaminarGap
from vvdp.components.rods import CYLINDER, END_STOP, LOAD_FORCE, PLUNGER, ROD_FRICTION, SPRING
from vvdp.components.self_acting_valves import CHECK_VALVE, RELIEF_VALVE, SHOCK_VALVE
from vvdp.components.shafts import LOAD_TORQUE, ROTOR, TORSION_SPRING
from vvdp.components.switching_valves import MODULATED_TWO_WAY_VALVE, ModulatedTwoWayValve
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.hydraulics.cylinder import Plunger
from vvdp.hydraulics.flow import Passage, passage
from vvdp.hydraulics.friction import RodFriction
from vvdp.hydraulics.line import Line
from vvdp.hydraulics.motor import Motor
from vvdp.hydraulics.orifice import Orifice, orifice_flow
from vvdp.hydraulics.pipe import LinePipe
from vvdp.hydraulics.ports import RodState, Wall
from vvdp.hydraulics.relief_valve import ShockValve
from vvdp.hydraulics.rod import EndStop, Spring
from vvdp.hydraulics.shaft import Rotor as RotorValues
from vvdp.hydraulics.shaft import TorsionSpring
from vvdp.hydraulics.volume import Vessel
from vvdp.network.build import Circuit, build
from vvdp.network.component import Component
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber, Connection, Load, Rotor
from vvdp.simulation.values import flat, leaves, rebuild
from vvdp.systems.system import load_system

OIL = UsualOil()
GRAPHS = 20


def at(circuit: Circuit, state: Any, t: float = 0.1) -> tuple[Any, Any]:
    """Rates and outputs in the modes that hold there."""
    case, command = circuit.case, circuit.case.command
    for _ in range(8):
        rates, outputs, *modes = circuit.model.circuit(t, state, command, case.params)
        if not modes or command.modes == (found := type(modes[0])(*np.floor(modes[0]))):
            return rates, outputs
        command = command._replace(modes=found)
    raise AssertionError("the modes do not come to rest")


# Conservation laws


def random_network(rng: np.random.Generator, of: Any) -> Network:
    """Components of the library between nodes drawn by lot."""
    net = Network(OIL)
    net.tank("tank", sine(1.2e5, 1e4, 3.0))
    net.pressure_source("source", sine(8e6, 1e6, 5.0))
    vessel = Vessel(oil_volume=2e-4, hose_compliance=1e-9, gas_volume=3e-4, precharge_pressure=3e6, gas_exponent=1.3)
    volumes = [f"volume_{i}" for i in range(int(rng.integers(2, 6)))]
    for i, name in enumerate(volumes):
        net.volume(name, vessel if i % 2 else of.chamber, start=1e6)
    net.shaft("shaft", Rotor(inertia=0.01))
    net.driven_shaft("drive", sine(100.0, 20.0, 2.0))
    net.rod("rod", Load(mass=5.0))
    hydraulic = [*volumes, "tank", "source"]

    def ends() -> dict[str, str]:
        a, b = rng.choice(len(hydraulic), 2, replace=False)
        return {"a": hydraulic[a], "b": hydraulic[b]}

    def inside() -> str:
        return str(rng.choice(volumes))

    one, two = rng.choice(len(volumes), 2, replace=False)
    plunger = Plunger(area_a=5e-4, moving_mass=2.0)
    friction = RodFriction(
        viscous_friction=2e3, coulomb_friction=50.0, breakaway_friction=80.0, stribeck_velocity=0.1,
        coulomb_velocity=0.01,
    )  # fmt: skip
    motor = Motor(
        displacement=5e-6, leakage_conductance=1e-12, shaft_damping=0.01, coulomb_torque=2.0, coulomb_speed=3.0,
        inertia=0.02,
    )  # fmt: skip
    soft = replace(of.relief, override_pressure=1e6, opening_time=2e-3)
    shock = ShockValve(cracking_pressure=8e6, rated_flow=1e-3, override_pressure=1e6, opening_time=0.0)
    stop = EndStop(lower_end=0.1, upper_end=0.4, stop_stiffness=1e7, stop_damping=1.0)
    add: list[Callable[[str], None]] = [
        lambda n: net.add(n, ORIFICE, of.orifice, area=sine(2e-6, 1e-6, 4.0), **ends()),
        lambda n: net.add(n, LAMINAR_GAP, LaminarGap(conductance=1e-11), **ends()),
        lambda n: net.add(n, CHECK_VALVE, of.check, **ends()),
        lambda n: net.add(n, RELIEF_VALVE, of.relief, a=inside(), b="tank"),
        lambda n: net.add(n, RELIEF_VALVE, soft, a=inside(), b="tank"),
        lambda n: net.add(n, SHOCK_VALVE, shock, **ends()),
        lambda n: net.add(n, PUMP, of.pump, inlet="tank", outlet=inside(), shaft=str(rng.choice(["drive", "shaft"]))),
        lambda n: net.add(n, MOTOR, motor, shaft=str(rng.choice(["drive", "shaft"])), **ends()),
        lambda n: net.add(n, FLOW_SOURCE, of.source, flow=sine(1e-4, 1e-4, 3.0), **ends()),
        lambda n: net.add(n, LINE, Line(length=1.0, diameter=0.01), **ends()),
        lambda n: add_pipe(net, n, LinePipe(length=3.0, diameter=0.01, hose_compliance=1e-9, pieces=2.0), ends(), 1e6),
        lambda n: net.add(n, CYLINDER, replace(of.cylinder, leakage_conductance=1e-12), a=volumes[one], b=volumes[two],
                          rod="rod"),
        lambda n: net.add(n, PLUNGER, plunger, a=str(rng.choice(hydraulic)), rod="rod"),
        lambda n: net.add(n, SPRING, Spring(stiffness=1e4, preload=50.0, rest_position=0.1), rod="rod"),
        lambda n: net.add(n, END_STOP, stop, rod="rod"),
        lambda n: net.add(n, ROD_FRICTION, friction, rod="rod"),
        lambda n: net.add(n, LOAD_FORCE, rod="rod", force=sine(100.0, 500.0, 2.0)),
        lambda n: net.add(n, ROTOR, ROTOR_VALUES, shaft="shaft"),
        lambda n: net.add(n, LOAD_TORQUE, shaft="shaft", torque=sine(5.0, 3.0, 2.0)),
        lambda n: net.add(n, TORSION_SPRING, TORSION, shaft=str(rng.choice(["drive", "shaft"]))),
    ]  # fmt: skip
    for number in range(int(rng.integers(5, 13))):
        add[int(rng.integers(len(add)))](f"part_{number}")
    return net


ROTOR_VALUES = RotorValues(inertia=0.02, shaft_damping=0.01, coulomb_torque=2.0, coulomb_speed=3.0)
TORSION = TorsionSpring(torsional_stiffness=10.0, preload_torque=2.0, rest_angle=0.5)
RANGES = {"position": (0.05, 0.45), "velocity": (-0.5, 0.5), "angle": (-5.0, 5.0), "speed": (-50.0, 200.0)}
RANGES |= {"opening": (0.0, 1.0), "flow": (-3e-4, 3e-4)}


def random_state(circuit: Circuit, rng: np.random.Generator) -> Any:
    numbers = []
    for path, _, kind in leaves(circuit.case.state):
        low, high = (2e5, 1.5e7) if kind and kind.unit == "Pa" else RANGES.get(path.rpartition(".")[2], (-5.0, 5.0))
        numbers.append(0.0 if path.startswith("books.") else float(rng.uniform(low, high)))
    return rebuild(circuit.case.state, iter(numbers))


def stored_rates(circuit: Circuit, state: Any, rates: Any) -> tuple[float, float, float, float]:
    """Differences of energy and oil along the rates, by steps that change no state by more than 1e-4 of it; and what
    rounding makes of them: some 1e-14 of all that is stored over the time, for the strain energy cancels by two digits.
    """
    y, dy = flat(state), flat(rates)
    sizes = np.array([kind.scale if kind and kind.unit != "1" else 1.0 for _, _, kind in leaves(state)])
    own = np.array([not path.startswith("books.") for path, _, _ in leaves(state)])
    dt = 1e-4 * float(np.min(maximum(np.abs(y), sizes)[own] / maximum(np.abs(dy[own]), 1e-30)))
    held = []
    for side in (-2.0, -1.0, 1.0, 2.0):
        found = circuit.model.stored(rebuild(state, iter((y + side * dt * dy).tolist())), circuit.case.params)
        held.append((float(found.energy), float(found.volume)))
    energy, volume = ((a - 8.0 * b + 8.0 * c - d) / (12.0 * dt) for a, b, c, d in zip(*held, strict=True))
    rounding = (1e-14 * max(abs(number) for number in column) / dt for column in zip(*held, strict=True))
    return energy, volume, *rounding


@pytest.mark.parametrize("seed", range(GRAPHS))
def test_random_network_keeps_energy_and_oil(seed, of):
    """To 1e-8 of all terms, the square of the share by which the differences change a state, and to rounding."""
    rng = np.random.default_rng(seed)
    circuit = build(random_network(rng, of))
    for _ in range(5):
        state = random_state(circuit, rng)
        rates, _ = at(circuit, state, 0.0)
        books = rates.books
        energy, volume, energy_rounding, volume_rounding = stored_rates(circuit, state, rates)
        supplied, spent = flat(books.supplied), flat(books.spent)
        size = abs(supplied).sum() + abs(spent).sum() + abs(energy)
        assert abs(supplied.sum() - spent.sum() - energy) < 1e-8 * size + energy_rounding
        oil = books.taken_in + books.given_out
        assert abs(books.taken_in - books.given_out - volume) < 1e-8 * oil + volume_rounding
        assert books.taken_in >= 0.0 and books.given_out >= -1e-12


def test_walls_at_a_prescribed_pressure_take_power_from_it(oil, of):
    net = Network(oil)
    net.pressure_source("supply", 1e7)
    net.tank("tank")
    net.rod("rod", velocity=0.2)
    net.add("cylinder", CYLINDER, of.cylinder, a="supply", b="tank", rod="rod")
    circuit = build(net)
    books = at(circuit, circuit.case.state)[0].books
    assert books.supplied.supply == pytest.approx((1e7 - 101325.0) * 2e-3 * 0.2)
    assert books.supplied.tank == pytest.approx(0.0, abs=1e-9)


# Invariance


def two_orifices(order: tuple[int, ...], names: dict[str, str], of: Any, halves: int = 1) -> Circuit:
    """A source, two volumes and three resistances, added in any order under any names."""
    net = Network(OIL)
    called = {name: names.get(name, name) for name in ("tank", "inlet", "line", "supply", "between", "load", "relief")}
    nodes = [
        lambda: net.tank(called["tank"]),
        lambda: net.volume(called["inlet"], of.chamber, start=5e6),
        lambda: net.volume(called["line"], of.chamber, start=2e6),
    ]
    area = 3e-6 / halves
    parts = [
        lambda: net.add(called["supply"], FLOW_SOURCE, of.source, a=called["tank"], b=called["inlet"], flow=3e-4),
        lambda: [
            net.add(f"{called['between']}_{i}", ORIFICE, of.orifice, a=called["inlet"], b=called["line"], area=area)
            for i in range(halves)
        ],
        lambda: net.add(called["load"], ORIFICE, of.orifice, a=called["line"], b=called["tank"], area=2e-6),
        lambda: net.add(called["relief"], RELIEF_VALVE, of.relief, a=called["inlet"], b=called["tank"]),
    ]
    for i in order:
        if i < len(nodes):
            nodes[i]()
    for i in order:
        if i < len(parts):
            parts[i]()
    return build(net)


def pressures(circuit: Circuit, inlet: str = "inlet", line: str = "line") -> list[float]:
    state = circuit.case.state._replace(**{inlet: 1.01e7, line: 3e6})
    rates = at(circuit, state)[0]
    return [getattr(rates, inlet), getattr(rates, line)]


@pytest.mark.parametrize("order", [(3, 2, 1, 0), (1, 3, 0, 2), (2, 0, 3, 1)])
def test_order_of_adding_changes_nothing(order, of):
    usual = pressures(two_orifices((0, 1, 2, 3), {}, of))
    assert pressures(two_orifices(order, {}, of)) == pytest.approx(usual, rel=1e-12)


def test_names_change_nothing(of):
    names = {"inlet": "x", "line": "fluid_state", "load": "orifice", "tank": "sea"}
    found = pressures(two_orifices((0, 1, 2, 3), names, of), "x", "fluid_state")
    assert found == pressures(two_orifices((0, 1, 2, 3), {}, of))


def test_two_halves_of_an_orifice_are_one(of):
    assert pressures(two_orifices((0, 1, 2, 3), {}, of, 2)) == pytest.approx(
        pressures(two_orifices((0, 1, 2, 3), {}, of)), rel=1e-12
    )


# Relief valves that need the surplus


@pytest.mark.parametrize("first", [True, False])
def test_second_ideal_relief_valve_gets_what_the_first_leaves(first, oil, of):
    """Together they take the surplus once, whichever of them opens."""
    net = Network(oil)
    net.tank("tank")
    net.volume("inlet", of.chamber, start=1.0e7)
    net.add("supply", FLOW_SOURCE, of.source, a="tank", b="inlet", flow=3e-4)
    low, high = replace(of.relief, cracking_pressure=9e6), replace(of.relief, cracking_pressure=2e7)
    net.add("one", RELIEF_VALVE, low if first else high, a="inlet", b="tank")
    net.add("two", RELIEF_VALVE, high if first else low, a="inlet", b="tank")
    circuit = build(net)
    rates, outputs = at(circuit, circuit.case.state)
    assert outputs.one_flow + outputs.two_flow == pytest.approx(3e-4, rel=1e-12)
    assert min(outputs.one_flow, outputs.two_flow) == 0.0
    assert abs(rates.inlet) < 1.0


def test_two_equal_relief_valves_take_the_surplus_once(oil, of):
    net = Network(oil)
    net.tank("tank")
    net.volume("inlet", of.chamber, start=1.2e7)
    net.add("one", RELIEF_VALVE, of.relief, a="inlet", b="tank")
    net.add("two", RELIEF_VALVE, of.relief, a="inlet", b="tank")
    net.add("supply", FLOW_SOURCE, of.source, a="tank", b="inlet", flow=3e-4)
    circuit = build(net)
    outputs = at(circuit, circuit.case.state)[1]
    assert (outputs.one_flow, outputs.two_flow) == (pytest.approx(3e-4), pytest.approx(0.0, abs=1e-18))


# Connections


def by_position(position: float, factor: float) -> float:
    return factor * position


def twice(flow: float) -> float:
    return 2.0e5 * flow


@pytest.fixture
def joined(oil, of):
    """A pump unit, a cylinder and an orifice to connect."""
    unit = prototype_unit()

    def draw(**moves: Any) -> Network:
        net = Network(unit.oil)
        net.tank("tank")
        net.volume("load", of.chamber, start=1e6)
        net.rod("rod", Load(mass=3.0), position=5e-3, velocity=0.1)
        net.add("plunger", PLUNGER, Plunger(area_a=1e-4, moving_mass=1.0), a="load", rod="rod")
        add_unit(net, unit, "load", Moves(**moves))
        return net

    return draw


def test_state_moves_the_spool(joined):
    plain, moved = build(joined()), build(joined(axial_position="rod.position"))
    assert at(plain, plain.case.state)[1] == at(moved, moved.case.state)[1]
    other = moved.case.state._replace(rod=RodState(1e-2, 0.1))
    assert at(moved, other)[1].valve_load_opening != at(moved, moved.case.state)[1].valve_load_opening


def test_state_moves_the_pump(joined):
    speed = Connection(by_position, ("rod.position", constant(188.0 / 5e-3)))
    plain, moved = build(joined()), build(joined(pump_speed=speed))
    assert flat(at(plain, plain.case.state)[0]) == pytest.approx(flat(at(moved, moved.case.state)[0]), rel=1e-12)


def test_motor_of_the_spool_follows_the_pump(joined):
    circuit = build(joined(spool_motor_speed="pump_shaft.speed"))
    assert "spool_motor = ShaftSpeed(pump_shaft.speed)" in circuit.text


def test_node_follows_what_is_added_later(oil, of):
    """A shaft that follows the result of a part, a source that follows that shaft: each is written behind the other."""
    net = Network(oil)
    net.driven_shaft("second", "first.speed")
    net.driven_shaft("first", Connection(twice, ("load.flow",)))
    net.tank("tank")
    net.volume("line", of.chamber, start=2e6)
    net.add("pump", PUMP, of.pump, inlet="tank", outlet="line", shaft="second")
    net.add("load", ORIFICE, of.orifice, a="line", b="tank", area=2e-6)
    circuit = build(net)
    outputs = at(circuit, circuit.case.state)[1]
    ideal = of.pump.displacement * 2e5 * outputs.load_flow
    assert outputs.pump_flow == pytest.approx(ideal - outputs.pump_leakage_flow, rel=0.05)


def test_connection_to_the_flow_of_a_line_is_its_flow(oil, of):
    """Its state has the same name, and is something else."""
    net = Network(oil)
    net.tank("tank")
    net.volume("line_end", of.chamber, start=2e7)
    net.volume("other", of.chamber, start=2e6)
    net.add("gauge", ORIFICE, of.orifice, a="other", b="tank", area=Connection(shown_area, ("hose.flow",)))
    net.add("hose", LINE, Line(length=1.0, diameter=0.01), a="line_end", b="other")
    circuit = build(net)
    state = circuit.case.state._replace(hose=circuit.case.state.hose._replace(flow=1e-3))
    outputs = at(circuit, state)[1]
    drop = 2e6 - 101325.0
    expected = orifice_flow(1e-3 * outputs.hose_flow, drop, circuit.case.command.held.medium.density, of.orifice)
    assert outputs.gauge_flow == pytest.approx(expected / 1.0, rel=2e-2)
    assert circuit.text.index("    hose = ") < circuit.text.index("    gauge = ")


def shown_area(flow: float) -> float:
    return 1e-3 * flow


def test_output_torque_and_speed_can_be_connected(oil, of):
    net = Network(oil)
    net.tank("tank")
    net.volume("line", of.chamber, start=2e6)
    net.driven_shaft("shaft", 100.0)
    net.shaft("wheel", Rotor(inertia=1.0))
    net.add("pump", PUMP, of.pump, inlet="tank", outlet="line", shaft="shaft")
    net.add("copy", LOAD_TORQUE, shaft="wheel", torque="pump.shaft")
    net.add("valve", ORIFICE, of.orifice, a="line", b="tank", area=Connection(shown_area, ("pump.flow",)))
    circuit = build(net)
    rates, outputs = at(circuit, circuit.case.state)
    assert rates.wheel.speed == pytest.approx(outputs.pump_shaft)
    assert outputs.pump_shaft < 0.0 < outputs.valve_flow


def test_unnamed_function_may_connect(oil, of):
    net = Network(oil)
    net.tank("tank")
    net.volume("line", of.chamber, start=2e6)
    area = Connection(lambda level, per: level * per, ("line.pressure", constant(1e-12)))
    net.add("load", ORIFICE, of.orifice, a="line", b="tank", area=area)
    net.add("other", ORIFICE, of.orifice, a="line", b="tank", area=2e-6)
    outputs = at(build(net), build(net).case.state)[1]
    assert outputs.load_flow == pytest.approx(outputs.other_flow, rel=1e-12)


def test_loop_of_results_is_refused_with_its_chain(oil, of):
    net = Network(oil)
    net.tank("tank")
    net.volume("line", of.chamber, start=2e6)
    net.add("one", ORIFICE, of.orifice, a="line", b="tank", area=Connection(shown_area, ("two.flow",)))
    net.add("two", ORIFICE, of.orifice, a="line", b="tank", area=Connection(shown_area, ("one.flow",)))
    with pytest.raises(NetworkError, match="one -> two -> one"):
        build(net)


def test_loop_over_a_shaft_is_refused_with_its_chain(oil, of):
    net = Network(oil)
    net.tank("tank")
    net.volume("line", of.chamber, start=2e6)
    net.driven_shaft("shaft", Connection(twice, ("pump.flow",)))
    net.add("pump", PUMP, of.pump, inlet="tank", outlet="line", shaft="shaft")
    with pytest.raises(NetworkError, match="shaft -> pump -> shaft"):
        build(net)


def test_jump_that_nobody_knows_beforehand_is_refused(oil, of):
    valve = ModulatedTwoWayValve(
        natural_frequency=200.0, damping_ratio=0.7, stroke=1e-3, lap=0.0, full_area=1e-5, discharge_coefficient=0.6,
        transition_pressure=1e4, normally_open=0.0, frequency=50.0,
    )  # fmt: skip
    net = Network(oil)
    net.tank("tank")
    net.volume("line", of.chamber, start=2e6)
    net.add("own", Component(opened, symbol="orifice"), of.orifice, a="line", b="tank")
    net.add("valve", MODULATED_TWO_WAY_VALVE, valve, a="line", b="tank", duty_ratio="own.opening")
    with pytest.raises(
        NetworkError, match="valve.duty_ratio: " + wording.network.changes_all_the_time.format(source="own.opening")
    ):
        build(net)


class Opened(NamedTuple):
    flow: Flow
    loss: Power
    opening: Fraction


def opened(a: FluidState, b: FluidState, values: Orifice) -> Opened:
    return Opened(*passage(orifice_flow(1e-6, a.pressure - b.pressure, 870.0, values), a, b), 0.5)


def test_periods_are_those_of_the_first_that_marks_them(oil, of):
    """Also where a shaft with a prescribed speed turns it, whose angle alone counts."""
    from vvdp.components.rotary_valve import ROTARY_VALVE

    unit = prototype_unit()
    net = Network(oil)
    net.tank("tank")
    net.volume("inlet", of.chamber, start=2e6)
    net.volume("line", of.chamber, start=2e6)
    net.driven_shaft("drive", Connection(twice, ("gauge.flow",)))
    net.driven_shaft("other", 10.0)
    for name, shaft in (("first", "drive"), ("second", "other")):
        ends = {"inlet": "inlet", "load": "line", "tank": "tank", "spool": shaft}
        net.add(name, ROTARY_VALVE, unit.valve, unit.check_valve, axial_position=5e-3, **ends)
    net.add("gauge", ORIFICE, of.orifice, a="line", b="tank", area=1e-6)
    circuit = build(net)
    case = circuit.case
    marks = [
        circuit.model.mark(0.0, case.state._replace(**{shaft: 7.0}), case.command, case.params)
        for shaft in ("drive", "other")
    ]
    assert marks[0] > 1.0 and marks[1] == 0.0
    assert at(circuit, case.state)[0].drive > 0.0


# Values and walls of own components


def both(a: FluidState, b: FluidState, narrow: Orifice, wide: Orifice) -> Passage:
    """Two sets of values of one class."""
    drop = a.pressure - b.pressure
    return passage(orifice_flow(1e-6, drop, 870.0, narrow) + orifice_flow(2e-6, drop, 870.0, wide), a, b)


def test_two_values_of_one_class_are_two(oil, of):
    net = Network(oil)
    net.tank("tank")
    net.volume("line", of.chamber, start=2e6)
    wide = replace(of.orifice, discharge_coefficient=0.9)
    net.add("own", Component(both, symbol="orifice"), of.orifice, wide, a="line", b="tank")
    circuit = build(net)
    drop = 2e6 - 101325.0
    expected = orifice_flow(1e-6, drop, 870.0, of.orifice) + orifice_flow(2e-6, drop, 870.0, wide)
    tank_volumes = expected / fluid_state(2e6, oil).volume_ratio
    assert at(circuit, circuit.case.state)[1].own_flow == pytest.approx(tank_volumes, rel=1e-12)


class PushedEffect(NamedTuple):
    rod: Force


class PushedWalls(NamedTuple):
    a: Wall


def pushed(a: FluidState, pilot: FluidState, rod: RodState, values: Plunger) -> PushedEffect:
    """A plunger beside a port at which nothing moves."""
    return PushedEffect((a.pressure - 101325.0) * values.area_a)


def pushed_walls(rod: RodState, values: Plunger) -> PushedWalls:
    return PushedWalls(Wall(values.area_a * rod.position, values.area_a * rod.velocity))


def test_walls_need_not_be_at_every_port(oil, of):
    net = Network(oil)
    net.volume("line", of.chamber, start=2e6)
    net.volume("pilot", of.chamber, start=2e6)
    net.rod("rod", Load(mass=1.0), velocity=0.1)
    component = Component(pushed, symbol="cylinder", walls=pushed_walls)
    net.add("own", component, Plunger(area_a=1e-3, moving_mass=1.0), a="line", pilot="pilot", rod="rod")
    circuit = build(net)
    rates = at(circuit, circuit.case.state)[0]
    assert rates.pilot == 0.0 and rates.line < 0.0


def test_store_on_a_prescribed_shaft_is_counted(oil):
    """Only the angle of such a shaft is a state."""
    net = Network(oil)
    net.driven_shaft("drive", sine(10.0, 1.0, 1.0))
    net.add("spring", TORSION_SPRING, TORSION, shaft="drive")
    circuit = build(net)
    state = circuit.case.state._replace(drive=2.0)
    rates = at(circuit, state)[0]
    energy, *_ = stored_rates(circuit, state, rates)
    assert rates.books.supplied.drive == pytest.approx(energy, rel=1e-8)


# Oils


def test_different_oils_may_meet_in_a_cylinder_only(oil, of):
    other = UsualOil(liquid_bulk_modulus=1e9, density=900.0)
    net = Network(oil)
    net.volume("one", of.chamber, start=2e6)
    net.volume("two", of.chamber, start=3e6, oil=other)
    net.tank("tank")
    net.tank("sea", oil=other)
    net.rod("rod", position=0.1, velocity=0.1)
    net.add("cylinder", CYLINDER, of.cylinder, a="one", b="two", rod="rod")
    net.add("left", ORIFICE, of.orifice, a="one", b="tank", area=1e-6)
    net.add("right", ORIFICE, of.orifice, a="two", b="sea", area=1e-6)
    for component, values in ((ORIFICE, of.orifice), (LINE, Line(length=1.0, diameter=0.01))):
        area = {"area": 1e-6} if component is ORIFICE else {}
        with pytest.raises(
            NetworkError, match=wording.network.different_oils.format(one="a", there="one", other="b", here="two")
        ):
            net.add("between", component, values, a="one", b="two", **area)
    circuit = build(net)
    held = circuit.case.command.held
    assert held.medium_two_oil.density == pytest.approx(held.medium.density * 900.0 / 876.0)
    outputs = at(circuit, circuit.case.state)[1]
    drops = 2e6 - 101325.0, 3e6 - 101325.0
    ratio = np.sqrt(drops[1] / held.medium_two_oil.density) / np.sqrt(drops[0] / held.medium.density)
    assert outputs.right_flow / outputs.left_flow == pytest.approx(ratio, rel=5e-3)


def test_oils_of_different_references_cannot_push_one_piston(oil, of):
    other = UsualOil(reference_pressure=2e5)
    net = Network(oil)
    net.volume("one", of.chamber, start=2e6)
    net.volume("two", of.chamber, start=3e6, oil=other)
    net.rod("rod")
    with pytest.raises(NetworkError, match=wording.network.different_references):
        net.add("cylinder", CYLINDER, of.cylinder, a="one", b="two", rod="rod")


# Start values and changed parameters


def test_changed_parameters_change_all_that_depends_on_them(oil, of):
    net = Network(oil, initial=of.relief)
    net.tank("tank")
    net.volume("inlet", of.chamber, start="initial.cracking_pressure")
    net.volume("line", Chamber(volume=1e-4), start=3e6)
    net.add("relief", RELIEF_VALVE, of.relief, a="inlet", b="tank")
    net.add("load", ORIFICE, of.orifice, a="inlet", b="line", area=1e-6)
    circuit = build(net)
    params = circuit.case.params
    assert (circuit.case.state.inlet, circuit.case.state.line) == (1e7, 3e6)
    changed = circuit.case_of(
        replace(
            params,
            initial=replace(params.initial, cracking_pressure=8e6),
            start=replace(params.start, line=4e6),
            temperature=constant(330.0),
            tank_pressure=constant(2e5),
        )
    )
    assert (changed.state.inlet, changed.state.line) == (8e6, 4e6)
    assert changed.command.held.medium.density < circuit.case.command.held.medium.density
    assert changed.command.held.tank.pressure == 2e5


def test_longer_helix_moves_the_spool_further():
    """The position follows from the duty ratio and the valve, which stands among the parameters once."""
    system, longer = load_system("prototype"), load_system("prototype", ["valve.helix_length=22.352 mm"])
    params = system.case.params
    case = system.circuit.case_of(replace(params, valve=longer.case.params.valve))
    cases = (case, longer.case, system.case)
    rates = [flat(system.model.circuit(0.0, c.state, c.command, c.params)[0]) for c in cases]
    assert np.array_equal(rates[0], rates[1])
    assert not np.array_equal(rates[0], rates[2])
