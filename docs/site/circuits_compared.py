"""Writes the tables of the page about rival circuits. `python docs/site/circuits_compared.py`"""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from vvdp.base.display import with_unit
from vvdp.comparison.circuit_result import FIGURES
from vvdp.comparison.circuit_trials import CircuitComparison, compare_circuits
from vvdp.systems.displacement.duties import Duty, shipped_duties
from vvdp.systems.displacement.rival_circuits import CIRCUITS, SINKS, RivalCircuit, with_value
from vvdp.systems.system import load_system

PAGE = Path(__file__).parents[1] / "circuits-compared.md"
BEGIN, END = "<!-- made by docs/site/circuits_compared.py -->\n", "<!-- to here -->\n"
LOADS_BEGIN, LOADS_END = "<!-- loads, made by docs/site/circuits_compared.py -->\n", "<!-- end of the loads -->\n"
LOADS = ("heavy", "two-loads", "three-loads")
"""Cycles of one, two and three cylinders."""
SPREAD_BEGIN, SPREAD_END = "<!-- spread, made by docs/site/circuits_compared.py -->\n", "<!-- end of the spread -->\n"
SPREAD = ("vvdp", "vvdp-slow", "throttle", "bleed-off", "constant-pressure", "load-sensing")
SPREAD_DUTIES = ("triangle", "heavy")
"""Circuits whose assumed values are spread, and on what."""
LEAST = 0.005
"""A power below which nothing is lost [W]."""
COLUMNS = (
    ("error [mm]", "tracking_error_max_m", 1e3),
    ("drawn [W]", "power_drawn_W", 1.0),
    ("returned", "power_returned_W", 1.0),
    ("delivered", "power_delivered_W", 1.0),
    ("received", "power_received_W", 1.0),
)
PRESSURES = (("highest [bar]", "pressure_max_Pa", 1e-5), ("lowest", "pressure_min_Pa", 1e-5))


def short(value: float) -> str:
    """A value with three digits, none for what is less than a hundredth."""
    if abs(value) < LEAST:
        return "0"
    text = f"{value:.3g}"
    return f"{float(text):.0f}" if "e" in text or abs(value) >= 1000.0 else text


def lost_in(found: CircuitComparison, duty: Duty) -> list[int]:
    """Places of the sinks in which any circuit loses power on a duty."""
    scores = [score for name in found.circuits if (score := found.score(duty.name, name))]
    return [place for place in range(len(SINKS)) if any(score.sinks[place] >= LEAST for score in scores)]


def rows(found: CircuitComparison, duty: Duty, sinks: Sequence[int]) -> Iterator[str]:
    """A row for each circuit that was run on a duty, with some of its sinks."""
    for name in found.circuits:
        score = found.score(duty.name, name)
        if score is None:
            continue
        figures = [short(scale * FIGURES[key][2](score)) for _, key, scale in COLUMNS]
        losses = [short(score.sinks[place]) for place in sinks]
        pressures = [short(scale * FIGURES[key][2](score)) for _, key, scale in PRESSURES]
        yield f"| `{name}` | {' | '.join([*figures, *losses, *pressures])} |"


def table(found: CircuitComparison, duty: Duty) -> Iterator[str]:
    """The table of a duty, with its load above."""
    sinks = lost_in(found, duty)
    lost = [SINKS[place].label for place in sinks]
    heads = [*(head for head, _, _ in COLUMNS), *lost, *(head for head, _, _ in PRESSURES)]
    relief = 1e-5 * duty.relief_pressure
    yield f"**{duty.name}**: {duty.title}; {duty.load}; relief valves at {relief:.0f} bar"
    yield ""
    yield f"| circuit | {' | '.join(heads)} |"
    yield "|---" * (len(heads) + 1) + "|"
    yield from rows(found, duty, sinks)
    yield ""


def ends() -> Iterator[tuple[str, str, str, float]]:
    """Each value of load sensing with a range, at each end where it is not already: in words, and where it goes."""
    for row in load_system("load-sensing").uncertainties:
        for end in row.range or ():
            if end != row.nominal:
                yield f"{row.key.replace('_', ' ')} {with_unit(end, row.kind)}", row.table, row.key, end


def spread_circuits() -> Iterator[RivalCircuit]:
    """The circuits of the spread, as shipped, with each value that they have at each end of its range, and with all at
    the end that costs more."""
    for circuit in (each for each in CIRCUITS if each.name in SPREAD):
        tables, dear = load_system(circuit.system).tables, circuit
        yield circuit
        for words, table, field, value in ends():
            if table == "pump" or circuit.name == "load-sensing":
                yield with_value(circuit, f"{circuit.name}, {words}", table, field, value)
                if value > getattr(tables[table], field):
                    dear = with_value(dear, f"{circuit.name}, all of these", table, field, value)
        yield dear


def drawn_table(found: CircuitComparison, duties: Sequence[str]) -> Iterator[str]:
    """What each circuit draws, less what it returns, on some duties."""
    yield f"| drawn [W] | {' | '.join(duties)} |"
    yield "|---" * (len(duties) + 1) + "|"
    for name in found.circuits:
        scores = [found.score(duty, name) for duty in duties]
        drawn = ["broke off" if score is None else short(score.drawn - score.returned) for score in scores]
        yield f"| {name} | {' | '.join(drawn)} |"
    yield ""


def compared(duties: Sequence[Duty], circuits: Sequence[RivalCircuit]) -> CircuitComparison:
    """What is tabulated."""
    return compare_circuits(duties, circuits)


def put(page: str, begin: str, end: str, lines: Iterator[str]) -> str:
    """The page with `lines` between two marks."""
    text = "\n".join(lines)
    return re.sub(f"{re.escape(begin)}.*?{re.escape(end)}", lambda _: f"{begin}\n{text}\n{end}", page, flags=re.DOTALL)


def main(path: Path = PAGE) -> None:
    """Writes the tables into the page."""
    found = compared(shipped_duties(), CIRCUITS)
    spread = compared([each for each in shipped_duties() if each.name in SPREAD_DUTIES], tuple(spread_circuits()))
    page = path.read_text("utf-8") if path.exists() else PAGE.read_text("utf-8")
    page = put(page, BEGIN, END, (line for duty in found.duties.values() for line in table(found, duty)))
    page = put(page, LOADS_BEGIN, LOADS_END, drawn_table(found, LOADS))
    path.write_text(put(page, SPREAD_BEGIN, SPREAD_END, drawn_table(spread, SPREAD_DUTIES)), "utf-8")


if __name__ == "__main__":
    main()
