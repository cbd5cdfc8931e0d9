"""What every estimator scored in every scenario, as values."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from vvdp.base.arrays import Array
from vvdp.comparison.scores import Measured


@dataclass(frozen=True)
class Traced:
    """One run of every estimator on the same readings: true speed and estimated ones over `time`, SI, (samples,)."""

    scenario: str
    time: Array
    speed: Array
    estimated: Mapping[str, Array]


class Played(NamedTuple):
    """A scenario as it was run: whether it is a step of the speed, and how many seeds it got."""

    title: str
    is_step: bool
    runs: int


class Entered(NamedTuple):
    """An estimator as it took part: what it is, and whether it works as the samples come and knows none before."""

    title: str
    causal: bool


@dataclass(frozen=True, kw_only=True)
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
    def scenarios_run(self) -> dict[str, Played]:
        """The scenarios that were run at least once."""
        return {name: played for name, played in self.scenarios.items() if played.runs}

    @property
    def first_step(self) -> str | None:
        """The first scenario in which the speed goes over to another."""
        return next((name for name, played in self.scenarios_run.items() if played.is_step), None)
