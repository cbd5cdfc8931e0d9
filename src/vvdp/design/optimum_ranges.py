"""How far an optimum moves over the ranges of the values that it does not vary, in closed form."""

from collections.abc import Mapping

import numpy as np

from vvdp.base.display import with_unit
from vvdp.base.kinds import Kind
from vvdp.design.optimise import Optimum
from vvdp.design.quantities import KINDS, LABELS, key, quantities
from vvdp.design.spreads import Spread, spreads, with_inputs
from vvdp.design.tolerance_runs import as_rows
from vvdp.design.variables import VARIABLES, with_variables
from vvdp.evaluation.ranges import Ranges

UNKNOWN = "no closed form knows it or holds over its range; vvdp run shows what it does"


def optimum_ranges(found: Optimum) -> Ranges:
    """Efficiency, PWM frequency and objective of the optimum at both ends of each value of the system that has a range.

    The variables of the design are left out: their ranges lie around other values.
    """
    problem = found.problem
    names = tuple(dict.fromkeys((problem.objective, "efficiency", "pwm_frequency")))
    varied = {VARIABLES[name].setting for name in found.values}
    given = {row.setting for row in problem.system.uncertainties} - varied
    all_spreads = [each for each in spreads(problem.system) if each.setting in given]
    taken = [each for each in all_spreads if each.in_closed_forms]
    pairs = [[_at_end(found, each, end, names) for end in (each.low, each.high)] for each in taken]
    return Ranges(
        rows=as_rows(taken),
        nominal={key(name, KINDS[name]): float(problem.mean(found.after, name)) for name in names},
        ends={
            key(name, KINDS[name]): np.array([[end[name] for end in pair] for pair in pairs]).reshape(-1, 2)
            for name in names
        },
        left_out={each.setting: UNKNOWN for each in all_spreads if each not in taken},
    )


def known_quantities(ranges: Ranges) -> dict[str, tuple[Kind, str]]:
    """Kind and label of the numbers of such ranges."""
    return {key(name, kind): (kind, LABELS[name]) for name, kind in KINDS.items() if key(name, kind) in ranges.nominal}


def ranges_in_words(ranges: Ranges) -> str:
    """Sentence on how uncertain values of the system move the optimum; empty if they move none of its numbers."""
    known = known_quantities(ranges)
    spans = [
        f"the {known[name][1]} lies between {' and '.join(with_unit(end, known[name][0]) for end in ranges.span(name))}"
        for name in ranges.nominal
        if ranges.moves(name)
    ]
    if not spans:
        return ""
    return f"Over the ranges of {len(ranges.rows)} values of the system, each alone, {', '.join(spans)}."


def _at_end(found: Optimum, spread: Spread, end: float, names: tuple[str, ...]) -> Mapping[str, float]:
    """Numbers of the optimum with one value at an end of its range, mean over the operating points."""
    problem = found.problem
    after = [
        quantities(with_variables(with_inputs(point.setup, {spread.setting: end}), found.values))
        for point in problem.points
    ]
    return {name: float(problem.mean(after, name)) for name in names}
