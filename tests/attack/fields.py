"""What is attacked: for each kind of file sound ones, what is made of them, and how they are read."""

import csv
import io
import re
import sys
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
from tests.attack import trees
from tests.attack.cage import Reading
from tests.attack.meanings import Meaning, columns_meaning, misreading, study_meaning, system_meaning
from tests.logs.files import mutate
from tests.systems.table_texts import tables_alone

from vvdp.base.display import key_suffix
from vvdp.base.errors import ConfigError, Fault, VvdpError
from vvdp.cli.main import main
from vvdp.design.problem import cycle_points
from vvdp.fitting import drop, jet, leakage
from vvdp.fitting.table import Quantity, read_columns
from vvdp.machines.recorded_cycle import recorded_cycle
from vvdp.studies.study import load_study
from vvdp.systems.system import load_system, shipped_systems

MOST_CASES = 20
"""Cases of a study whose systems are built."""
Read = Callable[[Path], Meaning]


class Field(Protocol):
    """A kind of file, and what is done with one of them by its seed, in a folder."""

    name: str
    files: int

    def warm(self, folder: Path) -> None:
        """Does once what all attacks need, before they are parted."""

    def attack(self, seed: int, folder: Path) -> Reading:
        """Makes a file in `folder` and has it read."""


def command(*words: str) -> int:
    """Exit code of a command in this process."""
    try:
        main(list(words))
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else 0
    return 0


def seeded(seed: int, name: str) -> np.random.Generator:
    """Random numbers of one file of a field."""
    return np.random.default_rng([seed, *name.encode()])


class Source(NamedTuple):
    """A sound text, and what reads such."""

    text: str
    read: Read


@dataclass(frozen=True)
class Texts:
    """Text files: three of four changed by their structure, one by its bytes.

    `verb` is a command that reads such a file without computing; without one it is only read.
    """

    name: str
    files: int
    sources: tuple[Source, ...]
    changed: Callable[[str, np.random.Generator], str]
    verb: tuple[str, ...] = ()
    file: str = "file.toml"

    def warm(self, folder: Path) -> None:
        """Reads the sound texts."""
        for number in range(len(self.sources)):
            self._sound(number, folder)

    @cache  # noqa: B019
    def _sound(self, number: int, folder: Path) -> Meaning:
        path, source = folder / self.file, self.sources[number]
        path.write_text(source.text, "utf-8")
        return source.read(path)

    def attack(self, seed: int, folder: Path) -> Reading:
        """Reads a changed text, and holds what was read against it."""
        random, number, path = seeded(seed, self.name), seed % len(self.sources), folder / self.file
        text, read = self.sources[number]
        before = self._sound(number, folder)
        if random.integers(4):
            path.write_text(self.changed(text, random), "utf-8", "surrogatepass")
        else:
            path.write_bytes(mutate(text.encode(), random))
        if self.verb and (code := command(*self.verb, str(path))):
            return Reading(code)
        try:
            return Reading(0, misreading(before, read(path)))
        except VvdpError as problem:
            print(problem, file=sys.stderr)
            return Reading(2)


def _changed_toml(text: str, random: np.random.Generator) -> str:
    return trees.toml(trees.changed(tomllib.loads(text), random))


def _changed_faults(text: str, random: np.random.Generator) -> str:
    """A system whose tables [faults] alone are changed."""
    tree = tomllib.loads(text)
    return trees.toml(tree | {"faults": trees.changed(tree["faults"], random)})


def _system(path: Path) -> Meaning:
    system = load_system(str(path))
    return system_meaning(tomllib.loads(path.read_text("utf-8")), system)


def _study(path: Path) -> Meaning:
    study = load_study(path)
    assert isinstance(study.system, str)
    base = load_system(study.system, study.settings, study.until)
    settings = [
        [f"{key}={value}" for key, value in case.items() if not isinstance(value, Mapping)] for case in study.cases
    ]
    systems = [load_system(study.system, [*study.settings, *each], study.until) for each in settings[:MOST_CASES]]
    return study_meaning(tomllib.loads(path.read_text("utf-8")), study, [base, *systems])


def _weighted(path: Path) -> Meaning:
    """A file of weighted operating points."""
    faults: list[Fault] = []
    points = cycle_points(path, load_system("prototype"), faults)
    if faults:
        raise ConfigError(faults)
    return Meaning(tomllib.loads(path.read_text("utf-8")), {"points": repr(points)}, {})


DRAWN = tuple(text for text in shipped_systems().values() if "\n[nodes" in text)
NAMED = (tables_alone("prototype"),)
FAULTS = """
[faults.frozen]
sensor = "axial_observer.pressure"
frozen = true
begin = "1.6 s"
[faults.blind]
sensor = "axial_sensor.instrument"
lost = true
begin = "1.6 s"
end = "1.8 s"
[faults.dirty]
sensor = "encoder.encoder"
missed = "20 %"
begin = "1.1 s"
[faults.stuck]
actuator = "passivity.command"
stuck = true
begin = "1.7 s"
[faults.jam]
jams = "spool"
torque = "5 N*m"
begin = "1.2 s"
end = "1.3 s"
[faults.thick]
value = "oil.air_fraction"
becomes = "30 %"
"""
FAULTY = shipped_systems()["vvdp-duty-control"] + FAULTS
STUDIES = (
    """title = "a grid"
system = "prototype"
until = "0.5 s"
outputs = ["efficiency", "steps"]
[settings]
"operation.pump_speed" = "1500 rpm"
[grid]
"operation.duty_ratio" = ["0.3", "0.5", "0.7"]
"oil.air_fraction" = ["0.5 %", "2 %"]
""",
    """system = "prototype"
outputs = ["efficiency"]
[random]
count = 6
seed = 1
[random.spreads]
"valve.radial_clearance" = { normal = "12.7 um", deviation = "0.5 um" }
"oil.liquid_bulk_modulus" = { uniform = ["1.2 GPa", "1.6 GPa"] }
""",
    """system = "buck-converter"
outputs = ["steps"]
[[cases]]
"oil.air_fraction" = "1 %"
[[cases]]
"oil.air_fraction" = "2 %"
"run.until" = "0.4 s"
""",
)
POINTS = (
    """[[points]]
weight = 2.0
"operation.duty_ratio" = "0.5"
[[points]]
weight = 3.0
"operation.duty_ratio" = "0.7"
"operation.pump_speed" = "1500 rpm"
""",
)
CYCLES = (
    "time [s],position [m]\n0,0.05\n0.74,0.263\n0.8,0.263\n1.54,0.05\n2.5,0.05\n",
    "time,position\n" + "".join(f"{0.01 * k:.2f},{0.15 + 0.1 * (k % 40) / 40:.4f}\n" for k in range(120)),
    "Zeit;position\ns;mm\n0,0;50,5\n0,5;120,25\n1,0;200,75\n1,75;50,5\n",
)
TABLES: tuple[tuple[str, Mapping[str, Quantity]], ...] = (
    (
        "flow [lpm],pressure drop [bar],diameter [mm]\n10,0.51,25.4\n20,1.9,25.4\n40,7.2,25.4\n60,15.8,25.4\n",
        drop.COLUMNS,
    ),
    ("# a note\nflow_m3_s;pressure_drop_Pa\n1,5e-4;2e5\n3e-4;7,9e5\n6e-4;3,1e6\n", drop.COLUMNS),
    ("opening,torque [N*m],port\n0.2,0.11,closing\n0.5,0.25,closing\n0.8,0.31,opening\n1,0.4,opening\n", jet.COLUMNS),
    (
        "pressure_drop [bar]\tleakage [lpm]\ttemperature [degC]\n10\t0.02\t40\n50\t0.1\t40\n90\t0.19\t50\n",
        leakage.COLUMNS,
    ),
)
CSV = "file.csv"
CLOCKS = ("time", "zeit")
"""Columns of times; a log may have several."""
CELLS = (
    "", "nan", "inf", "-1", "1e400", "0", "1,5", "1.5.5", "9" * 5000, "１０", "1_000", "0x10", "5 bar", "five",
    '"', "'", "=1+1",
    "1e-320", "\x00", "a" * 200_000, "−3", "1 000", "٣", "1e", "--", "#", "None", "true",
)  # fmt: skip


def changed_table(text: str, random: np.random.Generator) -> str:
    """A table after one to three accidents to its cells, rows, columns or headings."""
    mark = next((each for each in "\t;" if each in text), ",")
    rows = [line.split(mark) for line in text.splitlines()]
    for _ in range(int(random.choice((1, 1, 1, 2, 3)))):
        row, at = int(random.integers(len(rows))), int(random.integers(max(len(rows[0]), 1)))
        cell = str(random.choice(CELLS))
        match int(random.integers(10)):
            case 0 | 1:
                rows[row][at : at + 1] = [cell]
            case 2:
                rows[row].insert(at, cell)
            case 3:
                del rows[row][at:]
            case 4:
                rows.insert(row, list(rows[int(random.integers(len(rows)))]))
            case 5:
                del rows[row]
                rows = rows or [["time"]]
            case 6:
                for each in rows:
                    each[at:at] = each[at : at + 1]
            case 7:
                for each in rows:
                    each[:] = each[::-1]
            case 8:
                head = rows[0][at] if at < len(rows[0]) else ""
                rows[0][at : at + 1] = [str(random.choice([head.upper(), head + "s", "", head.split(" ")[0] + " [kg]",
                                                           head.split(" ")[0] + " [psi]", "x" * 3000]))]  # fmt: skip
            case 9:
                rows[row] = (
                    mark.join(rows[row]).replace(mark, str(random.choice([",", ";", "\t", mark * 2]))).split(mark)
                )
    return "\n".join(mark.join(row) for row in rows) + "\n"


def _cells_by_column(text: str, names: Sequence[str]) -> Mapping[str, Sequence[str]]:
    """The cells of the columns that bear one of the `names`, by Python's reader alone; a log may have other columns.

    A quantity that stands there twice counts, and so do cells to the right of the last heading.
    """
    lines = [line for line in text.splitlines() if line.strip()[:1] not in ("", "#")]
    mark = next((each for each in "\t;" if lines and each in lines[0]), ",")
    found: dict[str, list[str]] = {"beyond": []}
    rows = [[cell.strip() for cell in row] for row in csv.reader(io.StringIO("\n".join(lines)), delimiter=mark)]
    first = next((k for k, row in enumerate(rows) if any(_column_name(cell) in names for cell in row)), 0)
    heads, rows = rows[first], rows[first + 1 :]  # what stands above the headings of a log are notes
    for place, head in enumerate(heads):
        if (name := _column_name(head)) in names and not (name in CLOCKS and name in found):
            head = head.casefold() if _column_name(head) == head.casefold() else head
            found[f"{name}{2 if name in found else ''}"] = [head, *(row[place] for row in rows if len(row) > place)]
    found["beyond"] += [cell for row in rows for cell in row[len(heads) :]]
    return found


def _column_name(head: str) -> str:
    """A heading without its unit, in one spelling."""
    return re.sub(r"[\s-]+", "_", re.sub(r"[\[(].*", "", head).strip()).casefold()


def _cycle(path: Path) -> Meaning:
    found = recorded_cycle(path)
    cells = _cells(path, (*CLOCKS, "position"))
    return columns_meaning(cells, {"times": found.times, "positions": found.positions})


def _columns(wanted: Mapping[str, Quantity]) -> Read:
    suffixed = (name + key_suffix(quantity.kind).casefold() for name, quantity in wanted.items())

    def read(path: Path, names: Sequence[str] = (*wanted, *suffixed)) -> Meaning:
        found = read_columns(path, wanted)
        return columns_meaning(_cells(path, names), {name: held.tolist() for name, held in found.items()})

    return read


def _cells(path: Path, names: Sequence[str]) -> Mapping[str, Sequence[str]]:
    csv.field_size_limit(10**7)
    try:
        return _cells_by_column(path.read_bytes().decode("utf-8-sig"), names)
    except (UnicodeDecodeError, csv.Error, ValueError):
        return {"bytes": [repr(path.read_bytes())]}


TEXTS = (
    Texts("system files", 350, tuple(Source(text, _system) for text in NAMED), _changed_toml, ("show", "--json")),
    Texts("drawn networks", 350, tuple(Source(text, _system) for text in DRAWN), _changed_toml, ("show", "--json")),
    Texts("tables of faults", 250, (Source(FAULTY, _system),), _changed_faults),
    Texts("studies", 300, tuple(Source(text, _study) for text in STUDIES), _changed_toml),
    Texts("cycles", 250, tuple(Source(text, _cycle) for text in CYCLES), changed_table, file=CSV),
    Texts("operating points", 100, tuple(Source(text, _weighted) for text in POINTS), _changed_toml),
    Texts("tables to fit", 250, tuple(Source(each, _columns(own)) for each, own in TABLES), changed_table, file=CSV),
)  # fmt: skip
