"""The result of a fit: coefficients with their intervals, points, chart."""

from collections.abc import Iterator

from vvdp.base.display import key_suffix, percent
from vvdp.base.kinds import COUNT, EFFICIENCY
from vvdp.fitting.fitted import Coefficient, Fitted, Taker
from vvdp.results.result import Finding, Grade, Listing, Number, Result, Row, Section

MOST_SCATTER = 0.2
"""Of points about a law that may be taken for theirs: measured drops, leakages and torques repeat to a few percent."""
INTERVALS = (
    "An interval holds a coefficient with 95 % if the scatter about the law is all that is uncertain and alike at all "
    "points: Student's t with the degrees of freedom that are left. What all points share, such as the error of a mesh "
    "or of a sensor, is not in it. The law holds within the range of the points."
)


def fit_result(found: Fitted, file: str, host: Taker | None) -> Result:
    """The result of a fit to a table, of the valve of `host` where there is one."""
    numbers = {key: _number(each) for key, each in found.coefficients.items()}
    numbers |= {key + key_suffix(each.kind): _number(each) for key, each in found.valve.items()}
    numbers |= {
        "points": Number(float(found.points.rows), COUNT, "points"),
        "scatter": Number(found.scatter, EFFICIENCY, "scatter about the law, rms"),
    }
    listings = _listings(found, host)
    return Result(
        verb="fit",
        title=found.title,
        system=host.name if host else "",
        manner=f"{found.formula} {INTERVALS}",
        references=("merritt1967",) if found.valve.keys() & {"radial_clearance", "flow_coefficient"} else ("wang2017",),
        conditions={"table": file, **(host.conditions if host else {})},
        left_out=("What all points have in common: errors of mesh, sensor and set-up.",),
        numbers=numbers,
        listings=listings,
        tables={"points": found.points, "curve": found.curve},
        charts={"fit": found.chart},
        findings=(*_findings(found), *found.findings),
        sections=(
            Section(title="The law", words=(found.formula,), shows=("fit", *listings)),
            Section(title="The points", shows=("points",)),
            Section(title="How it was done", words=(INTERVALS,), shows=("conditions",)),
        ),
    )


def confidence(found: Fitted) -> dict[str, list[float]]:
    """Lower and upper end of the interval of each coefficient [SI], by its key."""
    return {
        **{key: [*each.interval[1:]] for key, each in found.coefficients.items()},
        **{key + key_suffix(each.kind): [*each.interval[1:]] for key, each in found.valve.items()},
    }


def _number(each: Coefficient) -> Number:
    return Number(each.interval.value, each.kind, each.label)


def _listings(found: Fitted, host: Taker | None) -> dict[str, Listing]:
    law = tuple(Row(each.label, each.kind, each.interval) for each in found.coefficients.values())
    listings = {"coefficients": Listing(title="Law", heads=("fitted", "95 % from", "to"), rows=law)}
    if host:
        rows = tuple(
            Row(each.label, each.kind, (*each.interval, host.present(key))) for key, each in found.valve.items()
        )
        listings["valve"] = Listing(title="Fitted values", heads=("fitted", "95 % from", "to", "system"), rows=rows)
    return listings


def _findings(found: Fitted) -> Iterator[Finding]:
    text = (
        f"{found.points.rows} points scatter by {percent(found.scatter, 2)} about the law; the farthest lies "
        f"{percent(float(abs(found.points['distance']).max()), 2)} off."
    )
    if not found.scatter > MOST_SCATTER:
        yield Finding(text=text)
        return
    yield Finding(
        title="The points do not follow the law",
        grade=Grade.WARNING,
        text=f"{text} That is more than {percent(MOST_SCATTER, 2)}: the coefficients describe no point well.",
        remedy="Look at the chart for a point that lies apart, check the units, or take another law.",
    )
