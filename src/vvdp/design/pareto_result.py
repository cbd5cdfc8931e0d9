"""A Pareto front as a result: designs that the simulation confirms, those that it refuses apart, charts of both."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from vvdp.base.display import percent, with_unit
from vvdp.base.files import write_whole
from vvdp.base.kinds import COUNT, EFFICIENCY, FLAG, FREQUENCY, MEAN_POWER
from vvdp.design.conditions import LEFT_OUT, conditions
from vvdp.design.pareto import Front
from vvdp.design.problem import ON_BOUND
from vvdp.design.proof import TOLERANCE
from vvdp.design.quantities import KINDS, LABELS, key
from vvdp.design.variables import redesign, value_in
from vvdp.results.chart import Chart, Colour, Level, Line, Lines, Stroke
from vvdp.results.result import Badge, Column, Finding, Grade, Listing, Number, Result, Row, Section, Table
from vvdp.systems.resolved import resolved_text

MANNER = (
    "An evolutionary search, begun with the optimum of each objective alone, spreads designs over the front; a "
    "gradient solver makes the first objective of each as small as the others allow. All designs are simulated. What "
    f"the simulation refuses is not on the front: a total loss more than {percent(TOLERANCE, 0)} off the analytic one, "
    "means that do not settle, or a run that fails. Each design is a system file in systems/ for vvdp run."
)
SIMULATED = {
    "loss_total": (MEAN_POWER, "total loss, simulated"),
    "pwm_frequency": (FREQUENCY, "PWM frequency, simulated"),
    "efficiency": (EFFICIENCY, "efficiency, simulated"),
    "settled": (FLAG, "settled"),
}


def front_result(found: Front, *, finished: bool) -> Result:
    """The front as a result."""
    system = found.problem.system
    tables = {"front": _table(found), "refused": _table(found, refused=True), "before": _before(found)}
    charts = {each.name: each for each in (*_pair_charts(found), _variable_chart(found))}
    good = ", ".join(f"{'large' if each.large else 'small'} {LABELS[each.quantity]}" for each in found.objectives)
    demands = "; ".join(each.words_with_origin for each in found.problem.limits) or "nothing"
    refused = (Section(title="Refused by the simulation", shows=("reasons", "refused")),) if found.rejects else ()
    return Result(
        verb="design pareto",
        title="Pareto front of the rotary valve",
        system=system.name,
        manner=MANNER,
        conditions=conditions(system),
        left_out=LEFT_OUT,
        numbers=dict(_numbers(found)),
        tables=tables,
        listings={"reasons": _reasons(found), "bounds": _bounds(found)},
        charts=charts,
        badges=(_badge(found),),
        findings=tuple(_findings(found)),
        sections=(
            Section(title="Figures", words=(f"Wanted: {good}. Subject to: {demands}.",), shows=tuple(charts)),
            Section(title="Designs on the front", shows=("front",), starts_page=True),
            *refused,
            Section(title="Variables and their bounds", shows=("bounds",)),
            Section(title="How it was done", words=(MANNER,), shows=("conditions",)),
        ),
        finished=finished,
    )


def write_designs(folder: Path, found: Front) -> None:
    """Writes every design as a system file into systems/ of a folder."""
    system = found.problem.system
    (folder / "systems").mkdir()
    good = ", ".join(f"{'large' if each.large else 'small'} {each.quantity}" for each in found.objectives)
    names = [*_names("point", found.front_designs), *_names("refused", found.rejects)]
    for name, place in zip(names, (*found.front_designs, *found.rejects), strict=True):
        note = f"{name} of a Pareto front: {good}"
        design = redesign(system, found.values[place], note, f"{system.title}, {name} of a front")
        write_whole(folder / "systems" / f"{name}.toml", resolved_text(design))


def _names(word: str, places: tuple[int, ...]) -> list[str]:
    """Names of system files, counted by the first objective."""
    return [f"{word}-{number:03d}" for number in range(1, len(places) + 1)]


def _table(found: Front, *, refused: bool = False) -> Table:
    """The designs on the front, or those that the simulation refuses with its reason."""
    places, title = found.front_designs, "Designs on the front"
    names = _names("point", places)
    if refused:
        places, title = found.rejects, "Designs that the simulation refuses"
        names = _names("refused", places)
    wanted = [each.quantity for each in found.objectives]
    variables = [b.variable for b in found.problem.bounds]
    columns = {"design": Column(np.array(names, str), None, "design")}
    for name in [*wanted, *(name for name in KINDS if name not in wanted)]:
        values = np.array([found.quantities[k][name] for k in places], float)
        columns[key(name, KINDS[name])] = Column(values, KINDS[name], LABELS[name])
    for each in variables:
        values = np.array([found.values[k][each.name] for k in places], float)
        columns[key(each.name, each.kind)] = Column(values, each.kind, each.label)
    if found.simulated:
        columns |= _simulation_table(found, places)
    if refused:
        reasons = ["; ".join(found.simulated[1 + k].doubts) for k in places]
        columns["reason"] = Column(np.array(reasons, str), None, "reason")
    shown = ["design", *(key(name, KINDS[name]) for name in wanted)]
    shown += ["simulated_loss_total_W"] if found.simulated else []
    shown += [key(each.name, each.kind) for each in variables]
    return Table(title=title, columns=columns, shown=tuple(shown), is_data=not places)


def _simulation_table(found: Front, places: tuple[int, ...]) -> dict[str, Column]:
    """Simulated quantities of designs; -1 is the design before the optimisation, which was simulated first."""
    columns = {}
    for name, (kind, label) in SIMULATED.items():
        values = np.array([float(getattr(found.simulated[1 + k], name)) for k in places], float)
        columns[key(f"simulated_{name}", kind)] = Column(values, kind, label)
    return columns


def _before(found: Front) -> Table:
    """The design as it was."""
    columns = {
        key(name, kind): Column(np.array([found.before[name]]), kind, LABELS[name]) for name, kind in KINDS.items()
    }
    at = found.problem.points[0].setup
    for variable in (bound.variable for bound in found.problem.bounds):
        value = np.array([value_in(at, variable.name)])
        columns[key(variable.name, variable.kind)] = Column(value, variable.kind, variable.label)
    if found.simulated:
        columns |= _simulation_table(found, (-1,))
    return Table(title="The design as it was", columns=columns, is_data=True)


def _numbers(found: Front) -> Iterator[tuple[str, Number]]:
    yield "evaluations", Number(found.evaluations, COUNT, "designs evaluated")
    yield "designs", Number(len(found.front_designs), COUNT, "designs on the front")
    yield (
        "confirmed_designs",
        Number(len(found.front_designs) if found.simulated else 0, COUNT, "designs that are confirmed"),
    )
    yield "refused_designs", Number(len(found.rejects), COUNT, "designs that the simulation refuses")
    yield "designs_on_a_bound", Number(len(found.on_a_bound), COUNT, "designs with a variable on a bound")


def _badge(found: Front) -> Badge:
    if found.simulated:
        return Badge(
            f"{len(found.front_designs)} designs confirmed by simulation",
            Grade.GOOD if found.front_designs else Grade.BAD,
        )
    return Badge("not simulated", Grade.WARNING)


def _findings(found: Front) -> Iterator[Finding]:
    count = len(found.front_designs)
    if not found.simulated:
        yield Finding(
            text="No design is confirmed: none was simulated, and analytic values alone may mislead.",
            grade=Grade.WARNING,
            title="Nothing is confirmed",
            remedy="The same command without --no-simulation simulates all designs.",
        )
    if found.rejects:
        yield Finding(
            text=f"{len(found.rejects)} of {len(found.values)} designs are not on the front, as the simulation refuses "
            f"them: it is more than {percent(TOLERANCE, 0)} off the analytic total loss, has not settled or failed.",
            grade=Grade.WARNING,
            title="Designs were refused",
        )
    yield Finding(text=f"{count} designs are on the front: none is better than another in every objective.")
    better = sum(
        all(each.sign * (found.quantities[k][each.quantity] - found.before[each.quantity]) <= 0.0 for each in
            found.objectives)
        for k in found.front_designs
    )  # fmt: skip
    whom = f"{better} of them {'is' if better == 1 else 'are'}" if better else "None of them is"
    yield Finding(text=f"{whom} at least as good as the design as it was in every objective.")
    bounds = len(found.on_a_bound)
    other = "other bounds would move that part of the front."
    yield Finding(
        text=f"{bounds} of these {count} designs {'has' if bounds == 1 else 'have'} a variable on a bound; {other}"
        if bounds
        else "No variable of any of them lies on a bound."
    )


def _reasons(found: Front) -> Listing:
    rows = (
        Row(name, None, ("; ".join(found.simulated[1 + place].doubts),))
        for name, place in zip(_names("refused", found.rejects), found.rejects, strict=True)
    )
    return Listing(title="Designs that the simulation refuses", heads=("reason",), rows=tuple(rows))


def _bounds(found: Front) -> Listing:
    rows = []
    for bound in found.problem.bounds:
        name = bound.variable.name
        low, high = (
            sum(abs(found.values[k][name] - end) <= ON_BOUND * end for k in found.front_designs)
            for end in (bound.low, bound.high)
        )
        amounts = (with_unit(end, bound.variable.kind) for end in (bound.low, bound.high))
        rows.append(Row(bound.variable.label, None, (*amounts, str(low), str(high))))
    heads = ("from", "to", "designs on the lower bound", "on the upper bound")
    return Listing(title="Bounds", heads=heads, rows=tuple(rows))


def _points(found: Front, x: str, y: str) -> tuple[Line, ...]:
    """The designs as points, those that are refused and the one as it was apart."""
    groups = (
        ("front", "confirmed" if found.simulated else "not simulated", Colour.LOAD),
        *((("refused", "refused by the simulation", Colour.FAINT),) if found.rejects else ()),
        ("before", "as it was", Colour.INLET),
    )
    return tuple(
        Line(x=x, y=y, table=table, label=label, colour=colour, stroke=Stroke.POINTS) for table, label, colour in groups
    )


def _pair_charts(found: Front) -> Iterator[Chart]:
    """All pairs of objectives: a chart for each but the last, in which the objectives after it stand over it."""
    keys = [key(each.quantity, KINDS[each.quantity]) for each in found.objectives]
    for place, x in enumerate(keys[:-1]):
        label = LABELS[found.objectives[place].quantity]
        yield Chart(
            name="trade-offs" if not place else f"trade-offs-{place + 1}",
            caption=f"Designs over the {label}. No design on the front is better than another in every objective; "
            "what the simulation refuses is not on it.",
            table="front",
            panels=tuple(Lines(lines=_points(found, x, y)) for y in keys[place + 1 :]),
            side_by_side=True,
            height=2.8,
        )


def _variable_chart(found: Front) -> Chart:
    first = found.objectives[0].quantity
    panels = []
    for bound in found.problem.bounds:
        y = key(bound.variable.name, bound.variable.kind)
        ends = tuple(Level(value=end, colour=Colour.RELIEF) for end in (bound.low, bound.high))
        panels.append(Lines(lines=_points(found, key(first, KINDS[first]), y), levels=ends))
    return Chart(
        name="variables",
        caption=f"The variables along the front, over the {LABELS[first]}; dashed: their bounds. Where designs of "
        f"alike {LABELS[first]} differ, the other objectives decide.",
        table="front",
        panels=tuple(panels),
        height=0.6 + 1.4 * len(panels),
    )
