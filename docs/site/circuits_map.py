"""Writes the table of docs/circuits-compared.md on which circuit draws least, over load, duty and number of consumers.

`python docs/site/circuits_map.py`
"""

import math
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import NamedTuple

from circuits_compared import PAGE, drag, pump_ends, put, short

from vvdp.comparison.circuit_trials import run_pair
from vvdp.systems.displacement.duties import Duty, known_cylinder, sized_duty
from vvdp.systems.displacement.duty_cycle import DutyCycle
from vvdp.systems.displacement.rival_circuits import CIRCUITS, RivalCircuit

BEGIN, END = "<!-- map, made by docs/site/circuits_map.py -->\n", "<!-- end of the map -->\n"
FORCES = (2e3, 5e3, 10e3)
"""Of the first consumer, against extending [N]."""
SHARES = (1.0, 0.25)
"""Of the time in which rods move."""
CONSUMERS = (1, 2, 3)
FURTHER = ((0.4, 0.1), (0.1, 0.06))
"""Of the second and third consumer: share of the first one's force, and stroke [m]."""
LOW, STROKE, WAY = 0.05, 0.216, 1.25
"""Where strokes begin, how far the first one goes, and how long either way takes [m, m, s]."""
NAMES = ("vvdp-slow", "throttle", "load-sensing", "independent-valves", "ideal-pump", "four-valves")
SWITCHED = "vvdp-slow"
"""The switched machine; its pump turns as slowly as its valve still spins."""
LIMIT = 0.05
"""Within which the powers of two circuits count as the same."""


class Use(NamedTuple):
    """A way to use circuits: force of the first consumer [N], share of the time in which rods move, consumers."""

    force: float
    share: float
    consumers: int


def duty_of(use: Use) -> Duty:
    """The duty of a use: out and back, then at rest until the round is over; all consumers have a throttle alike."""
    first = _moved(use, use.force, STROKE)
    further = [_moved(use, ratio * use.force, stroke) for ratio, stroke in FURTHER][: use.consumers - 1]
    return replace(first, further=tuple(replace(e, return_conductance=first.return_conductance) for e in further))


def _moved(use: Use, force: float, stroke: float) -> Duty:
    times, positions = [0.0, WAY, 2.0 * WAY], [LOW, LOW + stroke, LOW]
    if use.share < 1.0:
        times, positions = [*times, 2.0 * WAY / use.share], [*positions, LOW]
    cycle = DutyCycle(times=tuple(times), positions=tuple(positions), forces=(-force,) * len(times))
    name = f"{force:g} N, {1e3 * stroke:g} mm, {100.0 * use.share:g} %"
    return sized_duty(name, "", "", cycle, *known_cylinder())


def uses() -> tuple[Use, ...]:
    """All that are tabulated."""
    return tuple(Use(f, s, n) for f in FORCES for s in SHARES for n in CONSUMERS)


def net_powers() -> Mapping[tuple[Use, str], float]:
    """Input minus recovered power of each circuit on each use, with the favourable pump [W]."""
    circuits = {each.name: each for each in CIRCUITS if each.name in NAMES}
    wanted: dict[tuple[str, str, int], tuple[RivalCircuit, Duty]] = {}
    needs: dict[tuple[Use, str], list[tuple[str, str, int]]] = {}
    for use in uses():
        duty = duty_of(use)
        for name, circuit in circuits.items():
            parts = (duty,) if circuit.shares else duty.alone
            keys = [(name, f"{each.name} {each.return_conductance:g}", len(each.further)) for each in parts]
            wanted |= {key: (circuit, each) for key, each in zip(keys, parts, strict=True)}
            needs[use, name] = keys

    def power(pair: tuple[RivalCircuit, Duty]) -> float:
        score = run_pair(*pair).score
        return math.nan if score is None else score.drawn - score.returned

    with ThreadPoolExecutor(2) as pool:
        found = dict(zip(wanted, pool.map(power, wanted.values()), strict=True))
    return {key: sum(found[each] for each in keys) for key, keys in needs.items()}


def with_drag(powers: Mapping[tuple[Use, str], float]) -> dict[tuple[Use, str], float]:
    """The same with pumps that drag as much as is usual [W]."""
    circuits, torque = {each.name: each for each in CIRCUITS}, pump_ends()["friction_torque"]
    return {(use, name): power + drag(circuits[name], duty_of(use), torque) for (use, name), power in powers.items()}


def least(powers: Mapping[tuple[Use, str], float], use: Use) -> str:
    """Which circuit draws least."""
    return min(NAMES, key=lambda name: powers[use, name])


def lines(powers: Mapping[tuple[Use, str], float]) -> Iterator[str]:
    """A row for each use: powers of all circuits with the favourable pump, which is the least with it and with one that
    drags, and how much more the switched machine draws than that."""
    dragged = with_drag(powers)
    verdicts = "least | switched / least | least with drag | switched / least"
    yield f"| force [kN] | moving | consumers | {' | '.join(NAMES)} | {verdicts} |"
    yield "|---" * (len(NAMES) + 7) + "|"
    for use in uses():
        cells = [short(powers[use, name]) for name in NAMES]
        best, other = least(powers, use), least(dragged, use)
        ratios = powers[use, SWITCHED] / powers[use, best], dragged[use, SWITCHED] / dragged[use, other]
        head = f"| {1e-3 * use.force:g} | {100.0 * use.share:g} % | {use.consumers} "
        yield f"{head}| {' | '.join(cells)} | {best} | {short(ratios[0])} | {other} | {short(ratios[1])} |"
    yield ""


def main() -> None:
    """Writes the table into the page."""
    powers = net_powers()
    PAGE.write_text(put(PAGE.read_text("utf-8"), BEGIN, END, lines(powers)), "utf-8")


if __name__ == "__main__":
    main()
