"""Symbols of valves and resistances in the manner of ISO 1219-1, each about its centre, flow from bottom to top."""

from collections.abc import Mapping
from dataclasses import replace

from vvdp.report.symbol import Side, Symbol, Terminal
from vvdp.report.symbols import arrow, blocked_port, pipe, rotary_drive, rotary_valve_body, set_position, spring


def box(x0: float, y0: float, x1: float, y1: float) -> str:
    """A rectangle between two corners."""
    return f'<rect x="{x0:g}" y="{y0:g}" width="{x1 - x0:g}" height="{y1 - y0:g}"/>'


def through(reach: float) -> dict[str, Terminal]:
    """The terminals of a symbol in a vertical line, inlet below and outlet above."""
    return {"inlet": Terminal(0, reach, Side.BOTTOM), "outlet": Terminal(0, -reach, Side.TOP)}


def stubs(edge: float, reach: float) -> str:
    """The pieces of line between a box's edges and its terminals."""
    return pipe((0, edge), (0, reach)) + pipe((0, -edge), (0, -reach))


def _restriction(y: float, wide: float = 13.0, high: float = 15.0) -> str:
    return "".join(f'<path d="M {s * wide:g} {y - high:g} Q {s:g} {y:g} {s * wide:g} {y + high:g}"/>' for s in (-1, 1))


def orifice() -> Symbol:
    """A sharp-edged orifice, whose flow does not depend on the viscosity."""
    edges = "".join(pipe((s * 13, -13), (s * 3, 0), (s * 13, 13)) for s in (-1, 1))
    return Symbol((-20, -28, 20, 28), edges + pipe((0, 28), (0, -28)), through(28))


def throttle(adjustable: bool = False) -> Symbol:
    """A throttle."""
    hand = arrow((-20, 20), (20, -20), 8) if adjustable else ""
    return Symbol((-20, -28, 20, 28), _restriction(0) + pipe((0, 28), (0, -28)) + hand, through(28))


def two_orifices() -> Symbol:
    """Two restrictions in series."""
    drawn = _restriction(18, 13, 13) + _restriction(-18, 13, 13) + pipe((0, 40), (0, -40))
    return Symbol((-20, -40, 20, 40), drawn, through(40))


def flow_control() -> Symbol:
    """A flow control valve that compensates its pressure."""
    inside = _restriction(0, 9, 11) + pipe((0, 20), (0, -20)) + arrow((-18, 17), (18, -17), 7)
    compensated = arrow((17, 15), (17, 1), 6)
    return Symbol((-24, -34, 24, 34), box(-24, -20, 24, 20) + stubs(20, 34) + inside + compensated, through(34))


def one_way_throttle() -> Symbol:
    """A throttle with a check valve beside it."""
    throttle = _restriction(0, 10, 12) + pipe((0, 34), (0, -34))
    beside = pipe((0, 26), (24, 26), (24, 13)) + pipe((0, -26), (24, -26), (24, -5))
    check = '<circle cx="24" cy="0" r="5"/>' + pipe((15, 2), (24, 11), (33, 2))
    return Symbol((-14, -34, 34, 34), throttle + beside + check, through(34))


def _diamond() -> str:
    return pipe((0, 20), (20, 0), (0, -20), (-20, 0), (0, 20)) + stubs(20, 30)


def filter_symbol() -> Symbol:
    """A filter."""
    return Symbol((-20, -30, 20, 30), _diamond() + pipe((-20, 0), (20, 0), pilot=True), through(30))


def cooler() -> Symbol:
    """A cooler, heat going out either way."""
    heat = arrow((6, 0), (32, 0), 8) + arrow((-6, 0), (-32, 0), 8)
    return Symbol((-32, -30, 32, 30), _diamond() + heat, through(30))


def _spring_set(x: float) -> str:
    return spring(x, x + 26, 0) + arrow((x + 3, 15), (x + 24, -15), 7)


def _pressure_valve(shift: float) -> str:
    return box(-20, -20, 20, 20) + stubs(20, 36) + arrow((shift, 20), (shift, -20)) + _spring_set(20)


def relief_valve() -> Symbol:
    """A relief valve, opened by the pressure at its inlet."""
    pilot = pipe((0, 28), (-32, 28), (-32, 0), (-20, 0), pilot=True)
    return Symbol((-32, -36, 46, 36), _pressure_valve(-8) + pilot, through(36))


def unloading_valve() -> Symbol:
    """A valve that a pressure elsewhere opens against a spring."""
    pilot = pipe((-34, 0), (-20, 0), pilot=True)
    terminals = through(36) | {"pilot": Terminal(-34, 0, Side.LEFT)}
    return Symbol((-34, -36, 46, 36), _pressure_valve(-8) + pilot, terminals)


def sequence_valve() -> Symbol:
    """A sequence valve: opened by the pressure at its inlet, its spring drained on its own; a check valve beside it."""
    pilot = pipe((0, 28), (-32, 28), (-32, 0), (-20, 0), pilot=True)
    drain = pipe((46, 0), (58, 0), (58, 48), pilot=True)
    terminals = through(48) | {"drain": Terminal(58, 48, Side.BOTTOM)}
    return Symbol((-62, -48, 58, 48), _pressure_valve(-8) + pilot + drain + _bypass(-48), terminals)


def counterbalance_valve() -> Symbol:
    """A counterbalance valve: opened by the pressure at its inlet and by a pilot, with a check valve beside it."""
    own = pipe((0, 28), (-32, 28), (-32, 7), (-20, 7), pilot=True)
    pilot = pipe((-34, -7), (-20, -7), pilot=True)
    terminals = through(48) | {"pilot": Terminal(-34, -7, Side.LEFT)}
    drawn = _pressure_valve(-8) + own + pilot + _bypass(70)
    return Symbol((-34, -48, 84, 48), drawn, terminals)


def brake_valve() -> Symbol:
    """A brake valve: opened by a pilot alone, with a check valve beside it."""
    pilot = pipe((-34, 0), (-20, 0), pilot=True)
    terminals = through(48) | {"pilot": Terminal(-34, 0, Side.LEFT)}
    return Symbol((-34, -48, 84, 48), _pressure_valve(-8) + pilot + _bypass(70), terminals)


def compensator(upstream: bool) -> Symbol:
    """A pressure compensator whose pilot acts with its spring; before a throttle it is open without pressure."""
    y = -28 if upstream else 28
    own = pipe((0, y), (-32, y), (-32, 0), (-20, 0), pilot=True)
    load = pipe((46, 0), (58, 0), (58, -36), pilot=True)
    terminals = through(36) | {"pilot": Terminal(58, -36, Side.TOP)}
    return Symbol((-32, -36, 58, 36), _pressure_valve(0 if upstream else -8) + own + load, terminals)


def pump_compensator() -> Symbol:
    """The pressure control of a pump: its outlet's pressure against a set spring and the pressure of a pilot."""
    inlet, outlet = pipe((-10, 20), (-10, 36), pilot=True), pipe((-34, 0), (-20, 0), pilot=True)
    load = pipe((46, 0), (58, 0), (58, -36), pilot=True)
    inside = arrow((-10, 20), (-10, -20)) + pipe((-10, -20), (-10, -28))
    terminals = {
        "inlet": Terminal(-10, 36, Side.BOTTOM),
        "outlet": Terminal(-34, 0, Side.LEFT),
        "pilot": Terminal(58, -36, Side.TOP),
    }
    drawn = box(-20, -20, 20, 20) + inside + _spring_set(20) + inlet + outlet + load
    return Symbol((-34, -36, 58, 36), drawn, terminals)


def priority_valve() -> Symbol:
    """A priority valve: inlet below; its spring and pilot open the way to the priority port, its pressure the other."""
    boxes = box(-40, -20, 0, 20) + box(0, -20, 40, 20)
    rest = arrow((28, 20), (12, -20)) + blocked_port(28, -20, up=False)
    other = arrow((-12, 20), (-12, -20)) + blocked_port(-28, -20, up=False)
    lines = pipe((28, 20), (28, 34)) + pipe((12, -20), (12, -34)) + pipe((28, -20), (28, -34))
    own = pipe((12, -28), (-52, -28), (-52, 0), (-40, 0), pilot=True)
    load = pipe((66, 0), (76, 0), (76, -34), pilot=True)
    terminals = {
        "inlet": Terminal(28, 34, Side.BOTTOM),
        "priority": Terminal(12, -34, Side.TOP),
        "excess": Terminal(28, -34, Side.TOP),
        "pilot": Terminal(76, -34, Side.TOP),
    }
    return Symbol((-52, -34, 76, 34), boxes + rest + other + lines + spring(40, 66, 0) + own + load, terminals)


def cartridge_valve() -> Symbol:
    """A cartridge valve: its poppet between a, below, and b, at the side; spring and pilot at its back."""
    poppet = pipe((-12, -8), (-12, 8), (-5, 16), (5, 16), (12, 8), (12, -8), (-12, -8))
    sleeve = pipe((-12, -30), (-20, -30), (-20, 20), (-7, 20)) + pipe((7, 20), (20, 20), (20, 14))
    upper = pipe((12, -30), (20, -30), (20, 2)) + pipe((-12, -30), (12, -30))
    coil = pipe((0, -8), (-6, -12), (6, -16), (-6, -20), (6, -24), (0, -30))
    lines = pipe((0, 16), (0, 34)) + pipe((20, 8), (34, 8)) + pipe((0, -30), (0, -42), pilot=True)
    terminals = {
        "inlet": Terminal(0, 34, Side.BOTTOM),
        "outlet": Terminal(34, 8, Side.RIGHT),
        "pilot": Terminal(0, -42, Side.TOP),
    }
    return Symbol((-20, -42, 34, 34), poppet + sleeve + upper + coil + lines, terminals)


def _bypass(x: float) -> str:
    """A check valve from top to bottom beside a valve, in lines that join those of the valve."""
    ball = f'<circle cx="{x:g}" cy="-4" r="8"/>'
    seat = pipe((x - 14, -6), (x, -17), (x + 14, -6))
    lines = pipe((0, -42), (x, -42), (x, -17)) + pipe((x, 4), (x, 42), (0, 42))
    return ball + seat + lines + pipe((0, 36), (0, 48)) + pipe((0, -36), (0, -48))


def shuttle_valve() -> Symbol:
    """A shuttle valve: the higher of the pressures at both ends reaches the line above."""
    seats = pipe((-12, -11), (-24, 0), (-12, 11)) + pipe((12, -11), (24, 0), (12, 11))
    ends = pipe((-24, 0), (-40, 0), (-40, 32)) + pipe((24, 0), (40, 0), (40, 32)) + pipe((0, -32), (0, -16))
    terminals = {
        "A": Terminal(-40, 32, Side.BOTTOM),
        "B": Terminal(40, 32, Side.BOTTOM),
        "outlet": Terminal(0, -32, Side.TOP),
    }
    drawn = box(-30, -16, 30, 16) + seats + '<circle cx="-11" cy="0" r="9"/>' + ends
    return Symbol((-40, -32, 40, 32), drawn, terminals)


def reducing_valve() -> Symbol:
    """A pressure-reducing valve, closed by the pressure at its outlet."""
    pilot = pipe((0, -28), (-32, -28), (-32, 0), (-20, 0), pilot=True)
    return Symbol((-32, -36, 46, 36), _pressure_valve(0) + pilot, through(36))


def _check() -> str:
    ball = '<circle cx="0" cy="4" r="8"/>'
    return ball + pipe((-14, 6), (0, 17), (14, 6)) + pipe((0, 28), (0, 17)) + pipe((0, -4), (0, -28))


def check_valve() -> Symbol:
    """A check valve that lets flow pass upward."""
    return Symbol((-15, -28, 15, 28), _check(), through(28))


def poppet_valve() -> Symbol:
    """A check valve with a spring, which lets flow pass upward."""
    coil = pipe((0, -4), (7, -7), (-7, -11), (7, -15), (-7, -19), (0, -22))
    return Symbol((-15, -28, 15, 28), _check() + coil, through(28))


def pilot_check_valve() -> Symbol:
    """A check valve that a pilot pressure opens."""
    terminals = through(28) | {"pilot": Terminal(-34, 12, Side.LEFT)}
    return Symbol((-34, -28, 15, 28), _check() + pipe((-34, 12), (-8, 12), pilot=True), terminals)


def pilot_closed_check_valve() -> Symbol:
    """A check valve that a pilot pressure holds closed."""
    terminals = through(28) | {"pilot": Terminal(-34, -16, Side.LEFT)}
    behind = pipe((-34, -16), (-8, -16), (-8, -3), pilot=True)
    return Symbol((-34, -28, 15, 28), _check() + behind, terminals)


def _solenoid(x: float, wide: float = 22.0, proportional: bool = False) -> str:
    coil = box(x, -11, x + wide, 11) + pipe((x + 5, -11), (x + wide - 5, 11))
    return coil + (arrow((x - 4, 15), (x + wide + 4, -17), 6) if proportional else "")


def valve_2_2() -> Symbol:
    """A 2/2 switching valve, closed at rest."""
    boxes = box(-60, -20, -20, 20) + box(-20, -20, 20, 20) + stubs(20, 32)
    inside = arrow((-40, 20), (-40, -20)) + blocked_port(0, 20, up=True) + blocked_port(0, -20, up=False)
    return Symbol((-82, -32, 46, 32), boxes + inside + _solenoid(-82) + spring(20, 46, 0), through(32))


def proportional_2_2() -> Symbol:
    """A 2/2 proportional valve."""
    rails = pipe((-60, -25), (20, -25)) + pipe((-60, 25), (20, 25))
    boxes = box(-60, -20, -20, 20) + box(-20, -20, 20, 20) + stubs(20, 34) + rails
    inside = arrow((-40, 20), (-40, -20)) + blocked_port(0, 20, up=True) + blocked_port(0, -20, up=False)
    drive = _solenoid(-82, proportional=True) + spring(20, 46, 0)
    return Symbol((-86, -34, 46, 34), boxes + inside + drive, through(34))


def valve_3_2() -> Symbol:
    """A 3/2 switching valve: at rest the load goes to the tank."""
    boxes = box(-76, -22, -26, 22) + box(-26, -22, 26, 22)
    rest = arrow((-13, -22), (13, 22)) + blocked_port(-13, 22, up=True)
    on = arrow((-63, 22), (-63, -22)) + blocked_port(-37, 22, up=True)
    lines = pipe((-13, 22), (-13, 34)) + pipe((13, 22), (13, 34)) + pipe((-13, -22), (-13, -34))
    terminals = {
        "P": Terminal(-13, 34, Side.BOTTOM),
        "T": Terminal(13, 34, Side.BOTTOM),
        "A": Terminal(-13, -34, Side.TOP),
    }
    drawn = boxes + rest + on + lines + _solenoid(-98) + spring(26, 52, 0)
    letters = ((-21, -29, "A", 11.0), (-21, 29, "P", 11.0), (21, 29, "T", 11.0))
    return Symbol((-98, -34, 52, 34), drawn, terminals, letters=letters)


def diverter_3_2() -> Symbol:
    """A 3/2 switching valve that sends one line to a load, and to the tank at rest."""
    boxes = box(-76, -22, -26, 22) + box(-26, -22, 26, 22)
    rest = pipe((-13, 22), (-13, 2), (13, 2), (13, 14)) + arrow((13, 2), (13, 22), 8) + blocked_port(-13, -22, up=False)
    on = arrow((-63, 22), (-63, -22)) + blocked_port(-37, 22, up=True)
    lines = pipe((-13, 22), (-13, 34)) + pipe((13, 22), (13, 34)) + pipe((-13, -22), (-13, -34))
    drawn = boxes + rest + on + lines + _solenoid(-98) + spring(26, 52, 0)
    return replace(valve_3_2(), svg=drawn)


def _spool_of_three(half: float, below: Mapping[str, float], above: Mapping[str, float], inside: str) -> Symbol:
    """A proportional valve of three positions, half a box wide on either side of its middle; its ports and their x."""
    edge = 3.0 * half
    boxes = "".join(box(x - half, -22, x + half, 22) for x in (-2.0 * half, 0.0, 2.0 * half))
    rails = pipe((-edge, -27), (edge, -27)) + pipe((-edge, 27), (edge, 27))
    drives = _solenoid(-edge - 44, proportional=True) + spring(-edge - 20, -edge, 0)
    drives += spring(edge, edge + 20, 0) + _solenoid(edge + 22, proportional=True)
    ends = {name: Terminal(x, 38, Side.BOTTOM) for name, x in below.items()}
    ends |= {name: Terminal(x, -38, Side.TOP) for name, x in above.items()}
    lines = "".join(pipe((t.x, t.y * 22 / 38), (t.x, t.y)) for t in sorted(ends.values(), key=lambda t: (t.x, t.y)))
    letters = tuple(
        (x + (8.0 if x > 0 else -8.0), y, name, 11.0)
        for row, y in ((above, -34), (below, 34))
        for name, x in row.items()
        if len(name) < 3
    )
    return Symbol((-edge - 48, -38, edge + 48, 38), boxes + rails + inside + lines + drives, ends, letters=letters)


def _blocked_ports(*places: tuple[float, bool]) -> str:
    """Blocked ports at an x, below where true."""
    return "".join(blocked_port(x, 22 if below else -22, up=below) for x, below in places)


def valve_4_3() -> Symbol:
    """A 4/3 proportional directional valve, closed in its middle."""
    middle = _blocked_ports((-14, True), (-14, False), (14, True), (14, False))
    straight = arrow((-70, 22), (-70, -22)) + arrow((-42, -22), (-42, 22))
    crossed = arrow((42, 22), (70, -22)) + arrow((42, -22), (70, 22))
    return _spool_of_three(28, {"P": -14, "T": 14}, {"A": -14, "B": 14}, middle + straight + crossed)


def valve_6_3() -> Symbol:
    """A 6/3 proportional directional valve whose bypass is open in its middle."""
    middle = _blocked_ports((-22, True), (22, True), (-22, False), (22, False)) + arrow((0, 22), (0, -22))
    straight = arrow((-102, 22), (-102, -22)) + arrow((-58, -22), (-58, 22)) + _blocked_ports((-80, True), (-80, False))
    crossed = arrow((58, 22), (102, -22)) + arrow((58, -22), (102, 22)) + _blocked_ports((80, True), (80, False))
    below, above = {"P": -22, "bypass": 0, "T": 22}, {"A": -22, "onward": 0, "B": 22}
    return _spool_of_three(40, below, above, middle + straight + crossed)


def load_sensing_valve() -> Symbol:
    """A 4/3 proportional directional valve, closed in its middle, with a port for the pressure of the load."""
    middle = _blocked_ports((-22, True), (-22, False), (22, False))
    middle += pipe((22, 22), (22, 8), (0, 8), (0, 22))
    straight = arrow((-102, 22), (-102, -22)) + arrow((-58, -22), (-58, 22)) + pipe((-80, 22), (-80, 0), (-102, 0))
    crossed = arrow((58, 22), (102, -22)) + arrow((58, -22), (102, 22)) + pipe((80, 22), (80, 10), (70, 10))
    return _spool_of_three(40, {"P": -22, "LS": 0, "T": 22}, {"A": -22, "B": 22}, middle + straight + crossed)


def rotary_valve() -> Symbol:
    """A rotary on/off valve: a turning spool switches the pump to the load and to the tank by turns."""
    terminals = {
        "P": Terminal(18, 44, Side.BOTTOM),
        "T": Terminal(46, 44, Side.BOTTOM),
        "A": Terminal(18, -44, Side.TOP),
    }
    lines = pipe((18, 32), (18, 44)) + pipe((46, 32), (46, 44)) + pipe((18, -32), (18, -44))
    drawn = rotary_valve_body(0, 0) + rotary_drive(-64, 0) + set_position(64, 0) + lines
    letters = ((9, -39, "A", 11.0), (9, 39, "P", 11.0), (55, 39, "T", 11.0))
    return Symbol((-110, -44, 110, 44), drawn, terminals, (-110, 110), letters)


def line() -> Symbol:
    """A tube with a length, in a horizontal line."""
    tube = box(-32, -5, 32, 5) + pipe((-44, 0), (-32, 0)) + pipe((32, 0), (44, 0))
    ends = {"inlet": Terminal(-44, 0, Side.LEFT), "outlet": Terminal(44, 0, Side.RIGHT)}
    return Symbol((-44, -9, 44, 9), tube, ends)


def hose() -> Symbol:
    """A flexible hose, in a horizontal line."""
    curve = '<path d="M -44 0 Q 0 36 44 0"/><circle cx="-44" cy="0" r="3.2"/><circle cx="44" cy="0" r="3.2"/>'
    ends = {"inlet": Terminal(-44, 0, Side.LEFT), "outlet": Terminal(44, 0, Side.RIGHT)}
    return Symbol((-44, -9, 44, 20), curve, ends)
