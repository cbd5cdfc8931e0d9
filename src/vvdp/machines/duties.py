"""The duty cycles through which rival circuits move a cylinder, each with what a circuit is sized for."""

import csv
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vvdp.base.errors import ConfigError, Fault, ParameterError
from vvdp.base.rules import without_class
from vvdp.base.tables import nearest
from vvdp.control.duty_cycle import DutyCycle, cycle_period, cycle_speeds
from vvdp.hydraulics.cylinder import Cylinder
from vvdp.hydraulics.friction import RodFriction
from vvdp.systems.system import load_system

LEAST_RELIEF, RELIEF_STEP, RELIEF_OVER_LOAD = 60e5, 10e5, 2.0
"""Setting of a relief valve at least, its steps [Pa], and its ratio to the pressure that the load needs [1]."""
RETURN_DROP, RETURN_OPENING = 13e5, 0.8
"""Drop of the throttle in a return at the largest flow and the largest opening [Pa, 1]."""
MOST_FAULTS = 10
"""Lines of a file that are reported as wrong."""
COLUMNS = ("time", "position", "force")
"""Columns of a file with a cycle [s, m, N]."""


@dataclass(frozen=True)
class Duty:
    """A duty cycle with its load in words, and what circuits are sized for: pressure of relief valves, gauge, and
    conductance of a meter-out throttle, fully open.

    `further` are those of a second and third cylinder that move at the same time, for as long a round.
    """

    name: str
    title: str
    load: str
    cycle: DutyCycle
    relief_pressure: float
    return_conductance: float
    further: tuple["Duty", ...] = ()

    @property
    def alone(self) -> "tuple[Duty, ...]":
        """The duty of each cylinder for itself."""
        return (replace(self, further=()), *self.further)

    @property
    def period(self) -> float:
        """After which time it comes back [s]."""
        return cycle_period(self.cycle)


def known_cylinder() -> tuple[Cylinder, RodFriction]:
    """The cylinder that all circuits move, and its friction."""
    parts = load_system("throttle-control").circuit.network.parts
    cylinder, friction = parts["cylinder"].values[0], parts["friction"].values[0]
    assert isinstance(cylinder, Cylinder) and isinstance(friction, RodFriction)
    return cylinder, friction


def shipped_duties() -> tuple[Duty, ...]:
    """The shipped duty cycles."""
    return duties(*known_cylinder())


TRIANGLE = DutyCycle(times=(0.0, 4.0, 8.0), positions=(0.05, 0.266, 0.05), forces=(-1000.0,) * 3)
HEAVY = DutyCycle(times=(0.0, 1.25, 2.5), positions=(0.05, 0.266, 0.05), forces=(-10000.0,) * 3)
DIGGING = DutyCycle(
    times=(0.0, 1.8, 2.2, 2.6, 4.8, 5.2, 5.6, 6.8, 7.2, 7.6, 9.0, 9.5),
    positions=(0.05, 0.24, 0.25, 0.25, 0.10, 0.09, 0.09, 0.20, 0.21, 0.21, 0.06, 0.05),
    forces=(-2e3, -2e3, -2e3, 1e3, 5e3, 5e3, 3e3, 3e3, 1e3, -4e3, -4e3, -2e3),
)


def duties(cylinder: Cylinder, friction: RodFriction) -> tuple[Duty, ...]:
    """The shipped duty cycles for a cylinder."""
    alone = Duty(
        name="heavy",
        title="21.6 cm in 1.25 s and back",
        load="10 kN against extending",
        cycle=HEAVY,
        relief_pressure=110e5,
        return_conductance=3e-7,
    )
    medium, light = (_lighter(alone, cylinder, friction, *each) for each in ((0.15, -4000.0), (0.11, -1000.0)))
    return (
        Duty(
            name="triangle",
            title="21.6 cm in 4 s and back, the source's",
            load="1000 N against extending",
            cycle=TRIANGLE,
            relief_pressure=60e5,
            return_conductance=1.2e-7,
        ),
        alone,
        sized_duty(
            "digging", "reach, dig, dump and return", "5 kN either way, all four quadrants", DIGGING, cylinder, friction
        ),
        replace(
            alone,
            name="two-loads",
            title="heavy, and a second cylinder that goes 10 cm",
            load="10 and 4 kN against extending",
            further=(medium,),
        ),
        replace(
            alone,
            name="three-loads",
            title="the same, and a third one that goes 6 cm",
            load="10, 4 and 1 kN against extending",
            further=(medium, light),
        ),
    )


def _lighter(first: Duty, cylinder: Cylinder, friction: RodFriction, far: float, force: float) -> Duty:
    """A cylinder beside another one that goes from 50 mm to `far` [m] under a `force` [N], with a valve like its."""
    cycle = replace(first.cycle, positions=(0.05, far, 0.05), forces=(force,) * 3)
    sized = sized_duty(f"{-1e-3 * force:g} kN", f"to {100.0 * far:g} cm", "", cycle, cylinder, friction)
    return replace(sized, return_conductance=first.return_conductance)


def sized_duty(name: str, title: str, load: str, cycle: DutyCycle, cylinder: Cylinder, friction: RodFriction) -> Duty:
    """A duty cycle for which circuits are sized by one rule.

    Relief valves are set to twice the pressure that force and friction need on the side that they are on, in whole
    steps of 10 bar and at least 60; the meter-out throttle passes the largest flow at 13 bar, open by 0.8.
    """
    speeds = np.array([0.0, *cycle_speeds(cycle)])
    friction_force = friction.viscous_friction * np.max(np.abs(speeds)) + friction.coulomb_friction
    forces = np.array(cycle.forces)
    needed = max(
        (np.max(-forces, initial=0.0) + friction_force) / cylinder.area_a,
        (np.max(forces, initial=0.0) + friction_force) / cylinder.area_b,
    )
    relief = max(LEAST_RELIEF, RELIEF_STEP * math.ceil(RELIEF_OVER_LOAD * needed / RELIEF_STEP))
    largest = max(np.max(-speeds) * cylinder.area_a, np.max(speeds) * cylinder.area_b)
    conductance = float(largest / (RETURN_OPENING * math.sqrt(RETURN_DROP)))
    return Duty(
        name=name,
        title=title,
        load=load,
        cycle=cycle,
        relief_pressure=float(relief),
        return_conductance=conductance,
    )


def read_duty(path: Path, cylinder: Cylinder, friction: RodFriction) -> Duty:
    """A duty cycle from a CSV file with the columns time [s], position [m] and force [N], sized by the rule.

    Raises ConfigError, with its line, for a file that cannot be read and for a cycle that is none.
    """
    rows = _read_rows(path)
    times, positions, forces = (tuple(column) for column in zip(*rows, strict=True))
    start = times[0]
    try:
        cycle = DutyCycle(times=tuple(t - start for t in times), positions=positions, forces=forces)
    except ParameterError as problem:
        raise ConfigError([Fault(str(path), 0, "", without_class(str(problem)))]) from None
    low, high = 1e-3 * min(forces), 1e-3 * max(forces)
    return sized_duty(
        path.stem, f"{path.name}, {len(rows)} rows", f"{low:.3g} to {high:.3g} kN on the rod", cycle, cylinder, friction
    )


def _read_rows(path: Path) -> list[tuple[float, float, float]]:
    try:
        with path.open(encoding="utf-8", newline="") as file:
            lines = list(csv.reader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as problem:
        raise ConfigError([Fault(str(path), 0, "", f"cannot be read: {problem}")]) from None
    head = [cell.strip().lower() for cell in lines[0]] if lines else []
    faults = list(_faults_of_head(path, head))
    if faults:
        raise ConfigError(faults[:MOST_FAULTS])
    places = [head.index(name) for name in COLUMNS]
    rows = [found for k, line in enumerate(lines[1:], 2) if line and (found := _row(line, places, path, k, faults))]
    if not faults and len(rows) < 2:
        faults.append(Fault(str(path), 0, "", f"{len(rows)} rows; expected two at least"))
    if faults:
        raise ConfigError(faults[:MOST_FAULTS])
    return rows


def _faults_of_head(path: Path, head: Sequence[str]) -> Iterator[Fault]:
    """What is wrong with the names of the columns."""
    missing = [name for name in COLUMNS if name not in head]
    if missing:
        message = f"column {missing[0]!r} is missing; expected {', '.join(COLUMNS)} in s, m and N in the first line"
        yield Fault(str(path), 1, "", message)
        return
    for name, count in Counter(head).items():
        if name not in COLUMNS:
            yield Fault(str(path), 1, name, f"unknown column{nearest(name, COLUMNS)}")
        elif count > 1:
            yield Fault(str(path), 1, name, f"{count} columns have this name; leave one")


def _row(
    line: list[str], places: list[int], path: Path, number: int, faults: list[Fault]
) -> tuple[float, float, float] | None:
    """The numbers of a line; a line without them is a fault."""
    cells = [line[place].strip() if place < len(line) else "" for place in places]
    try:
        time, position, force = (float(cell) for cell in cells)
    except ValueError:
        time = position = force = math.nan
    if math.isfinite(time + position + force):
        return time, position, force
    faults.append(Fault(str(path), number, "", f"{','.join(cells)!r} are not three finite numbers"))
    return None
