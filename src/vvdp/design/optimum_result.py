"""An optimum as a result: before and after, what holds it, how sure it is, analytic beside simulated."""

from collections.abc import Collection, Iterator, Sequence

from vvdp.base.display import NOTHING, fixed_point, number, percent, with_unit
from vvdp.base.kinds import NUMBER
from vvdp.design.conditions import LEFT_OUT, conditions, sentence
from vvdp.design.optimise import Optimum
from vvdp.design.optimum_charts import chart_tables, optimum_charts
from vvdp.design.optimum_ranges import known_quantities, optimum_ranges, ranges_in_words
from vvdp.design.proof import Proof, simulated_means
from vvdp.design.quantities import KINDS, LABELS, key
from vvdp.design.sensitivity import LimitCurve
from vvdp.design.solver import geometry_of
from vvdp.design.variables import VARIABLES, value_in
from vvdp.evaluation.quantities import quantities as summary_quantities
from vvdp.evaluation.range_display import result_with_ranges
from vvdp.results.result import Finding, Grade, Listing, Number, Result, Row, Section, sentences

SOURCE_OPTIMUM = 2.48e5
"""Full-open drop that wang2017, section 2.6, states for its optimum [Pa]."""
MANNER = (
    "Variables are sought in their logarithms, with exact derivatives of the formulas, by an interior-point solver "
    "from the system and from random starts; a differential evolution, which uses no gradients, then searches the "
    "whole box. With the spool radius go the radii of the jets and the friction area, with its square the spool's "
    "mass, and with the outlet area its effective area."
)
HOLDING = (
    "From the multipliers of the solver. The change of the objective is for 1 % more of the value, which zero and a "
    "constraint of the geometry do not have; a bound that is not listed has no influence."
)
COUNTING = (
    "The compressibility loss counts the PWM frequency of the fully open valve here, that of the switching valve, "
    "which is lower, in vvdp valve and in the comparison with the simulation. The efficiency is the load power, less "
    "leakage and compressibility, over the input power; that of an analytic map leaves compressibility out."
)
COMPARING = (
    "The analytic values count volumes and add up an upper estimate of the losses, see the model of the rotary valve; "
    "1 to 4 % of difference is usual, more where a warning stands above. Here they are taken at the mean load pressure "
    "of the simulation, above at that of the operating point."
)


def optimum_result(
    found: Optimum, proven: Sequence[Proof], doubted: Sequence[Finding], curves: Sequence[LimitCurve], *, finished: bool
) -> Result:
    """The optimum with the simulations of it, what is in doubt, and how it goes with its limits."""
    charts = {each.name: each for each in optimum_charts(found, curves)}
    listings = {"variables": _variables(found), "quantities": _quantities(found), "held": _limits_table(found)}
    if proven:
        listings["simulated"] = _simulation_table(found, proven)
    system, ranges = found.problem.system, optimum_ranges(found)
    rests_on = sentences(tuple(filter(None, (ranges_in_words(ranges),))))
    result = Result(
        verb="design optimum",
        title="Optimum of the rotary valve",
        system=system.name,
        manner=MANNER,
        references=("wang2017",) if _is_published(found) else (),
        conditions=conditions(system),
        left_out=LEFT_OUT,
        numbers=dict(_numbers(found, proven)),
        tables=chart_tables(found, proven, curves),
        listings=listings,
        charts=charts,
        findings=(*_findings(found, proven), *rests_on, *doubted),
        sections=tuple(_sections(found, listings, charts)),
        finished=finished,
    )
    return result_with_ranges(result, ranges, known_quantities(ranges), "How it was done")


def _sections(found: Optimum, listings: Collection[str], charts: Collection[str]) -> Iterator[Section]:
    yield Section(title="Figures", shows=tuple(charts))
    demands = [
        *(each.words_with_origin for each in found.problem.limits),
        *(each.words for each in geometry_of(found.problem)),
    ]
    asked = f"Least {LABELS[found.problem.objective]}, subject to: {'; '.join(demands)}."
    points = ("points",) if len(found.problem.points) > 1 else ()
    yield Section(title="Question and bounds", words=(asked,), shows=("variables", *points), starts_page=True)
    yield Section(title="What holds the optimum", words=(HOLDING,), shows=("held",))
    yield Section(title="Before and after", words=(COUNTING,), shows=("quantities",))
    if "simulated" in listings:
        yield Section(title="Analytic against simulation", words=(COMPARING,), shows=("simulated",))
    if _is_published(found):
        yield Section(title="The published optimum", words=(_published_values(found),))
    yield Section(title="How it was done", words=(MANNER, _search(found)), shows=("conditions",))


def _numbers(found: Optimum, proven: Sequence[Proof]) -> Iterator[tuple[str, Number]]:
    problem = found.problem
    for name, value in found.values.items():
        yield key(name, VARIABLES[name].kind), Number(value, VARIABLES[name].kind, VARIABLES[name].label)
    for name, kind in KINDS.items():
        yield key(name, kind), Number(float(problem.mean(found.after, name)), kind, LABELS[name])
    known = summary_quantities(problem.system)
    for each in proven:
        where = f"point_{each.point + 1}_" if each.point else ""
        for name, value in each.found.items():
            kind, label = known.get(name, (NUMBER, name.replace("_", " ")))
            yield f"{each.design}_{where}simulated_{name}", Number(float(value), kind, f"{label}, {each.design}")


def _findings(found: Optimum, proven: Sequence[Proof]) -> Iterator[Finding]:
    problem = found.problem
    name = problem.objective
    kind = KINDS[name]
    was = float(problem.mean(found.before, name))
    subject = f", subject to {', '.join(each.words_with_origin for each in problem.limits)}" if problem.limits else ""
    text = f"The {LABELS[name]} goes from {with_unit(was, kind)} to {with_unit(found.objective, kind)}, analytically"
    text += f" ({_change(name, was, found.objective)}){subject}."
    if means := simulated_means(problem, proven):
        simulated, before, after = means
        kind = KINDS[simulated]
        what = "it" if simulated == name else f"the {LABELS[simulated]}"
        text += f" Simulated, {what} goes from {with_unit(before, kind)} to {with_unit(after, kind)}"
        text += f" ({_change(simulated, before, after)})."
    if len(problem.points) > 1:
        text += f" It is the weighted mean over {len(problem.points)} operating points."
    yield Finding(text=text)
    bounds = [each.words for each in found.active if each.kind != "limit"]
    if bounds:
        yield Finding(text=f"The optimum is set by these limits: {'; '.join(bounds)}; changing them moves it.")
    yield Finding(text=_search(found))


def _change(name: str, before: float, after: float) -> str:
    """From before to after: in per cent, for a share in percentage points."""
    if name in ("efficiency", "transition_fraction"):
        share = 100.0 * (after - before)
        return f"{'+' if share > 0.0 else ''}{fixed_point(share, 1)} points"
    if not before:
        return NOTHING
    return ("+" if after > before else "") + percent(after / before - 1.0)


def _search(found: Optimum) -> str:
    text = (
        f"{found.converged} of {found.starts} random starts ended in a design that meets all demands, "
        f"{found.agreeing} of them in this one."
    )
    if others := len(found.worse_optima):
        kind = KINDS[found.problem.objective]
        worse = ", ".join(with_unit(value, kind, 6) for value in found.worse_optima[:5])
        text += f" There are {others} worse local optima: {worse}{'.' if others <= 5 else ' and more.'}"
    if found.global_objective is not None:
        apart = percent(max(abs(found.global_objective / found.objective - 1.0), 1e-6), 4)
        text += f" A global search of {found.global_evaluations} designs, without gradients, came within {apart} of it."
    return text


def _is_published(found: Optimum) -> bool:
    sources = {row.source for row in found.problem.system.rows if row.table == "valve"}
    return "wang2017" in sources and found.problem.objective == "pressure_drop_total"


def _published_values(found: Optimum) -> str:
    near = abs(found.objective / SOURCE_OPTIMUM - 1.0) < 0.012
    return (
        "The 2.48 bar of wang2017 depend on bounds that it does not state. The source gives 6.61 bar for the prototype "
        "and 2.48 bar for its optimum, without the bounds of its variables. With the prototype's radius and clearance "
        "the best is 6.63 bar at 72 Hz; 2.48 bar follow, for example, at 72 Hz with a clearance of at most 22.5 µm and "
        "no limit on the transition fraction, which is then 0.50. "
        f"This optimum is {'that' if near else 'another'} value, within the bounds listed here."
    )


def _variables(found: Optimum) -> Listing:
    at = found.problem.points[0].setup
    rows = []
    for bound in found.problem.bounds:
        name, kind = bound.variable.name, bound.variable.kind
        given = [words for words, is_given in (("lower", bound.low_given), ("upper", bound.high_given)) if is_given]
        whose = {0: "usual bounds", 1: f"{''.join(given)} one given", 2: "given"}[len(given)]
        values = (value_in(at, name), found.values[name], bound.low, bound.high)
        rows.append(Row(bound.variable.label, kind, values, note=whose))
    return Listing(title="Variables", heads=("before", "optimum", "from", "to"), rows=tuple(rows))


def _quantities(found: Optimum) -> Listing:
    rows = []
    for name, kind in KINDS.items():
        before, after = (float(found.problem.mean(each, name)) for each in (found.before, found.after))
        rows.append(Row(LABELS[name], kind, (before, after, _change(name, before, after))))
    return Listing(title="Results, analytic", heads=("before", "optimum", "change"), rows=tuple(rows))


def _share(per_cent: float) -> str:
    return f"{number(per_cent)} %" if per_cent == per_cent else NOTHING


def _limits_table(found: Optimum) -> Listing:
    rows = (
        Row(each.words, None, (each.kind, _share(each.elasticity), number(each.sensitivity))) for each in found.active
    )
    heads = ("which is a", "1 % more changes the objective by", "sensitivity, SI over SI")
    return Listing(title="Held by", heads=heads, rows=tuple(rows))


COMPARED = (
    ("PWM frequency, averaged", "pwm_frequency", ("pwm_frequency_Hz",), ("analytic_pwm_frequency_Hz",)),
    (
        "throttling and relief",
        "loss_total",
        ("loss_full_open_W", "loss_transition_W"),
        ("analytic_loss_full_open_W", "analytic_loss_transition_W"),
    ),
    ("leakage", "loss_leakage", ("loss_valve_leakage_W",), ("analytic_loss_leakage_W",)),
    ("total loss", "loss_total", ("loss_total_W",), ("analytic_loss_total_W",)),
    ("flow to the load", "load_flow", ("mean_load_flow_m3_s",), ("analytic_load_flow_m3_s",)),
)


def _simulation_table(found: Optimum, proven: Sequence[Proof]) -> Listing:
    by_design = {(each.point, each.design): each for each in proven}
    rows = []
    for point in range(len(found.problem.points)):
        group = f"Operating point {point + 1}" if len(found.problem.points) > 1 else ""
        for label, name, simulated, analytic in COMPARED:
            cells: list[float | str | None] = []
            for design in ("before", "after"):
                pair = [_sum(by_design.get((point, design)), keys) for keys in (simulated, analytic)]
                cells += [*pair, percent(pair[1] / pair[0] - 1.0) if pair[0] else NOTHING]
            rows.append(Row(label, KINDS[name], tuple(cells), group=group))
    heads = ("before, simulated", "analytic", "difference", "optimum, simulated", "analytic", "difference")
    return Listing(title="Simulation before and after", heads=heads, rows=tuple(rows))


def _sum(proof: Proof | None, keys: Sequence[str]) -> float:
    """The sum of what a simulation gave under `keys`; nan where it did not."""
    if proof is None or not proof.found.keys() >= set(keys):
        return float("nan")
    return float(sum(proof.found[each] for each in keys))


def doubt_findings(simulated: Sequence[str], analytic: Sequence[str]) -> tuple[Finding, ...]:
    """Findings that the simulation does not confirm, then reasons to doubt the analytic values."""
    refuted = "The simulation does not bear out the optimum"
    return (
        *(Finding(text=sentence(text), grade=Grade.BAD, title=refuted) for text in simulated),
        *(Finding(text=sentence(text), grade=Grade.WARNING, title="In doubt at the optimum") for text in analytic),
    )
