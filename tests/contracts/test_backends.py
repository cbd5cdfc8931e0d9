"""One text, five ways of running it: Python floats, arrays, CasADi symbols, own symbols and compiled code agree."""

import ctypes
import dataclasses
import inspect
from types import ModuleType
from typing import Any, get_type_hints

import numpy as np
import pytest
from tests.compiled import compiled
from tests.components.conftest import random_record, settings

from vvdp.base.params import Params
from vvdp.base.signal import Signal, signal_value
from vvdp.fluid import mixture
from vvdp.simulation.lane_code import lane_rates
from vvdp.simulation.layout import members, vectors
from vvdp.simulation.link import link
from vvdp.simulation.trace import dependencies, evaluate, trace
from vvdp.simulation.values import as_series, flat, leaves, names, rebuild
from vvdp.systems.system import load_system, shipped_systems

pytestmark = pytest.mark.heavy

ROUNDING = 1e-12
COUNT = 200

# Whole right-hand sides

MOVING = [
    'operation.pump_speed={step=["1200 rpm", "1800 rpm"], at="0.5 s"}',
    'operation.duty_ratio={sine="0.5", amplitude="0.3", frequency="5 Hz"}',
]
SETTINGS = {
    "as shipped": [],
    "blocked in between": ["valve.lap_ratio=1.3", "relief_valve.override_pressure=10 bar"],
    "underlap": ["valve.lap_ratio=0.5", "valve.jet_exponent=0.4", "valve.eccentricity=0.3"],
    "uneven jets": ["valve.jet_exponent=0.65", "valve.jet_asymmetry=0.85", "oil.pressure_viscosity=2e-8 1/Pa"],
    "choking nozzles": ["valve.pressure_recovery=0.7", "oil.vapour_pressure=0.1 bara"],
    "dynamic relief": ["relief_valve.override_pressure=10 bar", "relief_valve.opening_time=2 ms"],
    "check valve": ["check_valve.reverse_opening=0", "check_valve.cracking_pressure=0.05 bar"],
    "driven": ["spool_drive.coupling=0.1 N*m*s", "operation.spool_motor_speed=3000 rpm"],
    "pump with everything": [
        "pump.leakage_conductance=2e-12 m^3/(s*Pa)",
        "pump.ripple_amplitude=0.03",
        "pump.friction_torque=2 N*m",
        "operation.tank_pressure=2 bar",
    ],
    "oil and pump with everything": [
        "oil.vapour_pressure=0.1 bara",
        "oil.bulk_modulus_slope=11",
        "oil.bunsen_coefficient=0.09",
        "oil.dissolving_time=1 s",
        "oil.release_time=0.1 s",
        "pump.precompression=0.2",
        "pump.dead_volume=5 cc/rev",
    ],
    "moving": MOVING,
}


RANGES = {
    "Pa": (1e3, 1.5e7),
    "rad": (-30.0, 30.0),
    "rad/s": (-50.0, 300.0),
    "m": (-0.02, 0.6),
    "m/s": (-0.5, 0.5),
    "m^3/s": (-1e-3, 1e-3),
    "1": (0.0, 1.2),
}


def random_states(case, rng):
    """Rows over the whole range of a run, and beyond: vacuum, reversed flow, relief valve open, port shut."""
    columns = []
    for path, _, kind in leaves(case.state):
        low, high = (0.0, 0.0) if path.startswith("books.") else RANGES[kind.unit]
        columns.append(rng.uniform(low, high, COUNT))
    return np.ascontiguousarray(np.transpose(columns))


def numbers_of(value):
    return [leaf for _, leaf, _ in leaves(value)]


def agrees(one, other, scale):
    """Each number against the largest that occurs of it: sums of flows of either sign cancel."""
    return np.max(np.abs(np.where(one == other, 0.0, other - one)) / scale) < ROUNDING


LARGE = ("displacement-control", "displacement-control-gerotor", "vvdp-duty-control-gerotor")
"""Systems of seconds each, whose parts stand in smaller ones as well."""


def variants():
    """Every shipped system, and the one with a rotary valve and a load line with other settings."""
    for name in shipped_systems():
        for setting in SETTINGS if name == "prototype" else ("as shipped",):
            marks = pytest.mark.thorough if name in LARGE else ()
            yield pytest.param(name, setting, id=f"{name}, {setting}", marks=marks)


@pytest.mark.sampled(6)
@pytest.mark.parametrize(("name", "setting"), [*variants()])
def test_whole_circuit_is_the_same_in_every_form(name, setting):
    """Rates and outputs, what is stored and held between samples: floats, arrays, symbols and compiled code."""
    casadi = pytest.importorskip("casadi")
    system = load_system(name, SETTINGS[setting])
    model, case = system.model, system.case
    rng = np.random.default_rng(20261121)
    rows, times = random_states(case, rng), rng.uniform(0.0, 1.0, COUNT)
    u, p = case.command, case.params

    def forms(t, state):
        """All that is asked of a circuit at one instant, or at many, or at symbols."""
        rates, outputs, modes = model.circuit(t, state, u, p)
        return [
            *numbers_of(rates),
            *numbers_of(modes),
            *numbers_of(outputs),
            *numbers_of(model.stored(state, p)),
            *numbers_of(model.conditions(t, p)),
        ]

    states = [rebuild(case.state, iter(row.tolist())) for row in rows]
    plain = np.array([forms(t, state) for t, state in zip(times.tolist(), states, strict=True)], float)
    assert np.all(np.isfinite(plain))
    scale = np.max(np.abs(plain), axis=0).clip(1e-300)
    together = forms(times, as_series(case.state, rows))
    assert agrees(plain, np.array([np.broadcast_to(value, COUNT) for value in together]).T, scale)

    t, y = casadi.SX.sym("t"), casadi.SX.sym("y", rows.shape[1])
    symbolic = forms(t, rebuild(case.state, iter([y[i] for i in range(rows.shape[1])])))
    function = casadi.Function("f", [t, y], [casadi.vertcat(*symbolic)])
    assert agrees(plain, np.array([np.ravel(function(t, row)) for t, row in zip(times, rows, strict=True)]), scale)

    linked, flats = link(model, case), vectors(case)
    compiled = np.zeros((COUNT, rows.shape[1] + len(case.command.modes)))
    held = np.zeros((COUNT, flat(case.command.held).size))
    for i, (instant, row) in enumerate(zip(times.tolist(), rows, strict=True)):
        linked.rates(instant, row, flats.command, flats.params, compiled[i])
        command = flats.command.copy()
        linked.sample(0, instant, row, flats.command, flats.memory.copy(), flats.params, command)
        held[i] = command[: held.shape[1]]
    width = compiled.shape[1]
    assert agrees(plain[:, :width], compiled, scale[:width])
    assert agrees(plain[:, -held.shape[1] :], held, scale[-held.shape[1] :])
    assert np.array_equal(flat(model.start(p)), flats.state)


def signal_values(params, times):
    """The value of each signal at each time, shape (signals, times): what a traced graph takes in their place."""
    signals = [leaf for _, leaf in members(params, "") if isinstance(leaf, Signal)]
    return np.array([[signal_value(t, one) for t in times.tolist()] for one in signals])


@pytest.mark.thorough
@pytest.mark.parametrize(("name", "setting"), [*variants()])
def test_traced_rates_are_those_of_the_circuit(name, setting):
    """And no state that a rate depends on is missing in the pattern of the graph."""
    system = load_system(name, SETTINGS[setting])
    model, case = system.model, system.case
    rng = np.random.default_rng(20261121)
    rows, times = random_states(case, rng), rng.uniform(0.0, 1.0, COUNT)

    def plain(t, row):
        rates, _, modes = model.circuit(t, rebuild(case.state, iter(row.tolist())), case.command, case.params)
        return [*numbers_of(rates), *numbers_of(modes)]

    graph, flats = trace(model, case), vectors(case)
    signals = signal_values(case.params, times)
    traced = evaluate(graph, times, rows.T, flats.command, flats.params, signals)
    values = np.array([plain(t, row) for t, row in zip(times.tolist(), rows, strict=True)])
    together = np.array([np.broadcast_to(value, COUNT) for value in traced]).T
    assert agrees(values, together, np.max(np.abs(values), axis=0).clip(1e-300))

    found = np.zeros((values.shape[1], rows.shape[1]), bool)
    for i, j in np.ndindex(20, rows.shape[1]):
        moved = rows[i].copy()
        moved[j] += 1e-3 * max(abs(moved[j]), 1e-3)
        found[:, j] |= np.array(plain(times[i], moved)) != values[i]
    assert not np.any(found & ~dependencies(graph, flats.params))
    assert not np.any(found & ~dependencies(graph))


def in_lanes(lanes, values):
    """Rows of numbers, shape (numbers, COUNT), as the function of many cases takes them: its cases side by side."""
    return np.ascontiguousarray(values.reshape(values.shape[0], -1, lanes.width).swapaxes(0, 1))


@pytest.mark.sampled(6)
@pytest.mark.parametrize(("name", "setting"), [*variants()])
def test_rates_of_many_cases_at_once_are_those_of_each(name, setting):
    system = load_system(name, SETTINGS[setting])
    model, case = system.model, system.case
    rng = np.random.default_rng(20261122)
    rows, times = random_states(case, rng), rng.uniform(0.0, 1.0, COUNT)
    linked, flats = link(model, case), vectors(case)
    each = np.zeros((COUNT, rows.shape[1] + len(case.command.modes)))
    for i, (instant, row) in enumerate(zip(times.tolist(), rows, strict=True)):
        linked.rates(instant, row, flats.command, flats.params, each[i])

    lanes = lane_rates(trace(model, case))
    shared = [np.repeat(vector[:, None], COUNT, 1) for vector in (flats.command, flats.params)]
    inputs = [times[None], rows.T, *shared, signal_values(case.params, times)]
    packed = [in_lanes(lanes, values) for values in (*inputs, np.zeros_like(each.T))]
    rates = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 6)(lanes.address)
    for group in zip(*packed, strict=True):
        rates(*(array.ctypes.data for array in group))
    together = packed[-1].swapaxes(1, 2).reshape(each.shape)
    assert agrees(each, together, np.max(np.abs(each), axis=0).clip(1e-300))


# Every formula

POSITIVE = {
    "opening": (0.05, 1.0),
    "density": (800.0, 900.0),
    "from_density": (800.0, 900.0),
    "viscosity": (5e-3, 0.1),
    "temperature": (280.0, 360.0),
    "pressure": (2e5, 2e7),
    "from_pressure": (1.2e5, 1.5e7),
    "reference_pressure": (1e5, 1.1e5),
    "load_pressure": (5e6, 1e7),
    "port_pressure": (1e6, 1e7),
    "relief_pressure": (1.15e7, 1.4e7),
    "rated_drop": (1e5, 1e6),
    "transition_pressure": (1e3, 1e5),
    "flow_exponent": (1.7, 2.0),
    "volume": (1e-6, 1e-3),
    "inlet_volume": (1e-6, 1e-4),
    "gas": (1e-5, 4e-5),
    "gas_volume": (3e-4, 1.004e-3),
    "gas_pressure": (1e7, 3e7),
    "swept_volume": (0.0, 1e-4),
    "area": (1e-6, 1e-4),
    "pwm_frequency": (10.0, 60.0),
    "mean_bulk_modulus": (1e9, 1.4e9),
    "friction_coefficient": (1e-4, 1e-2),
    "ramp": (0.1, 0.2),
    "outlet_pressure": (2e5, 2e7),
    "outlet_volume_ratio": (0.9, 1.0),
    "distance": (0.0, 0.5),
    "base": (0.3, 1.0),
    "t": (0.0, 1.0),
    "pressure_rise": (1e6, 1e7),
    "clearance": (1e-5, 2e-5),
    "tank_pressure": (1e5, 3e5),
    "relief_override": (1e5, 1e6),
    "second_pressure": (2e5, 2e7),
    "third_pressure": (2e5, 2e7),
}
SIGNED = {
    "flow": (-1e-3, 1e-3),
    "flow_a": (-1e-3, 1e-3),
    "flow_b": (-1e-3, 1e-3),
    "net_flow": (-1e-3, 1e-3),
    "surplus_flow": (-1e-3, 1e-3),
    "ideal_flow": (-1e-3, 1e-3),
    "full_section_flow": (-1e-3, 1e-3),
    "volume_rate": (-1e-4, 1e-4),
    "pressure_drop": (-1e7, 1e7),
    "pressure_difference": (-1e7, 1e7),
    "drop": (-1e6, 2e6),
    "pilot_difference": (-1e7, 1e7),
    "spool_angle": (-20.0, 20.0),
    "shaft_angle": (-20.0, 20.0),
    "spool_speed": (-50.0, 300.0),
    "motor_speed": (-50.0, 300.0),
    "shaft_speed": (-50.0, 300.0),
    "axial_position": (-0.01, 0.03),
    "duty_ratio": (-0.2, 1.2),
    "half_width": (-0.1, 0.5),
    "position": (-0.002, 0.502),
    "velocity": (-0.5, 0.5),
    "command": (-1.5, 1.5),
    "load_force": (-1e4, 1e4),
    "exponent": (-0.15, 0.0),
    "shortfall": (-1e7, 1e7),
}
ANY_NUMBER = (0.2, 0.9)
GEROTOR_FLOWS = {"flow": (-4e-5, 4e-5)}
OWN_RANGES = {
    "power_growth": {"ratio": (0.01, 200.0), "exponent": (0.0, 0.5)},
    "gerotor_command": GEROTOR_FLOWS,
    "calibrated_command": GEROTOR_FLOWS,
    "gas_state": {"volume": (1e-4, 1e-3), "temperature": (250.0, 450.0)},
    "gas_internal_energy": {"volume": (1e-4, 1e-3), "temperature": (250.0, 450.0)},
    "molar_volume": {"pressure": (1e6, 3e7), "temperature": (250.0, 450.0)},
    "oil_stiffness": {"bulk_modulus": (1e8, 1e9)},
}
FORWARD = {"flow": (1e-4, 1e-3), "duty_ratio": (0.35, 0.65)}  # for formulas that say "> 0"
ONLY_FORWARD = {
    "transition_loss", "closed_form_load_flow", "compression_regime", "equilibrium_speed", "fit_friction_area",
    "nozzle_reynolds_number", "spool_time_constant", "stall_torque", "flow_damping", "driven_speed",
}  # fmt: skip
# Tables and texts over many angles, searches, and energies under a law that is handed over: not for the loop.
NOT_IN_THE_LOOP = {
    "binary_valves", "equal_valves", "code_count", "code_flow", "pulse_volume",
    "quasi_steady_cycle", "quasi_steady_mean", "mean_of_cycle", "averaged_spool_speed", "speed_of_cycle",
    "balanced_cycle", "delivered_flows", "operating_point", "average_transition",
    "range_warnings", "best_relief_pressure", "bearing_eccentricity", "radial_force",
    "specific_volume_exponent", "mean_modulus",
    "modulus.compression_energy_per_volume", "modulus.compression_energy_per_mass",
}  # fmt: skip
# Refuse a value with an error, which only plain numbers can.
REFUSING = {"fit_friction_area"}


def sampled(module: ModuleType, name: str, function, components, rng) -> list[Any] | None:
    """One random argument list; None when the formula has none to be varied."""
    hints, arguments = get_type_hints(function), []
    for parameter in inspect.signature(function).parameters:
        hint = hints[parameter]
        if hint is float:
            ranges = {**POSITIVE, **SIGNED, **(FORWARD if name in ONLY_FORWARD else {}), **OWN_RANGES.get(name, {})}
            arguments.append(float(rng.uniform(*ranges.get(parameter, ANY_NUMBER))))
        else:
            arguments.append(components(hint, rng))
    return arguments


def bind_floats(arguments: list[Any], take) -> list[Any]:
    """`arguments` with every float and every number of a NamedTuple replaced, in order; parameter sets stay."""

    def bound(value: Any) -> Any:
        if isinstance(value, float):
            return take()
        if hasattr(value, "_fields"):
            return type(value)(*map(bound, value))
        return value

    return [bound(a) for a in arguments]


def numbers(result: Any) -> list[Any]:
    if hasattr(result, "_fields"):
        return [x for part in result for x in numbers(part)]
    return [result]


@pytest.fixture(scope="module")
def components():
    """A random value of any class that a formula takes."""
    from vvdp.base.signal import Signal
    from vvdp.fluid import modulus
    from vvdp.hydraulics import (
        balanced_valve,
        characteristic,
        check_valve,
        compensated_throttle,
        cooler,
        counterbalance_valve,
        cushion,
        cylinder,
        delay_line,
        directional_valve,
        filter_element,
        flow,
        flow_control_valve,
        flow_source,
        four_way_valve,
        friction,
        gas_accumulator,
        gerotor_drive,
        heat,
        line,
        linkage,
        motor,
        pilot_check_valve,
        pipe,
        ports,
        proportional_valve,
        reducing_valve,
        relief_valve,
        reservoir,
        rod,
        seat_valve,
        shaft,
        shuttle_valve,
        soft_switching,
        stick_friction,
        switching_valve,
        telescope,
        unsteady_friction,
        variable_machine,
        variable_pump,
    )
    from vvdp.valve import branch, condition, geometry, joined_ports, torque

    values = {}
    for name in shipped_systems():
        case = load_system(name).case
        for inner in names(case.params):
            value = getattr(case.params, inner)
            if dataclasses.is_dataclass(value) and not isinstance(value, Signal):
                for cls in type(value).__mro__:
                    values.setdefault(cls, value)
    by_name = {c.__name__: v for c, v in values.items()}
    oil, valve = by_name["Oil"], by_name["RotaryValve"]
    air = {"liquid_bulk_modulus": 1.4e9, "air_fraction": 0.01, "reference_pressure": 101325.0}
    polytropic = {**air, "polytropic_exponent": 1.3}
    gerotor = {
        "largest_flow": 3e-5, "forward_dead_band": 0.06, "backward_dead_band": 0.08, "backward_gain": 0.9
    }  # fmt: skip
    made = [
        check_valve.CheckValve(
            cracking_pressure=1e4, rated_flow=1e-3, rated_drop=1e5, reverse_opening=0.1, opening_time=2e-3
        ),
        modulus.IsothermalAir(**air),
        modulus.PolytropicAir(**polytropic),
        modulus.YuAir(**polytropic, dissolving_rate=1e-8),
        modulus.DissolvingAir(**polytropic, critical_pressure=1e7),
        balanced_valve.BalancedValve(
            cracking_pressure=1e6, override_pressure=1e7, rated_flow=1e-3, rated_drop=1e6, opening_time=5e-3
        ),
        balanced_valve.CartridgeValve(
            cracking_pressure=1e6, override_pressure=1e7, rated_flow=1e-3, rated_drop=1e6, opening_time=0.0,
            ring_ratio=0.6,
        ),
        counterbalance_valve.SequenceValve(
            cracking_pressure=1e7, override_pressure=1e7, rated_flow=1e-3, rated_drop=1e6, opening_time=5e-3,
            reverse_cracking_pressure=5e4, reverse_override_pressure=5e6,
        ),
        counterbalance_valve.CounterbalanceValve(
            cracking_pressure=1e7, override_pressure=1e7, rated_flow=1e-3, rated_drop=1e6, opening_time=0.0,
            reverse_cracking_pressure=5e4, reverse_override_pressure=5e6, pilot_ratio=3.0,
        ),
        directional_valve.DirectionalValve(conductance=1e-7, overlap=0.05, transition_pressure=1e4, lag=0.01),
        proportional_valve.ProportionalValve(
            conductance=1e-7, leakage_conductance=1e-13, transition_pressure=1e4, lag=0.01
        ),
        line.Line(length=2.0, diameter=0.01),
        pipe.TubeWall(diameter=0.02, wall_thickness=0.002, youngs_modulus=2e11),
        cylinder.Plunger(area_a=2e-3, moving_mass=100.0),
        cylinder.Cylinder(area_a=2e-3, area_b=1e-3, stroke=0.5, moving_mass=100.0, leakage_conductance=1e-13),
        friction.RodFriction(
            viscous_friction=2e3, coulomb_friction=50.0, breakaway_friction=80.0, stribeck_velocity=0.1,
            coulomb_velocity=0.01,
        ),
        friction.ShaftFriction(shaft_damping=0.01, coulomb_torque=2.0, coulomb_speed=3.0),
        motor.Motor(
            displacement=5e-6, leakage_conductance=1e-12, shaft_damping=0.01, coulomb_torque=2.0, coulomb_speed=3.0,
            inertia=0.02,
        ),
        rod.EndStop(lower_end=0.0, upper_end=0.5, stop_stiffness=1e7, stop_damping=1.0),
        rod.Spring(stiffness=1e4, preload=50.0, rest_position=0.1),
        rod.Weight(mass=100.0, slope=0.5),
        shaft.TorsionSpring(torsional_stiffness=10.0, preload_torque=2.0, rest_angle=0.5),
        switching_valve.SwitchingValve(
            natural_frequency=200.0, damping_ratio=0.7, stroke=1e-3, lap=1e-4, full_area=1e-5
        ),
        soft_switching.SwitchChamber(
            oil_volume=1e-6, hose_compliance=0.0, gas_volume=5e-5, precharge_pressure=1.3e6, gas_exponent=1.4,
        ),
        soft_switching.Mouth(mouth_area=1e-4),
        switching_valve.PulseTrain(frequency=30.0, duty_ratio=0.4),
        pilot_check_valve.PilotCheckValve(
            cracking_pressure=1e4, rated_flow=1e-3, rated_drop=1e7, reverse_opening=0.1, opening_time=0.0,
            pilot_ratio=3.0,
        ),
        seat_valve.SeatValve(rated_flow=1e-3, rated_drop=5e5, lag=0.01),
        flow_control_valve.FlowControlValve(rated_flow=1e-3, minimum_drop=8e5, maximum_drop=5e6, flow_rise=0.04),
        relief_valve.LoadReliefValve(
            cracking_pressure=1.2e7, override_pressure=1e6, rated_flow=6.7e-4, reseat_drop=0.0, opening_time=0.0,
            margin=2e6, least_pressure=3e6,
        ),
        reducing_valve.ReducingValve(
            closing_pressure=1e7, override_pressure=9e6, rated_flow=1e-3, rated_drop=5e5, opening_time=5e-3
        ),
        characteristic.Characteristic(dead_band=0.05, rangeability=30.0),
        compensated_throttle.CompensatedThrottle(
            conductance=8e-7, compensator_conductance=1.2e-6, metering_drop=7e5, override_pressure=1e5,
            transition_pressure=2e4, opening_time=5e-3,
        ),
        reservoir.Reservoir(
            base_area=0.1, tank_height=0.4, tank_volume=0.02, suction_height=1e-3, port_area=1e-3, sealed=1.0,
            air_exponent=1.3,
        ),
        gas_accumulator.NitrogenCharge(gas_volume=1e-3, precharge_pressure=1e7, heat_time=5.0),
        gas_accumulator.PistonCharge(
            gas_volume=1e-3, precharge_pressure=1e7, heat_time=5.0, piston_area=5e-3, moving_mass=3.0
        ),
        gas_accumulator.GasAccumulator(
            gas_volume=1e-3, precharge_pressure=1e7, heat_time=5.0, oil_volume=2e-5, inlet_area=1e-4,
            start_pressure=1.5e7,
        ),
        gas_accumulator.SpringAccumulator(
            piston_area=5e-4, stroke=0.1, spring_pressure=1e7, pressure_rise=1e7, moving_mass=1.0
        ),
        cushion.Cushion(port_area=1e-4, throttle_area=2e-6, cushion_begin=0.03, cushion_end=0.01),
        linkage.Gear(gear_ratio=3.0, torsional_stiffness=1e4, tooth_damping=10.0),
        linkage.Link(stiffness=1e6, link_damping=1e3),
        linkage.Arm(base_arm=0.3, eye_arm=0.4, retracted_length=0.45, stiffness=1e6, link_damping=1e3),
        linkage.RoadLoad(mass=2000.0, rolling_resistance=0.01, drag_area=1.0, slope=0.1),
        stick_friction.StickFriction(dry_friction=100.0, stick_stiffness=300.0, stick_damping=10.0),
        telescope.Telescope(areas=(5e-3, 3e-3, 2e-3), strokes=(0.1, 0.2, 0.3), moving_mass=20.0),
        heat.HeatBalance(start_temperature=313.15, wall_conductance=5.0),
        heat.Coolant(conductance=100.0, temperature=293.15),
        delay_line.DelayLine(length=10.0, diameter=0.02, sound_speed=1260.0),
        filter_element.FilterElement(
            clean_conductance=2e-8, dirt_capacity=0.02, dirt_content=5e-3, bypass_pressure=3e5,
            bypass_conductance=1e-8,
        ),
        cooler.Cooler(rated_flow=1e-3, rated_drop=1e5, rated_viscosity=0.03),
        variable_pump.PumpControl(margin=2e6, highest_pressure=1.2e7, proportional_band=1e7, reset_time=0.01),
        flow_source.FlowSource(counted_at_outlet=1.0),
        gerotor_drive.GerotorDrive(
            area=5e-4, lag=0.01, conductance=1.1e-10, viscous_friction=8.3, lower_end=-6e-3, upper_end=27e-3
        ),
        four_way_valve.FourWayValve(
            conductance=1e-7, overlap_pa=0.05, overlap_pb=0.05, overlap_at=-0.1, overlap_bt=-0.1,
            transition_pressure=1e4, natural_frequency=60.0, damping_ratio=0.7, largest_rate=20.0, hysteresis=0.04,
            flow_yield=1e-9, bypass_conductance=1e-7, bypass_travel=0.3,
        ),
        shuttle_valve.ShuttleValve(changeover_pressure=1e7, rated_flow=1e-3, rated_drop=5e5),
        variable_machine.VariableMachine(
            displacement=5e-6, leakage_conductance=1e-12, shaft_damping=0.01, coulomb_torque=2.0, coulomb_speed=3.0,
            inertia=0.02, pressure_friction=0.03, response_time=0.05, largest_rate=10.0,
            laminar_slip=3e-9, turbulent_slip=2e-5, viscous_drag=2e5, kinetic_drag=0.5, setting_drag=0.3,
        ),
        gerotor_drive.GerotorMap(**gerotor),
        gerotor_drive.GerotorBelief(**gerotor, straight_flow=1e-6),
        gerotor_drive.GerotorCalibration(commands=(-1.0, -0.1, 0.1, 1.0), flows=(-3e-5, 0.0, 0.0, 3e-5)),
        torque.SpoolSurface(
            bearing_length=0.02, pocket_length=0.05, pocket_coverage=0.7, pocket_depth=1e-3, pocket_drag_factor=4.0
        ),
    ]  # fmt: skip
    values |= {type(v): v for v in made}
    SHAPES = {
        line.RoundLine: line.Line,
        motor.Displacing: motor.Motor,
        flow.RatedEdge: seat_valve.SeatValve,
        flow.RootEdge: directional_valve.DirectionalValve,
    }

    def component(hint: Any, rng: np.random.Generator) -> Any:
        if hint in values:
            return values[hint]
        if hint in SHAPES:
            return values[SHAPES[hint]]
        by_class = {
            mixture.FluidState: lambda: mixture.fluid_state(float(rng.uniform(2e5, 2e7)), oil),
            condition.Condition: lambda: condition.Condition(
                flow=float(rng.uniform(1e-4, 1e-3)),
                load_pressure=float(rng.uniform(5e6, 1e7)),
                relief_pressure=float(rng.uniform(1.15e7, 1.4e7)),
                tank_pressure=float(rng.uniform(1e5, 3e5)),
                density=float(rng.uniform(800.0, 900.0)),
            ),
            branch.BranchFlow: lambda: branch.branch_flow(float(rng.uniform(-1e6, 1e6)), 0.5, 870.0, valve),
            branch.BranchDrops: lambda: branch.turbulent_drops(float(rng.uniform(2e-4, 1e-3)), 1.0, 870.0, valve),
            branch.BranchLaw: lambda: branch.branch_law(870.0, valve),
            joined_ports.Ends: lambda: joined_ports.Ends(
                relief_over_load=float(rng.uniform(1e6, 3e6)),
                relief_over_tank=float(rng.uniform(8e6, 1.2e7)),
                rise=float(rng.uniform(0.0, 1e6)),
                nozzle=float(rng.uniform(2e5, 6e5)),
                other=float(rng.uniform(2e5, 4e5)),
            ),
            geometry.Openings: lambda: geometry.Openings(*map(float, rng.uniform(0.05, 1.0, 2))),
            geometry.JetSkews: lambda: geometry.JetSkews(*map(float, rng.uniform(-0.2, 0.2, 2))),
            geometry.PortShape: lambda: geometry.port_shape(valve),
            unsteady_friction.LayeredState: lambda: unsteady_friction.LayeredState(
                *map(float, rng.uniform(-1e-3, 1e-3, 6))
            ),
            gas_accumulator.ChargeState: lambda: gas_accumulator.ChargeState(
                float(rng.uniform(0.996, 4.0)), float(rng.uniform(250.0, 450.0))
            ),
            gas_accumulator.ChargeAmount: lambda: gas_accumulator.ChargeAmount(float(rng.uniform(3.5, 4.5))),
            ports.Medium: lambda: ports.Medium(float(rng.uniform(800.0, 900.0)), float(rng.uniform(5e-3, 0.1))),
            ports.ShaftState: lambda: ports.ShaftState(*map(float, rng.uniform(0.3, 2.5, 2))),
            ports.RodState: lambda: ports.RodState(*map(float, rng.uniform(-0.3, 0.3, 2))),
            delay_line.Arriving: lambda: delay_line.Arriving(*map(float, rng.uniform(-100.0, 100.0, 4))),
            delay_line.DelayState: lambda: delay_line.DelayState(*map(float, rng.uniform(0.0, 10.0, 6))),
            gerotor_drive.GerotorState: lambda: gerotor_drive.GerotorState(
                float(rng.uniform(-3e-5, 3e-5)), float(rng.uniform(-8e-3, 30e-3))
            ),
            switching_valve.SpoolState: lambda: switching_valve.SpoolState(
                float(rng.uniform(-1e-4, 1.1e-3)), float(rng.uniform(-1.0, 1.0))
            ),
        }
        if hint in by_class:
            return by_class[hint]()
        return next(settings(hint)) if issubclass(hint, Params) else random_record(hint, rng)

    return component


def formulas(formula_modules, functions_of):
    for module in formula_modules:
        short = module.__name__.rpartition(".")[2]
        for name, function in functions_of(module).items():
            if name.endswith("_compiled"):  # the text that compiled code takes instead; compared below with the other
                continue
            if name not in NOT_IN_THE_LOOP and f"{short}.{name}" not in NOT_IN_THE_LOOP:
                yield module, name, function


def test_every_formula_agrees_between_floats_arrays_and_casadi(formula_modules, functions_of, components):
    """To 1e-12 of the largest of 20 random values: their terms may cancel."""
    casadi = pytest.importorskip("casadi")
    count = 0
    for module, name, function in formulas(formula_modules, functions_of):
        rng = np.random.default_rng(5)
        cases = [sampled(module, name, function, components, rng) for _ in range(20)]
        plain = np.array([numbers(function(*case)) for case in cases], float)
        scale = np.max(np.abs(plain), axis=0).clip(1e-300)
        assert np.all(np.isfinite(plain) | np.isinf(plain)), name

        inputs: list[list[float]] = []
        for case in cases:
            row: list[float] = []
            flat_case = iter(numbers_of_arguments(case))
            bind_floats(case, lambda it=flat_case, row=row: row.append(next(it)))
            inputs.append(row)
        if not inputs[0] or name in REFUSING:
            continue
        count += 1
        columns = iter(np.array(inputs).T)
        together = numbers(function(*bind_floats(cases[0], lambda it=columns: next(it))))
        arrays = np.array([np.broadcast_to(np.asarray(x, float), len(cases)) for x in together]).T
        assert np.max(np.abs(np.where(arrays == plain, 0.0, arrays - plain)) / scale) < ROUNDING, name

        symbols = casadi.SX.sym("x", len(inputs[0]))
        taken = iter(range(len(inputs[0])))
        result = numbers(function(*bind_floats(cases[0], lambda it=taken, s=symbols: s[next(it)])))
        traced = casadi.Function("f", [symbols], [casadi.vertcat(*result)])
        values = np.array([np.ravel(traced(row)) for row in inputs])
        assert np.max(np.abs(np.where(values == plain, 0.0, values - plain)) / scale) < ROUNDING, name
    assert count > 70


def numbers_of_arguments(arguments: list[Any]) -> list[float]:
    found: list[float] = []

    def collect(value: Any) -> None:
        if isinstance(value, float):
            found.append(value)
        elif hasattr(value, "_fields"):
            for part in value:
                collect(part)

    for argument in arguments:
        collect(argument)
    return found


@pytest.mark.thorough
def test_every_formula_agrees_between_floats_and_compiled_code(formula_modules, functions_of, components):
    count = 0
    for module, name, function in formulas(formula_modules, functions_of):
        if name in REFUSING:
            continue
        rng = np.random.default_rng(5)
        cases = [sampled(module, name, function, components, rng) for _ in range(20)]
        plain = np.array([numbers(function(*case)) for case in cases], float)
        fast = compiled(function, *cases[0])
        values = np.array([numbers(fast(*case)) for case in cases], float)
        scale = np.max(np.abs(plain), axis=0).clip(1e-300)
        assert np.max(np.abs(np.where(values == plain, 0.0, values - plain)) / scale) < ROUNDING, name
        count += 1
    assert count > 80
