"""Claims on a rotary PWM valve: against throttling, against a linear valve, self-spinning or driven, and its ripple."""

import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial

from vvdp.base.display import plain, with_unit
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import LENGTH, MASS, PRESSURE_LEVEL
from vvdp.machines.duties import Duty
from vvdp.results.result import Result
from vvdp.results.verdict import verdict_table
from vvdp.rigs.conditions import conditions
from vvdp.rivals.actuation_claim import LIGHT_MASS, actuation_claim, annular_stroke, same_ports_stroke
from vvdp.rivals.claim import Claim
from vvdp.rivals.driving_claim import driving_claim, driving_point, self_spinning
from vvdp.rivals.linear_valve_claim import linear_valve_claim
from vvdp.rivals.ripple_claim import ripple_claim
from vvdp.rivals.supply_claim import supply_claim
from vvdp.rivals.throttling_claim import throttling_claim
from vvdp.simulation.link import quiet
from vvdp.steady.test_stand import Stand, standstill
from vvdp.valve.geometry import transition_fraction

LEFT_OUT = (
    "Pump and motor losses beyond the parameters, the same for both ways of control.",
    "What the throttling valve itself adds: its lowest drop and its actuation.",
    "Power that moves the published linear valves: the source shows it of one, 300 V and up to 30 A while it switches.",
    "Stiction, flow forces and springs of the linear valve; energy put into its braking is not recovered.",
    "Seals and bearings of a driven spool's shaft, and the efficiency of its motor.",
)
MANNER = (
    "Claims of chapters 1, 2 and 5 of the source, each calculated for this system: losses and ripple from periodic "
    "steady states of the PWM-resolved circuit, actuation powers in closed form."
)
DRIVING, RIPPLE = "self-spinning against driven", "ripple"


def claims(
    stand: Stand,
    duties: Sequence[Duty] = (),
    *,
    cores: int | None = None,
    say: Callable[[str], None] = quiet,
) -> Result:
    """All claims for one system, its rivals on `duties`, the shipped ones unless given.

    Those that need a load line are left out, and said to be, where there is none. So is a driven spool beside a
    self-spinning one where the flow cannot turn it.

    Ctrl-C leaves out those that are not yet calculated; before the first of them is, it is raised. Raises
    ParameterError where the spool does not turn.

    Source  wang2017, chapters 1, 2 and 5
    """
    if stuck := standstill(stand.set_point, stand.means(stand.set_point), stand):
        raise ParameterError(f"{stand.name}: {stuck}")
    began = time.perf_counter()
    say("against throttling")
    found = [throttling_claim(stand, cores=cores, say=say)]
    say("compared with other circuits")
    found.append(supply_claim(stand, duties, cores=cores, say=say))
    pending, left_out = _with_load_line(stand, cores, say)
    found += _checked_claims(pending, left_out, say)
    finished = not pending
    found.append(actuation_claim(stand))
    if finished:
        say("linear valves")
        found.append(linear_valve_claim(stand, cores=cores, say=say))
    return Result(
        verb="rig claims",
        title="Published claims for the rotary PWM valve",
        system=stand.name,
        manner=MANNER,
        references=("wang2017", "tu2011"),
        conditions=_conditions(stand),
        left_out=tuple(left_out),
        tables={
            "verdicts": verdict_table([pair for each in found for pair in each.statements], "section"),
            **{name: table for each in found for name, table in each.tables.items()},
        },
        charts={chart.name: chart for each in found for chart in each.charts},
        numbers={key: number for each in found for key, number in each.numbers.items()},
        findings=tuple(finding for each in found for finding in each.findings),
        seconds=time.perf_counter() - began,
        finished=finished,
    )


def _checked_claims(
    pending: dict[str, Callable[[], Claim]], left_out: list[str], say: Callable[[str], None]
) -> Iterator[Claim]:
    """Each `pending` claim, which is then no longer so; what cannot be calculated is added to what is `left_out`."""
    while pending:
        name = next(iter(pending))
        say(name)
        try:
            yield pending[name]()
        except ParameterError as problem:
            left_out.append(f"{_title([name])}: {problem}.")
        except KeyboardInterrupt:
            left_out.append(f"{_title(list(pending))}: interrupted before.")
            return
        pending.pop(name)


def _with_load_line(
    stand: Stand, cores: int | None, say: Callable[[str], None]
) -> tuple[dict[str, Callable[[], Claim]], list[str]]:
    """The claims that need a load line, as far as this system can have them, and what is left out of all of them."""
    left_out = list(LEFT_OUT)
    if not stand.makes_pressure:
        both = _title([DRIVING, RIPPLE])
        return {}, [*left_out, f"{both}: both need a load line, and here a source is the load."]
    pending: dict[str, Callable[[], Claim]] = {
        DRIVING: partial(driving_claim, stand, cores=cores, say=say),
        RIPPLE: partial(ripple_claim, stand, cores=cores),
    }
    alone, largest = self_spinning(stand), driving_point(stand, stand.pump_flow(stand.set_point))
    if stuck := standstill(largest, alone.means(largest), alone):
        del pending[DRIVING]
        left_out.append(f"{_title([DRIVING])}: left to itself {stuck}.")
    return pending, left_out


def _title(names: list[str]) -> str:
    words = ", and ".join(names)
    return words[0].upper() + words[1:]


def _conditions(stand: Stand) -> dict[str, str]:
    point, valve = stand.set_point, stand.bench.valve
    same, light = with_unit(same_ports_stroke(valve), LENGTH, 3), with_unit(annular_stroke(valve), LENGTH, 3)
    return conditions(stand) | {
        "duty ratio": f"{plain(point.duty_ratio, 4)} unless varied",
        "load pressure": f"{with_unit(point.load_pressure, PRESSURE_LEVEL)} unless varied",
        "linear valves": f"{with_unit(valve.spool_mass, MASS)} moved by {same}, and {with_unit(LIGHT_MASS, MASS)} by "
        f"{light}, in {plain(100.0 * transition_fraction(valve), 3)} % of a period (assumed)",
    }
