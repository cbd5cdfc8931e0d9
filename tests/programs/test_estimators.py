"""Estimators by name: against the laws that they call, closed forms, and the program that joins encoder and filter."""

from typing import NamedTuple

import numpy as np
import pytest

from vvdp.base.errors import ConfigError
from vvdp.base.params import Params, field_kinds
from vvdp.base.tables import parsed_table
from vvdp.control.flow_map import FlowMap, flow_for_duty
from vvdp.estimation.estimator import to_estimate
from vvdp.estimation.event_filter import event_filter_step
from vvdp.estimation.event_memory import EventFilterMemory, event_filter_start
from vvdp.estimation.event_settings import EventFilter, EventFilterValues, event_filter
from vvdp.evaluation.quantities import quantities
from vvdp.evaluation.summary import summary
from vvdp.network.build import build
from vvdp.network.program import ProgramType
from vvdp.programs.encoders import ShaftEncoder, encoder_settings
from vvdp.programs.estimators import (
    CylinderLoad,
    Delivery,
    Moved,
    Sections,
    Switching,
    flow_map_step,
    observer_start,
    observer_step,
    period_start,
    period_step,
)
from vvdp.programs.spool_encoder import encoder_of, filter_of
from vvdp.sensing.encoder import Encoder, EncoderMemory, Shaft, encoder_start, encoder_step
from vvdp.sensing.wheel import equal_wheel
from vvdp.simulation.run import simulate
from vvdp.systems.system import built_system

ROUNDING = 1e-12
"""Of an angle or speed that is calculated with sums in another order [rad, rad/s]."""

SYSTEM = """
[nodes]
tank = { type = "tank" }
line = { type = "volume", volume = "1 l", start = "20 bar" }
wheel = { type = "driven-shaft", speed = { ramp = ["20 rev/s", "30 rev/s"], from = "0.1 s", to = "0.3 s" } }

[components]
load = { type = "orifice", a = "line", b = "tank", area = "6 mm^2" }

[components.pump]
type = "pump"
inlet = "tank"
outlet = "line"
shaft = "wheel"
displacement = "10 cc/rev"
leakage_conductance = "1e-12 m^3/(s*Pa)"
friction_torque = "1 N*m"

[programs.speed]
type = "event-filter"
reads = "edges"
FILTER
sectors = 8
index_shift = "0.2"

[programs.edges]
type = "encoder"
reads = "wheel"
sectors = 8
index_shift = "0.2"
spot_width = "1 mm"
track_radius = "20 mm"
spot_roundness = "0.5"
threshold = "0.5"
hysteresis = "0.02"
noise = "0.01"
counter_bits = 16
missed_edges = "0"
seed = 3

[run]
until = "0.5 s"
sample_period = "1 ms"
"""


def filter_lines():
    """The usual values of the filter, as a file gives them in SI."""
    usual, kinds = event_filter(equal_wheel(8, 0.2)), field_kinds(EventFilterValues)
    units = {name: "" if kinds[name].unit == "1" else f" {kinds[name].unit}" for name in kinds}
    return "\n".join(f'{name} = "{getattr(usual, name)!r}{unit}"' for name, unit in units.items())


@pytest.fixture(scope="module")
def system():
    return built_system(parsed_table(SYSTEM.replace("FILTER", filter_lines()), "mine.toml"), "mine")


class JoinedMemory(NamedTuple):
    encoder: EncoderMemory
    filter: EventFilterMemory


class JoinedSettings(Params):
    encoder: Encoder
    filter: EventFilter


def joined_start(settings):
    return JoinedMemory(
        encoder=encoder_start(settings.encoder, 0.0, 0.0, 3.0),
        filter=event_filter_start(settings.filter, 0.0, 0.0, 0.0),
    )


def joined_step(t, memory, reading, settings):
    encoder, seen = encoder_step(memory.encoder, reading, settings.encoder)
    remembered, estimate = event_filter_step(memory.filter, seen, settings.filter)
    return JoinedMemory(encoder, remembered), estimate


def test_two_programs_are_the_one_that_joins_them(system):
    """But for the order of additions: the filter runs behind the encoder, wherever it stands in the file.

    The program `event-filter` takes times from the last edge on and leaves out whole revolutions.
    """
    network = system.circuit.network
    own = network.programs["speed"].settings
    table = ShaftEncoder(
        sectors=8.0, index_shift=0.2, spot_width=1e-3, track_radius=20e-3, spot_roundness=0.5,
        threshold=network.programs["edges"].settings.encoder.threshold, hysteresis=0.02, noise=0.01,
        counter_bits=16.0, missed_edges=0.0, seed=3.0,
    )  # fmt: skip
    encoder = encoder_of(table)
    both = JoinedSettings(encoder=encoder, filter=filter_of(own, encoder.wheel))
    unknown = to_estimate(joined_start(both).filter.belief, 0.0, 0.0, 0.0, 0.0)
    joined = ProgramType(joined_step, Shaft, unknown, JoinedSettings, joined_start)
    reads = {"time": "t", "angle": "wheel.angle", "speed": "wheel.speed"}
    network.program("encoder", joined, both, reads=reads)
    circuit = build(network)
    command = simulate(circuit.model, circuit.case, system.stepping).command
    del network.programs["encoder"]
    assert np.ptp(command.speed.speed[-100:]) < 20.0
    assert command.speed.speed[-1] == pytest.approx(30.0 * 2.0 * np.pi, rel=0.05)
    for name in ("angle", "speed", "missed_edges", "innovation"):
        assert np.max(abs(getattr(command.speed, name) - getattr(command.encoder, name))) < ROUNDING
    assert np.array_equal(command.speed.missed_edges, command.encoder.missed_edges)
    assert encoder_settings(table) == network.programs["edges"].settings


def test_a_filter_says_how_good_its_estimate_of_any_shaft_is():
    """Over a second in which the wheel turns evenly; the numbers have its name, and none is there without an index."""
    text = SYSTEM.replace("FILTER", filter_lines()).replace('until = "0.5 s"', 'until = "1.5 s"')
    found = built_system(parsed_table(text, "mine.toml"), "mine")
    numbers = summary(found, simulate(found.model, found.case, found.stepping))
    keys = [key for key in numbers if key.startswith("wheel_")]
    assert len(keys) == 11 and set(keys) <= quantities(found).keys()
    assert numbers["wheel_speed_error_rms_rad_s"] < 0.02 * 30.0 * 2.0 * np.pi
    assert 0.8 < numbers["wheel_angle_coverage"] <= 1.0
    (line,) = (line for line in found.extras.OVERVIEW if line.keys == ("wheel_speed_coverage",))
    assert line.group == "Estimate of the wheel"
    without = built_system(parsed_table(text.replace('index_shift = "0.2"', 'index_shift = "0"'), "mine.toml"), "mine")
    assert not [key for key in quantities(without) if key.startswith("wheel_")]


def test_a_threshold_that_is_off_is_led_back_in_a_loop(system):
    """The encoder reads the threshold of the last call; at 0.6 of the light it is 0.1 too high."""
    text = SYSTEM.replace("FILTER", filter_lines()).replace('"event-filter"', '"threshold"')
    adapted = 'type = "threshold"\nthreshold = "0.6"\nramp_slope = "0.05 rad"\nadaptation_gain = "0.1"\ndither = "0.2"'
    text = text.replace('type = "threshold"', adapted).replace('until = "0.5 s"', 'until = "4 s"')
    text = text.replace(
        'reads = "wheel"', 'reads = "wheel"\nthreshold_shift = "speed.threshold_shift"\nprevious = true'
    )
    text = text.replace('threshold = "0.5"\nhyst', 'threshold = "0.6"\nhyst')
    found = built_system(parsed_table(text, "mine.toml"), "mine")
    command = simulate(found.circuit.model, found.circuit.case, found.stepping).command
    assert command.speed.threshold[-1000:].mean() == pytest.approx(0.5, abs=0.03)
    assert command.speed.threshold_shift[-1000:].mean() == pytest.approx(-0.1, abs=0.03)
    with pytest.raises(ConfigError, match=r"(edges -> speed -> edges|speed -> edges -> speed)"):
        built_system(parsed_table(text.replace("previous = true", ""), "mine.toml"), "mine")


def test_a_ramp_is_averaged_to_half_a_period_ago():
    """Of a spool of two sections at 25 rev/s: periods of 20 ms."""
    settings, memory = Sections(sections=2.0), period_start(None)
    for number in range(60):
        t = 1e-3 * number
        memory, found = period_step(t, memory, Switching(5.0 * t, 50.0 * np.pi), settings)
    assert found.value == pytest.approx(5.0 * (t - 0.01), rel=1e-12)


def test_a_resting_cylinder_shows_its_load():
    """(p_a - p_0) A_a - (p_b - p_0) A_b = 3e6 x 1e-3 - 1e6 x 0.5e-3 = 2500 N, held by the load."""
    settings = CylinderLoad(
        moving_mass=50.0, viscous_friction=100.0, observer_rate=100.0, load_rate=20.0, sample_period=1e-3,
        area_a=1e-3, area_b=0.5e-3,
    )  # fmt: skip
    memory = observer_start(settings)
    for number in range(500):
        memory, found = observer_step(1e-3 * number, memory, Moved(0.1, 3101325.0, 1101325.0), settings)
    assert tuple(found) == pytest.approx((0.1, 0.0, -2500.0), abs=1e-9)


def test_a_flow_map_gives_the_duty_ratio():
    flows = FlowMap(duty_ratios=(0.0, 0.5, 1.0), line_pressures=(1e5, 1e7), flows=(0.0, 2e-4, 5e-4, 0.0, 1e-4, 4e-4))
    _, found = flow_map_step(0.0, None, Delivery(3e-4, 6e6), flows)
    assert flow_for_duty(found.duty_ratio, 6e6, flows) == pytest.approx(3e-4, rel=1e-12)


OBSERVED = """
[programs.load_seen]
type = "load-observer"
period = "2 ms"
reads = { position = "rod.position", pressure_a = "line.pressure" }
moving_mass = "50 kg"
viscous_friction = "100 N*s/m"
observer_rate = "100 1/s"
load_rate = "20 1/s"
sample_period = "1 ms"
area_a = "10 cm^2"
"""


def test_an_observer_is_called_at_its_own_sample_period():
    head = SYSTEM.partition("[programs.speed]")[0].replace("[nodes]", '[nodes]\nrod = { type = "rod", mass = "1 kg" }')
    text = head + '[components.spring]\ntype = "weight"\nrod = "rod"\nmass = "1 kg"\nslope = "0 deg"\n' + OBSERVED
    run = '[run]\nuntil = "10 ms"\nsample_period = "5 ms"\n'
    with pytest.raises(ConfigError, match=r"0\.002 s must be the sample_period, 0\.001 s"):
        built_system(parsed_table(text + run, "mine.toml"), "mine")
    found = built_system(parsed_table(text.replace('period = "2 ms"\n', "", 1) + run, "mine.toml"), "mine")
    assert found.circuit.model.programs["load_seen"].period == 1e-3
