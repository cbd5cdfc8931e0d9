"""Waves in a pipe of pieces: what the roughness of its pressure says of its extremes."""

import numpy as np
import pytest

from vvdp.base.tables import Table
from vvdp.runs.simulate import check_accuracy, run_system
from vvdp.simulation.run import simulate
from vvdp.systems.pipe_waves import ROUGHEST, roughness
from vvdp.systems.summary import summary
from vvdp.systems.system import built_system
from vvdp.systems.validity import broken_bounds

LENGTH, DENSITY, MODULUS = 10.0, 876.0, 1.4e9
TRANSIT = LENGTH * np.sqrt(DENSITY / MODULUS)
"""Time of a wave from end to end: 7.910 ms."""


def test_roughness_by_hand():
    """The shortest wave has 16 times its amplitude, one of 12 pieces 16 sin(pi/12)^4, a straight line nothing."""
    zigzag, t = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0]), np.array([[-1.0], [1.0]])
    assert roughness(100.0 + t * zigzag) == pytest.approx(16.0 / 101.0, rel=1e-14)
    long_wave = np.cos(2.0 * np.pi * np.arange(13) / 12.0)
    assert roughness(100.0 + t * long_wave) == pytest.approx(16.0 * np.sin(np.pi / 12.0) ** 4 / 101.0, rel=1e-12)
    assert roughness(100.0 + t * np.arange(7.0)) == pytest.approx(0.0, abs=1e-14)


def test_what_does_not_change_is_not_rough():
    assert roughness(np.tile([1e5, 9e5, 2e5, 7e5, 1e5], (3, 1))) == 0.0


def test_fewer_than_five_pieces_are_rough_by_their_whole_swing():
    assert roughness(np.array([[99.0, 99.0], [101.0, 101.0]])) == pytest.approx(1.0 / 101.0, rel=1e-14)


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
    if off > 0.03:
        assert not found["trusted"]
        assert any("waves shorter than its pieces" in told for told in broken_bounds(system, found))


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
