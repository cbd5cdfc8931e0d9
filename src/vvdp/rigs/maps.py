"""Maps of a virtually variable displacement pump over duty ratio, load pressure, pump speed and oil temperature.

Analytic ones come from the quasi-steady averages, simulated ones from the periodic state of the PWM-resolved circuit at
every point. Finished points of a simulated map are kept at once, so an interrupted one goes on where it stopped.
"""

import hashlib
import shutil
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from vvdp.base.arrays import Array
from vvdp.base.display import with_unit
from vvdp.base.errors import ParameterError, unusable
from vvdp.base.files import clear_below, clear_unfinished
from vvdp.base.kinds import PRESSURE_LEVEL
from vvdp.base.manifest import has_list, open_directory, refuse_foreign, refuse_links
from vvdp.base.version import VERSION
from vvdp.evaluation.load_ripple import estimated_ripple
from vvdp.fluid.mixture import compression_energy_per_volume, specific_volume_ratio
from vvdp.fluid.oil import density
from vvdp.hydraulics.spool_drive import drive_power
from vvdp.results.store import DESCRIPTION
from vvdp.rigs.capacity import PRESSURES, averaged_flows, capacity_points, derived_capacities
from vvdp.rigs.efficiencies import EFFICIENCIES, SET, with_efficiencies
from vvdp.rigs.map_axes import Axes
from vvdp.rigs.ripple import line_capacity
from vvdp.simulation.link import link, quiet
from vvdp.simulation.run import compiled_loop
from vvdp.simulation.values import flat, leaves
from vvdp.steady.averages import averages, means_at
from vvdp.steady.cycle_means import CycleMeans
from vvdp.steady.shooting import DISTANCE, LIMIT, TOLERANCE
from vvdp.steady.steady_states import HELD, Steady, steady_states
from vvdp.steady.test_stand import SetPoint, Stand, guessed_speed, standstill
from vvdp.studies.engine import HERE, Engine
from vvdp.studies.run import hold_interrupts, silent
from vvdp.studies.store import Finished, is_own, is_store, opened_store
from vvdp.studies.work import Batching, check_same, kept_batches
from vvdp.valve.losses import full_open_drop
from vvdp.valve.torque import pwm_frequency

STORE = "points"
"""Folder of the finished points in that of a simulated map."""
BATCHING = Batching(least=4, seconds=0.5)
"""A point is worth more than a case of a study: a killed map loses half a second of work, or four points."""

FOUND = (
    "delivered_flow_m3_s",
    "outlet_flow_m3_s",
    "commanded_flow_m3_s",
    "derived_capacity_m3_rad",
    *EFFICIENCIES,
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
ANALYTIC_ONLY = ("loss_compressibility_W", "estimated_ripple_Pa", "ripple_reaches_relief")
SIMULATED_ONLY = (
    "load_area_m2",
    "pressure_min_inlet_Pa",
    "pressure_max_inlet_Pa",
    "pressure_min_load_line_Pa",
    "pressure_max_load_line_Pa",
    "cavitation_volume",
    "cavitation_port_share",
    "cavitation_number_lowest",
    "second_law",
    "within_validity",
    "trusted",
    "periodic_residual",
    "periodic_distance",
)


@dataclass(frozen=True)
class PumpMap:
    """A map: a column [SI] for every quantity, a row for every point in the order of `axes.points`.

    Pressures in columns are gauge, flows counted in tank volumes where simulated, in actual volumes where analytic; but
    `outlet_flow_m3_s`, which is the volume that the delivered flow has under the load pressure.
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
    def is_finished(self) -> bool:
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
    points = SetPoint(d, p, n, t)
    rows = np.column_stack(np.broadcast_arrays(*stand.cycle_point(points)))
    means = averages(rows, stand.bench.valve, cores=cores, say=say)
    stuck = _standstills(stand, axes.points, means)
    columns = averaged_columns(stand, points, means)
    if stand.makes_pressure:
        columns |= _ripple_columns(stand, points, columns)
    turns = np.array([reason is None for reason in stuck])
    settings = capacity_points(stand, axes.duty_ratios, axes.pump_speeds, axes.temperatures)
    flows = averaged_flows(stand, settings, cores=cores, say=say)
    columns = _judge(
        stand,
        axes,
        {name: np.where(turns, values, np.nan) for name, values in columns.items()},
        derived_capacities(stand, settings, flows),
    )
    reasons = _reasons(stand, columns, stuck)
    return PumpMap(
        stand=stand,
        axes=axes,
        simulated=False,
        columns=columns,
        reasons=reasons,
        ran=axes.count,
        seconds=time.perf_counter() - began,
    )


def averaged_columns(stand: Stand, points: Any, means: Any) -> dict[str, Array]:
    """Columns of the quasi-steady averages `means` at many operating points at once; `points` has arrays of them."""
    d, p, n, _ = points
    bench, tank = stand.bench, stand.tank_pressure
    pump, oil, valve = bench.pump, bench.oil, bench.valve
    flow = stand.pump_flow(points)
    speed: Any = guessed_speed(means, stand)
    motor: Any = drive_power(bench.operation.spool_motor_speed.base, speed, bench.spool_drive)
    frequency: Any = pwm_frequency(speed, valve)
    leakage = stand.leakage(points)
    delivered = means.load_flow - leakage
    shaft = flow * (means.inlet_pressure - tank) + pump.friction_torque * n
    return {
        "delivered_flow_m3_s": delivered,
        "outlet_flow_m3_s": delivered,
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
        "motor_overloaded": (shaft > bench.rated_power).astype(float),
        "loss_compressibility_W": frequency * bench.inlet_volume * compression_energy_per_volume(p, tank, oil),
    }


def _ripple_columns(stand: Stand, points: Any, columns: Mapping[str, Any]) -> dict[str, Array]:
    """The estimated ripple of the load line, and whether its crest opens the relief valve through the open valve.

    Where it does, a constant load pressure says too little of what goes over the relief valve.
    """
    levels, place = np.unique(points.load_pressure, return_inverse=True)
    capacity: Any = np.array([line_capacity(float(level), stand) for level in levels])[place]
    flow, frequency = columns["mean_pump_flow_m3_s"], columns["pwm_frequency_Hz"]
    delivered: Any = np.clip(columns["delivered_flow_m3_s"], 0.0, None)
    swing: Any = estimated_ripple(delivered, flow, frequency, capacity)
    drop = full_open_drop(flow, density(points.oil_temperature, stand.bench.oil), stand.bench.valve)
    crest = points.load_pressure + 0.5 * swing + drop.nozzle + drop.centre_section + drop.outlet_turbine
    return {
        "estimated_ripple_Pa": swing,
        "ripple_reaches_relief": ((crest >= stand.relief_pressure) & (delivered > 0.0)).astype(float),
    }


def _standstills(stand: Stand, points: Sequence[SetPoint], means: CycleMeans) -> list[str | None]:
    """For each point why the spool does not turn there, None where it does; `means` has a row for each.

    Raises ParameterError where it turns at none.
    """
    found = [standstill(point, means_at(means, row), stand) for row, point in enumerate(points)]
    if found and all(found):
        raise ParameterError(f"{stand.name}: {found[0]}, at each of {len(found)} points")
    return found


def _columns(values: Iterable[Any]) -> tuple[Any, ...]:
    """Columns as formulas take them: written for floats, they work on arrays too."""
    return tuple(values)


def _judge(stand: Stand, axes: Axes, columns: Mapping[str, Array], capacities: Array) -> dict[str, Array]:
    """`columns` with operating points, efficiencies and losses, in their order.

    capacities  of all settings, over temperature, pump speed and duty ratio [m^3/rad]
    """
    t, n, p, d = axes.shape
    capacity = np.broadcast_to(capacities.reshape(t, n, 1, d), (t, n, p, d)).ravel()
    found = with_efficiencies(stand, axes, columns, capacity)
    order = [name for name in (*SET, *FOUND, *ANALYTIC_ONLY, *SIMULATED_ONLY) if name in found]
    return {name: np.asarray(found[name], float) for name in order}


def _reasons(stand: Stand, columns: Mapping[str, Array], reasons: Sequence[str | None]) -> tuple[str | None, ...]:
    """Why each point has no result, or no efficiency."""
    dry = ~(columns["delivered_flow_m3_s"] > 0.0)
    above = columns["load_pressure_Pa"] + stand.reference > stand.relief_pressure
    relief = f"{ABOVE_RELIEF} of {with_unit(stand.relief_pressure, PRESSURE_LEVEL)}"
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
) -> PumpMap:
    """The map as the PWM-resolved circuit gives it, every point in its periodic steady state.

    The derived capacities are simulated before the map, `PRESSURES` points for each setting. Points that `directory`
    already has are not run again; they are known by every number that they depend on. `engine` says where the others
    are run. Each batch is kept when it is done and `progress` is informed of it (points done, of all).
    Ctrl-C ends the map after the current batches, and running it again resumes it. Raises ConfigError where the
    directory cannot be used, ParameterError where the spool turns at no point, RunError where a worker has another
    vvdp, or none is left.
    """
    began = time.perf_counter()
    rows = np.array([stand.cycle_point(point) for point in axes.points])
    _standstills(stand, axes.points, averages(rows, stand.bench.valve, say=say))
    store = directory / STORE
    finished = opened_store(store, {"vvdp": VERSION, "system": stand.name})
    settings = capacity_points(stand, axes.duty_ratios, axes.pump_speeds, axes.temperatures)
    digest = link(stand.model, stand.bench.case, say=say).digest
    wanted = {point: _key(stand, point, digest) for point in (*settings, *axes.points)}
    pending = [_Wanted(key, point) for point, key in wanted.items() if key not in finished]
    count, mapped_points = len(wanted), len(axes.points)
    if count > mapped_points:
        say(
            f"{mapped_points} points of the map, and {count - mapped_points} for the derived capacities: "
            f"{PRESSURES} pressures at each setting"
        )
    if len(pending) < count:
        say(f"{count - len(pending)} of {count} points are finished already")
    progress(count - len(pending), count)
    if pending:
        compiled_loop(say)  # here, so that workers find it compiled
    ran = 0
    with hold_interrupts() as interrupted:
        for done in kept_batches(partial(_points_done, stand), pending, store, engine, interrupted, BATCHING):
            finished |= {each.key: each for each in done}
            ran += len(done)
            progress(count - len(pending) + ran, count)
    lowest, mapped = ([finished.get(wanted[point]) for point in points] for points in (settings, axes.points))
    found = _collect(stand, axes, mapped, derived_capacities(stand, settings, _delivered_flow(lowest)))
    return replace(found, ran=ran, seconds=time.perf_counter() - began)


class _Wanted(NamedTuple):
    """A point, and what it is known by."""

    key: str
    point: SetPoint


def _points_done(stand: Stand, batch: Sequence[_Wanted], cores: int) -> list[Finished]:
    """Results of a batch, in the process that runs it."""
    digest = link(stand.model, stand.bench.case).digest
    check_same(_key(stand, batch[0].point, digest), batch[0].key)
    states = steady_states([(stand, each.point) for each in batch], cores=cores)
    return [_finish_point(each.key, state) for each, state in zip(batch, states, strict=True)]


@contextmanager
def map_directory(directory: Path, verb: str = "map", *, simulated: bool = True, force: bool = False) -> Iterator[None]:
    """Makes `directory` the place of a map, new or gone on with, and removes it again if nothing came into it.

    `verb` says of which verb the map is a part. Without `force` a simulated map and an analytic one do not replace each
    other; with it an earlier map is discarded.

    Raises ConfigError where it holds something else or cannot be written.
    """
    if directory.exists() and not directory.is_dir():
        raise unusable(directory, "is not a directory")
    if force and directory.exists():
        clear_below(directory)
        refuse_foreign(directory, directory, lambda path: path.parent == directory / STORE and is_own(path))
        shutil.rmtree(directory)
    elif directory.exists() and any(directory.iterdir()):
        _require_map(directory, verb)
    stored = (directory / STORE).exists()
    if stored and not simulated:
        raise unusable(directory, "holds a simulated map; choose another directory for an analytic one")
    if simulated and not stored and (directory / DESCRIPTION).is_file():
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


def _require_map(directory: Path, verb: str) -> None:
    """Raises ConfigError where `directory` holds something else than a map of `verb`, or files that have changed."""
    if not has_list(directory) and not is_store(directory / STORE):
        raise unusable(directory, "holds something else than a map; choose another directory")
    refuse_links(directory)
    if not has_list(directory):
        return
    opened = open_directory(directory, resuming=True)
    if DESCRIPTION in opened.files and opened.json(DESCRIPTION).get("verb") != verb:
        raise unusable(directory, "holds the result of another command; choose another directory")


def _key(stand: Stand, point: SetPoint, digest: str) -> str:
    """The identity of a point: everything that its result depends on."""
    tolerance = min(stand.stepping.relative_tolerance, TOLERANCE)
    solver = (LIMIT, DISTANCE, tolerance, HELD, stand.stepping.method)
    found = hashlib.sha256(repr((VERSION, digest, solver, tuple(point))).encode())
    found.update(repr([path for path, _, _ in leaves(stand.bench.params)]).encode())
    found.update(flat(stand.bench.params).tobytes())
    return found.hexdigest()


def _finish_point(key: str, state: Steady) -> Finished:
    summary = dict(state.summary)
    if state.periodic is not None and summary:
        summary |= {
            "load_area_m2": float(state.area),
            "periodic_residual": float(state.periodic.residual),
            "periodic_distance": float(state.periodic.distance),
        }
    return Finished(key, dict(zip(SetPoint._fields, state.point, strict=True)), state.reason, summary)


def _delivered_flow(done: Sequence[Finished | None]) -> Array:
    """Mean flow to the load of points, leakage taken off; nan without one [m^3/s]."""
    return np.array([float(each.summary.get("mean_load_flow_m3_s", np.nan)) if each else np.nan for each in done])


def _collect(stand: Stand, axes: Axes, done: Sequence[Finished | None], capacities: Array) -> PumpMap:
    rows: list[Mapping[str, float | bool]] = [each.summary if each else {} for each in done]

    def column(name: str) -> Array:
        return np.array([float(row.get(name, np.nan)) for row in rows])

    some = [name for name in SIMULATED_ONLY if any(name in row for row in rows)]
    columns = {name: column(name) for name in (*FOUND, *some)}
    delivered, pressure = _delivered_flow(done), _columns([column("pressure_mean_load_line_Pa") + stand.reference])[0]
    shrunk = specific_volume_ratio(pressure, stand.bench.oil)
    columns |= {"delivered_flow_m3_s": delivered, "outlet_flow_m3_s": delivered * shrunk}
    reasons = [each.failure if each else NOT_RUN for each in done]
    judged = _judge(stand, axes, columns, capacities)
    return PumpMap(
        stand=stand,
        axes=axes,
        simulated=True,
        columns=judged,
        reasons=_reasons(stand, judged, reasons),
        ran=0,
        seconds=0.0,
    )


Flags = npt.NDArray[np.bool_]


def usable(found: PumpMap) -> Flags:
    """Where the pump delivers and its motor bears it, in the shape of the axes."""
    bears = found.columns["motor_overloaded"] == 0.0
    flags: Flags = np.isfinite(found.columns["overall_efficiency"]) & bears
    return flags.reshape(found.axes.shape)
