"""What `vvdp run --check` says: close to the true error, on every shipped system and on random variants."""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.evaluation.accuracy import OF_THE_RUN, Move, moves
from vvdp.evaluation.quantities import summary_units
from vvdp.evaluation.summary import summary
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system, shipped_systems

pytestmark = pytest.mark.heavy

FINEST = 1e-11
SEEN = 1e-9
"""Changes below this are those of rounding."""


def found_at(system, tolerance):
    stepping = replace(system.stepping, relative_tolerance=tolerance, window=1e-3)
    return summary(system, simulate(system.model, system.case, stepping))


def of_the_machine(changes):
    """Without what an estimator makes of samples, which one edge more or less moves by jumps."""
    return [move for move in changes if "error_rms" not in move.key]


def test_moves_by_hand():
    found = {"loss_a_W": 100.0, "loss_b_W": 0.05, "steps": 10.0, "settled": True, "flow_m3_s": 2e-4}
    finer = {"loss_a_W": 101.0, "loss_b_W": 0.06, "steps": 20.0, "settled": False, "flow_m3_s": 2e-4}
    first, second, third = moves(found, finer, {"loss_a_W": "W", "loss_b_W": "W", "flow_m3_s": "m^3/s"})
    assert first == Move("loss_b_W", 0.06, pytest.approx(0.01 / 0.101))  # over a thousandth of the largest loss
    assert second == Move("loss_a_W", 101.0, pytest.approx(1.0 / 101.0))
    assert third.change == 0.0 and "steps" in OF_THE_RUN


UNTIL = {
    "axial-chamber": "0.7 s",
    "axial-gerotor": "1.2 s",
    "bleed-off-control": "5 s",
    "digital-pump-control": "6 s",
    "flow-control-unit": "5 s",
    "ideal-pump-control": "5 s",
    "independent-units": "5 s",
    "independent-valves": "5 s",
    "linear-valves": "5 s",
    "load-sensing": "5 s",
    "measured-pump-control": "5 s",
}
"""Where nothing flows while a drive stands at its stop, longer than that; where a rod turns back, until it has. With an
encoder 0.3 s end before it is controlled: one edge more or less moves what the control does. After 5 s the flow of
enabled pistons into a chamber has a mean of next to nothing, so they have 6 s."""


@pytest.mark.sampled(4)
@pytest.mark.parametrize("name", shipped_systems())
def test_parts_are_exact_at_the_default(name):
    """Within 1e-5 of the converged value, relative to the part or to a thousandth of the largest of its unit; extremes,
    which are those at the ends of steps, within 3e-5."""
    system = load_system(name, until=UNTIL.get(name, "0.3 s"))
    found, exact = (found_at(system, tolerance) for tolerance in (system.stepping.relative_tolerance, FINEST))
    changes = of_the_machine(moves(found, exact, summary_units(system)))
    allowed = [3e-5 if "_max_" in move.key or "_min_" in move.key else 1e-5 for move in changes]
    assert [m for m, most in zip(changes, allowed, strict=True) if m.change >= most] == []


def variant(rng):
    """The prototype with other numbers and, half of the time, other laws."""
    settings = [
        f"operation.duty_ratio={rng.uniform(0.1, 0.9):.3f}",
        f"load.area={rng.uniform(2.0, 8.0):.2f} mm^2",
        f"inlet.volume={rng.uniform(8.0, 40.0):.1f} cc",
        f"oil.air_fraction={rng.uniform(0.1, 3.0):.2f} %",
        f"relief_valve.cracking_pressure={rng.uniform(90.0, 150.0):.1f} bar",
    ]
    if rng.random() < 0.5:
        settings.append(f"relief_valve.override_pressure={rng.uniform(2.0, 15.0):.1f} bar")
        if rng.random() < 0.5:
            settings.append(f"relief_valve.opening_time={rng.uniform(0.5, 5.0):.1f} ms")
        if rng.random() < 0.5:
            settings.append(f"relief_valve.reseat_drop={rng.uniform(1.0, 10.0):.1f} bar")
    if rng.random() < 0.3:
        settings.append("check_valve.reverse_opening=0")
    if rng.random() < 0.3:
        settings.append(f"valve.lap_ratio={rng.uniform(0.6, 1.3):.2f}")
    return load_system("prototype", settings, until="0.2 s")


@pytest.mark.slow
def test_the_check_tells_the_true_error_of_random_variants():
    """Most of 50 within a factor of three: what moves most may be right by chance, or the finer run no better."""
    rng, shares = np.random.default_rng(20261122), []
    for _ in range(50):
        system = variant(rng)
        tolerance = system.stepping.relative_tolerance
        coarse, finer, exact = (found_at(system, x) for x in (tolerance, 0.1 * tolerance, FINEST))
        said, true = (of_the_machine(moves(coarse, other, summary_units(system)))[0].change for other in (finer, exact))
        shares.append(max(said, SEEN) / max(true, SEEN))
    assert np.mean((np.array(shares) > 1.0 / 3.0) & (np.array(shares) < 3.0)) >= 0.8
