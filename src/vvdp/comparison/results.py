"""Scores of every estimator in every scenario, as values."""

from collections.abc import Mapping
from dataclasses import dataclass

from vvdp.base.arrays import Array
from vvdp.comparison.contest import Contest
from vvdp.comparison.figures import Measured


@dataclass(frozen=True)
class Traced:
    """One run of every estimator on the same readings: true speed and estimated ones over `time`, SI, (samples,)."""

    scenario: str
    time: Array
    speed: Array
    estimated: Mapping[str, Array]


@dataclass(frozen=True, kw_only=True)
class Comparison(Contest):
    """Scores of every estimator in every scenario.

    `scores` holds the figures of `vvdp.comparison.scores.summary`, `costs` the time that a sample takes [s]; `steps`
    are the scenarios that are a step of the speed, `causal` the estimators that know no sample before it comes.
    """

    sectors: int
    rate: float
    costs: Mapping[str, Measured]
    steps: frozenset[str]
    causal: frozenset[str]
    traced: Traced | None

    @property
    def first_step(self) -> str | None:
        """The first scenario in which the speed goes over to another."""
        return next((name for name in self.scenarios_run if name in self.steps), None)
