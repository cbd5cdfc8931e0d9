"""Columns, tables and findings of the quality of runs: balance, iterations, y+ at the walls, residuals."""

from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np

from vvdp.base.display import number, percent
from vvdp.base.kinds import COUNT, EFFICIENCY, FLAG, NUMBER
from vvdp.cfd.numerics import Phase
from vvdp.cfd.quality import CRITERIA
from vvdp.cfd.solve import Solved
from vvdp.cfd.turbulence import Turbulence
from vvdp.results.result import Column, Finding, Grade, Listing, Row, Section

WALL_LAWS = (
    "y+ is the distance of the first cell's centre from the wall in viscous lengths. Wall functions of k-epsilon are "
    "meant for 30 to 300; below about 11 they take the layer as laminar. A residual "
    "is the initial one of an iteration as OpenFOAM normalises it, mean over the last 50 iterations."
)


class Ordered(Protocol):
    """An order of a part of the valve, as far as it says how its flow is solved."""

    @property
    def turbulence(self) -> Turbulence:
        """Model of turbulence."""

    @property
    def phases(self) -> tuple[Phase, ...]:
        """Schemes, one after the other."""


QUALITY = Section(title="Walls and residuals", words=(WALL_LAWS,), shows=("walls", "residuals"), starts_page=True)


def approach(order: Ordered) -> dict[str, str]:
    """Conditions of a result: model of turbulence, and order of the convection's scheme at the end."""
    return {"turbulence": order.turbulence.model, "convection": order.phases[-1].order}


def state_columns(runs: Sequence[Solved]) -> dict[str, Column]:
    """Columns of a table with a row for each run: balance, iterations, whether it has settled, y+ over all walls."""
    walls = np.array([run.quality.over_all_walls for run in runs])
    return {
        "mass_imbalance": Column(np.array([run.judgement.imbalance for run in runs]), EFFICIENCY, "imbalance"),
        "iterations": Column(np.array([float(run.judgement.iteration) for run in runs]), COUNT, "iterations"),
        "has_settled": Column(np.array([float(run.settled) for run in runs]), FLAG, "settled"),
        "y_plus_least": Column(walls[:, 0], NUMBER, "y+, least"),
        "y_plus_mean": Column(walls[:, 1], NUMBER, "y+, mean"),
        "y_plus_largest": Column(walls[:, 2], NUMBER, "y+, largest"),
        "residual_share": Column(
            np.array([run.quality.residual_share for run in runs]), NUMBER, "largest residual over its criterion"
        ),
    }


def quality_listings(names: Sequence[str], runs: Sequence[Solved]) -> dict[str, Listing]:
    """Listings of the section `QUALITY`: y+ of each patch of walls and the residual of each field, of runs by name."""
    walls = [
        Row(f"{name}, {each.patch}", NUMBER, (each.least, each.mean, each.largest))
        for name, run in zip(names, runs, strict=True)
        for each in run.quality.walls
    ]
    residuals = [
        Row(f"{name}, {field}", NUMBER, (value, CRITERIA[field]))
        for name, run in zip(names, runs, strict=True)
        for field, value in run.quality.residuals.items()
    ]
    return {
        "walls": Listing(title="y+ at the walls", heads=("least", "mean of the faces", "largest"), rows=tuple(walls)),
        "residuals": Listing(title="Residual of each field", heads=("found", "criterion"), rows=tuple(residuals)),
    }


def restless_findings(runs: Sequence[Solved]) -> Iterator[Finding]:
    """A warning where some of several runs have not settled, and a note where residuals exceed their criteria."""
    if restless := [run for run in runs if not run.settled]:
        yield Finding(
            title="Not settled",
            grade=Grade.WARNING,
            text=f"{len(restless)} of {len(runs)} runs still changed after all their iterations, by up to "
            f"{percent(max(run.judgement.change for run in restless), 2)}.",
            remedy="Take a finer grid.",
        )
    yield from residual_findings(runs)


def residual_findings(runs: Sequence[Solved]) -> Iterator[Finding]:
    """A note of the fields whose residual exceeds its criterion, with the largest over all runs."""
    fields = dict.fromkeys(field for run in runs for field in run.quality.unmet)
    if fields:
        largest = {field: max(run.quality.residuals.get(field, 0.0) for run in runs) for field in fields}
        told = ", ".join(
            f"{field} {number(each, 2)} (criterion {CRITERIA[field]:g})" for field, each in largest.items()
        )
        yield Finding(
            title="Residuals above their criteria",
            text=f"{told}. A run is ended by the change of its drop from window to window, not by residuals.",
        )
