"""The robust optimum as a result: the front of mean loss against size, the nominal optimum beside it."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import percent, with_unit
from vvdp.base.files import discard, write_listed, write_whole
from vvdp.base.kinds import COUNT, EFFICIENCY, FREQUENCY, MEAN_POWER, VOLUME
from vvdp.base.manifest import read_list
from vvdp.design.quantities import key
from vvdp.design.robust import Candidate, Robust
from vvdp.design.variables import redesign, value_in
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Badge, Column, Finding, Grade, Listing, Number, Result, Row, Section, Table
from vvdp.systems.resolved import resolved_text

MANNER = (
    "Each scenario is an operating point with one draw of all tolerances and of the oil's temperature; every design is "
    "simulated in every one of them. The first designs are those of least loss in closed form, from small to large; "
    "later ones are bred from those on the front. A design with a run that fails, has not settled or does not balance, "
    "or that switches more slowly on the mean than the system as it is, is not on the front."
)


def robust_result(found: Robust) -> Result:
    """The search as a result."""
    front = found.front
    tables = {
        "front": _table("Designs on the front", found, front, "point"),
        "before": _table("The system as it is", found, (found.before,), "as it is"),
        "nominal": _table("Least loss in closed form", found, (found.nominal,), "nominal"),
        "refused": _table("Designs that the simulation refuses", found, found.rejects, "refused"),
    }
    confirmed = Badge(f"{len(front)} designs confirmed by simulation", Grade.GOOD if front else Grade.BAD)
    return Result(
        verb="design robust",
        title="Robust optimum of the rotary valve",
        system=found.problem.system.name,
        manner=MANNER,
        conditions={"scenarios": str(len(found.scenarios)), "subject to": _demands(found)},
        left_out=("Wear of the barriers, and what a smaller valve costs or saves to make.",),
        numbers=dict(_numbers(found)),
        tables=tables,
        listings={"spreads": _spreads(found)},
        charts={"loss-over-size": _chart()},
        badges=(confirmed,),
        findings=tuple(_findings(found)),
        sections=(
            Section(title="Mean loss against size", shows=("loss-over-size", "front")),
            Section(title="What is drawn", shows=("spreads",)),
            Section(title="How it was done", words=(MANNER,), shows=("conditions",)),
        ),
        finished=found.finished,
    )


def write_front(folder: Path, found: Robust) -> None:
    """Writes every design on the front as a system file into systems/ of a folder, in place of earlier ones."""
    system, texts = found.problem.system, {}
    for number, each in enumerate(found.front, 1):
        name = f"point-{number:03d}"
        design = redesign(system, each.values, f"{name} of a robust front", f"{system.title}, {name} of a robust front")
        texts[f"systems/{name}.toml"] = resolved_text(design)
    with write_listed(folder, texts):
        for path, text in texts.items():
            write_whole(folder / path, text)
    discard(folder, [name for name in read_list(folder) if name.startswith("systems/") and name not in texts])


def _demands(found: Robust) -> str:
    return "; ".join(limit.words_with_origin for limit in found.problem.limits) or "nothing"


def _table(title: str, found: Robust, designs: Sequence[Candidate], word: str) -> Table:
    """A row for each design: what the simulations say, its size, its variables."""

    def column(name: str) -> Array:
        return np.array([getattr(each, name) for each in designs], float)

    names = [f"{word}-{k:03d}" if word in ("point", "refused") else word for k in range(1, len(designs) + 1)]
    columns = {
        "design": Column(np.array(names, str), None, "design"),
        "mean_loss_W": Column(column("loss"), MEAN_POWER, "mean loss"),
        "largest_loss_W": Column(column("largest_loss"), MEAN_POWER, "largest loss"),
        "spool_volume_m3": Column(column("size"), VOLUME, "spool volume"),
        "mean_pwm_frequency_Hz": Column(column("pwm_frequency"), FREQUENCY, "PWM frequency, mean"),
        "mean_efficiency": Column(column("efficiency"), EFFICIENCY, "efficiency, mean"),
    }
    at = found.problem.points[0].setup
    for variable in (bound.variable for bound in found.problem.bounds):
        values = [each.values.get(variable.name, value_in(at, variable.name)) for each in designs]
        columns[key(variable.name, variable.kind)] = Column(np.array(values, float), variable.kind, variable.label)
    if word == "refused":
        columns["reason"] = Column(np.array([each.refusal for each in designs], str), None, "reason")
    return Table(title=title, columns=columns, is_data=word == "refused" or not designs)


def _numbers(found: Robust) -> Iterator[tuple[str, Number]]:
    nan = float("nan")
    least = found.front[0].loss if found.front else nan
    yield "loss_before_W", Number(found.before.loss, MEAN_POWER, "mean loss as it is")
    yield "loss_nominal_W", Number(found.nominal.loss, MEAN_POWER, "mean loss of the nominal optimum")
    yield "loss_robust_W", Number(least, MEAN_POWER, "least mean loss")
    yield "designs", Number(float(len(found.front)), COUNT, "designs on the front")
    yield "refused_designs", Number(float(len(found.rejects)), COUNT, "designs that the simulation refuses")
    yield "scenarios", Number(float(len(found.scenarios)), COUNT, "scenarios")
    yield "simulated_designs", Number(float(len(found.candidates) + 2), COUNT, "designs that were simulated")


def _findings(found: Robust) -> Iterator[Finding]:
    if not found.front:
        yield Finding(
            text="The simulation confirms no design.", grade=Grade.WARNING, title="No front",
            remedy="Take more --generations, or wider bounds.",
        )  # fmt: skip
        return
    best, before = found.front[0], found.before.loss
    yield Finding(
        text=f"On the mean over {len(found.scenarios)} scenarios the system as it is loses "
        f"{with_unit(before, MEAN_POWER)}, the best design {with_unit(best.loss, MEAN_POWER)} "
        f"({percent(1.0 - best.loss / before)} less) at {with_unit(best.size, VOLUME)}."
    )
    if found.nominal.refusal:
        yield Finding(text=f"The optimum in closed form is no design for all scenarios: {found.nominal.refusal}.")
    else:
        yield Finding(
            text=f"The optimum in closed form loses {with_unit(found.nominal.loss, MEAN_POWER)} there, "
            f"{percent(found.nominal.loss / best.loss - 1.0)} more than the best."
        )
    smallest = found.front[-1]
    yield Finding(
        text=f"The smallest on the front has {with_unit(smallest.size, VOLUME)} and loses "
        f"{with_unit(smallest.loss, MEAN_POWER)}."
    )


def _spreads(found: Robust) -> Listing:
    rows = tuple(Row(each.label, None, (str(each), each.note)) for each in found.taken)
    return Listing(title="What is drawn", heads=("between", "from"), rows=rows)


def _chart() -> Chart:
    x = "spool_volume_m3"
    lines = (
        Line(x=x, y="mean_loss_W", label="mean", colour=Colour.INLET, stroke=Stroke.MARKED),
        Line(x=x, y="largest_loss_W", label="largest", colour=Colour.TANK, stroke=Stroke.POINTS),
    )
    return Chart(
        name="loss-over-size",
        caption="Mean and largest power lost over all scenarios against the size of the spool; each is simulated.",
        table="front",
        panels=(Lines(lines=lines),),
    )
