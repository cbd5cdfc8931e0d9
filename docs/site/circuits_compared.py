"""Writes the tables of the page about rival circuits. `python docs/site/circuits_compared.py`"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from circuit_sentences import NONE, flowed, load_sentences, rows_between, sentences, short, spread_sentences

from vvdp.base.display import with_unit
from vvdp.base.signal import Signal
from vvdp.comparison.circuit_result import FIGURES
from vvdp.comparison.circuit_trials import CircuitComparison, CircuitRun, compare_circuits, run_pair
from vvdp.comparison.equal_error import is_reached
from vvdp.machines.duties import Duty, shipped_duties
from vvdp.network.nodes import DrivenShaft
from vvdp.rivals.rival_account import system_for
from vvdp.rivals.rival_circuits import CIRCUITS, SINKS, RivalCircuit, with_value
from vvdp.systems.system import System, load_system

PAGE = Path(__file__).parents[1] / "circuits-compared.md"
BEGIN, END = "<!-- made by docs/site/circuits_compared.py -->\n", "<!-- to here -->\n"
LOADS_BEGIN, LOADS_END = "<!-- loads, made by docs/site/circuits_compared.py -->\n", "<!-- end of the loads -->\n"
LOADS = ("heavy", "two-loads", "three-loads")
"""Cycles of one, two and three cylinders."""
SPREAD_BEGIN, SPREAD_END = "<!-- spread, made by docs/site/circuits_compared.py -->\n", "<!-- end of the spread -->\n"
SPREAD = ("vvdp", "vvdp-slow", "throttle", "bleed-off", "constant-pressure", "load-sensing", "digital-pump")
OWN_RANGES = ("load-sensing", "digital-pump")
"""Circuits whose own values are spread; the others have the ranges of the pump of the first one."""
PUMP_LOSSES = ("leakage_conductance", "friction_torque")
"""Values of every pump."""
LESS_IS_DEAR = ("valve_conductance",)
"""Values of which the lower end costs more."""
SPREAD_DUTIES = ("triangle", "heavy")
"""Circuits whose assumed values are spread, and on what."""
ERROR = r"rms error of [\d.]+ mm"
"""Where the page has the error at which all are compared."""
SENTENCES_BEGIN = "<!-- sentences, made by docs/site/circuits_compared.py from the tables -->\n"
SENTENCES_END = "<!-- end of the sentences -->\n"
ASSUMED_BEGIN = "<!-- statements on what is assumed, made from its table -->\n"
ASSUMED_END = "<!-- end of the statements on what is assumed -->\n"
SAID_BEGIN = "<!-- statements on the loads, made from their table -->\n"
SAID_END = "<!-- end of the statements on loads -->\n"
CLOSE_BEGIN, CLOSE_END = "<!-- close, made by docs/site/circuits_compared.py -->\n", "<!-- end of close -->\n"
CLOSE, CLOSE_DUTY = 1e-3, "heavy"
"""An error below that at which all are compared [m], and the cycle on which it is asked for."""
SWAY_BEGIN, SWAY_END = "<!-- sway, made by docs/site/circuits_compared.py -->\n", "<!-- end of sway -->\n"
SWAYS_BEGIN = "<!-- statement on small changes, made from their table -->\n"
SWAYS_END = "<!-- end of the statement on small changes -->\n"
SWAY, SWAY_DUTIES = (0.9995, 0.9998, 1.0, 1.0002, 1.0005), ("heavy", "three-loads")
"""Shares of the poles before a loop, which move no delay by more than 0.1 ms, and the cycles that are run with them."""
FULL_SPEED = 60.0 * math.pi
"""Of a pump without a drive of its own: 1800 rpm [rad/s]."""
COLUMNS = (
    ("rms error [mm]", "tracking_error_rms_m", 1e3),
    ("largest", "tracking_error_max_m", 1e3),
    ("drawn [W]", "power_drawn_W", 1.0),
    ("returned", "power_returned_W", 1.0),
    ("delivered", "power_delivered_W", 1.0),
    ("received", "power_received_W", 1.0),
)
PRESSURES = (("highest [bar]", "pressure_max_Pa", 1e-5), ("lowest", "pressure_min_Pa", 1e-5))


def lost_in(found: CircuitComparison, duty: Duty) -> list[int]:
    """Places of the sinks in which any circuit loses power on a duty."""
    scores = [score for name in found.circuits if (score := found.score(duty.name, name))]
    return [place for place in range(len(SINKS)) if any(score.sinks[place] >= NONE for score in scores)]


Powers = Mapping[tuple[str, str], float]


def pump_ends() -> dict[str, float]:
    """The unfavourable end of leakage and friction torque of a pump, by its key."""
    found = load_system("load-sensing").uncertainties
    return {row.key: max(row.range) for row in found if row.key in PUMP_LOSSES and row.range}


def drag(circuit: RivalCircuit, duty: Duty, torque: float) -> float:
    """Power that a friction torque takes from the drives of all pumps of a circuit [W]: T omega, whatever they give.

    None beside the losses of a measured pump.
    """
    if circuit.measured:
        return 0.0
    parts = (duty,) if circuit.shares else duty.alone
    return torque * pump_speed(system_for(circuit, parts[0])) * len(parts)


def pump_speed(system: System) -> float:
    """Speed of the pump of a circuit [rad/s]; that of the others where it has no shaft."""
    network = system.circuit.network
    shaft, motor = network.nodes.get("pump_shaft"), network.parts.get("pump_motor")
    speed = motor.inputs["rated_speed"] if motor else shaft.speed if isinstance(shaft, DrivenShaft) else None
    return float(speed.extremes[0]) if isinstance(speed, Signal) else FULL_SPEED


def unfavourable(found: CircuitComparison) -> Powers:
    """What each circuit draws minus what it returns with the pump that loses the most, by cycle and circuit [W].

    Its loop is that of the run with the favourable pump. A measured pump is the same in both.
    """
    ends = pump_ends()

    def power(run: CircuitRun) -> float:
        circuit, duty = found.circuits[run.circuit], found.duties[run.duty]
        if circuit.measured:
            return run.tried[run.kept].power
        leaking = with_value(circuit, circuit.name, circuit.leakage, ends["leakage_conductance"])
        rate = run.tried[run.kept].filter_rate
        score = run_pair(leaking, duty, rate=rate, begins=run.begins).score
        if score is None:
            return math.nan
        return score.drawn - score.returned + drag(circuit, duty, ends["friction_torque"])

    with ThreadPoolExecutor(2) as pool:
        powers = pool.map(power, found.found)
        return {(run.duty, run.circuit): each for run, each in zip(found.found, powers, strict=True)}


def rows(found: CircuitComparison, duty: Duty, sinks: Sequence[int], dear: Powers) -> Iterator[str]:
    """A row for each circuit that was run on a duty, with some of its sinks."""
    for name in found.circuits:
        score = found.score(duty.name, name)
        if score is None:
            continue
        nets = [short(each) for each in (score.drawn - score.returned, dear[duty.name, name])]
        figures = [short(scale * FIGURES[key][2](score)) for _, key, scale in COLUMNS]
        figures = [*figures[:2], *nets, *figures[2:]]
        losses = [short(score.sinks[place]) for place in sinks]
        pressures = [short(scale * FIGURES[key][2](score)) for _, key, scale in PRESSURES]
        yield f"| `{name}` | {' | '.join([*figures, *losses, *pressures])} |"


NET = ("net, favourable pump [W]", "net, unfavourable pump [W]")
"""Heads of input minus recovered power."""


def table(found: CircuitComparison, duty: Duty, dear: Powers) -> Iterator[str]:
    """The table of a duty, with its load above."""
    sinks = lost_in(found, duty)
    lost = [SINKS[place].label for place in sinks]
    own = [head for head, _, _ in COLUMNS]
    heads = [*own[:2], *NET, *own[2:], *lost, *(head for head, _, _ in PRESSURES)]
    relief = 1e-5 * duty.relief_pressure
    yield f"**{duty.name}**: {duty.title}; {duty.load}; relief valves at {relief:.0f} bar"
    yield ""
    yield f"| circuit | {' | '.join(heads)} |"
    yield "|---" * (len(heads) + 1) + "|"
    yield from rows(found, duty, sinks, dear)
    yield ""


def ends(system: str) -> Iterator[tuple[str, str, float]]:
    """Each value of a system's pump with a range, at each end where it is not already: in words, its key."""
    for row in load_system(system).uncertainties:
        for end in row.range or ():
            if end != row.nominal:
                yield f"{row.key.replace('_', ' ')} {with_unit(end, row.kind)}", row.key, end


def spread_circuits() -> Iterator[RivalCircuit]:
    """The circuits of the spread, as shipped, with each value that they have at each end of its range, and with all at
    the end that costs more."""
    circuits = {each.name: each for each in CIRCUITS}
    for circuit in (circuits[name] for name in SPREAD):
        nominal = {row.setting: row.nominal for row in load_system(circuit.system).rows}
        dear, pump = circuit, circuit.leakage.rpartition(".")[0]
        yield circuit
        own = circuit.name in OWN_RANGES
        for words, key, value in ends(circuit.system if own else circuits[OWN_RANGES[0]].system):
            if key in PUMP_LOSSES or own:
                path = f"{pump}.{key}"
                yield with_value(circuit, f"{circuit.name}, {words}", path, value)
                if (value > nominal[path]) != (key in LESS_IS_DEAR):
                    dear = with_value(dear, f"{circuit.name}, all of these", path, value)
        yield dear


def drawn_table(found: CircuitComparison, duties: Sequence[str]) -> Iterator[str]:
    """What each circuit draws, less what it returns, on some duties."""
    yield f"| net [W] | {' | '.join(duties)} |"
    yield "|---" * (len(duties) + 1) + "|"
    for name in found.circuits:
        scores = [found.score(duty, name) for duty in duties]
        drawn = ["broke off" if score is None else short(score.drawn - score.returned) for score in scores]
        yield f"| {name} | {' | '.join(drawn)} |"
    yield ""


def close_table(found: CircuitComparison) -> Iterator[str]:
    """What each circuit draws at its own error, at the one at which all are compared, and at the closest to a small one
    that it reaches, with its poles."""
    duty = found.duties[CLOSE_DUTY]
    near = compared([duty], tuple(found.circuits.values()), CLOSE)
    wide = {run.circuit: run for run in found.found if run.duty == duty.name}
    yield "| circuit | rms error [mm] | net [W] | poles [1/s] | rms error | net | poles | rms error | net | reached |"
    yield "|---" * 10 + "|"
    for run in near.found:
        usual = wide[run.circuit]
        points = (usual.tried[0], usual.tried[usual.kept], run.tried[run.kept])
        cells = [short(1e3 * points[0].error), short(points[0].power)]
        for each in points[1:]:
            cells += [short(each.filter_rate), short(1e3 * each.error), short(each.power)]
        yield f"| `{run.circuit}` | {' | '.join(cells)} | {'yes' if is_reached(points[2].error, CLOSE) else 'no'} |"
    yield ""


def span(values: Sequence[float]) -> str:
    """The smallest and the largest of some values, in words."""
    return f"{short(min(values))} to {short(max(values))}"


def sway_table(found: CircuitComparison) -> Iterator[str]:
    """How far the numbers of each circuit move where the poles before its loop move by 0.05 % at most."""
    yield f"| circuit | {' | '.join(f'rms error [mm], {name} | net [W] | highest [bar]' for name in SWAY_DUTIES)} |"
    yield "|---" * (1 + 3 * len(SWAY_DUTIES)) + "|"
    for name in found.circuits:
        runs = [run for duty in SWAY_DUTIES for run in found.found if (run.duty, run.circuit) == (duty, name)]
        yield f"| `{name}` | {' | '.join(cell for run in runs for cell in sway(found, run))} |"
    yield ""


def sway(found: CircuitComparison, run: CircuitRun) -> tuple[str, str, str]:
    """Smallest and largest rms error, power and pressure of a run with slightly other poles."""
    circuit, duty, rate = found.circuits[run.circuit], found.duties[run.duty], run.tried[run.kept].filter_rate
    runs = [run_pair(circuit, duty, rate=share * rate, begins=run.begins) for share in SWAY]
    scores = [each.score for each in runs if each.score]
    errors = span([1e3 * each.tracking_rms for each in scores])
    powers = span([each.drawn - each.returned for each in scores])
    return errors, powers, span([1e-5 * each.pressure_max for each in scores])


WIDE = 0.01
"""A power that moves by more is named."""


def sway_sentence(page: str) -> str:
    """Which circuits the table of small changes shows to move, and by how much."""
    found = []
    for line in page.partition(SWAY_BEGIN)[2].partition(SWAY_END)[0].splitlines():
        name, *cells = [cell.strip() for cell in line.strip("| ").split(" | ")]
        for place, duty in enumerate(SWAY_DUTIES if name.startswith("`") else ()):
            error, power, pressure = cells[3 * place : 3 * place + 3]
            low, high = map(float, power.split(" to "))
            if high > (1.0 + WIDE) * low:
                found.append(f"{name} on {duty}: {power} W at {error} mm, with {pressure} bar at most")
    return f"The power of all others moves by less than 1 %. Not so {'; '.join(found)}. Its codes are whole numbers."


def compared(duties: Sequence[Duty], circuits: Sequence[RivalCircuit], error: float | None = None) -> CircuitComparison:
    """What is tabulated."""
    return compare_circuits(duties, circuits, error=error)


def put(page: str, begin: str, end: str, lines: Iterator[str]) -> str:
    """The page with `lines` between two marks."""
    text = "\n".join(lines)
    return re.sub(f"{re.escape(begin)}.*?{re.escape(end)}", lambda _: f"{begin}\n{text}\n{end}", page, flags=re.DOTALL)


def with_sentences(page: str) -> str:
    """The page with what its tables say."""
    page = put(page, SENTENCES_BEGIN, SENTENCES_END, sentences(page))
    loads, spread = rows_between(page, LOADS_BEGIN, LOADS_END), rows_between(page, SPREAD_BEGIN, SPREAD_END)
    page = put(page, SAID_BEGIN, SAID_END, iter(["\n\n".join(map(flowed, load_sentences(page, loads))), ""]))
    page = put(page, SWAYS_BEGIN, SWAYS_END, iter([sway_sentence(page), ""]))
    return put(page, ASSUMED_BEGIN, ASSUMED_END, iter([*map(flowed, spread_sentences(spread)), ""]))


def main(path: Path = PAGE) -> None:
    """Writes the tables into the page."""
    found = compared(shipped_duties(), CIRCUITS)
    assert found.error is not None
    dear, spread_duties = unfavourable(found), [each for each in shipped_duties() if each.name in SPREAD_DUTIES]
    spread = compared(spread_duties, tuple(spread_circuits()), found.error)
    page = path.read_text("utf-8") if path.exists() else PAGE.read_text("utf-8")
    page = re.sub(ERROR, f"rms error of {short(1e3 * found.error)} mm", page)
    page = put(page, BEGIN, END, (line for duty in found.duties.values() for line in table(found, duty, dear)))
    page = put(page, LOADS_BEGIN, LOADS_END, drawn_table(found, LOADS))
    page = put(page, SWAY_BEGIN, SWAY_END, sway_table(found))
    page = put(page, CLOSE_BEGIN, CLOSE_END, close_table(found))
    page = put(page, SPREAD_BEGIN, SPREAD_END, drawn_table(spread, SPREAD_DUTIES))
    path.write_text(with_sentences(page), "utf-8")


if __name__ == "__main__":
    main()
