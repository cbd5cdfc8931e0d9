"""What a comparison comes to, on disk and back.

comparison.json   everything but the traces
comparison.csv    a row for every scenario and estimator; standard errors in columns that end in _se
traces.csv        true and estimated speed over time, first seed of the first scenario whose speed changes
meta.json         version and origin; marks the folder as one of results
"""

import csv
import json
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import vvdp
from vvdp.base.arrays import Array
from vvdp.base.errors import unusable
from vvdp.comparison.scores import Measured

FORMAT = 1
FILE = "comparison.json"


@dataclass(frozen=True)
class Traced:
    """One run of every estimator on the same readings: true speed and estimated ones over `time`, SI, (samples,)."""

    scenario: str
    time: Array
    speed: Array
    estimated: Mapping[str, Array]


class Played(NamedTuple):
    """A scenario as it was run: whether its speed changes, and how many seeds it got."""

    title: str
    changes: bool
    runs: int


class Entered(NamedTuple):
    """An estimator as it took part: what it is, and whether it works as the samples come and knows none before."""

    title: str
    causal: bool


@dataclass(frozen=True)
class Comparison:
    """What every estimator scored in every scenario.

    `seeds` were asked for; `scores` holds the figures of `vvdp.comparison.scores.summary` by scenario and estimator,
    `costs` the time that a sample takes [s].
    """

    sectors: int
    rate: float
    seeds: int
    scenarios: Mapping[str, Played]
    estimators: Mapping[str, Entered]
    scores: Mapping[tuple[str, str], Mapping[str, Measured]]
    costs: Mapping[str, Measured]
    traced: Traced | None
    seconds: float
    finished: bool

    @property
    def content(self) -> dict[str, Any]:
        """All but the traces, as JSON can hold it: a number that is not finite becomes null."""
        return {
            "format": FORMAT,
            "sectors": self.sectors,
            "rate_Hz": self.rate,
            "seeds": self.seeds,
            "finished": self.finished,
            "seconds": self.seconds,
            "traced": self.traced.scenario if self.traced else None,
            "estimators": [
                {"name": name, **entered._asdict(), **_pair("cost_s", self.costs[name])}
                for name, entered in self.estimators.items()
            ],
            "scenarios": [{"name": name, **played._asdict()} for name, played in self.scenarios.items()],
            "scores": [
                {"scenario": scenario, "estimator": estimator, **_flat(figures)}
                for (scenario, estimator), figures in self.scores.items()
            ],
        }


def _flat(figures: Mapping[str, Measured]) -> dict[str, float | None]:
    return {key: value for name, figure in figures.items() for key, value in _pair(name, figure).items()}


def _pair(key: str, figure: Measured) -> dict[str, float | None]:
    value, error = (x if math.isfinite(x) else None for x in figure)
    return {key: value, f"{key}_se": error}


def write_comparison(folder: Path, comparison: Comparison) -> None:
    """Writes a comparison into `folder`."""
    content = comparison.content
    _write_json(folder / FILE, content)
    written = time.strftime("%Y-%m-%dT%H:%M:%S%z")
    _write_json(folder / "meta.json", {"format": FORMAT, "vvdp": vvdp.__version__, "written": written})
    costs = {row["name"]: row["cost_s"] for row in content["estimators"]}
    rows = [{**row, "cost_s": costs[row["estimator"]]} for row in content["scores"]]
    with (folder / "comparison.csv").open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]) if rows else ["scenario", "estimator"])
        table.writeheader()
        table.writerows(rows)
    if traced := comparison.traced:
        columns = {"time_s": traced.time, "true_speed_rad_s": traced.speed}
        columns |= {f"{name}_speed_rad_s": speed for name, speed in traced.estimated.items()}
        np.savetxt(
            folder / "traces.csv",
            np.column_stack(list(columns.values())),
            fmt="%.9g",
            delimiter=",",
            header=",".join(columns),
            comments="",
        )


def _write_json(path: Path, content: Mapping[str, Any]) -> None:
    path.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def is_comparison(directory: Path) -> bool:
    """Whether `directory` holds a comparison."""
    return (directory / FILE).is_file()


def read_comparison(directory: Path) -> Comparison:
    """The comparison in `directory`. Raises ConfigError where there is none, or one from another format."""
    path = directory / FILE
    if not is_comparison(directory):
        raise unusable(directory, f"is not a comparison: {FILE} missing")
    try:
        content = json.loads(path.read_text("utf-8"))
        written = content["format"]
        if written == FORMAT:
            return _comparison(directory, content)
    except (OSError, ValueError, KeyError, TypeError) as problem:
        raise unusable(directory, f"is damaged: {problem!r}") from None
    raise unusable(path, f"was written in format {written}; this version reads format {FORMAT}")


def _comparison(directory: Path, content: Mapping[str, Any]) -> Comparison:
    return Comparison(
        sectors=content["sectors"],
        rate=content["rate_Hz"],
        seeds=content["seeds"],
        scenarios={row.pop("name"): Played(**row) for row in content["scenarios"]},
        estimators={row["name"]: Entered(row["title"], row["causal"]) for row in content["estimators"]},
        scores={(row.pop("scenario"), row.pop("estimator")): _figures(row) for row in content["scores"]},
        costs={row["name"]: _figures(row)["cost_s"] for row in content["estimators"]},
        traced=_traced(directory, content["traced"], content["estimators"]) if content["traced"] else None,
        seconds=content["seconds"],
        finished=content["finished"],
    )


def _figures(row: Mapping[str, Any]) -> dict[str, Measured]:
    def number(key: str) -> float:
        return math.nan if row[key] is None else float(row[key])

    return {key: Measured(number(key), number(f"{key}_se")) for key in row if f"{key}_se" in row}


def _traced(directory: Path, scenario: str, estimators: list[dict[str, Any]]) -> Traced:
    columns = np.loadtxt(directory / "traces.csv", delimiter=",", skiprows=1, ndmin=2).T
    return Traced(scenario, columns[0], columns[1], {row["name"]: columns[2 + i] for i, row in enumerate(estimators)})
