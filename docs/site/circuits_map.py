"""Writes the table of docs/circuits-compared.md on which circuit draws least, over load, duty and number of consumers.

`python docs/site/circuits_map.py`
"""

import math
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache
from typing import NamedTuple

from circuit_sentences import flowed
from circuits_compared import PAGE, drag, pump_ends, put, short

from vvdp.comparison.circuit_trials import run_pair
from vvdp.control.duty_cycle import DutyCycle
from vvdp.machines.duties import Duty, known_cylinder, sized_duty
from vvdp.rivals.rival_circuits import CIRCUITS, RivalCircuit

BEGIN, END = "<!-- map, made by docs/site/circuits_map.py -->\n", "<!-- end of the map -->\n"
FORCES = (2e3, 5e3, 10e3)
"""Of the first consumer, against extending [N]."""
SHARES = (1.0, 0.25)
"""Of the flow at which rods go their way in the shortest time."""
CONSUMERS = (1, 2, 3)
FURTHER = ((0.4, 0.1), (0.1, 0.06))
"""Of the second and third consumer: share of the first one's force, and stroke [m]."""
LOW, STROKE, WAY = 0.05, 0.216, 1.25
"""Where strokes begin, how far the first one goes, and how long either way takes at least [m, m, s]."""
NAMES = ("vvdp-slow", "throttle", "load-sensing", "independent-valves", "ideal-pump", "digital-pump", "four-valves")
SWITCHED = "vvdp-slow"
"""The switched machine; its pump turns as slowly as its valve still spins."""
SAID_BEGIN, SAID_END = "<!-- statements on the map, made from it -->\n", "<!-- end of the statements on the map -->\n"


class Use(NamedTuple):
    """A way to use circuits: force of the first consumer [N], share of the largest flow, consumers."""

    force: float
    share: float
    consumers: int


@cache
def duty_of(use: Use) -> Duty:
    """The duty of a use: out and back; all consumers have the throttle of the first, sized for the largest flow."""
    first = _moved(use, use.force, STROKE)
    conductance = first.return_conductance / use.share
    further = [_moved(use, ratio * use.force, stroke) for ratio, stroke in FURTHER][: use.consumers - 1]
    each = [replace(every, return_conductance=conductance) for every in (first, *further)]
    return replace(each[0], further=tuple(each[1:]))


def _moved(use: Use, force: float, stroke: float) -> Duty:
    way = WAY / use.share
    cycle = DutyCycle(times=(0.0, way, 2.0 * way), positions=(LOW, LOW + stroke, LOW), forces=(-force,) * 3)
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
    return {(use, name): power + drag_of(use, name) for (use, name), power in powers.items()}


@cache
def drag_of(use: Use, name: str) -> float:
    """Drag power of the pumps of a circuit in a use [W]."""
    (circuit,) = (each for each in CIRCUITS if each.name == name)
    return drag(circuit, duty_of(use), pump_ends()["friction_torque"])


def least(powers: Mapping[tuple[Use, str], float], use: Use) -> str:
    """Which circuit draws least."""
    return min(NAMES, key=lambda name: powers[use, name])


def lines(powers: Mapping[tuple[Use, str], float]) -> Iterator[str]:
    """A row for each use: powers of all circuits with the favourable pump, which is the least with it and with one that
    drags, and how much more the switched machine draws than that."""
    dragged = with_drag(powers)
    verdicts = "least | switched / least | least with drag | switched / least"
    yield f"| force [kN] | flow | consumers | {' | '.join(NAMES)} | {verdicts} |"
    yield "|---" * (len(NAMES) + 7) + "|"
    for use in uses():
        cells = [short(powers[use, name]) for name in NAMES]
        best, other = least(powers, use), least(dragged, use)
        ratios = powers[use, SWITCHED] / powers[use, best], dragged[use, SWITCHED] / dragged[use, other]
        head = f"| {1e-3 * use.force:g} | {100.0 * use.share:g} % | {use.consumers} "
        yield f"{head}| {' | '.join(cells)} | {best} | {short(ratios[0])} | {other} | {short(ratios[1])} |"
    yield ""


def kept_map(page: str) -> dict[Use, tuple[dict[str, float], list[str]]]:
    """The rows of the table on the page, by use: powers of all circuits [W], and the last four cells."""
    text, count = page.partition(BEGIN)[2].partition(END)[0], len(NAMES)
    cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.strip().splitlines()[2:]]
    return {
        Use(1e3 * float(row[0]), 0.01 * float(row[1].rstrip(" %")), int(row[2])): (
            dict(zip(NAMES, map(float, row[3 : 3 + count]), strict=True)),
            row[3 + count :],
        )
        for row in cells
    }


def with_said(page: str) -> str:
    """The page with what its map says."""
    kept = kept_map(page)

    favourable = {(use, name): power for use, (powers, _) in kept.items() for name, power in powers.items()}
    dragged = with_drag(favourable)

    def ratios(rival: str, found: Mapping[tuple[Use, str], float], several: bool) -> str:
        some = [found[use, SWITCHED] / found[use, rival] for use in kept if (use.consumers > 1) == several]
        return f"{min(some):.1f} to {max(some):.1f}"

    places = [[said[place] for _, said in kept.values()] for place in (0, 2)]
    same = sum(a == b for a, b in zip(*places, strict=True))
    first, other = (", ".join(f"`{name}` in {each.count(name)}" for name in NAMES if name in each) for each in places)
    wins = sum(each.count(SWITCHED) for each in places)
    text = f"""**Switching draws least in {wins} of {len(kept)} uses, with either pump.** The least power is drawn by
        {first} of them; if every pump drags, {other}. In {same} uses it is the same circuit with either pump;
        in all others it depends on the pump and on how many consumers share one. For one consumer the switched
        machine draws {ratios("load-sensing", favourable, False)} times what load sensing draws,
        {ratios("load-sensing", dragged, False)} times if every pump drags, since its own turns more slowly; for
        two and three, which have a machine each, {ratios("load-sensing", favourable, True)} and
        {ratios("load-sensing", dragged, True)} times. Compared with throttling it is
        {ratios("throttle", favourable, False)} and {ratios("throttle", favourable, True)} times, with a pump of
        enabled pistons for each consumer {ratios("digital-pump", favourable, False)} and
        {ratios("digital-pump", favourable, True)} times. **So switching
        is worth it in place of a throttled fixed pump, and for one consumer it comes close to load sensing
        where pumps drag.**"""
    return put(page, SAID_BEGIN, SAID_END, iter([flowed(text), ""]))


def main() -> None:
    """Writes the table into the page, and what it says."""
    powers = net_powers()
    PAGE.write_text(with_said(put(PAGE.read_text("utf-8"), BEGIN, END, lines(powers))), "utf-8")


if __name__ == "__main__":
    main()
