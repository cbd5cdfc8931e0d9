"""Cases of a system with other values: each value alone at the ends of its range, several at once between them.

What a value reaches is what changes when it alone stands at one of its ends. Values that reach nothing in common are
then changed together: where nothing else changes, each number that a value reaches follows this value, whatever the
others are. Where something else does, or no circuit can be built, the values are divided, down to one alone.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from vvdp.base.arrays import Array, Mask
from vvdp.base.errors import VvdpError
from vvdp.base.tables import Sourced, with_settings
from vvdp.base.units import parse
from vvdp.simulation.layout import held_part, vectors
from vvdp.systems.system import System

OUTSIDE = "it changes the circuit itself, or from what numbers are counted"
SHAPE = "it changes how many numbers the circuit has"


@dataclass(frozen=True)
class Probe:
    """A value with another number, in the unit in which it is written."""

    row: Sourced
    number: float

    @property
    def option(self) -> str:
        """As `--set` takes it."""
        unit = self.row.kind.display_unit
        return f'{self.row.setting}="{self.number!r} {unit}"' if unit else f"{self.row.setting}={self.number!r}"

    @property
    def si(self) -> float:
        """The number [SI], as files are read. Raises ParameterError where its quantity cannot have it."""
        return parse(f"{self.number!r} {self.row.kind.display_unit}".rstrip(), self.row.kind)

    @property
    def is_written(self) -> bool:
        """Whether this is the number of the file."""
        return self.row.note != "default" and self.si == self.row.nominal


@dataclass(frozen=True)
class Found:
    """The numbers of a case, all vectors one after the other; none with the reason, and how early it is noticed."""

    numbers: Array
    why_not: str = ""
    stage: int = 0


class Probing:
    """Cases of a system with other values, each built once; `fixed` gives what must stay the same."""

    def __init__(self, system: System, fixed: Callable[[System], object]) -> None:
        self.system, self.fixed, self.before = system, fixed, fixed(system)
        self.base = vectors(system.case)
        self.numbers = np.concatenate(self.base)
        self.alone: dict[tuple[str, float], Found] = {}
        self.together: dict[tuple[str, float], Found] = {}
        held = held_part(system.case)
        self.counted: Mask = np.full(self.numbers.size, fill_value=True)  # what is held is calculated from the rest
        self.counted[self.base.state.size + held.start : self.base.state.size + held.stop] = False

    def find(self, probe: Probe) -> Found:
        """The case with one other value."""
        key = probe.row.setting, probe.number
        if key not in self.alone:
            self.alone[key] = self._build([probe])
        return self.alone[key]

    def view(self, probe: Probe) -> Found:
        """The same, as a case with several other values shows it if there is one."""
        return self.together.get((probe.row.setting, probe.number)) or self.find(probe)

    def place(self, at: int) -> tuple[int, int]:
        """Where one of the numbers stands: in which vector, and where in it."""
        starts = np.cumsum([0, *map(len, self.base)])
        vector = int(np.searchsorted(starts, at, side="right")) - 1
        return vector, at - int(starts[vector])

    def build_inner(self, ranges: Iterable[tuple[Probe, ...]]) -> None:
        """Build the cases between the ends of ranges whose ends can be built, for `view`."""
        waiting = [(probe, self._reach(each)) for each in ranges for probe in each[1:-1]]
        for batch in _apart([each for each in waiting if not each[0].is_written]):
            self._build_together(batch)

    def _reach(self, probes: Sequence[Probe]) -> Mask:
        """The numbers that change at the ends of a range."""
        ends = [self.find(probes[at]).numbers for at in (0, -1)]
        reach: Mask = (np.stack(ends) != self.numbers).any(axis=0) & self.counted
        return reach

    def _build_together(self, batch: Sequence[tuple[Probe, Mask]]) -> None:
        if len(batch) == 1:
            self.find(batch[0][0])
            return
        found = self._build([probe for probe, _ in batch])
        reached = np.any([reach for _, reach in batch], axis=0)
        if found.why_not or ((found.numbers != self.numbers) & self.counted & ~reached).any():
            self._build_together(batch[: len(batch) // 2])
            self._build_together(batch[len(batch) // 2 :])
            return
        for probe, reach in batch:
            self.together[probe.row.setting, probe.number] = Found(np.where(reach, found.numbers, self.numbers))

    def _build(self, probes: Sequence[Probe]) -> Found:
        try:
            if all(probe.is_written for probe in probes):
                return Found(self.numbers)
            options = [probe.option for probe in probes]
            system = self.system.read_from(with_settings(self.system.table, options))
        except (VvdpError, ValueError) as problem:
            why = str(problem).splitlines()[0].removeprefix("--set: ")[:160]
            return Found(self.numbers, why, stage=1)
        if self.fixed(system) != self.before:
            return Found(self.numbers, OUTSIDE, stage=2)
        made = vectors(system.case)
        if any(a.shape != b.shape for a, b in zip(made, self.base, strict=True)):
            return Found(self.numbers, SHAPE, stage=3)
        return Found(np.concatenate(made))


def _apart(waiting: Sequence[tuple[Probe, Mask]]) -> Iterator[list[tuple[Probe, Mask]]]:
    """Probes in batches within which no two are of one value, or reach one number."""
    while waiting:
        batch, left, settings, reached = [], [], set[str](), np.zeros_like(waiting[0][1])
        for probe, reach in waiting:
            if probe.row.setting in settings or (reached & reach).any():
                left.append((probe, reach))
                continue
            batch.append((probe, reach))
            settings.add(probe.row.setting)
            reached = reached | reach
        yield batch
        waiting = left
