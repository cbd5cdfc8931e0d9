"""Writes the table of docs/circuits-compared.md with one measured pump in all circuits whose pump gives flow one way.

`python docs/site/circuits_measured.py`

The losses are those of `measured-pump`. At a constant speed its drag moves nothing but the power of the shaft, and is
linear in the rise of the pressure and in the setting, so that it follows from the means of a run with its slip.
"""

from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor

from circuit_sentences import flowed
from circuits_compared import PAGE, pump_speed, put, short

from vvdp.evaluation.summary import simulated_summary
from vvdp.hydraulics.ports import Medium
from vvdp.hydraulics.variable_machine import VariableMachine, drag_torque, slip_flow
from vvdp.machines.duties import Duty, shipped_duties
from vvdp.rivals.rival_account import begin_of, system_for
from vvdp.rivals.rival_circuits import CIRCUITS, RivalCircuit, with_value
from vvdp.simulation.outcome import outcome
from vvdp.simulation.run import simulate
from vvdp.systems.system import System, load_system

BEGIN, END = "<!-- measured, made by docs/site/circuits_measured.py -->\n", "<!-- end of measured -->\n"
SAID_BEGIN = "<!-- statement on the measured pump, made from its table -->\n"
SAID_END = "<!-- end of the statement on the measured pump -->\n"
NAMES = ("vvdp", "vvdp-slow", "throttle", "bleed-off", "constant-pressure", "load-sensing", "independent-valves")
NAMES += ("ideal-pump", "measured-pump")
DUTIES = ("triangle", "heavy", "digging")


def measured_pump() -> VariableMachine:
    """The pump whose losses are taken."""
    pump = load_system("measured-pump-control").circuit.network.parts["pump"].values[0]
    assert isinstance(pump, VariableMachine)
    return pump


def medium_of(system: System) -> Medium:
    """The oil of a system at 40 degC."""
    oil = system.circuit.network.oil
    return Medium(density=oil.density, viscosity=oil.density * oil.viscosity_40)


def with_slip(circuit: RivalCircuit) -> RivalCircuit:
    """A circuit whose pump leaks as the measured one does."""
    slip = slip_flow(1.0, medium_of(load_system(circuit.system)), measured_pump())
    return with_value(circuit, circuit.name, circuit.leakage, slip)


def net_power(circuit: RivalCircuit, duty: Duty) -> float:
    """What the drive of the pump gives on a duty with the measured pump, at the common reference [W]."""
    leaking = circuit if circuit.measured else with_slip(circuit)
    begin = begin_of(leaking, duty)
    system = system_for(leaking, duty, begin)
    found = simulated_summary(outcome(simulate(system.model, system.case, system.stepping)), system)
    nodes, speed, pump = system.circuit.network.parts["pump"].nodes, pump_speed(system), measured_pump()
    drawn = float(found["power_pump_shaft_W" if "shaft" in nodes else "power_pump_W"])
    if circuit.measured:
        return drawn
    rise = float(found[f"pressure_mean_{nodes.get('outlet', nodes.get('b'))}_Pa"])
    flow = float(found["flow_mean_pump_m3_s"]) + float(found.get("flow_mean_pump_leakage_m3_s", 0.0))
    return drawn + drag_torque(speed, rise, flow / (pump.displacement * speed), medium_of(system), pump) * speed


def net_powers() -> Mapping[tuple[str, str], float]:
    """What every circuit draws on every duty [W]."""
    circuits = [each for name in NAMES for each in CIRCUITS if each.name == name]
    duties = [each for name in DUTIES for each in shipped_duties() if each.name == name]
    pairs = [(circuit, duty) for circuit in circuits for duty in duties]
    with ThreadPoolExecutor(2) as pool:
        powers = pool.map(lambda pair: net_power(*pair), pairs)
        return {(c.name, d.name): power for (c, d), power in zip(pairs, powers, strict=True)}


def lines(powers: Mapping[tuple[str, str], float]) -> Iterator[str]:
    """A row for each circuit."""
    yield f"| net, measured pump [W] | {' | '.join(DUTIES)} |"
    yield "|---" * (len(DUTIES) + 1) + "|"
    for name in NAMES:
        yield f"| `{name}` | {' | '.join(short(powers[name, duty]) for duty in DUTIES)} |"
    yield ""


def kept_powers(page: str) -> dict[str, list[float]]:
    """The rows of the table on the page [W], by circuit."""
    text = page.partition(BEGIN)[2].partition(END)[0]
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.strip().splitlines()[2:]]
    return {row[0].strip("`"): [float(cell) for cell in row[1:]] for row in rows}


def with_said(page: str) -> str:
    """The page with what its table says."""
    kept = kept_powers(page)

    def over(a: str, b: str) -> str:
        return "{}, {} and {}".format(*(f"{x / y:.1f}" for x, y in zip(kept[a], kept[b], strict=True)))

    text = f"""With one measured pump for all, the VVDP draws {over("vvdp", "load-sensing")} times what load sensing
        draws on triangle, heavy and digging, with two thirds of the pump's speed
        {over("vvdp-slow", "load-sensing")} times, and throttling {over("throttle", "vvdp")} times what the VVDP
        draws."""
    return put(page, SAID_BEGIN, SAID_END, iter([flowed(text), ""]))


def main() -> None:
    """Writes the table into the page, and what it says."""
    powers = net_powers()
    PAGE.write_text(with_said(put(PAGE.read_text("utf-8"), BEGIN, END, lines(powers))), "utf-8")


if __name__ == "__main__":
    main()
