"""Writes the tables of the page about rival circuits. `python docs/site/circuits_compared.py`"""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from vvdp.comparison.circuit_result import FIGURES
from vvdp.comparison.circuit_trials import CircuitComparison, compare_circuits
from vvdp.systems.displacement.duties import Duty, shipped_duties
from vvdp.systems.displacement.rival_circuits import CIRCUITS, SINKS, RivalCircuit

PAGE = Path(__file__).parents[1] / "circuits-compared.md"
BEGIN, END = "<!-- made by docs/site/circuits_compared.py -->\n", "<!-- to here -->\n"
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
    if abs(value) < 0.005:
        return "0"
    text = f"{value:.3g}"
    return f"{float(text):.0f}" if "e" in text or abs(value) >= 1000.0 else text


def rows(found: CircuitComparison, duty: Duty) -> Iterator[str]:
    """A row for each circuit that was run on a duty."""
    for name in found.circuits:
        score = found.score(duty.name, name)
        if score is None:
            continue
        figures = [short(scale * FIGURES[key][2](score)) for _, key, scale in COLUMNS]
        pressures = [short(scale * FIGURES[key][2](score)) for _, key, scale in PRESSURES]
        yield f"| `{name}` | {' | '.join([*figures, *map(short, score.sinks), *pressures])} |"


def table(found: CircuitComparison, duty: Duty) -> Iterator[str]:
    """The table of a duty, with its load above."""
    heads = [*(head for head, _, _ in COLUMNS), *(sink.label for sink in SINKS), *(head for head, _, _ in PRESSURES)]
    relief = 1e-5 * duty.relief_pressure
    yield f"**{duty.name}**: {duty.title}; {duty.load}; relief valves at {relief:.0f} bar"
    yield ""
    yield f"| circuit | {' | '.join(heads)} |"
    yield "|---" * (len(heads) + 1) + "|"
    yield from rows(found, duty)
    yield ""


def compared(duties: Sequence[Duty], circuits: Sequence[RivalCircuit]) -> CircuitComparison:
    """What is tabulated."""
    return compare_circuits(duties, circuits)


def main(path: Path = PAGE) -> None:
    """Writes the tables into the page."""
    found = compared(shipped_duties(), CIRCUITS)
    text = "\n".join(line for duty in found.duties.values() for line in table(found, duty))
    page = path.read_text("utf-8") if path.exists() else PAGE.read_text("utf-8")
    pattern = re.compile(f"{re.escape(BEGIN)}.*{re.escape(END)}", re.DOTALL)
    path.write_text(pattern.sub(lambda _: f"{BEGIN}\n{text}\n{END}", page), "utf-8")


if __name__ == "__main__":
    main()
