"""Waves in a pipe of pieces: what the roughness of its pressure says of its extremes."""

import numpy as np
import pytest

from vvdp.base.tables import Table
from vvdp.evaluation.pipe_waves import ROUGHEST, roughness
from vvdp.evaluation.summary import summary
from vvdp.evaluation.validity import broken_bounds
from vvdp.runs.simulate import check_accuracy, run_system
from vvdp.simulation.run import simulate
from vvdp.systems.system import built_system

LENGTH, DENSITY, MODULUS = 10.0, 876.0, 1.4e9
TRANSIT = LENGTH * np.sqrt(DENSITY / MODULUS)
"""Time of a wave from end to end: 7.910 ms."""


def rough(swing, transits, damping=0.0):
    """The roughness of a swing about 100 bar that comes and goes."""
    return roughness(np.array([[100.0 - each, 100.0 + each] for each in swing]).T, transits, damping)


def test_a_front_is_off_by_two_thirds_of_its_height():
    """Just before a front the integral of the Airy function from minus infinity to 0 has come, by hand 2/3."""
    front = np.arange(401) >= 200
    assert rough(front, transits=8.0 * 20.0**3 / 401.0) == pytest.approx(2.0 / 3.0 / 101.0, rel=2e-2)


def test_a_wave_is_off_by_its_shift_of_phase():
    """A wave of 40 pieces after M transits of n pieces: by k^3 n M/24, from sin(k/2) = k/2 - k^3/48 of a chain."""
    x, k, n, transits = np.arange(2001.0) - 1000.0, 2.0 * np.pi / 40.0, 2001, 0.5
    packet = np.cos(k * x) * np.exp(-((x / 300.0) ** 2))
    assert rough(packet, transits) == pytest.approx(2.0 * np.sin(k**3 * n * transits / 48.0) / 101.0, rel=4e-2)


def test_damping_stops_dispersion():
    """At 0.3 before a piece is reached, so that a straight rise of 100 pieces has a kink at its ends alone."""
    rise = np.clip(np.arange(401.0) - 150.0, 0.0, 100.0) / 100.0
    assert rough(rise, 1e6) > 0.1 / 101.0
    assert rough(rise, 1e6, damping=0.3) == pytest.approx(0.5 * 0.3 * 401 * 0.01 / 101.0, rel=1e-9)


def test_what_does_not_change_is_not_rough():
    assert roughness(np.tile([1e5, 9e5, 2e5, 7e5, 1e5], (3, 1)), 100.0) == 0.0


def test_fewer_than_five_pieces_are_rough_by_their_whole_swing():
    assert roughness(np.array([[99.0, 99.0], [101.0, 101.0]]), 100.0) == pytest.approx(1.0 / 101.0, rel=1e-14)


def closed_pipe(pieces, rise, damping=0.0, falls=False):
    """A lossless pipe with a closed end, whose other end goes from 100 to 150 bar in a time [s]; it may go back."""
    ways = [["0 s", "100 bar"], ["5 ms", "100 bar"], [f"{5e-3 + rise} s", "150 bar"]]
    pressure = {"table": [*ways, [f"{5e-3 + 2.0 * rise} s", "100 bar"]] if falls else ways}
    circuit = {
        "oil": {"density": "876 kg/m^3", "liquid_bulk_modulus": "1.4 GPa", "air_fraction": "0"},
        "nodes": {
            "supply": {"type": "pressure-source", "pressure": pressure},
            "end": {"type": "volume", "volume": "1 cc", "start": "100 bar"},
        },
        "components": {
            "pipe": {
                "type": "pipe", "a": "supply", "b": "end", "length": "10 m", "diameter": "20 mm",
                "hose_compliance": "0 1/Pa", "wall_friction": "0", "pieces": str(pieces), "start": "100 bar",
                "damping": str(damping),
            },
        },
        "run": {"until": "0.2 s", "relative_tolerance": "1e-7"},
    }  # fmt: skip
    system = built_system(Table("pipe", circuit, {}), "pipe")
    return system, summary(system, simulate(system.model, system.case, system.stepping))


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("pieces", "transits"), [(5, 1e-3), (20, 1e-3), (40, 1e-3), (40, 0.25), (20, 0.5), (40, 1.0), (80, 1.0)]
)
def test_extremes_are_right_or_the_run_is_not_valid(pieces, transits):
    """A change within two transits doubles at the closed end, to 200 bar, whatever its shape (d'Alembert)."""
    system, found = closed_pipe(pieces, transits * TRANSIT)
    off = abs(found["pressure_max_end_Pa"] / 200e5 - 1.0)
    assert found["within_validity"] == (found["wave_roughness_pipe"] <= ROUGHEST)
    if transits == 1e-3:
        assert 0.18 < off < 0.205 and 0.18 < found["wave_roughness_pipe"] < 0.205
    if off > 0.03:
        assert not found["trusted"]
        assert any("waves that its pieces do not show right" in told for told in broken_bounds(system, found))


SIGNS = {"max": 1.0, "min": -1.0}


def closing_valve(pieces, damping, until):
    """Ten metres of lossless pipe at a source of 100 bar, whose end a valve shuts at 1 s within 2 ms."""
    circuit = {
        "oil": {"density": "876 kg/m^3", "liquid_bulk_modulus": "1.4 GPa", "air_fraction": "0"},
        "nodes": {
            "tank": {"type": "tank"},
            "supply": {"type": "pressure-source", "pressure": "100 bar"},
            "end": {"type": "volume", "volume": "1 cc", "start": "100 bar"},
        },
        "components": {
            "pipe": {
                "type": "pipe", "a": "supply", "b": "end", "length": "10 m", "diameter": "20 mm",
                "hose_compliance": "0 1/Pa", "wall_friction": "0", "pieces": str(pieces), "start": "100 bar",
                "damping": str(damping),
            },
            "valve": {
                "type": "two-way-valve", "a": "end", "b": "tank", "natural_frequency": "500 Hz", "stroke": "1 mm",
                "lap": "-0.5 mm", "full_area": "3.41 mm^2", "command": {"step": ["1", "0"], "at": "1 s"},
            },
        },
        "run": {"until": until, "average_from": "0.9 s", "relative_tolerance": "1e-7"},
    }  # fmt: skip
    system = built_system(Table("valve", circuit, {}), "valve")
    return summary(system, simulate(system.model, system.case, system.stepping))


@pytest.mark.thorough
@pytest.mark.parametrize("pieces", [20, 40, 80])
@pytest.mark.parametrize("damping", [0.0, 0.1, 0.3])
def test_a_valve_that_closes_has_the_rise_of_joukowsky(pieces, damping):
    """Up by rho c v from 100 bar at the closed end, and down by as much, over 38 transits; or the run is not valid."""
    open_, found = (closing_valve(pieces, damping, until) for until in ("0.99 s", "1.3 s"))
    velocity = open_["flow_mean_valve_m3_s"] / (0.25 * np.pi * 0.02**2)
    rise = np.sqrt(DENSITY * MODULUS) * velocity
    assert rise == pytest.approx(11.12e5, rel=5e-3)
    off = max(abs(found[f"pressure_{end}_end_Pa"] - 100e5 - sign * rise) for end, sign in SIGNS.items())
    off /= 101.01325e5 + rise
    assert off < 0.03 or not found["trusted"]
    assert off < 0.01 or damping == 0.0
    if damping == 0.0:
        assert found["wave_roughness_pipe"] == pytest.approx({20: 0.072, 40: 0.063, 80: 0.053}[pieces], rel=1e-2)
        assert off == pytest.approx({20: 0.072, 40: 0.060, 80: 0.047}[pieces], rel=1e-2)


def test_a_change_that_the_pieces_resolve_is_trusted_and_doubles():
    _, found = closed_pipe(80, TRANSIT)
    assert found["trusted"]
    assert found["pressure_max_end_Pa"] == pytest.approx(200e5, rel=0.03)


def test_a_check_divides_pipes_twice_as_finely():
    """A front that 20 pieces do not resolve: a smaller tolerance changes nothing, other pieces the extremes."""
    run = run_system(closed_pipe(20, 1e-3 * TRANSIT)[0])
    found = {move.key: move for move in check_accuracy(run)}
    finer = closed_pipe(40, 1e-3 * TRANSIT)[1]["pressure_max_end_Pa"]
    moved = found["pressure_max_end_Pa"]
    assert moved.value == pytest.approx(finer, rel=1e-5)
    assert moved.change == pytest.approx(abs(run.summary["pressure_max_end_Pa"] / finer - 1.0), rel=1e-3)
    assert moved.change > 1e-2
    assert not [key for key in found if "_pipe_1_" in key or "_pipe_to_end_" in key]


@pytest.mark.parametrize(("pieces", "most"), [(5, 5e-3), (20, 1e-3)])
def test_damping_leaves_a_front_no_overshoot(pieces, most):
    """It doubles to 200 bar and comes back to 100, instead of 237 and 54; what it takes is a loss, and all closes."""
    _, found = closed_pipe(pieces, 1e-3 * TRANSIT, damping=0.3)
    assert found["pressure_max_end_Pa"] == pytest.approx(200e5, rel=most)
    assert found["pressure_min_end_Pa"] == pytest.approx(100e5, rel=most)
    assert abs(found["energy_residual"]) < 1e-8
    assert found["loss_pipe_from_supply_W"] > 0.0


@pytest.mark.parametrize(("pieces", "transits"), [(10, 0.5), (20, 0.25), (20, 0.6), (20, 1.0), (40, 1.0)])
def test_a_pulse_that_damping_takes_is_not_valid(pieces, transits):
    """A pulse within two transits doubles at the closed end (d'Alembert): to 200 bar, or the run is not valid."""
    _, found = closed_pipe(pieces, transits * TRANSIT, damping=0.3, falls=True)
    assert abs(found["pressure_max_end_Pa"] / 200e5 - 1.0) < 0.03 or not found["trusted"]


def test_damping_vanishes_with_the_number_of_pieces():
    """It spreads a corner as diffusion does, over the root of the length of a piece: half of it, 0.707 of the loss."""
    lost = [200e5 - closed_pipe(n, TRANSIT, damping=0.3, falls=True)[1]["pressure_max_end_Pa"] for n in (20, 40)]
    assert lost[1] / lost[0] == pytest.approx(np.sqrt(0.5), rel=0.02)
