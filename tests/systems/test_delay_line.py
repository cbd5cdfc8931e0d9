"""A line with an exact delay: square waves without ringing, Joukowsky's surge, and what it holds."""

import math

import numpy as np
import pytest

from vvdp.base.tables import Table
from vvdp.evaluation.summary import summary
from vvdp.evaluation.validity import broken_bounds
from vvdp.simulation.run import simulate
from vvdp.systems.system import built_system

LENGTH, DIAMETER, SPEED, DENSITY, MODULUS = 10.0, 0.02, 1250.0, 876.0, 1.4e9
DELAY = LENGTH / SPEED
BAR, ATMOSPHERE = 1e5, 101325.0


def closed_line(pressure, until, samples="100", **oil):
    """A line between a source and a closed end: system, run and summary."""
    circuit = {
        "oil": {"density": "876 kg/m^3", "liquid_bulk_modulus": "1.4 GPa", "air_fraction": "0", **oil},
        "nodes": {
            "supply": {"type": "pressure-source", "pressure": pressure},
            "end": {"type": "volume", "volume": "1 cc", "start": "100 bar"},
        },
        "components": {
            "line": {
                "type": "delay-line", "a": "supply", "b": "end", "length": "10 m", "diameter": "20 mm",
                "sound_speed": "1250 m/s", "start": "100 bar", "samples": samples,
            },
        },
        "run": {"until": until, "relative_tolerance": "1e-7", "record_interval": "0.08 ms"},
    }  # fmt: skip
    system = built_system(Table("line", circuit, {}), "line")
    run = simulate(system.model, system.case, system.stepping)
    return system, run, summary(system, run)


def stepped(until="0.2 s", samples="100", **oil):
    """The same with a step from 100 to 150 bar after one delay."""
    return closed_line({"step": ["100 bar", "150 bar"], "at": "8 ms"}, until, samples, **oil)


def test_a_square_wave_rings_by_less_than_2_percent_and_crosses_its_middle_as_often_as_theory_says():
    _, run, found = stepped()
    end = (run.state.end - ATMOSPHERE) / BAR
    middle = np.flatnonzero(np.diff(np.sign(end - 150.0)))
    expected = DELAY * (2.0 + 2.0 * np.arange(12))
    assert run.times[middle] == pytest.approx(expected, abs=0.02 * DELAY)
    since = (run.times - DELAY) / DELAY
    flat = (since % 2.0 < 0.95) | (since % 2.0 > 1.2)  # away from the fronts, which are at 1
    high = (np.floor((since - 1.0) / 2.0) % 2 == 0) & (since > 1.0)
    assert np.max(np.abs(end - np.where(high, 200.0, 100.0))[flat]) < 0.02 * 50.0
    assert found["trusted"]
    assert max(abs(found["energy_residual"]), abs(found["mass_residual"])) < 1e-7


def test_what_the_line_holds_is_what_is_on_its_way():
    """The energy in its balance is that of the waves in its memory, counted anew."""
    system, run, _ = stepped(until="0.16 s")
    memory, period = run.final_memory["line_waves"], DELAY / 100.0
    on_its_way = period * (np.sum(memory.means**2) + np.sum(memory.swings**2))
    assert run.state.line_ends.energy[-1] == pytest.approx(on_its_way, rel=1e-6)
    root = math.sqrt(DENSITY * SPEED / (0.25 * math.pi * DIAMETER**2))
    held = 0.25 * math.pi * DIAMETER**2 * LENGTH + period * np.sum(memory.means) / root
    assert run.state.line_ends.volume[-1] == pytest.approx(held, rel=1e-9)
    assert system.circuit.network.groups["line"].programs == ("line_waves",)


def test_the_loss_of_sampling_vanishes_with_the_samples():
    """Of a ramp as the square of their distance: its swing about its mean in a sample is h/root(12) of its slope."""
    ramp = {"table": [["0 s", "100 bar"], ["8 ms", "100 bar"], ["16 ms", "150 bar"]]}
    coarse, fine = (closed_line(ramp, "24 ms", samples)[2]["loss_line_W"] for samples in ("20", "40"))
    assert coarse / fine == pytest.approx(4.0, rel=0.05)


def test_a_line_at_rest_stays_at_rest():
    _, run, found = closed_line("100 bar", "50 ms")
    assert np.max(np.abs(run.state.end - run.state.end[0])) < 1.0
    assert found["loss_line_W"] == pytest.approx(0.0, abs=1e-9)


def test_joukowsky_within_a_percent():
    """A valve that closes in a millisecond: rho c v, and a quarter of c/l."""
    circuit = {
        "oil": {"density": "876 kg/m^3", "liquid_bulk_modulus": "1.4 GPa", "air_fraction": "0"},
        "nodes": {
            "tank": {"type": "tank"},
            "supply": {"type": "pressure-source", "pressure": "100 bar"},
            "end": {"type": "volume", "volume": "1 cc", "start": "100 bar"},
        },
        "components": {
            "line": {
                "type": "delay-line", "a": "supply", "b": "end", "length": "10 m", "diameter": "20 mm",
                "sound_speed": "1259.7 m/s", "start": "100 bar",
            },
            "valve": {
                "type": "two-way-valve", "a": "end", "b": "tank", "command": {"step": ["1", "0"], "at": "1 s"},
                "natural_frequency": "500 Hz", "stroke": "1 mm", "lap": "-0.5 mm", "full_area": "3.41 mm^2",
            },
        },
        "run": {"until": "1.3 s", "relative_tolerance": "1e-7", "record_interval": "0.1 ms"},
    }  # fmt: skip
    system = built_system(Table("valve", circuit, {}), "valve")
    run = simulate(system.model, system.case, system.stepping)
    found = summary(system, run)
    rise = 11.119 * BAR  # findings of an independent method of characteristics
    assert found["pressure_max_end_Pa"] - 100 * BAR == pytest.approx(rise, rel=0.015)
    assert 100 * BAR - found["pressure_min_end_Pa"] == pytest.approx(rise, rel=0.015)
    assert found["trusted"]
    late = run.times > 1.0
    end = run.state.end[late] - ATMOSPHERE - 100 * BAR
    crossings = run.times[late][np.flatnonzero(np.diff(np.sign(end)) != 0)][1:]
    period = 2.0 * np.mean(np.diff(crossings))
    assert 1.0 / period == pytest.approx(1259.7 / (4.0 * LENGTH), rel=2e-3)


def test_oil_whose_waves_would_grow_steeper_is_not_valid():
    system, _, found = stepped(until="20 ms", air_fraction="8 %")
    assert not found["within_validity"]
    assert any("its waves would grow steeper" in sentence for sentence in broken_bounds(system, found))


def test_a_speed_that_no_oil_has_is_not_valid():
    system, _, found = stepped(until="20 ms", liquid_bulk_modulus="1.2 GPa")
    assert any("no faster waves" in sentence for sentence in broken_bounds(system, found))
