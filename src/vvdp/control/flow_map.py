"""The mean flow of a rotary valve over its duty ratio and the pressure behind it, as a table, and its inverse.

Bilinear between its rows, so that at any pressure the inverse is exact; it does not depend on the origin of the table.

Source  ours, docs/models/whole-machine.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

from vvdp.base.kinds import FLOW, NUMBER, PRESSURE_LEVEL, Fraction
from vvdp.base.params import Params
from vvdp.base.rules import refuse_rows, require_rising
from vvdp.base.select import clip, maximum


class FlowMap(Params):
    """`flows` [m^3/s] at all `duty_ratios` of the first of `line_pressures` (absolute), then of the next, and so on.

    Duty ratios are axial positions over the helix length: below 0 and above 1 there is more to come. The flow must not
    fall from one duty ratio to the next.
    """

    duty_ratios: Annotated[tuple[float, ...], NUMBER]
    line_pressures: Annotated[tuple[float, ...], PRESSURE_LEVEL]
    flows: Annotated[tuple[float, ...], FLOW]

    def check(self) -> None:
        n, m = len(self.duty_ratios), len(self.line_pressures)
        if n < 2 or m < 2 or len(self.flows) != n * m:
            refuse_rows(
                self,
                "flows",
                f"{len(self.flows)} flows for {n} duty ratios and {m} pressures; expected at least two of "
                "each, and a flow for every pair",
            )
        require_rising(self, "duty_ratios")
        require_rising(self, "line_pressures")
        for j in range(m):
            require_rising(self, "flows", strictly=False, rows=slice(j * n, (j + 1) * n))


class Rows(NamedTuple):
    """The two rows of a map between which a pressure lies: where they begin, and the share of the upper one."""

    lower: int
    upper: int
    share: Fraction


def rows_at(line_pressure: float, flow_map: FlowMap) -> Rows:
    """The rows of a map about a pressure; the nearest alone beyond its ends.

    line_pressure  absolute [Pa]
    """
    pressures, n = flow_map.line_pressures, len(flow_map.duty_ratios)
    j = _interval(line_pressure, pressures)
    share = clip((line_pressure - pressures[j]) / (pressures[j + 1] - pressures[j]), 0.0, 1.0)
    return Rows(j * n, (j + 1) * n, share)


def flow_for_duty(duty_ratio: float, line_pressure: float, flow_map: FlowMap) -> float:
    """Mean flow of a duty ratio [m^3/s]; that of the nearest one beyond the map's ends.

    duty_ratio     axial position over helix length [1]
    line_pressure  absolute [Pa]
    """
    rows, duties = rows_at(line_pressure, flow_map), flow_map.duty_ratios
    i = _interval(duty_ratio, duties)
    share = clip((duty_ratio - duties[i]) / (duties[i + 1] - duties[i]), 0.0, 1.0)
    low, high = _flow(i, rows, flow_map), _flow(i + 1, rows, flow_map)
    return low + share * (high - low)


def duty_for_flow(flow: float, line_pressure: float, flow_map: FlowMap) -> float:
    """Duty ratio that delivers a mean flow [1].

    Without flow it is the highest one that still delivers none, ready to deliver; beyond the highest flow of the valve
    it is the map's last, which switches least.

    flow           [m^3/s]
    line_pressure  absolute [Pa]
    """
    rows, duties = rows_at(line_pressure, flow_map), flow_map.duty_ratios
    low, high = 0, len(duties) - 1
    wanted = maximum(flow, _flow(low, rows, flow_map))
    if wanted >= _flow(high, rows, flow_map):
        return duties[high]
    while high - low > 1:
        middle = (low + high) // 2
        if _flow(middle, rows, flow_map) <= wanted:
            low = middle
        else:
            high = middle
    before, after = _flow(low, rows, flow_map), _flow(high, rows, flow_map)
    share = (wanted - before) / (after - before)
    return duties[low] + share * (duties[high] - duties[low])


def _flow(i: int, rows: Rows, flow_map: FlowMap) -> float:
    """Flow of the duty ratio number i, between two rows [m^3/s]."""
    low, high = flow_map.flows[rows.lower + i], flow_map.flows[rows.upper + i]
    return low + rows.share * (high - low)


def _interval(value: float, places: tuple[float, ...]) -> int:
    """Number of the place before a value, of rising places, the last but one at most."""
    low, high = 0, len(places) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if places[middle] <= value:
            low = middle
        else:
            high = middle
    return low
