"""Writes tables and pictures of the page about when switching is worth it. `python docs/site/when_switching_pays.py`"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from vvdp.comparison.circuit_result import FIGURES
from vvdp.comparison.circuit_trials import CircuitComparison, compare_circuits
from vvdp.machines.duties import Duty, known_cylinder, read_duty, sized_duty
from vvdp.report.plot import new_figure
from vvdp.rivals.claim import Claim
from vvdp.rivals.linear_valve_claim import linear_valve_claim
from vvdp.rivals.rival_circuits import CIRCUITS
from vvdp.rivals.supply_claim import WAYS, supply_claim
from vvdp.rivals.supply_ways import RIVALS
from vvdp.steady.test_stand import Stand, stand
from vvdp.systems.system import load_system

DOCS = Path(__file__).parents[1]
PAGE = DOCS / "when-switching-pays.md"
MACHINES = {"excavator-arm": "Excavator arm", "injection-moulding": "Injection moulding", "test-stand": "Test rig"}
"""Files of the cycles, and what a person calls the machine."""
SHARES = (0.7, 1.0, 1.3)
"""Forces and times of a cycle over those of the file."""
SIMULATED = (
    "throttle",
    "flow-control-unit",
    "linear-valves",
    "ideal-pump",
    "four-valves",
)
"""Circuits that are simulated on the cycles."""


def machines() -> list[Duty]:
    """The duty cycles of the machines."""
    moved = known_cylinder()
    return [read_duty(DOCS / "cycles" / f"{name}.csv", *moved) for name in MACHINES]


def scaled(duty: Duty, forces: float, times: float) -> Duty:
    """A duty cycle with its forces and times scaled, and sized anew."""
    cycle = replace(
        duty.cycle,
        forces=tuple(forces * each for each in duty.cycle.forces),
        times=tuple(times * each for each in duty.cycle.times),
    )
    return sized_duty(duty.name, duty.title, duty.load, cycle, *known_cylinder())


def bench() -> Stand:
    """The prototype on its stand."""
    return stand(load_system("prototype"))


def watts(value: float) -> str:
    """A power with three digits."""
    return f"{float(f'{value:.3g}'):.0f}" if abs(value) >= 10.0 else f"{value:.2g}"


def share_rows(claim: Claim) -> Iterator[str]:
    """For each rival the share of the map that the PWM valve wins, with its spread."""
    yield "| rival | won over it | at worst | at best |"
    yield "|---|---|---|---|"
    for key, name in RIVALS.items():
        shares = [claim.numbers[f"won_over_{key}{ending}"].value for ending in ("", "_low", "_high")]
        yield f"| {name} | {' | '.join(f'{100.0 * each:.0f} %' for each in shares)} |"


def loss_rows(claim: Claim) -> Iterator[str]:
    """For each machine the mean loss of every way, the least in bold, and its lead on the PWM valve."""
    table = claim.tables["duty_cycles"]
    names = [MACHINES[name] for name in table["cycle"]]
    yield f"| mean loss [W] | {' | '.join(names)} |"
    yield "|---" * (len(names) + 1) + "|"
    least = [min(float(table[f"loss_{key}_W"][row]) for key in WAYS) for row in range(table.rows)]
    for key, name in WAYS.items():
        values = [float(each) for each in table[f"loss_{key}_W"]]
        cells = [f"**{watts(v)}**" if v == low else watts(v) for v, low in zip(values, least, strict=True)]
        yield f"| {name} | {' | '.join(cells)} |"


def lead_rows(claim: Claim) -> Iterator[str]:
    """For each machine by how much the PWM valve loses more or less than each rival, lowest and highest."""
    table = claim.tables["duty_cycles"]
    yield f"| the rival loses more by [W] | {' | '.join(MACHINES[name] for name in table['cycle'])} |"
    yield "|---" * (table.rows + 1) + "|"
    for key, name in RIVALS.items():
        ends = zip(table[f"gain_over_{key}_low_W"], table[f"gain_over_{key}_high_W"], strict=True)
        yield f"| {name} | {' | '.join(f'{watts(low)} to {watts(high)}' for low, high in ends)} |"


def circuit_rows(found: CircuitComparison) -> Iterator[str]:
    """For each circuit what it draws on each machine, less what it gives back, and its largest error."""
    heads = [f"{MACHINES[name]} [W] | error [mm]" for name in found.duties]
    yield f"| circuit | {' | '.join(heads)} |"
    yield "|---" * (2 * len(heads) + 1) + "|"
    for circuit in found.circuits:
        scores = [found.score(duty, circuit) for duty in found.duties]
        cells = ["–| –" if s is None else _drawn(s) for s in scores]
        yield f"| `{circuit}` | {' | '.join(cells)} |"


def _drawn(score: object) -> str:
    drawn, returned, error = (
        FIGURES[key][2](score)  # type: ignore[arg-type]
        for key in ("power_drawn_W", "power_returned_W", "tracking_error_max_m")
    )
    return f"{watts(drawn - returned)} | {1e3 * error:.2g}"


def valve_rows(claim: Claim) -> Iterator[str]:
    """For each published linear valve whose drop is known, how many it takes and what they lose."""
    table = claim.tables["linear_valves"]
    yield "| valve | flow [lpm] at [bar] | switches in [ms] | full strokes up to [Hz] | side by side | loss [W] | as much at [Hz] |"  # noqa: E501
    yield "|---" * 7 + "|"
    for row in range(table.rows):
        flow, drop, time = (float(table[key][row]) for key in ("rated_flow_m3_s", "rated_drop_Pa", "switching_time_s"))
        told = f"{flow * 6e4:.3g}" if flow == flow else "–"
        told += f" at {drop * 1e-5:.3g}" if drop == drop else " at –"
        cells = [table["valve"][row], told, f"{1e3 * time:.3g}", watts(float(table["highest_pwm_frequency_Hz"][row]))]
        for key in ("parallel_valves", "loss_W", "equal_loss_pwm_frequency_Hz"):
            value = float(table[key][row])
            cells.append(watts(value) if value >= 100.0 else f"{value:.3g}" if value == value else "–")
        yield f"| {' | '.join(cells)} |"


def replaced(text: str, name: str, rows: Iterator[str]) -> str:
    """The text of the page with one of its tables written anew."""
    begin, end = f"<!-- {name}: made by docs/site/when_switching_pays.py -->\n", "<!-- to here -->\n"
    pattern = re.compile(f"{re.escape(begin)}.*?{re.escape(end)}", re.DOTALL)
    assert pattern.search(text), name
    return pattern.sub(lambda _: f"{begin}\n" + "\n".join(rows) + f"\n\n{end}", text, count=1)


def tables(claim: Claim, valves: Claim, found: CircuitComparison) -> Mapping[str, Iterator[str]]:
    """The tables of the page by name."""
    return {
        "shares": share_rows(claim),
        "losses": loss_rows(claim),
        "leads": lead_rows(claim),
        "circuits": circuit_rows(found),
        "valves": valve_rows(valves),
    }


def draw(claim: Claim, valves: Claim, folder: Path) -> None:
    """Writes the pictures of both claims as PNG."""
    for each in (claim, valves):
        for chart in each.charts:
            new_figure(chart, each.tables).savefig(folder / f"{chart.name}.png", dpi=110)


def compared(duties: Sequence[Duty]) -> CircuitComparison:
    """What is tabulated of the simulated circuits."""
    known = {each.name: each for each in CIRCUITS}
    return compare_circuits(duties, [known[name] for name in SIMULATED])


def main(path: Path = PAGE, images: Path = DOCS / "images") -> None:
    """Writes tables and pictures."""
    held, duties = bench(), machines()
    claim, valves, found = supply_claim(held, duties), linear_valve_claim(held), compared(duties)
    text = PAGE.read_text("utf-8")
    for name, rows in tables(claim, valves, found).items():
        text = replaced(text, name, rows)
    path.write_text(text, "utf-8")
    draw(claim, valves, images)


if __name__ == "__main__":
    main()
