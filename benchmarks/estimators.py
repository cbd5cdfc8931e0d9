"""The event filter's update against filterpy's, what a sample costs every estimator, and the smoother by its parts."""

import os
import subprocess
import sys
from functools import partial
from typing import NamedTuple

import numpy as np
from filterpy.kalman import KalmanFilter

from benchmarks.measure import HERE, ROUNDS, interleaved, ratios, report, run_as_command, spread
from benchmarks.reference import taken_out
from vvdp.base.kinds import AccelerationDensity, AngularVariance
from vvdp.base.params import Params
from vvdp.comparison.estimators import contenders
from vvdp.comparison.scenarios import scenarios
from vvdp.comparison.smoothing import run_compiled
from vvdp.comparison.trials import compiled_encoder, compiled_step, run_estimator, simulate_record
from vvdp.estimation.smoother import filter_edges, smooth_edges, smoothed_at
from vvdp.numerics.kalman import AngleSpeed, predict, update
from vvdp.simulation.replay import Replay

UPDATES, SAMPLES = 2000, 200_000
"""Measured by filterpy in a round; samples that an estimator goes through."""
SAMPLE_TARGET, RATIO_TARGET = 200.0, 100.0
COMMIT, EARLIER_TARGET = "e01da77c", 1.5
"""The last commit whose filter had no doubt beside its own, and how much longer a sample may take since."""
START = AngleSpeed(0.0, 150.0, 1000.0, 0.0, 1000.0)


class Edge(NamedTuple):
    interval: float
    angle: float


class Densities(Params):
    acceleration_density: AccelerationDensity
    edge_variance: AngularVariance


def updated(belief: AngleSpeed, edge: Edge, settings: Densities) -> tuple[AngleSpeed, AngleSpeed]:
    """One prediction and one update: what both sides are timed on."""
    prior = predict(belief, edge.interval, settings.acceleration_density)
    after = update(prior, edge.angle - prior.angle, settings.edge_variance)
    return after, after


def filterpy_updates(edges: np.ndarray, settings: Densities) -> np.ndarray:
    """Angle and speed after each edge, shape (edges, 2)."""
    q = settings.acceleration_density
    rival = KalmanFilter(dim_x=2, dim_z=1)
    rival.x, rival.P = np.array([START.angle, START.speed]), 1000.0 * np.eye(2)
    rival.H, rival.R = np.array([[1.0, 0.0]]), np.array([[settings.edge_variance]])
    found = np.empty((len(edges), 2))
    for i, (h, angle) in enumerate(edges):
        rival.predict(F=np.array([[1.0, h], [0.0, 1.0]]), Q=q * np.array([[h**3 / 3, h**2 / 2], [h**2 / 2, h]]))
        rival.update(angle)
        found[i] = rival.x
    return found


def against_filterpy(rounds: int) -> None:
    """The same edges through both; they must agree before their times mean anything."""
    random, settings = np.random.default_rng(1), Densities(acceleration_density=0.25, edge_variance=5.5e-3)
    sector = np.pi / 4
    intervals = np.full(UPDATES, sector / 150.0) * (1.0 + 0.1 * random.uniform(-1.0, 1.0, UPDATES))
    angles = 150.0 * np.cumsum(intervals) + 0.07 * random.standard_normal(UPDATES)
    edges = np.column_stack([intervals, angles])
    replay = Replay(updated, START, Edge(0.005, 0.0), settings)
    many = np.tile(edges, (SAMPLES // UPDATES, 1))
    apart = np.max(np.abs(replay(START, edges).shown[:, :2] - filterpy_updates(edges, settings)))
    report("largest difference of the two", f"{apart:.2g} rad, rad/s", "1e-9", apart < 1e-9)
    times = interleaved(
        {"vvdp": lambda: replay(START, many), "filterpy": lambda: filterpy_updates(edges, settings)}, rounds
    )
    report("predict and update, vvdp", spread(times["vvdp"], "ns", 1e9 / len(many)))
    report("predict and update, filterpy", spread(times["filterpy"], "ns", 1e9 / UPDATES))
    found = [ratio * len(many) / UPDATES for ratio in ratios(times, "filterpy", "vvdp")]
    report("filterpy over vvdp", spread(found, "times"), f"{RATIO_TARGET:g}", float(np.median(found)) >= RATIO_TARGET)


def cost_per_sample(samples: int, rounds: int) -> None:
    """Every estimator over the same readings: 8 sectors, 24.7 turns a second, 1 kHz."""
    scenario = scenarios()[0]
    record = simulate_record(scenario, compiled_encoder(scenario), 0, samples)
    variants = {}
    for each in contenders():
        variants[each.name] = partial(run_estimator, each, compiled_step(each), record, each.rows(scenario, record))
    times = interleaved(variants, rounds)
    for name, taken in times.items():
        met = float(np.median(taken)) * 1e9 / samples < SAMPLE_TARGET
        report(f"{name}, one sample", spread(taken, "ns", 1e9 / samples), f"{SAMPLE_TARGET:g}", met)
        if name != "event-filter":
            report("  over event-filter", spread(ratios(times, name, "event-filter"), "times"))


def against_earlier(samples: int, rounds: int) -> None:
    """A sample of the event filter now, and in the commit before its doubts, each in a process of its own, in turns."""
    with taken_out(COMMIT) as earlier:
        trees = {"now": HERE.parent, COMMIT: earlier if earlier is not None and samples == SAMPLES else HERE.parent}
        found: dict[str, list[float]] = {name: [] for name in trees}
        for name, tree in [*trees.items()] * rounds:
            environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tree / "src"), str(HERE.parent)])}
            code = f"from benchmarks.estimators import sample_of_the_filter as s; print(s({samples}))"
            done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, check=True)
            found[name].append(float(done.stdout))
    shares = ratios(found, "now", COMMIT)
    met = float(np.median(shares)) <= EARLIER_TARGET
    report(f"event-filter, one sample over {COMMIT}", spread(shares, "times"), f"{EARLIER_TARGET:g}", met)


def sample_of_the_filter(samples: int) -> float:
    """Processor time of a sample of the event filter, the least of five [ns]."""
    scenario, each = scenarios()[0], contenders()[0]
    record = simulate_record(scenario, compiled_encoder(scenario), 0, samples)
    rows, step = each.rows(scenario, record), compiled_step(each)
    run_estimator(each, step, record, rows)
    times = interleaved({"filter": partial(run_estimator, each, step, record, rows)}, 5)["filter"]
    return min(times) * 1e9 / samples


def cost_of_smoothing(edges: int, rounds: int) -> None:
    """A record of edges at 198 a second forward, back, and at an instant for each between them, compiled."""
    random, R, q = np.random.default_rng(2), 5.5e-3, 0.25
    times = np.cumsum(random.uniform(4e-3, 6e-3, edges))
    angles, variances = 155.0 * times + np.sqrt(R) * random.standard_normal(edges), np.full(edges, R)
    prior = AngleSpeed(angles[0], 155.0, 1000.0, 0.0, 1000.0)
    instants = random.uniform(times[0], times[-1], edges)
    instants.sort()
    record = smooth_edges(times, angles, variances, q, prior, run_compiled)
    smoothed_at(instants, record, run_compiled)
    found = interleaved(
        {
            "an edge forward": lambda: filter_edges(times, angles, variances, q, prior, run_compiled),
            "an edge forward and back": lambda: smooth_edges(times, angles, variances, q, prior, run_compiled),
            "an instant between two": lambda: smoothed_at(instants, record, run_compiled),
            "an instant between two, not compiled": lambda: smoothed_at(instants, record),
        },
        rounds,
    )
    for name, taken in found.items():
        report(f"smoother, {name}", spread(taken, "ns", 1e9 / edges), listed=True)


def main(short: bool) -> None:
    """All four questions, on one core."""
    against_filterpy(1 if short else ROUNDS)
    cost_per_sample(*((2000, 1) if short else (SAMPLES, ROUNDS)))
    against_earlier(*((2000, 1) if short else (SAMPLES, ROUNDS)))
    cost_of_smoothing(*((2000, 1) if short else (SAMPLES, ROUNDS)))


if __name__ == "__main__":
    run_as_command(main)
