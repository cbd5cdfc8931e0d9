"""Maps of a virtually variable displacement pump over duty ratio, load pressure, pump speed and oil temperature.

Analytic ones come from the quasi-steady averages, simulated ones from the periodic state of the PWM-resolved circuit at
every point. Finished points of a simulated map are kept at once, so an interrupted one goes on where it stopped.
"""

import hashlib
import itertools
import shutil
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

import vvdp
from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, Fault, ParameterError, unusable
from vvdp.base.files import clear_unfinished
from vvdp.base.units import ATMOSPHERE
from vvdp.fluid.mixture import compression_energy_per_volume
from vvdp.fluid.oil import dynamic_viscosity
from vvdp.hydraulics.spool_drive import drive_power
from vvdp.rigs import periodic, steady
from vvdp.rigs.averages import averages
from vvdp.rigs.conditions import BAR, CELSIUS, RPM, gauge
from vvdp.rigs.cycle import CycleMeans
from vvdp.rigs.result import read_rig
from vvdp.rigs.stand import SetPoint, Stand
from vvdp.rigs.steady import Steady, steady_states
from vvdp.simulation.link import link, quiet
from vvdp.simulation.run import compiled_loop
from vvdp.simulation.values import flat, leaves
from vvdp.studies.engine import HERE, Engine
from vvdp.studies.run import interrupts_held, silent
from vvdp.studies.store import Finished, opened_store
from vvdp.studies.work import Batching, check_same, kept_batches
from vvdp.valve.leakage import leakage_conductance
from vvdp.valve.torque import pwm_frequency

STORE = "points"
"""Folder of the finished points in that of a simulated map."""
BATCHING = Batching(least=4, seconds=0.5)
"""A point is worth more than a case of a study: a killed map loses half a second of work, or four points."""
MOST_POINTS = 1_000_000

SET = ("duty_ratio", "load_pressure_Pa", "pump_speed_rad_s", "oil_temperature_K")
FOUND = (
    "delivered_flow_m3_s",
    "volumetric_efficiency",
    "hydromechanical_efficiency",
    "overall_efficiency",
    "input_power_W",
    "spool_motor_power_W",
    "load_power_W",
    "loss_total_W",
    "pwm_frequency_Hz",
    "pressure_mean_load_line_Pa",
    "pressure_mean_inlet_Pa",
    "mean_pump_flow_m3_s",
    "mean_tank_flow_m3_s",
    "flow_mean_relief_valve_m3_s",
    "mean_leakage_flow_m3_s",
    "motor_overloaded",
)
ANALYTIC_ONLY = ("loss_compressibility_W",)
SIMULATED_ONLY = (
    "load_area_m2",
    "pressure_min_inlet_Pa",
    "pressure_max_inlet_Pa",
    "pressure_min_load_line_Pa",
    "pressure_max_load_line_Pa",
    "cavitation",
    "trusted",
    "periodic_residual",
    "periodic_distance",
)


@dataclass(frozen=True)
class Axes:
    """The values that a map goes through; its points are ordered with the duty ratio fastest, the temperature slowest.

    Pressures are absolute. Raises ConfigError with all that is wrong when made.
    """

    duty_ratios: tuple[float, ...]
    load_pressures: tuple[float, ...]
    pump_speeds: tuple[float, ...]
    temperatures: tuple[float, ...]

    def __post_init__(self) -> None:
        faults = [
            Fault("map", 0, name, problem)
            for name, values, scale in (
                ("duty ratios", self.duty_ratios, _DUTY),
                ("load pressures", self.load_pressures, _PRESSURE),
                ("pump speeds", self.pump_speeds, _SPEED),
                ("temperatures", self.temperatures, _TEMPERATURE),
            )
            if (problem := _axis_problem(values, scale))
        ]
        if not faults and self.count > MOST_POINTS:
            faults = [Fault("map", 0, "", f"{self.count} points; at most {MOST_POINTS}")]
        if faults:
            raise ConfigError(faults)

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """Numbers of temperatures, pump speeds, load pressures and duty ratios."""
        return len(self.temperatures), len(self.pump_speeds), len(self.load_pressures), len(self.duty_ratios)

    @property
    def count(self) -> int:
        """Number of points."""
        return int(np.prod(self.shape))

    @property
    def points(self) -> list[SetPoint]:
        """All set points in the order of a map's columns."""
        ordered = itertools.product(self.temperatures, self.pump_speeds, self.load_pressures, self.duty_ratios)
        return [SetPoint(d, p, n, t) for t, n, p, d in ordered]


class _Scale(NamedTuple):
    """How a person reads the values of an axis, and what they may be [SI]: above `lowest`, up to `highest`."""

    unit: str
    size: float
    zero: float
    expected: str
    lowest: float
    highest: float

    def words(self, value: float) -> str:
        """`value` [SI] with its unit."""
        return f"{round((value - self.zero) / self.size, 6):.6g} {self.unit}".rstrip()


BELOW_ZERO = -1e-12
"""A duty ratio that counts as 0: what rounding leaves of it."""
_DUTY = _Scale("", 1.0, 0.0, "numbers from 0 to 1", BELOW_ZERO, 1.0 - BELOW_ZERO)
_PRESSURE = _Scale("bar", BAR, ATMOSPHERE, "numbers above -1.01325 bar", 0.0, np.inf)
_SPEED = _Scale("rpm", RPM, 0.0, "numbers above 0 rpm", 0.0, np.inf)
_TEMPERATURE = _Scale("degC", 1.0, CELSIUS, "numbers above -273.15 degC", 0.0, np.inf)


def _axis_problem(values: Sequence[float], scale: _Scale) -> str | None:
    if not values:
        return "none; expected at least one"
    if outside := [v for v in values if not (np.isfinite(v) and scale.lowest < v <= scale.highest)]:
        more = f" and {len(outside) - 1} more" if len(outside) > 1 else ""
        return f"{scale.words(outside[0])}{more}; expected {scale.expected}"
    for before, after in itertools.pairwise(values):
        if after <= before:
            return f"{scale.words(after)} after {scale.words(before)}; expected increasing values"
    return None


def default_axes(stand: Stand, duties: int = 12, pressures: int = 10) -> Axes:
    """Duty ratios up to 1, load pressures up to 95 % of the relief setting; speed and temperature of the system."""
    here = stand.set_point
    rise = stand.relief_pressure - stand.tank_pressure
    shares = np.linspace(0.05, 0.95, pressures) if pressures > 1 else np.array([0.8])
    steps = np.linspace(1.0 / duties, 1.0, duties)
    return Axes(
        tuple(float(d) for d in steps),
        tuple(float(stand.tank_pressure + share * rise) for share in shares),
        (here.pump_speed,),
        (here.oil_temperature,),
    )


@dataclass(frozen=True)
class PumpMap:
    """A map: a column [SI] for every quantity, a row for every point in the order of `axes.points`.

    Pressures in columns are gauge, flows counted in tank volumes where simulated, in actual volumes where analytic.
    `reasons` says why a point has no result, or not all of it; None where it has all.
    """

    stand: Stand
    axes: Axes
    simulated: bool
    columns: Mapping[str, Array]
    reasons: tuple[str | None, ...]
    ran: int
    seconds: float

    @property
    def finished(self) -> bool:
        """Whether every point has been worked on."""
        return NOT_RUN not in self.reasons

    def grid(self, column: str) -> Array:
        """A column over temperature, pump speed, load pressure and duty ratio, in the shape of the axes."""
        return self.columns[column].reshape(self.axes.shape)


NOT_RUN = "not run yet"


def analytic_map(
    stand: Stand,
    axes: Axes,
    *,
    cores: int | None = None,
    cache: Path | None = None,
    say: Callable[[str], None] = quiet,
) -> PumpMap:
    """The map as the quasi-steady averages give it: constant load pressure, stiff oil, a relief valve without lag.

    The compressibility loss is nominal, f V W_V, and not part of the efficiency: see `compressibility_loss`. A driven
    spool turns as fast as its motor and the flow together let it. Raises ParameterError where the spool turns at no
    point.

    Source  ours, docs/rigs.md
    """
    began = time.perf_counter()
    t, n, p, d = _columns(np.ravel(v) for v in np.meshgrid(
        axes.temperatures, axes.pump_speeds, axes.load_pressures, axes.duty_ratios, indexing="ij"
    ))  # fmt: skip
    bench, tank = stand.bench, stand.tank_pressure
    pump, oil, valve = bench.pump, bench.oil, bench.valve
    points = SetPoint(d, p, n, t)
    flow = stand.pump_flow(points)
    rows = np.column_stack(np.broadcast_arrays(*stand.cycle_point(points)))
    averaged = averages(rows, valve, cores=cores, cache=cache, say=say)
    means = CycleMeans(*_columns(averaged.T))
    stuck = _standstills(stand, axes.points, averaged)
    speed: Any = stand.guessed_speed(means)
    motor: Any = drive_power(bench.operation.spool_motor_speed.base, speed, bench.spool_drive)
    frequency = pwm_frequency(speed, valve)
    leakage = leakage_conductance(dynamic_viscosity(t, oil), valve) * (p - tank)
    delivered = means.load_flow - leakage
    shaft = flow * (means.inlet_pressure - tank) + pump.friction_torque * n
    columns = {
        "delivered_flow_m3_s": delivered,
        "input_power_W": shaft,
        "spool_motor_power_W": motor if stand.is_driven else np.zeros_like(d),
        "load_power_W": delivered * (p - tank),
        "pwm_frequency_Hz": frequency,
        "pressure_mean_load_line_Pa": p - stand.reference,
        "pressure_mean_inlet_Pa": means.inlet_pressure - stand.reference,
        "mean_pump_flow_m3_s": flow,
        "mean_tank_flow_m3_s": means.tank_flow,
        "flow_mean_relief_valve_m3_s": means.relief_flow,
        "mean_leakage_flow_m3_s": leakage,
        "motor_overloaded": (shaft > bench.motor.rated_power).astype(float),
        "loss_compressibility_W": frequency * bench.inlet_volume * compression_energy_per_volume(p, tank, oil),
    }
    turns = np.array([reason is None for reason in stuck])
    columns = _judged(stand, axes, {name: np.where(turns, values, np.nan) for name, values in columns.items()})
    reasons = _reasons(stand, columns, stuck)
    return PumpMap(stand, axes, False, columns, reasons, axes.count, time.perf_counter() - began)


def _standstills(stand: Stand, points: Sequence[SetPoint], means: Array) -> list[str | None]:
    """For each point why the spool does not turn there, None where it does; a row of `means` for each.

    Raises ParameterError where it turns at none.
    """
    rows = zip(points, means.tolist(), strict=True)
    found = [stand.standstill(point.oil_temperature, CycleMeans(*each)) for point, each in rows]
    if found and all(found):
        raise ParameterError(f"{stand.name}: {found[0]}, at each of {len(found)} points")
    return found


def _columns(values: Iterable[Any]) -> tuple[Any, ...]:
    """Columns as formulas take them: written for floats, they work on arrays too."""
    return tuple(values)


def _judged(stand: Stand, axes: Axes, columns: Mapping[str, Array]) -> dict[str, Array]:
    """`columns` with the set points before them and the efficiencies and losses that follow from them.

    The derived flow of a pump at duty ratio d is d D omega. An efficiency is nan where nothing is delivered.
    """
    set_ = dict(zip(SET, (np.array(column, float) for column in zip(*axes.points, strict=True)), strict=True))
    set_["load_pressure_Pa"] = set_["load_pressure_Pa"] - stand.reference
    motor = np.nan_to_num(columns["spool_motor_power_W"])
    power_in = columns["input_power_W"] + motor
    derived = set_["duty_ratio"] * stand.bench.pump.displacement * set_["pump_speed_rad_s"]
    with np.errstate(all="ignore"):
        delivers = columns["delivered_flow_m3_s"] > 0.0
        volumetric = np.where(delivers & (derived > 0.0), columns["delivered_flow_m3_s"] / derived, np.nan)
        overall = np.where(delivers & (columns["load_power_W"] > 0.0), columns["load_power_W"] / power_in, np.nan)
        found = {
            **set_,
            **columns,
            "volumetric_efficiency": volumetric,
            "hydromechanical_efficiency": overall / volumetric,
            "overall_efficiency": overall,
            "loss_total_W": power_in - columns["load_power_W"],
        }
    order = [name for name in (*SET, *FOUND, *ANALYTIC_ONLY, *SIMULATED_ONLY) if name in found]
    return {name: np.asarray(found[name], float) for name in order}


def _reasons(stand: Stand, columns: Mapping[str, Array], reasons: Sequence[str | None]) -> tuple[str | None, ...]:
    """Why each point has no result, or no efficiency."""
    dry = ~(columns["delivered_flow_m3_s"] > 0.0)
    above = columns["load_pressure_Pa"] + stand.reference > stand.relief_pressure
    relief = f"{ABOVE_RELIEF} of {gauge(stand.relief_pressure)} bar"
    idle = ~(columns["load_power_W"] > 0.0)
    return tuple(
        relief if too_high and nothing and reason != NOT_RUN
        else reason or (NOTHING_DELIVERED if nothing else NO_LOAD_POWER if no_power else None)
        for reason, nothing, too_high, no_power in zip(reasons, dry, above, idle, strict=True)
    )  # fmt: skip


NOTHING_DELIVERED = "delivers nothing"
ABOVE_RELIEF = "the load pressure is above the relief setting"
NO_LOAD_POWER = "no load pressure above the tank's, so no efficiency"


def simulated_map(
    stand: Stand,
    axes: Axes,
    directory: Path,
    *,
    engine: Engine = HERE,
    progress: Callable[[int, int], None] = silent,
    say: Callable[[str], None] = quiet,
    cache: Path | None = None,
) -> PumpMap:
    """The map as the PWM-resolved circuit gives it, every point in its periodic steady state.

    Points that `directory` already has are not run again; they are known by every number that they depend on. `engine`
    says where the others are run. Each batch is kept when it is done and `progress` hears of it (points done, of all).
    Ctrl-C ends the map after the batches at hand, and running it again goes on from there. Raises ConfigError where the
    directory cannot be used, ParameterError where the spool turns at no point, RunError where a worker has another
    vvdp, or none is left.
    """
    began = time.perf_counter()
    rows = np.array([stand.cycle_point(point) for point in axes.points])
    _standstills(stand, axes.points, averages(rows, stand.bench.valve, cache=cache, say=say))
    store = directory / STORE
    finished = opened_store(store, {"vvdp": vvdp.__version__, "system": stand.name})
    points = axes.points
    digest = link(stand.model, stand.bench.case, cache, say).digest
    wanted = [_Wanted(_key(stand, point, digest), point) for point in points]
    pending = [each for each in wanted if each.key not in finished]
    if len(pending) < len(points):
        say(f"{len(points) - len(pending)} of {len(points)} points are finished already")
    progress(len(points) - len(pending), len(points))
    if pending:
        compiled_loop(say)  # here, so that workers find it compiled
    ran = 0
    with interrupts_held() as interrupted:
        for done in kept_batches(partial(_points_done, stand, cache), pending, store, engine, interrupted, BATCHING):
            finished |= {each.key: each for each in done}
            ran += len(done)
            progress(len(points) - len(pending) + ran, len(points))
    return _collected(stand, axes, [finished.get(each.key) for each in wanted], ran, time.perf_counter() - began)


class _Wanted(NamedTuple):
    """A point, and what it is known by."""

    key: str
    point: SetPoint


def _points_done(stand: Stand, cache: Path | None, batch: Sequence[_Wanted], cores: int) -> list[Finished]:
    """What comes of a batch, where it is run."""
    digest = link(stand.model, stand.bench.case, cache).digest
    check_same(_key(stand, batch[0].point, digest), batch[0].key)
    states = steady_states([(stand, each.point) for each in batch], cores=cores, cache=cache)
    return [_finished(each.key, state) for each, state in zip(batch, states, strict=True)]


@contextmanager
def map_directory(directory: Path, rig: str = "map", *, simulated: bool = True, force: bool = False) -> Iterator[None]:
    """Makes `directory` the place of a map, new or gone on with, and removes it again if nothing came into it.

    `rig` says of which rig the map is a part. Without `force` a simulated map and an analytic one do not replace each
    other; with it an earlier map is discarded.

    Raises ConfigError where it holds something else or cannot be written.
    """
    if directory.exists() and not directory.is_dir():
        raise unusable(directory, "is not a directory")
    known = ("rig.json", f"{STORE}/study.json")
    if directory.exists() and any(directory.iterdir()) and not any((directory / name).is_file() for name in known):
        raise unusable(directory, "holds something else than a map; choose another directory")
    if force and directory.exists():
        shutil.rmtree(directory)
    if (directory / "rig.json").is_file() and read_rig(directory).rig != rig:
        raise unusable(directory, "holds the result of another rig; choose another directory")
    stored = (directory / STORE).exists()
    if stored and not simulated:
        raise unusable(directory, "holds a simulated map; choose another directory for an analytic one")
    if simulated and not stored and (directory / "rig.json").is_file():
        raise unusable(directory, "holds an analytic map; choose another directory for a simulated one")
    try:
        clear_unfinished(directory)
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise unusable(directory, f"cannot be written ({problem.strerror})") from None
    try:
        yield
    finally:
        if not any(directory.iterdir()):
            directory.rmdir()


def _key(stand: Stand, point: SetPoint, digest: str) -> str:
    """What a point is known by: everything that its result depends on."""
    tolerance = min(stand.stepping.relative_tolerance, periodic.TOLERANCE)
    solver = (periodic.LIMIT, periodic.DISTANCE, tolerance, steady.HELD, stand.stepping.method)
    found = hashlib.sha256(repr((vvdp.__version__, digest, solver, tuple(point))).encode())
    for _, table in sorted(stand.bench.tables.items()):
        found.update(repr([path for path, _, _ in leaves(table)]).encode())
        found.update(flat(table).tobytes())
    return found.hexdigest()


def _finished(key: str, state: Steady) -> Finished:
    summary = dict(state.summary)
    if state.periodic is not None and summary:
        summary |= {
            "load_area_m2": float(state.area),
            "periodic_residual": float(state.periodic.residual),
            "periodic_distance": float(state.periodic.distance),
        }
    return Finished(key, dict(zip(SetPoint._fields, state.point, strict=True)), state.reason, summary)


def _collected(stand: Stand, axes: Axes, done: Sequence[Finished | None], ran: int, seconds: float) -> PumpMap:
    rows: list[Mapping[str, float | bool]] = [each.summary if each else {} for each in done]

    def column(name: str) -> Array:
        return np.array([float(row.get(name, np.nan)) for row in rows])

    some = [name for name in SIMULATED_ONLY if any(name in row for row in rows)]
    columns = {name: column(name) for name in (*FOUND, *some)}
    columns["delivered_flow_m3_s"] = column("mean_load_flow_m3_s")  # leakage taken off
    reasons = [each.failure if each else NOT_RUN for each in done]
    judged = _judged(stand, axes, columns)
    return PumpMap(stand, axes, True, judged, _reasons(stand, judged, reasons), ran, seconds)


Flags = npt.NDArray[np.bool_]


def usable(found: PumpMap) -> Flags:
    """Where the pump delivers and its motor bears it, in the shape of the axes."""
    bears = found.columns["motor_overloaded"] == 0.0
    flags: Flags = np.isfinite(found.columns["overall_efficiency"]) & bears
    return flags.reshape(found.axes.shape)
