"""Symbols of pumps, motors, cylinders, stores and what they move, in the manner of ISO 1219-1, about their centres."""

from dataclasses import replace

from vvdp.report import symbols as draw
from vvdp.report.symbol import Side, Symbol, Terminal
from vvdp.report.symbols import arrow, arrow_head, filled_polygon, pipe
from vvdp.report.valve_symbols import box

ROUND = 26.0


def _circle(radius: float) -> str:
    return f'<circle cx="0" cy="0" r="{radius:g}"/>'


def _round_shape(lower: str, upper: str) -> dict[str, Terminal]:
    return {lower: Terminal(0, ROUND, Side.BOTTOM), upper: Terminal(0, -ROUND, Side.TOP)}


def pump() -> Symbol:
    """A pump of fixed displacement."""
    drawn = _circle(ROUND) + filled_polygon((0, -26), (-9, -11), (9, -11))
    return Symbol((-26, -26, 26, 26), drawn, _round_shape("suction", "outlet"), (-26, 26))


def variable_pump() -> Symbol:
    """A pump of variable displacement."""
    fixed = pump()
    return replace(fixed, svg=fixed.svg + arrow((-24, 24), (24, -24), 9))


def overcentre_pump() -> Symbol:
    """A pump of variable displacement for both directions of flow."""
    one_way = variable_pump()
    return replace(one_way, svg=one_way.svg + filled_polygon((0, 26), (-9, 11), (9, 11)))


def hydraulic_motor() -> Symbol:
    """A hydraulic motor of fixed displacement."""
    drawn = _circle(ROUND) + filled_polygon((0, 9), (-9, 24), (9, 24))
    return Symbol((-26, -26, 26, 26), drawn, _round_shape("inlet", "outlet"), (-26, 26))


def overcentre_motor() -> Symbol:
    """A hydraulic motor of variable displacement for both directions of flow."""
    fixed = hydraulic_motor()
    back = filled_polygon((0, -9), (-9, -24), (9, -24))
    return replace(fixed, svg=fixed.svg + back + arrow((-24, 24), (24, -24), 9))


def flow_source() -> Symbol:
    """A source that holds a flow."""
    drawn = _circle(ROUND) + arrow((0, 5), (0, -24), 9)
    return Symbol((-26, -26, 26, 26), drawn, _round_shape("suction", "outlet"), letters=((0, 13, "Q", 14.0),))


def pressure_source() -> Symbol:
    """A source that holds a pressure."""
    drawn = _circle(24) + filled_polygon((0, -24), (-9, -9), (9, -9))
    return Symbol((-24, -24, 24, 24), drawn, {"port": Terminal(0, -24, Side.TOP)}, letters=((0, 5, "p", 16.0),))


def accumulator() -> Symbol:
    """A gas accumulator."""
    return Symbol((-15, -31, 15, 31), draw.accumulator(0, 31), {"port": Terminal(0, 31, Side.BOTTOM)})


def _capsule() -> str:
    return '<rect x="-15" y="-31" width="30" height="62" rx="15"/>'


def piston_accumulator() -> Symbol:
    """A gas accumulator with a piston."""
    gas = pipe((0, -10), (-7, -22), (7, -22), (0, -10))
    drawn = _capsule() + box(-15, -3, 15, 5) + gas
    return Symbol((-15, -31, 15, 31), drawn, {"port": Terminal(0, 31, Side.BOTTOM)})


def spring_accumulator() -> Symbol:
    """An accumulator with a spring."""
    coil = pipe((0, 4), (8, 0), (-8, -6), (8, -12), (-8, -18), (0, -22), (0, -31))
    drawn = _capsule() + pipe((-15, 4), (15, 4)) + coil
    return Symbol((-15, -31, 15, 31), drawn, {"port": Terminal(0, 31, Side.BOTTOM)})


def tank() -> Symbol:
    """A tank, the line ending in it from above."""
    return Symbol((-12, -7, 12, 7), pipe((-12, -6), (-12, 6), (12, 6), (12, -6)), {"port": Terminal(0, -6, Side.TOP)})


def level_tank() -> Symbol:
    """A tank with a level, both lines ending below it."""
    walls = pipe((-30, -14), (-30, 20), (30, 20), (30, -14))
    lines = pipe((-14, -26), (-14, 12)) + pipe((14, -26), (14, 12))
    level = pipe((-30, 0), (30, 0), pilot=True)
    ends = {"suction": Terminal(14, -26, Side.TOP), "inlet": Terminal(-14, -26, Side.TOP)}
    return Symbol((-30, -26, 30, 20), walls + level + lines, ends)


def dot() -> Symbol:
    """A node by itself."""
    return Symbol((-4, -4, 4, 4), draw.junction(0, 0))


def sensor(text: str = "p") -> Symbol:
    """A sensor with the letter of what it reads."""
    drawn = _circle(14) + pipe((0, 14), (0, 22))
    return Symbol((-14, -14, 14, 22), drawn, {"port": Terminal(0, 22, Side.BOTTOM)}, (-14, 14), ((0, 0, text, 13.0),))


def _cylinder_body() -> str:
    piston = box(-22, -18, -14, 18)
    return box(-60, -18, 42, 18) + piston + _shaft(-14, 78)


def cylinder() -> Symbol:
    """A double-acting cylinder with one rod."""
    lines = pipe((-51, 18), (-51, 30)) + pipe((33, 18), (33, 30))
    terminals = {"cap": Terminal(-51, 30, Side.BOTTOM), "rod": Terminal(33, 30, Side.BOTTOM)}
    return Symbol((-60, -18, 78, 30), _cylinder_body() + lines, terminals, (None, 78))


def spring_cylinder() -> Symbol:
    """A single-acting cylinder that a spring returns."""
    coil = pipe((-14, -11), (-7, 14), (0, -14), (7, 14), (14, -14), (21, 14), (28, -14), (35, 14), (42, -11))
    body = box(-60, -18, 42, 18) + box(-22, -18, -14, 18) + coil
    rod = _shaft(-14, 78) + pipe((-51, 18), (-51, 30))
    return Symbol((-60, -18, 78, 30), body + rod, {"cap": Terminal(-51, 30, Side.BOTTOM)}, (None, 78))


def plunger() -> Symbol:
    """A single-acting cylinder with a plunger."""
    drawn = pipe((42, -11), (42, -18), (-60, -18), (-60, 18), (42, 18), (42, 11)) + box(-20, -11, 78, 11)
    drawn += pipe((-51, 18), (-51, 30))
    return Symbol((-60, -18, 78, 30), drawn, {"cap": Terminal(-51, 30, Side.BOTTOM)}, (None, 78))


def weight() -> Symbol:
    """A mass that gravity pulls."""
    drawn = box(-26, -20, 26, 20) + arrow((14, -12), (14, 13), 8)
    return Symbol((-26, -20, 26, 20), drawn, {}, (-26, 26), ((-7, 0, "m", 15.0),))


def mass() -> Symbol:
    """A mass that slides."""
    return Symbol((-26, -20, 26, 20), box(-26, -20, 26, 20), {}, (-26, 26), ((0, 0, "m", 16.0),))


def inertia() -> Symbol:
    """An inertia that turns."""
    return Symbol((-8, -26, 8, 26), box(-8, -26, 8, 26), {}, (-8, 8))


def electric_motor() -> Symbol:
    """A motor that turns a shaft."""
    return Symbol((-24, -24, 24, 24), _circle(24), {}, (-24, 24), ((0, 0, "M", 19.0),))


def combustion_engine() -> Symbol:
    """A prime mover that is no electric motor."""
    return Symbol((-24, -24, 24, 24), box(-24, -24, 24, 24), {}, (-24, 24), ((0, 0, "M", 19.0),))


def driven_rod() -> Symbol:
    """A rod whose position is prescribed."""
    both = arrow((0, 9), (18, 9), 7) + arrow((0, 9), (-18, 9), 7)
    return Symbol((-24, -18, 24, 18), box(-24, -18, 24, 18) + both, {}, (-24, 24), ((0, -7, "x", 14.0),))


def gear() -> Symbol:
    """A pair of gear wheels, seen from the side."""
    drawn = box(-14, -26, -6, 2) + box(6, -2, 14, 26) + pipe((-14, 0), (-24, 0)) + pipe((14, 0), (24, 0))
    mesh = pipe((-6, 0), (6, 0), pilot=True)
    return Symbol((-24, -26, 24, 26), drawn + mesh, {}, (-24, 24))


def lever() -> Symbol:
    """A lever on a pivot."""
    pivot = pipe((0, 4), (-8, 20), (8, 20), (0, 4))
    return Symbol((-28, -12, 28, 20), pipe((-28, 0), (28, 0)) + pivot + draw.junction(0, 4), {}, (-28, 28))


def arm() -> Symbol:
    """An arm that a cylinder turns."""
    pivot = pipe((-16, 10), (-24, 24), (-8, 24), (-16, 10))
    drawn = pipe((-16, 10), (20, -20)) + pipe((6, 24), (20, -20)) + pivot
    return Symbol((-28, -24, 28, 24), drawn + draw.junction(-16, 10) + draw.junction(20, -20), {}, (-28, 28))


def drum() -> Symbol:
    """A drum that winds a rope."""
    rope = arrow((16, 0), (16, 28), 8)
    return Symbol((-20, -20, 20, 28), _circle(16) + draw.junction(0, 0) + rope, {}, (-20, 20))


def wheel() -> Symbol:
    """A wheel on a road."""
    road = pipe((-26, 18), (26, 18)) + pipe((-20, 18), (-26, 25)) + pipe((0, 18), (-6, 25)) + pipe((20, 18), (14, 25))
    return Symbol((-26, -18, 26, 25), _circle(18) + draw.junction(0, 0) + road, {}, (-26, 26))


def vehicle() -> Symbol:
    """A vehicle on its wheels."""
    wheels = '<circle cx="-14" cy="14" r="6"/><circle cx="14" cy="14" r="6"/>'
    drawn = box(-26, -14, 26, 8) + wheels + pipe((-30, 20), (30, 20))
    return Symbol((-30, -14, 30, 20), drawn, {}, (-26, 26), ((0, -3, "m", 14.0),))


def telescope() -> Symbol:
    """A single-acting telescopic cylinder."""
    body = pipe((30, -20), (-60, -20), (-60, 20), (30, 20)) + box(-50, -13, 50, 13) + box(-40, -6, 78, 6)
    drawn = body + pipe((-55, 20), (-55, 30))
    return Symbol((-60, -20, 78, 30), drawn, {"cap": Terminal(-55, 30, Side.BOTTOM)}, (None, 78))


def _ground(x: float) -> str:
    hatch = "".join(pipe((x, y), (x + 6, y - 6)) for y in (-9, -2, 5, 12, 19))
    return pipe((x, -17), (x, 17)) + hatch


def spring(grounded: bool = True) -> Symbol:
    """A spring, held at its right end where it is grounded."""
    drawn = draw.spring(-28, 28, 0) + (_ground(28) if grounded else "")
    return Symbol((-28, -19, 34 if grounded else 28, 19), drawn, {}, (-28, None if grounded else 28))


def damper(grounded: bool = True) -> Symbol:
    """A damper or friction, held at its right end where it is grounded."""
    pot = pipe((-10, -11), (14, -11), (14, 11), (-10, 11)) + pipe((14, 0), (28, 0))
    drawn = pot + pipe((-28, 0), (2, 0)) + pipe((2, -8), (2, 8)) + (_ground(28) if grounded else "")
    return Symbol((-28, -19, 34 if grounded else 28, 19), drawn, {}, (-28, None if grounded else 28))


def end_stop() -> Symbol:
    """An end stop: a plate that meets a wall."""
    drawn = pipe((-28, 0), (-4, 0)) + pipe((-4, -12), (-4, 12)) + _ground(10)
    return Symbol((-28, -19, 16, 19), drawn, {}, (-28, None))


def force() -> Symbol:
    """A force that acts on a rod."""
    return Symbol((-28, -14, 24, 14), arrow((24, 0), (-28, 0), 11), {}, (-28, None), ((10, -10, "F", 13.0),))


def torque() -> Symbol:
    """A torque that acts on a shaft."""
    arc = '<path d="M 6 -15 A 16 16 0 0 1 6 15"/>' + arrow_head(-1, 17, (-0.93, 0.37), 9)
    return Symbol((-20, -19, 24, 19), pipe((-20, 0), (0, 0)) + arc, {}, (-20, None), ((-9, -11, "T", 13.0),))


def _shaft(x0: float, x1: float) -> str:
    return pipe((x0, -2.6), (x1, -2.6)) + pipe((x0, 2.6), (x1, 2.6))


def coupling() -> Symbol:
    """A coupling between two shafts."""
    plates = pipe((-4, -15), (-4, 15)) + pipe((4, -15), (4, 15))
    return Symbol((-18, -17, 18, 17), plates + _shaft(-18, -4) + _shaft(4, 18), {}, (-18, 18))
