"""A study: a system, what is varied in it, and which results are wanted; from Python or from a file.

system = "prototype"                      # a shipped system, or a file beside this one
until = "0.5 s"                           # optional, as are [settings] and the title
outputs = ["efficiency", "mean_load_flow_m3_s"]

[settings]                                # the same in all cases
"operation.pump_speed" = "1500 rpm"

[grid]                                    # every combination
"operation.duty_ratio" = ["0.3", "0.5", "0.7"]
"oil.air_fraction" = ["0.5 %", "2 %"]

[random]                                  # instead of the grid, or at each of its points
count = 20
seed = 1
[random.spreads]
"valve.radial_clearance" = { normal = "12.7 um", deviation = "0.5 um" }
"oil.liquid_bulk_modulus" = { uniform = ["1.2 GPa", "1.6 GPa"] }

[[cases]]                                 # instead of both: each case written out
"operation.duty_ratio" = "0.3"
"""

import hashlib
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import NormalDist
from typing import Any, TypeAlias

import numpy as np

from vvdp.base.errors import ConfigError, Fault, ParameterError
from vvdp.base.kinds import TIME
from vvdp.base.tables import Table, fault_at, read_table, refuse_unknown
from vvdp.base.units import number_and_unit, parse
from vvdp.systems.system import System, named_systems

Settings: TypeAlias = Mapping[str, object]
"""Values by `table.key`, each as a system file has it: text with a unit, a number, or a signal's mapping."""

MOST_CASES = 1_000_000
"""Of a study; each has a row in the list of cases, which is made before the first one runs."""
DEVIATIONS = 3.0
"""Where a normal spread ends on either side."""


@dataclass(frozen=True)
class Uniform:
    """Any value between two, alike; both with the same unit."""

    low: str
    high: str

    def quantile(self, share: float) -> str:
        """The value below which the share `share` of all draws lies."""
        (low, unit), (high, other) = number_and_unit(self.low), number_and_unit(self.high)
        if unit != other or not low <= high:
            raise ParameterError(f"uniform between {self.low!r} and {self.high!r}; expected one unit, the lower first")
        return f"{low + share * (high - low)!r} {unit}".strip()


@dataclass(frozen=True)
class Normal:
    """Values around a mean with a standard deviation of the same unit, none further than three deviations away."""

    mean: str
    deviation: str

    def quantile(self, share: float) -> str:
        """The value below which the share `share` of all draws lies."""
        (mean, unit), (deviation, other) = number_and_unit(self.mean), number_and_unit(self.deviation)
        if unit != other or not deviation >= 0.0:
            raise ParameterError(
                f"normal around {self.mean!r} by {self.deviation!r}; expected one unit, and a deviation of at least 0"
            )
        normal = NormalDist()
        tail = normal.cdf(-DEVIATIONS)
        return f"{mean + deviation * normal.inv_cdf(tail + share * (1.0 - 2.0 * tail))!r} {unit}".strip()


@dataclass(frozen=True)
class Random:
    """`count` draws of every spread, the same ones at each point of `grid`.

    A draw depends on seed, name and number alone: more draws or another spread beside leave the earlier ones as they
    were, so that their cases need not be run again.
    """

    spreads: Mapping[str, Uniform | Normal]
    count: int
    seed: int
    grid: Mapping[str, Sequence[Any]] = field(default_factory=dict)

    def draw(self, number: int) -> dict[str, str]:
        """The settings of one draw."""
        return {name: spread.quantile(self._share(name, number)) for name, spread in self.spreads.items()}

    def _share(self, name: str, number: int) -> float:
        word = int.from_bytes(hashlib.sha256(name.encode()).digest()[:8])
        return float(np.random.default_rng([self.seed, number, word]).random())


Variations: TypeAlias = Mapping[str, Sequence[Any]] | Sequence[Settings] | Random
"""A full grid (values by `table.key`), each case written out, or random draws."""


@dataclass(frozen=True)
class Study:
    """A system, by name or as loaded, with `settings` for all cases, what is varied, and which results are wanted.

    `outputs` are keys of a run's summary. `until` changes the length of the runs as it does for a single one.
    """

    system: str | System
    variations: Variations
    outputs: Sequence[str]
    settings: Sequence[str] = ()
    until: str | None = None
    title: str = ""

    @property
    def cases(self) -> list[Settings]:
        """Settings that each case changes, in order: the last name of a grid changes fastest, draws faster still."""
        if isinstance(self.variations, Random):
            draws = [self.variations.draw(number) for number in range(self.variations.count)]
            return [{**point, **draw} for point in _points(self.variations.grid) for draw in draws]
        if isinstance(self.variations, Mapping):
            return _points(self.variations)
        return list(self.variations)


def _points(grid: Mapping[str, Sequence[Any]]) -> list[Settings]:
    return [dict(zip(grid, point, strict=True)) for point in itertools.product(*grid.values())]


def load_study(path: Path | str) -> Study:
    """The study that a file describes. Raises ConfigError with all its faults."""
    path = Path(path)
    table = read_table(path)
    content, faults = table.content, list[Fault]()
    refuse_unknown(content, KEYS, "", table, faults)
    title = content.get("title", "")
    if not isinstance(title, str):
        faults.append(fault_at(table, "title", f"{title!r} is not a text in quotes"))
    system = _system(path, table, faults)
    until = _until(table, faults)
    outputs = content.get("outputs")
    if not isinstance(outputs, list) or not outputs or not all(isinstance(word, str) for word in outputs):
        message = f'{outputs!r}; expected a list of keys of a summary, for example ["efficiency"]'
        faults.append(fault_at(table, "outputs", message))
        outputs = []
    settings = _settings(table, faults)
    variations = _variations(table, faults)
    _refuse_twice(settings, variations, table, faults)
    if faults:
        raise ConfigError(faults)
    common = {key: value for key, value in settings.items() if isinstance(value, Mapping)}
    if common:  # a signal: every case carries it, in the form of the file
        variations = [{**common, **case} for case in Study(system, variations, ()).cases]
    plain = tuple(f"{key}={value}" for key, value in settings.items() if key not in common)
    return Study(
        system=system,
        variations=variations,
        outputs=tuple(outputs),
        settings=plain,
        until=until,
        title=title,
    )


def _system(path: Path, table: Table, faults: list[Fault]) -> str:
    """The name of a shipped system, or the path of a file beside that of the study."""
    system = table.content.get("system")
    if not isinstance(system, str) or not system:
        faults.append(fault_at(table, "system", f"{system!r}; expected the name of a shipped system or of a file"))
        return ""
    return str(beside) if system not in named_systems() and (beside := path.parent / system).is_file() else system


def _until(table: Table, faults: list[Fault]) -> str | None:
    until = table.content.get("until")
    if until is None or (isinstance(until, str) and _is_time(until, table, faults)):
        return until
    if not isinstance(until, str):
        faults.append(fault_at(table, "until", f'{until!r}; expected a time, for example "0.5 s"'))
    return None


def _is_time(text: str, table: Table, faults: list[Fault]) -> bool:
    try:
        parse(text, TIME)
    except ParameterError as problem:
        faults.append(fault_at(table, "until", str(problem)))
        return False
    return True


def _settings(table: Table, faults: list[Fault]) -> dict[str, Any]:
    settings = _flatten(table, "settings", faults)
    for key, value in settings.items():
        if isinstance(value, list | bool):
            faults.append(fault_at(table, f"settings.{key}", f"{value!r}; expected a value"))
    return settings


def _variations(table: Table, faults: list[Fault]) -> Variations:
    """Variations: a grid, draws at each of its points, or cases that are written out."""
    content = table.content
    grid = _flatten(table, "grid", faults)
    for key, values in grid.items():
        if not isinstance(values, list) or not values:
            faults.append(fault_at(table, f"grid.{key}", f"{values!r}; expected a list of values"))
    _refuse_many(grid, table, faults)
    random = _random(table, grid, faults) if "random" in content else None
    if "cases" in content:
        return _cases(table, faults)
    if not grid and random is None:
        faults.append(fault_at(table, "", "nothing is varied; expected [grid], [random] or [[cases]]"))
    return random if random is not None else grid


def _refuse_twice(settings: Mapping[str, object], variations: Variations, table: Table, faults: list[Fault]) -> None:
    """Append a fault for each value that is the same in all cases and varied as well."""
    varied: dict[str, str] = {}
    if isinstance(variations, Random):
        varied = {**dict.fromkeys(variations.grid, "[grid]"), **dict.fromkeys(variations.spreads, "[random.spreads]")}
    elif isinstance(variations, Mapping):
        varied = dict.fromkeys(variations, "[grid]")
    else:
        varied = {key: "[[cases]]" for case in variations for key in case}
    for key in settings.keys() & varied.keys():
        message = f"is in {varied[key]} as well; a value is either the same in all cases or varied"
        faults.append(fault_at(table, f"settings.{key}", message))


def _refuse_many(grid: Mapping[str, object], table: Table, faults: list[Fault]) -> None:
    """Append a fault for a grid with more points than can be made."""
    counts = [len(values) for values in grid.values() if isinstance(values, list)]
    if (points := math.prod(counts)) > MOST_CASES:
        product = " x ".join(map(str, counts))
        message = f"{product} = {points} points; must be at most {MOST_CASES}: give fewer values, or use [random]"
        faults.append(fault_at(table, "grid", message))


def _cases(table: Table, faults: list[Fault]) -> list[Settings]:
    cases = table.content["cases"]
    if not isinstance(cases, list) or not cases or not all(isinstance(case, dict) and case for case in cases):
        faults.append(fault_at(table, "cases", "expected tables [[cases]], each with the values of one case"))
        cases = []
    if "grid" in table.content or "random" in table.content:
        message = "contradicts grid and random; write the cases out or have them made"
        faults.append(fault_at(table, "cases", message))
    found: list[Settings] = [_join_keys(case) for case in cases]
    for number, case in enumerate(found, 1):
        for key in case:
            if "." not in key:
                faults.append(fault_at(table, f"cases.{number}.{key}", 'expected a key of the form "table.key"'))
    return found


KEYS = ("title", "system", "until", "outputs", "settings", "grid", "random", "cases")
VALUES = frozenset(("value", "step", "ramp", "sine", "table", "from", "uniform", "normal"))
"""Words of which a mapping has one where it is a value, and no table of values."""


def _join_keys(table: Mapping[str, object], above: str = "") -> dict[str, Any]:
    """`table` with `operation.duty_ratio = ...`, which TOML nests, under the same name as when it is quoted."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        path = f"{above}{key}"
        if "." in key or not isinstance(value, Mapping) or (above and VALUES & set(value)):
            found[path] = value
        else:
            found |= _join_keys(value, f"{path}.")
    return found


def _flatten(table: Table, name: str, faults: list[Fault], path: str = "") -> dict[str, Any]:
    """The values by `table.key` of the table `name`, which stands at `path` in the file."""
    path = path or name
    content: Any = table.content
    for word in path.split("."):
        content = content.get(word, {}) if isinstance(content, Mapping) else {}
    if not isinstance(content, Mapping) or (name in table.content and not content):
        faults.append(fault_at(table, path, f"{content!r}; expected a table of values by table.key"))
        return {}
    found = _join_keys(content)
    for key in found:
        if "." not in key:
            faults.append(fault_at(table, f"{path}.{key}", 'expected a key of the form "table.key"'))
    return found


def _random(table: Table, grid: Mapping[str, Any], faults: list[Fault]) -> Random | None:
    content = table.content["random"]
    if not isinstance(content, Mapping):
        faults.append(fault_at(table, "random", f"{content!r}; expected a table with count, seed and spreads"))
        return None
    refuse_unknown(content, ("count", "seed", "spreads"), "random", table, faults)
    count, seed = content.get("count"), content.get("seed")
    if type(count) is not int or not 1 <= count <= MOST_CASES:
        faults.append(fault_at(table, "random.count", f"{count!r}; must be a whole number from 1 to {MOST_CASES}"))
        count = 1
    points = math.prod(len(values) for values in grid.values() if isinstance(values, list))
    if points <= MOST_CASES < points * count:
        message = f"{count} draws at each of {points} points are {points * count} cases; must be at most {MOST_CASES}"
        faults.append(fault_at(table, "random.count", message))
    if type(seed) is not int or seed < 0:
        faults.append(fault_at(table, "random.seed", f"{seed!r}; expected a whole number, not negative"))
        seed = 0
    return Random(_spreads(table, grid, faults), count, seed, grid)


def _spreads(table: Table, grid: Mapping[str, object], faults: list[Fault]) -> dict[str, Uniform | Normal]:
    spreads: dict[str, Uniform | Normal] = {}
    entries = _flatten(table, "spreads", faults, "random.spreads")
    for key, words in entries.items():
        path = f"random.spreads.{key}"
        if key in grid:
            faults.append(fault_at(table, path, "stands in the grid as well"))
        try:
            spreads[key] = _spread(words)
        except ParameterError as problem:
            faults.append(fault_at(table, path, str(problem)))
    if not entries:
        faults.append(fault_at(table, "random.spreads", "missing; expected the spread of at least one value"))
    return spreads


def _spread(words: Any) -> Uniform | Normal:
    """The spread of a value. Raises ParameterError where it is none."""
    match words:
        case {"uniform": [str(low), str(high)], **rest} if not rest:
            spread: Uniform | Normal = Uniform(low, high)
        case {"normal": str(mean), "deviation": str(deviation), **rest} if not rest:
            spread = Normal(mean, deviation)
        case _:
            message = "expected { uniform = [a, b] } or { normal = mean, deviation = s }, with units"
            raise ParameterError(f"{words!r}; {message}")
    spread.quantile(0.5)
    return spread
