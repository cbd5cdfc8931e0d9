"""What the circuits from practice should show: balances of forces, torques, flows and heat at rest, and quasi-static
integrations by SciPy, written down with nothing of vvdp. Pressures are gauge; oil without air."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq, fsolve

BAR, LPM, G, P0, MODULUS, DENSITY = 1e5, 1e-3 / 60.0, 9.80665, 101325.0, 1.4e9, 876.0
RPM = np.pi / 30.0


class Number(NamedTuple):
    """A number by hand, that of the run, and by how much of it what the formula leaves out may move it."""

    by_hand: float
    found: float
    within: float


class Course:
    """States and outputs of a run over time; pressures of nodes as gauge pressures."""

    def __init__(self, run, found, nodes):
        self.found, self.nodes = found, nodes
        self.times, self.state, self.outputs = run.times, run.state, run.outputs

    def whole(self, path: str):
        name, *rest = path.split(".")
        values = getattr(self.state, name, None)
        values = getattr(self.outputs, name) if values is None else values
        for each in rest:
            values = getattr(values, each)
        return values - P0 if path in self.nodes else values

    def at(self, path: str, t: float) -> float:
        return float(np.interp(t, self.times, self.whole(path)))

    def mean(self, path: str, begin: float, end: float) -> float:
        return float(np.mean(np.interp(np.linspace(begin, end, 1001), self.times, self.whole(path))))

    def slope(self, path: str, begin: float, end: float) -> float:
        return (self.at(path, end) - self.at(path, begin)) / (end - begin)

    def when(self, path: str, value: float, since: float, until: float) -> float:
        """When a rising or falling course passes a value between two times [s]."""
        return float(brentq(lambda t: self.at(path, t) - value, since, until))


def nu(pressure):
    """Volume of oil over that at the tank."""
    return np.exp(-pressure / MODULUS)


def root(drop):
    return np.sign(drop) * np.sqrt(np.abs(drop))


Table = Mapping[str, Number]


def swing_drive(c: Course) -> Table:
    """Torque of the drop over inertia, with relief, brake and shock valve along their lines."""
    D, J, Q, friction = 80e-6 / (2 * np.pi), 2.677, 120 * LPM, 20.0

    def starting(w):
        spare = 1.0 - D * w / Q
        feed = brentq(lambda P: (P / BAR - 200) / 10 * np.sqrt(P / (210 * BAR)) - spare, 200 * BAR, 210 * BAR)
        return (D * (feed - 5 * BAR - 10 * BAR * (D * w / Q) ** 2) - friction) / J

    def stopping(w):
        feed = c.at("feed", 5.8)
        braked = brentq(
            lambda P: (P / BAR - 250) / 10 * np.sqrt((P - feed) / (260 * BAR - feed)) - D * w / Q, 250 * BAR, 261 * BAR
        )
        return (D * (braked - feed) + friction) / J

    start, stop = (quad(lambda w, rate=rate: 1.0 / rate(w), 20.0, 100.0)[0] for rate in (starting, stopping))
    began = c.when("swing.speed", 20.0, 0.05, 0.8)
    slows = c.when("swing.speed", 100.0, 5.3, 6.0)
    return {
        "from 20 to 100 rad/s [s]": Number(start, c.when("swing.speed", 100.0, 0.8, 1.6) - began, 5e-3),
        "speed, Q/D [rad/s]": Number(Q / D, c.slope("swing.angle", 3.0, 5.0), 5e-3),
        "from 100 to 20 rad/s [s]": Number(stop, c.when("swing.speed", 20.0, 6.0, 6.4) - slows, 5e-3),
    }


def regenerative_boom(c: Course) -> Table:
    """Balances of force and flow, up and down."""
    A_a, A_b, W, damping, Q = 7854e-6, 4006e-6, 5000 * G, 5e3, 40 * LPM
    edge = 2e-6 * 0.85 / 0.95

    def up(x):
        v, bottom, a, b, line = x[0], *(x[1:] * BAR)
        over_check = (b - line) / BAR
        into_a = (bottom - a) / BAR
        return (
            (a * A_a - b * A_b - W - damping * v) / W,
            Q / nu(line) - v * (A_a / nu(a) - A_b / nu(b)),
            v * A_b - 60 * LPM * (over_check - 0.5) / 2.5 * root(over_check / 3.0),
            v * A_a - edge * root(line - bottom),
            v * A_a - 80 * LPM * min((into_a - 0.5) / 4.5, 1.0) * root(into_a / 5.0),
        )

    def down(x):
        v, bottom, a, b = x[0], *(x[1:] * BAR)
        opening = (a - bottom + 3.0 * (b - bottom) - 180 * BAR) / (60 * BAR)
        return (
            (a * A_a - b * A_b - W + damping * v) / W,
            Q - v * A_b,
            v * A_a - 80 * LPM * opening * root((a - bottom) / (30 * BAR)),
            v * A_a - edge * root(bottom),
        )

    v_up, _, a_up, *_ = fsolve(up, (0.17, 149.0, 144.0, 157.0, 155.0))
    v_down, _, a_down, b_down = fsolve(down, (0.17, 5.0, 87.0, 50.0))
    return {
        "velocity up [m/s]": Number(v_up, c.at("boom.velocity", 1.9), 2e-3),
        "bottom side, up [bar]": Number(a_up, c.at("chamber_a", 1.9) / BAR, 2e-3),
        "velocity down [m/s]": Number(v_down, -c.at("boom.velocity", 3.9), 5e-3),
        "bottom side, down [bar]": Number(a_down, c.at("chamber_a", 3.9) / BAR, 5e-3),
        "rod side, down, which opens the valve [bar]": Number(b_down, c.at("chamber_b", 3.9) / BAR, 5e-3),
    }


def load_sensing_block(c: Course) -> Table:
    """Throttles behind compensators that hold their drop, and what is left for the third."""
    A, K, K_c, damping, Q = 2000e-6, 7.97e-7, 1.2e-6, 5e3, 60 * LPM

    def section(line, opening, load):
        """Actual flow of a section [m^3/s] and pressure of its cylinder, from the force on it [Pa]."""

        def surplus(flow):
            a = load + damping * flow / A / A
            held = (flow / (K * opening)) ** 2
            lift = np.clip((7.5 * BAR - held) / BAR, 1e-9, 1.0)
            return flow - root(line - a) / np.hypot(1.0 / (K * opening), 1.0 / (K_c * lift))

        flow = brentq(surplus, 1e-9, K * opening * np.sqrt(7.5 * BAR))
        return flow, load + damping * flow / A / A

    loads = (60 * BAR, 100 * BAR, 150 * BAR)

    def velocities(line, third):
        flows = [section(line, u, load) for u, load in zip((0.5, 0.375, third), loads, strict=True)]
        return [q / A * nu(a) / nu(line) for q, a in flows], sum(q for q, _ in flows)

    line = brentq(lambda P: velocities(P, 1.0)[1] - Q, 152 * BAR, 175 * BAR)
    few, _ = velocities(c.at("line", 1.4), 0.25)
    many, _ = velocities(line, 1.0)
    return {
        "pump line when all is asked for [bar]": Number(line / BAR, c.at("line", 2.9) / BAR, 1e-3),
        "low load before [m/s]": Number(few[0], c.at("low_rod.velocity", 1.4), 1e-3),
        "low load then [m/s]": Number(many[0], c.at("low_rod.velocity", 2.9), 1e-3),
        "middle load then [m/s]": Number(many[1], c.at("middle_rod.velocity", 2.9), 1e-3),
        "high load before [m/s]": Number(few[2], c.at("high_rod.velocity", 1.4), 1e-3),
        "high load then, what is left of 60 lpm [m/s]": Number(many[2], c.at("high_rod.velocity", 2.9), 1e-3),
    }


def hydrostatic_winch(c: Course) -> Table:
    """Torque of the load over the displacement, and flow less leakage over it."""
    D_p, D_m, leak, damping, low = 28e-6 / (2 * np.pi), 56e-6 / (2 * np.pi), 1.2e-12, 0.05, 20 * BAR
    w_p, torque = 1500 * RPM, 2000 * G * 0.2 / 20

    def up(w):
        drop = (torque + damping * w) / D_m
        return D_p * w_p / nu(low) - (2 * leak * drop + D_m * w) / nu(low + drop), drop

    def down(w):
        drop = (torque - damping * w) / D_m
        return D_m * w / nu(low) - (D_p * w_p + 2 * leak * drop) / nu(low + drop), drop

    w_up, w_down = (brentq(lambda w, way=way: way(w)[0], 50.0, 100.0) for way in (up, down))
    drop_up, drop_down = up(w_up)[1], down(w_down)[1]
    return {
        "lifting, motor [rad/s]": Number(w_up, c.slope("motor_shaft.angle", 2.0, 3.0), 5e-3),
        "high line while lifting [bar]": Number((low + drop_up) / BAR, c.mean("high_line", 2.0, 3.0) / BAR, 5e-3),
        "lowering, motor [rad/s]": Number(w_down, -c.slope("motor_shaft.angle", 6.0, 7.0), 5e-3),
        "high line while lowering [bar]": Number((low + drop_down) / BAR, c.mean("high_line", 6.0, 7.0) / BAR, 5e-3),
        "power given back to the drive [kW]": Number(
            0.96 * D_p * drop_down * w_p / 1e3, c.mean("pump_shaft", 6.0, 7.0) * w_p / 1e3, 5e-3
        ),
    }


class Gas:
    """Ideal nitrogen behind a bladder, its heat to the shell, and the compression of the oil beside it."""

    def __init__(self, volume, precharge, start, heat_time, oil):
        self.first, self.start, self.heat_time = volume, start + P0, heat_time
        self.begin, self.oil = volume * (precharge + P0) / self.start, oil

    def pressure(self, V, T):
        return self.start * (self.begin / V) * (T / 293.15) - P0

    def rates(self, V, T, flow):
        """Rates of volume and temperature at a flow of oil into it, at its pressure [m^3/s]."""
        P = self.pressure(V, T) + P0
        compliance = (self.oil + self.first - V) / MODULUS
        warming = (293.15 - T) / (self.heat_time * T)
        dV = (compliance * P * warming - flow) / (1.0 + 1.4 * compliance * P / V)
        return dV, T * (-0.4 * dV / V + warming)


def injection_cylinder(c: Course) -> Table:
    """Volume and temperature of the gas and position of the screw, without inertia."""
    A, K, damping, gas = 7854e-6, 1.5e-6, 250e3, Gas(10e-3, 120 * BAR, 200 * BAR, 20.0, 1e-3)
    inlet = 0.61 * 1000e-6 * np.sqrt(2.0 / DENSITY)

    def velocity(t, P):
        K_all = 1.0 / np.hypot(1.0 / (K * (1.0 - np.exp(-t / 10e-3)) + 1e-12), 1.0 / inlet)
        return brentq(lambda v: A * v - K_all * root(P - (10 * BAR + damping * v / A)), 0.0, 1.0)

    def rates(t, y):
        V, T, _ = y
        v = velocity(t, gas.pressure(V, T))
        return (*gas.rates(V, T, -A * v), v)

    def done(t, y):
        return y[2] - 0.14

    done.terminal = True
    path = solve_ivp(rates, (0.0, 1.0), (gas.begin, 293.15, 0.0), events=done, rtol=1e-8, max_step=5e-3)
    V, T, _ = path.y[:, -1]
    there = c.when("screw.position", 0.14, 0.1, 0.6)
    P = gas.pressure(V, T)
    return {
        "time for 140 mm [s]": Number(path.t[-1], there - 0.1, 5e-3),
        "gas then [bar]": Number(P / BAR, (c.at("accumulator_gas_pressure", there) - P0) / BAR, 5e-3),
        "temperature of the gas then [K]": Number(T, c.at("accumulator.gas_temperature", there), 2e-3),
        "velocity then [m/s]": Number(velocity(1.0, P), c.at("screw.velocity", there), 5e-3),
    }


def flow_divider(c: Course) -> Table:
    """Torques of both motors and their friction, flows and leakage: linear but for the oil's compression."""
    A, D, leak, load_damping, shaft_damping = 2000e-6, 16e-6 / (2 * np.pi), 2e-12, 5e3, 0.005

    def wrong(x, flow):
        w, v_l, v_r, line = x[0] * 100.0, x[1], x[2], x[3] * BAR
        left, right = (P * BAR + load_damping * v / A for P, v in ((60.0, v_l), (120.0, v_r)))
        return (
            D * (2 * line - left - right) - 2 * shaft_damping * w,
            flow / nu(line) - v_l * A / nu(left) - v_r * A / nu(right),
            v_l * A / nu(left) - (D * w + leak * (line - left)) / nu(line),
            v_r * A / nu(right) - D * w / nu(line) - leak * (line - right) / nu(right),
        )

    _, left, right, line = fsolve(wrong, (1.3, 0.17, 0.16, 96.0), args=(40 * LPM,))
    _, slow_left, slow_right, _ = fsolve(wrong, (0.6, 0.08, 0.08, 93.0), args=(20 * LPM,))
    return {
        "line, the mean of both [bar]": Number(line, c.at("line", 1.4) / BAR, 1e-3),
        "left [m/s]": Number(left, c.at("left_rod.velocity", 1.4), 1e-3),
        "right [m/s]": Number(right, c.at("right_rod.velocity", 1.4), 1e-3),
        "left at half the flow [m/s]": Number(slow_left, c.slope("left_rod.position", 2.5, 3.0), 1e-3),
        "right at half the flow [m/s]": Number(slow_right, c.slope("right_rod.position", 2.5, 3.0), 1e-3),
    }


def pump_controlled_cylinder(c: Course) -> Table:
    """Flow of the pump less its leakage over the piston's area; the charge line takes up the rod's volume."""
    A_a, A_b, D, leak, damping = 1963e-6, 946e-6, 16e-6 / (2 * np.pi), 2e-12, 3e3
    w, W, charge = 1500 * RPM, 1600 * G, 15 * BAR

    def low_side(direction, through):
        """Chamber b behind a check valve that its pilot holds fully open."""
        return charge - direction * 3 * BAR * (through / (40 * LPM)) ** 2

    def up(x):
        v, a = x[0], x[1] * BAR
        b = low_side(1.0, D * w - leak * (a - charge) - v * A_b)
        balance = (a * A_a - b * A_b - W - damping * v) / W
        return balance, v * A_a / nu(a) - D * w / nu(b) + leak * (a - b) / nu(a)

    def down(x):
        v, a = x[0], x[1] * BAR
        b = low_side(-1.0, (A_a - A_b) * v)
        return (a * A_a - b * A_b - W + damping * v) / W, v * A_a - D * w - leak * (a - b)

    v_up, a_up = fsolve(up, (0.2, 90.0))
    v_down, a_down = fsolve(down, (0.2, 84.0))
    drop = a_down * BAR - low_side(-1.0, (A_a - A_b) * v_down)
    return {
        "velocity up [m/s]": Number(v_up, c.slope("rod.position", 1.0, 1.8), 3e-3),
        "piston side, up [bar]": Number(a_up, c.mean("chamber_a", 1.0, 1.8) / BAR, 3e-3),
        "velocity down [m/s]": Number(v_down, -c.slope("rod.position", 2.9, 3.5), 3e-3),
        "piston side, down [bar]": Number(a_down, c.mean("chamber_a", 2.9, 3.5) / BAR, 3e-3),
        "power given back to the drive [kW]": Number(
            0.95 * D * drop * w / 1e3, c.mean("pump_shaft", 2.9, 3.5) * w / 1e3, 5e-3
        ),
    }


def independent_metering(c: Course) -> Table:
    """F + b v = P_s A_a - P_t A_b - v^2 (A_a^3/K_1^2 + A_b^3/K_4^2), and the same on the way back."""
    A_a, A_b, K, damping, F = 1963e-6, 946e-6, 6e-7, 2e3, 20e3
    supply, tank = 160 * BAR, 5 * BAR
    square_out = A_a**3 / (0.5 * K) ** 2 + A_b**3 / K**2
    square_back = A_a**3 / (0.4 * K) ** 2 + A_b**3 / K**2
    out = max(np.roots((square_out, damping, F - supply * A_a + tank * A_b)))
    back = max(np.roots((square_back, damping, tank * (A_a - A_b) - F)))
    return {
        "velocity out [m/s]": Number(out, c.at("rod.velocity", 1.4), 5e-3),
        "piston side, out [bar]": Number(
            (supply - (out * A_a / (0.5 * K)) ** 2) / BAR, c.at("chamber_a", 1.4) / BAR, 5e-3
        ),
        "rod side, out [bar]": Number((tank + (out * A_b / K) ** 2) / BAR, c.at("chamber_b", 1.4) / BAR, 5e-3),
        "velocity back [m/s]": Number(back, -c.at("rod.velocity", 2.9), 5e-3),
        "rod side, back, filled from the tank [bar]": Number(
            (tank - (back * A_b / K) ** 2) / BAR, c.at("chamber_b", 2.9) / BAR, 2e-2
        ),
    }


def hydraulic_hybrid(c: Course) -> Table:
    """Speed of the vehicle, volume and temperature of the gas; tyres without slip."""
    D, leak, damping, low, r = 500e-6 / (2 * np.pi), 5e-12, 0.5, 10 * BAR, 0.4
    mass, gas = 4000.0 + 2.2 / r**2, Gas(32e-3, 120 * BAR, 160 * BAR, 20.0, 2e-3)
    wanted = ((0.0, 0.5, 0.8, 4.2, 4.5, 6.0, 6.3, 8.7, 9.0), (0.0, 0.0, -1.0, -1.0, 0.0, 0.0, 1.0, 1.0, 0.0))

    def rates(t, y):
        v, s, V, T = y
        P, w = gas.pressure(V, T), v / r
        torque = D * (P - low) * (s - 0.04) - damping * w
        road = 0.01 * 4000.0 * G + 0.5 * 1.2 * 4.0 * v * v
        flow = -D * w * (s if s > 0.0 else s * nu(P) / nu(low)) - leak * (P - low)
        return ((torque / r - road) / mass, (np.interp(t, *wanted) - s) / 0.05, *gas.rates(V, T, flow))

    y = solve_ivp(rates, (0.0, 10.0), (12.0, 0.0, gas.begin, 293.15), rtol=1e-8, max_step=0.02, dense_output=True).sol

    def by_hand(t):
        return gas.pressure(*y(t)[2:]) / BAR

    def gauge(t):
        return (c.at("accumulator_gas_pressure", t) - P0) / BAR

    return {
        "velocity when it has braked, 5 s [m/s]": Number(y(5.0)[0], c.mean("vehicle.velocity", 4.9, 5.1), 2e-3),
        "gas then [bar]": Number(by_hand(5.0), gauge(5.0), 2e-3),
        "gas when it drives off, 6 s [bar]": Number(by_hand(6.0), gauge(6.0), 2e-3),
        "velocity at 9.5 s [m/s]": Number(y(9.5)[0], c.mean("vehicle.velocity", 9.4, 9.6), 2e-3),
        "gas at 9.5 s [bar]": Number(by_hand(9.5), gauge(9.5), 2e-3),
    }


def cooler_circuit(c: Course) -> Table:
    """Three balances of heat at rest; on the way there one capacity with all conductances."""
    Q, walls, cooler, capacity = 20 * LPM, 4.0, 80.0, 876.0 * 1900.0
    load = 0.5 * DENSITY * (Q / (0.61 * 4e-6)) ** 2
    q = Q / nu(load + BAR)
    carried = capacity * q
    heat = np.array(
        ((carried, -carried - walls, 0.0), (0.0, carried, -carried - walls), (-carried - walls - cooler, 0.0, carried))
    )
    rise = np.linalg.solve(heat, (0.0, -load * Q, 0.0))
    slowest = capacity * 21e-3 / (cooler + 3.0 * walls)
    reached = rise[0] * (1.0 - np.exp(-500.0 / slowest))
    return {
        "power of the pump [kW]": Number(load * Q / 1e3, c.found["power_pump_W"] / 1e3, 1e-2),
        "sump over the surroundings [K]": Number(rise[0], c.at("sump_temperature", 4000.0) - 293.15, 1e-2),
        "return line over the surroundings [K]": Number(rise[2], c.at("back_temperature", 4000.0) - 293.15, 1e-2),
        "sump after 500 s [K]": Number(reached, c.at("sump_temperature", 500.0) - 293.15, 2e-2),
    }


def servo_axis(c: Course) -> Table:
    """e'' + K_v e' + K_v/T_i e = 0 with e = 0, e' = v at first, K_v from the valve at the pressure of the friction."""
    A, K, gain, reset, v = 1e-3, 3.56e-7, 13.0, 0.3, 0.15
    flow_gain = K * np.sqrt(0.5 * (210 * BAR - 1e4 * v / A))
    K_v = gain * flow_gain / A
    slow, fast = np.sort(np.roots((1.0, K_v, K_v / reset)).real)[::-1]
    t = np.linspace(0.0, 0.5, 50001)
    error = v * (np.exp(slow * t) - np.exp(fast * t)) / (slow - fast)
    times, position = c.times, c.whole("rod.position")
    found = np.interp(times, (0.2, 1.7), (0.05, 0.275)) - position
    running = (times > 0.2) & (times < 1.7)
    leak = 1e-12 * 1e4 * v / A
    return {
        "largest error while it runs [mm]": Number(error.max() * 1e3, found[running].max() * 1e3, 5e-2),
        "opening of the valve at 1.6 s": Number((v * A + leak) / flow_gain, c.at("valve.position", 1.6), 5e-3),
        "pressures over the piston at 1.6 s [bar]": Number(
            1e4 * v / A / BAR, (c.at("chamber_a", 1.6) - c.at("chamber_b", 1.6)) / BAR, 5e-3
        ),
    }


def suspension_strut(c: Course) -> Table:
    """The gas as a spring of n P A^2/V and the damper of A^2/G, on 402 kg; how far it gives way by the gas law."""
    A, n, first = 1257e-6, 1.4, 31.21 * BAR + P0
    last = first + 500.0 / A
    V_first, V_last = (0.5e-3 * ((20 * BAR + P0) / P) ** (1 / n) for P in (first, last))
    oil = 0.1e-3 * (last - first) / MODULUS
    decay, stiffness = A * A / 8e-10 / (2 * 402.0), n * last * A * A / V_last
    swing = np.sqrt(stiffness / 402.0 - decay**2)
    x, t = c.whole("body.position"), c.times
    turns = t[1:-1][(np.diff(x)[:-1] * np.diff(x)[1:] < 0.0) & (t[1:-1] > 0.25)][:3]
    return {
        "gives way for good [mm]": Number((V_first - V_last + oil) / A * 1e3, (x[0] - x[-1]) * 1e3, 2e-3),
        "swing from turn to turn [Hz]": Number(swing / (2 * np.pi), 0.5 / float(turns[2] - turns[1]), 3e-2),
    }


BY_HAND: Mapping[str, Callable[[Course], Table]] = {
    each.__name__.replace("_", "-"): each
    for each in (
        swing_drive, regenerative_boom, load_sensing_block, hydrostatic_winch, injection_cylinder, flow_divider,
        pump_controlled_cylinder, independent_metering, hydraulic_hybrid, cooler_circuit, servo_axis, suspension_strut,
    )
}  # fmt: skip
