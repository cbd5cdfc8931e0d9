"""Noise models of the axial sensor side by side: one periodic sensor error, one motion, and what each makes of it at
what cost.

Lumped filter, discrete signal generator, and periodic Kalman filter with Fourier and with Gaussian functions, on the
gerotor drive, whose flow is known.
"""

import time
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import COUNT, LENGTH, RATIO, SAMPLE_COST, Area, Length, Speed, Time
from vvdp.base.params import Params
from vvdp.estimation.axial_filter import NO_DUTY, AxialSeen, Phase, PollutionModel
from vvdp.estimation.gerotor_observer import GerotorObserver, gerotor_observer_start, gerotor_observer_step
from vvdp.estimation.noise_basis import TURN, NoiseBasis, fourier_basis, function_count, gaussian_basis, write_basis
from vvdp.estimation.signal_generator import (
    GeneratorDesign,
    LumpedMemory,
    LumpedObserver,
    generator_observer,
    generator_observer_step,
    generator_start,
    lumped_observer_step,
)
from vvdp.results.result import Column, Table
from vvdp.simulation.replay import Replay, Step

MARGIN_POINTS = 2000
ROUNDS = 5
"""How often each model is timed; the shortest time counts."""


NOTHING_SEEN = AxialSeen(
    time=0.0,
    optical=0.0,
    phase=Phase(angle=0.0, speed=0.0, angle_deviation=0.0),
    pressure=0.0,
    flow=0.0,
    held=0.0,
    margin=1.0,
    duty=NO_DUTY,
)


class NoiseTrial(Params):
    """Trial of the models: the spool goes to and fro over `stroke` in `motion_period` and turns with `spool_speed`; the
    second half of `duration` counts. Margins are those of a drive with this `natural_frequency`."""

    spool_speed: Speed = TURN * 10.0
    sample_period: Time = 1e-3
    duration: Time = 40.0
    stroke: Length = 20.32e-3
    motion_period: Time = 4.0
    area: Area = 5.067e-4
    white_noise: Length = 20e-6
    sensor_deviation: Length = 30e-6
    position_drift: Length = 3e-6
    coefficient_drift: Length = 0.6e-6
    generator_drift: Length = 3e-6
    bandwidth: Speed = 60.0
    natural_frequency: Speed = 72.03


class Model(NamedTuple):
    """Size and margin of a noise model; the margin is NaN where none is calculated."""

    name: str
    functions: int
    states: int
    margin: float


class Entry(NamedTuple):
    """A model with what runs it."""

    model: Model
    step: Step
    memory: Any
    settings: Any


def noise_model_table(shape: Array, trial: NoiseTrial, functions: tuple[int, ...] = (10, 20, 40)) -> Table:
    """A row for each model: functions, states, margin, errors of position and periodic sensor error, time of a sample.

    shape      the periodic sensor error at equal distances over a turn, mean 0 [m]
    functions  of the periodic filters, even numbers

    Raises ParameterError where a period of the periodic sensor error is no whole number of samples.
    """
    entries = tuple(entries_of(trial, functions))
    rows, position, pollution = record(shape, trial)
    half = slice(rows.shape[0] // 2, None)
    found = []
    for entry in entries:
        replay = Replay(entry.step, entry.memory, NOTHING_SEEN, entry.settings)
        shown = dict(zip(replay.columns, replay(entry.memory, rows).shown.T, strict=True))
        off, noise = shown["position"] - position, shown["pollution"] - pollution
        cost = min(_seconds(replay, entry, rows) for _ in range(ROUNDS)) / rows.shape[0]
        errors = np.sqrt(np.mean(off[half] ** 2.0)), np.max(np.abs(off[half])), np.sqrt(np.mean(noise[half] ** 2.0))
        found.append((*errors, cost))
    rms, peak, missed, costs = np.array(found).T
    models = [entry.model for entry in entries]
    columns = {
        "model": Column(np.array([m.name for m in models]), None, "noise model"),
        "functions": Column(np.array([float(m.functions) for m in models]), COUNT, "functions"),
        "states": Column(np.array([float(m.states) for m in models]), COUNT, "states"),
        "margin": Column(np.array([m.margin for m in models]), RATIO, "margin with a spring drive"),
        "position_error_rms_m": Column(rms, LENGTH, "error of the position, rms"),
        "position_error_peak_m": Column(peak, LENGTH, "error of the position, largest"),
        "pollution_error_rms_m": Column(missed, LENGTH, "error of the periodic sensor error, rms"),
        "cost_s": Column(costs, SAMPLE_COST, "time of a sample"),
    }
    return Table(title="Noise models of the axial sensor", columns=columns)


def _seconds(replay: Replay, entry: Entry, rows: Array) -> float:
    begin = time.thread_time()
    replay(entry.memory, rows)
    return time.thread_time() - begin


def entries_of(trial: NoiseTrial, functions: tuple[int, ...]) -> Iterator[Entry]:
    """The models that are put side by side."""
    t = trial
    lumped = LumpedObserver(area=t.area, sample_period=t.sample_period, bandwidth=t.bandwidth)
    yield Entry(Model("lumped", 0, 1, np.nan), lumped_observer_step, LumpedMemory(0.0, 0.0), lumped)
    design = GeneratorDesign(
        area=t.area,
        sample_period=t.sample_period,
        noise_period=TURN / t.spool_speed,
        sensor_deviation=t.sensor_deviation,
        position_drift=t.position_drift,
        generator_drift=t.generator_drift,
    )
    generator = generator_observer(design)
    memory = generator_start(generator, 0.0)
    yield Entry(Model("signal generator", 0, memory.mean.size, np.nan), generator_observer_step, memory, generator)
    for count in functions:
        yield _periodic(f"Fourier, {count}", count, fourier_basis(count // 2), trial)
    for count in functions:
        yield _periodic(f"Gaussian, {count}", count, gaussian_basis(count, TURN / (count + 1)), trial)


def _periodic(name: str, functions: int, basis: NoiseBasis, trial: NoiseTrial) -> Entry:
    pollution = PollutionModel(
        basis=basis,
        sensor_deviation=trial.sensor_deviation,
        coefficient_drift=trial.coefficient_drift,
        coefficient_deviation=1e-3,
        helix_length=trial.stroke,
        duty_deviation=0.01,
    )
    settings = GerotorObserver(
        area=trial.area,
        pollution=pollution,
        sample_period=trial.sample_period,
        position_drift=trial.position_drift,
        position_deviation=1e-3,
        stop_position=0.0,
    )
    memory = gerotor_observer_start(settings, 0.0)
    margin = basis_margin(basis, trial.natural_frequency, trial.spool_speed)
    return Entry(Model(name, functions, memory.mean.size, margin), gerotor_observer_step, memory, settings)


def basis_margin(basis: NoiseBasis, natural_frequency: float, spool_speed: float) -> float:
    """Share of the swing of a spring drive over a turn that a basis leaves: 1 is all, 0 nothing [1].

    Smallest eigenvalue of (2/T) times the Gram matrix of cos and sin of the drive's swing, without what the
    basis can stand for. For Fourier functions that is `observability_margin`.

    natural_frequency, spool_speed  [rad/s]
    """
    angles = (np.arange(MARGIN_POINTS) + 0.5) / MARGIN_POINTS * TURN
    rows = np.zeros((MARGIN_POINTS, function_count(basis)))
    for angle, row in zip(angles, rows, strict=True):
        write_basis(float(angle), basis, row, 0)
    swing = natural_frequency / spool_speed * angles
    moved = np.column_stack([np.cos(swing), np.sin(swing)])
    left = moved - rows @ np.linalg.lstsq(rows, moved, rcond=None)[0]
    return float(np.linalg.eigvalsh(left.T @ left)[0]) * 2.0 / MARGIN_POINTS


def record(shape: Array, trial: NoiseTrial) -> tuple[Array, Array, Array]:
    """Readings of the sensor, a row for each sample, with true position and true periodic sensor error [m]."""
    times = np.arange(round(trial.duration / trial.sample_period)) * trial.sample_period
    swing, angles = TURN / trial.motion_period, trial.spool_speed * times
    position = 0.5 * trial.stroke * (1.0 - np.cos(swing * times))
    flow = trial.area * 0.5 * trial.stroke * swing * np.sin(swing * times)
    places = np.arange(shape.size) / shape.size * TURN
    pollution = np.interp(angles, places, shape, period=TURN)
    white = trial.white_noise * np.random.default_rng(0).normal(size=times.size)
    none = np.zeros_like(times)
    optical = position + pollution + white
    speed = none + trial.spool_speed
    margin, unseen = none + 1.0, none * np.nan
    return (
        np.column_stack([times, optical, angles, speed, none, none, none, flow, none, margin, unseen, none, none]),
        position,
        pollution,
    )
