"""Every mistake of a person who draws a network is told in one line, before anything runs."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from vvdp.base.errors import ConfigError, NetworkError, ParameterError, RunError
from vvdp.base.kinds import Flow, Power, Pressure, Torque
from vvdp.base.signal import constant
from vvdp.components.flow_sources import FLOW_SOURCE
from vvdp.components.resistances import ORIFICE
from vvdp.components.rods import CYLINDER, SPRING
from vvdp.components.shafts import LOAD_TORQUE
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.flow import Passage, passage
from vvdp.hydraulics.orifice import Orifice, orifice_flow
from vvdp.hydraulics.ports import ShaftSpeed
from vvdp.hydraulics.rod import Spring
from vvdp.network.build import build
from vvdp.network.component import Component
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber, Connection, Load, Rotor
from vvdp.simulation.check import check_model
from vvdp.systems.system import load_system


class Lag(NamedTuple):
    flow: Flow


class Held(NamedTuple):
    flow: float


class Lossy(NamedTuple):
    flow: Flow
    loss: Power


class NoLoss(NamedTuple):
    flow: Flow


class TwoPorts(NamedTuple):
    a: Flow
    b: Flow
    loss: Power


class Lagged(NamedTuple):
    flow: Flow
    loss: Power
    rates: Lag


class Unlike(NamedTuple):
    flow: Flow
    loss: Pressure


class NoKind(NamedTuple):
    flow: Flow
    loss: Power
    shown: float


class HeldRates(NamedTuple):
    flow: Flow
    loss: Power
    rates: Held


class Twice(NamedTuple):
    flow: Flow
    a: Flow
    loss: Power


class Braked(NamedTuple):
    shaft: Torque
    loss: Power


def drop_of(a, b):
    return a.pressure - b.pressure


def right(a: FluidState, b: FluidState, values: Orifice) -> Passage:
    return passage(orifice_flow(1e-6, drop_of(a, b), 870.0, values), a, b)


def uphill(a: FluidState, b: FluidState, values: Orifice) -> Passage:
    return passage(orifice_flow(1e-6, drop_of(b, a), 870.0, values), a, b)


def wrong_sign(a: FluidState, b: FluidState, values: Orifice) -> TwoPorts:
    flow, loss = right(a, b, values)
    return TwoPorts(flow, flow, loss)


def forgotten_loss(a: FluidState, b: FluidState, values: Orifice) -> NoLoss:
    return NoLoss(right(a, b, values).flow)


def forgotten_port(a: FluidState, b: FluidState, c: FluidState, values: Orifice) -> TwoPorts:
    flow, loss = right(a, b, values)
    return TwoPorts(-2.0 * flow, flow, loss)


def forgotten_rates(a: FluidState, b: FluidState, state: Lag, values: Orifice) -> Passage:
    return right(a, b, values)


def too_few(a: FluidState, b: FluidState, state: Lag, values: Orifice) -> Lagged:
    return Lagged(*right(a, b, values))


def wrong_unit(a: FluidState, b: FluidState, values: Orifice) -> Unlike:
    return Unlike(*right(a, b, values))


def no_kind(a: FluidState, b: FluidState, values: Orifice) -> NoKind:
    return NoKind(*right(a, b, values), 1.0)


def state_without_kind(a: FluidState, b: FluidState, state: Held, values: Orifice) -> HeldRates:
    return HeldRates(*right(a, b, values), Held(0.0))


def counted_twice(a: FluidState, b: FluidState, values: Orifice) -> Twice:
    flow, loss = right(a, b, values)
    return Twice(flow, -flow, loss)


def chooses(a: FluidState, b: FluidState, values: Orifice) -> Passage:
    if a.pressure > b.pressure:
        return right(a, b, values)
    return right(a, b, values)


def with_math(a: FluidState, b: FluidState, values: Orifice) -> Passage:
    return passage(1e-9 * math.sqrt(abs(drop_of(a, b))) * np.sign(drop_of(a, b)), a, b)


RNG = np.random.default_rng(1)


def random(a: FluidState, b: FluidState, values: Orifice) -> Passage:
    return passage(orifice_flow(1e-6 * RNG.random(), drop_of(a, b), 870.0, values), a, b)


def misspelt(a: FluidState, b: FluidState, values: Orifice) -> Passage:
    return passage(orifice_flow(1e-6, a.presure - b.pressure, 870.0, values), a, b)


def unannotated(a, b: FluidState, values: Orifice) -> Passage:
    return right(a, b, values)


def no_result(a: FluidState, b: FluidState, values: Orifice):
    return right(a, b, values)


def portless(values: Orifice) -> Lossy:
    return Lossy(0.0, 0.0)


def three(a: FluidState, b: FluidState, c: FluidState, values: Orifice) -> Passage:
    return right(a, b, values)


def driving(a: FluidState, b: FluidState, shaft: ShaftSpeed, values: Orifice) -> Braked:
    return Braked(1.0, shaft.speed)


def earlier(t: float, values: Orifice) -> float:
    return t


def number(state: Lag, values: Orifice) -> float:
    return 1.0


def held_by_time(t: float, values: Orifice) -> Lag:
    return Lag(t)


OWN = [
    (Component(uphill, symbol=""), "uphill: its loss is -.*wrong way round"),
    (Component(wrong_sign, symbol=""), r"wrong_sign: what it gives to its ports adds up to .* m\^3/s.*a sign wrong"),
    (Component(forgotten_loss, symbol=""), "forgotten_loss: it gives .* W more than it takes.*a loss forgotten"),
    (Component(forgotten_port, symbol=""), "forgotten_port: what it gives.*a port forgotten"),
    (Component(forgotten_rates, symbol=""), "forgotten_rates: what 'state' is does not follow"),
    (Component(too_few, symbol=""), "Lagged is given too few values.*rates"),
    (
        Component(wrong_unit, symbol=""),
        r"'loss' of its result is a pressure level \[Pa\]; expected one in W",
    ),
    (Component(no_kind, symbol=""), "no_kind: output 'shown' has no kind"),
    (Component(state_without_kind, symbol=""), "state_without_kind: 'flow' of its state has no kind"),
    (Component(counted_twice, symbol=""), "counted_twice returns both 'flow' and 'a'"),
    (Component(chooses, symbol=""), "chooses by the state; write the choice with select"),
    (Component(with_math, symbol=""), "as np.sqrt for math.sqrt"),
    (Component(random, symbol=""), "two answers to the same question; random numbers belong"),
    (Component(misspelt, symbol=""), "FluidState has no field 'presure'; did you mean 'pressure'"),
    (Component(unannotated, symbol=""), "unannotated: what 'a' is does not follow"),
    (Component(no_result, symbol=""), "no_result: its result needs an annotation"),
    (Component(portless, symbol=""), "portless has no port"),
    (Component(three, symbol=""), "three returns a Passage and has 3 hydraulic ports; expected two"),
    (Component(right, symbol="", stop=earlier), r"stop, stop, returns 0(.0)? when asked at t = 0 s"),
    (Component(right, symbol="", stored=number), "right: its stored, number|what 'state' is does not follow"),
    (Component(right, symbol="", held=held_by_time), r"right: its held, held_by_time, takes 't' \(time\)"),
    (Component(right, symbol="", averages=("flaw",)), "averages 'flaw', which is none of its outputs"),
    (Component(driving, symbol=""), r"driving: it gives .* W more than it takes"),
]


@pytest.mark.parametrize(("component", "told"), OWN, ids=[c.law.__name__ for c, _ in OWN])
def test_mistake_in_an_own_component(component, told, oil, of):
    """Told while it is added, while the network is built, or by the check before a run."""
    with pytest.raises((NetworkError, RunError), match=told) as caught:
        net = Network(oil)
        net.tank("tank")
        net.volume("line", of.chamber, start=2e6)
        net.shaft("shaft", Rotor(inertia=1.0))
        ends = {"a": "line", "b": "tank", "c": "line", "shaft": "shaft"}
        found = {port: ends[port] for port in component.ports}
        net.add("own", component, of.orifice, **found)
        circuit = build(net)
        check_model(circuit.model, circuit.case)
    assert "\n" not in str(caught.value)


def test_right_component_is_not_refused(oil, of):
    net = Network(oil)
    net.tank("tank")
    net.volume("line", of.chamber, start=2e6)
    net.add("own", Component(right, symbol=""), of.orifice, a="line", b="tank")
    circuit = build(net)
    check_model(circuit.model, circuit.case)


def area_of(level: float) -> float:
    return 1e-6 * level


def orifice(net, of, area, **more):
    net.add("x", ORIFICE, of.orifice, a="line", b="tank", area=area, **more)


DRAWN = [
    (lambda n, of: n.add("x", ORIFICE, of.orifice, a="line", area=1e-6), "x: port 'b' is open; join it to one of"),
    (lambda n, of: n.add("x", ORIFICE, of.orifice, a="lime", b="tank", area=1e-6), "'lime', which is no node; did you"),
    (lambda n, of: n.add("x", ORIFICE, of.orifice, a="line", b="tank"), "x: input 'area' is not connected"),
    (lambda n, of: orifice(n, of, "5 mm^2"), r"'5 mm\^2' leads nowhere.*text"),
    (lambda n, of: orifice(n, of, -1.0), "x.area: -1 m.*outside"),
    (lambda n, of: orifice(n, of, "line.pressure"), r"x.area is an area \[m\^2\]"),
    (lambda n, of: n.add("x", ORIFICE, of.orifice, a="line", b="tank", aera=1e-6), "is not connected"),
    (lambda n, of: orifice(n, of, 1e-6, c="line"), "no port or input 'c'"),
    (lambda n, of: n.add("x", ORIFICE, of.source, a="line", b="tank", area=1e-6), "takes the values Orifice; Fl"),
    (lambda n, of: n.add("x", ORIFICE, a="line", b="tank", area=1e-6), "takes 1 parameter classes, Orifice; 0 given"),
    (lambda n, of: n.add("x", ORIFICE, of.orifice, a="line", b="rod", area=1e-6), "joins a volume .*; 'rod' is"),
    (lambda n, of: n.add("line", ORIFICE, of.orifice, a="line", b="tank", area=1e-6), "the name 'line' is taken"),
    (lambda n, of: n.add("total", ORIFICE, of.orifice, a="line", b="tank", area=1e-6), "'total' is reserved"),
    (lambda n, of: n.add("return", ORIFICE, of.orifice, a="line", b="tank", area=1e-6), "'return' is reserved"),
    (lambda n, of: n.add("2x", ORIFICE, of.orifice, a="line", b="tank", area=1e-6), "cannot be a name"),
    (lambda n, of: orifice(n, of, 1e-6, start=Lag(0.0)), "has no state"),
    (lambda n, of: orifice(n, of, Connection(area_of, (5.0,))),
     "5.0 cannot be an argument of area_of"),
    (lambda n, of: n.volume("x", of.chamber, start=200.0), "nearly a vacuum; pressures are in Pa, not in bar"),
    (lambda n, of: n.volume("x", of.chamber, start="5 bar"), "'5 bar' is neither a number in SI nor the path"),
    (lambda n, of: n.volume("x", 1e-3, start=1e5), "x: its values are 0.001; expected Chamber or Vessel"),
    (lambda n, of: n.volume("x", Chamber(volume=12.7), start=1e5), "12.7 m.*outside"),
    (lambda n, of: n.volume("x", Chamber(volume="5 cc"), start=1e5), "'5 cc' is a text; expected a number in SI"),
    (lambda n, of: n.tank("x", 2.0), "x: pressure 2 Pa absolute is nearly a vacuum"),
    (lambda n, of: n.tank("x", "line.pressure"), "calculated once per sample; expected a number in SI or a Signal"),
    (lambda n, of: n.pressure_source("x", 200.0), "x: pressure 200 Pa absolute is nearly a vacuum"),
    (lambda n, of: n.pressure_source("x", None), "x: None is no source"),
    (lambda n, of: n.driven_shaft("x", "spool.speed"), "x: 'spool.speed' leads nowhere"),
    (lambda n, of: n.shaft("x"), "x has no inertia"),
    (lambda n, of: n.rod("x", Load(mass=0.0)), "x has no mass"),
    (lambda n, of: n.add("x", LOAD_TORQUE, shaft="rod", torque=1.0), "joins a shaft or driven shaft; 'rod' is a rod"),
]  # fmt: skip


@pytest.mark.parametrize(("draw", "told"), DRAWN, ids=[told for _, told in DRAWN])
def test_mistake_in_drawing(draw, told, oil, of):
    with pytest.raises((NetworkError, ParameterError), match=told) as caught:
        net = Network(oil)
        net.tank("tank")
        net.volume("line", of.chamber, start=2e6)
        net.rod("rod", Load(mass=1.0))
        net.add("supply", FLOW_SOURCE, of.source, a="tank", b="line", flow=constant(1e-4))
        net.add("spring", SPRING, Spring(stiffness=1e3, preload=0.0, rest_position=0.0), rod="rod")
        draw(net, of)
        build(net)
    assert "\n" not in str(caught.value)


def test_networks_of_nothing_and_of_reserved_values(oil, of):
    with pytest.raises(NetworkError, match="at least one component"):
        build(Network(oil))
    with pytest.raises(NetworkError, match="'start' is reserved"):
        Network(oil, start=of.orifice)
    with pytest.raises(ParameterError, match="temperature: 40 K"):
        net = Network(oil, temperature=constant(40.0))
        net.tank("tank")
        net.volume("line", of.chamber, start=2e6)
        net.add("load", ORIFICE, of.orifice, a="line", b="tank", area=1e-6)
        build(net)


# The same in a file, with its line


FILE = """\
title = "A cylinder"

[run]
until = "1 s"

[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "100 cc", start = "20 bar" }
rod = { type = "rod", mass = "2 kg" }

[components]
supply = { type = "flow-source", a = "tank", b = "line", flow = "4 lpm", counted_at_outlet = 0 }
load = { type = "orifice", a = "line", b = "tank", area = "1 mm^2", VALUES }
spring = { type = "spring", rod = "rod", stiffness = "10 kN/m", preload = "0 N", rest_position = "0 mm" }
"""
FILE = FILE.replace("VALUES", 'discharge_coefficient = 0.6, transition_pressure = "1 kPa"')
IN_FILE = [
    ('volume = "100 cc"', 'volume = "100 bar"', 8, "nodes.line.volume"),
    ('volume = "100 cc"', "volume = 100", 8, "nodes.line.volume"),
    ('volume = "100 cc"', 'volumes = "100 cc"', 8, "volume"),
    ('start = "20 bar"', 'start = "many"', 8, "nodes.line.start"),
    ('a = "line", b = "tank", area', 'a = "line", area', 13, "port 'b' is open"),
    ('a = "line", b = "tank", area', 'a = "lime", b = "tank", area', 13, "did you mean 'line'"),
    ('type = "orifice"', 'type = "orifce"', 13, "did you mean 'orifice'"),
    ('type = "volume"', 'type = "volum"', 8, "did you mean 'volume'"),
    ('area = "1 mm^2"', 'area = "1 mm"', 13, "components.load.area"),
    ('area = "1 mm^2"', 'aera = "1 mm^2"', 13, "did you mean 'area'"),
    ('area = "1 mm^2"', 'area = { from = "rod.postion" }', 13, "has no 'postion'; did you mean 'position'"),
    ('area = "1 mm^2"', 'area = { from = "rod.position" }', 13, "is an area [m^2], 'rod.position' is a position [m]"),
    ('area = "1 mm^2"', 'area = { from = "lime.pressure" }', 13, "'lime.pressure' leads nowhere"),
    ('rod = "rod", stiffness', 'rod = "line", stiffness', 14, "joins a rod"),
    ('mass = "2 kg"', 'mass = "0 kg"', 9, "rod has no mass"),
    ('until = "1 s"', 'until = "1 bar"', 4, "run.until"),
    ("spring = {", "line = {", 14, "the name 'line' is taken"),
    ("spring = {", "check = {", 14, "the name 'check' is reserved for the equations that are written from the network"),
    ("line = {", "check = {", 8, "the name 'check' is reserved"),
    ('type = "orifice"', 'type = "pulsed-switching-valve"', 13, "takes no a, b, area; the keys given"),
]
ONE_CAUSE = [
    ("load = {", "check = {", "the name 'check' is reserved"),
    ('type = "orifice"', 'type = "pulsed-switching-valve"', "the keys given are those of type 'orifice'"),
    ('type = "spring"', 'type = "gerotor-drive"', "the keys given are those of type 'spring'"),
    ('type = "spring"', 'type = "sprig"', "type 'sprig' is unknown; did you mean 'spring'?"),
]


@pytest.mark.parametrize(("old", "new", "told"), ONE_CAUSE, ids=[told for *_, told in ONE_CAUSE])
def test_what_follows_from_a_mistake_is_not_told_beside_it(tmp_path, old, new, told):
    path = tmp_path / "mine.toml"
    assert old in FILE
    path.write_text(FILE.replace(old, new), encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        load_system(str(path))
    (fault,) = caught.value.faults
    assert told in fault.message


@pytest.mark.parametrize(("old", "new", "line", "told"), IN_FILE, ids=[told for *_, told in IN_FILE])
def test_mistake_in_a_file(tmp_path, old, new, line, told):
    path = tmp_path / "mine.toml"
    assert old in FILE
    path.write_text(FILE.replace(old, new), encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        load_system(str(path))
    text = str(caught.value)
    assert told in text
    assert f"{path}:{line}:" in text


def test_file_without_a_mistake_is_ready(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(FILE, encoding="utf-8")
    system = load_system(str(path))
    check_model(system.model, system.case)


def test_cylinder_without_its_rod(oil, of):
    net = Network(oil)
    net.volume("one", of.chamber, start=2e6)
    net.volume("two", of.chamber, start=2e6)
    with pytest.raises(NetworkError, match="port 'rod' is open; join it to one of no node yet"):
        net.add("cylinder", CYLINDER, of.cylinder, a="one", b="two")
