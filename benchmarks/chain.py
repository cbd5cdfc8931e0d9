"""What a step costs as a chain of states grows: a hose in pieces, by either method."""

import time
from dataclasses import replace

from benchmarks.measure import report, run_as_command
from vvdp.simulation.run import Method, Stepping, simulate
from vvdp.systems.system import System, load_system

PIECES = (8, 32, 128)
ROUNDS = 3
MOST = 1.3
"""Times as long a step may take, over the growth in states."""


def step_time(system: System, stepping: Stepping, rounds: int) -> float:
    """Processor time of a step [s], the least of some runs."""
    simulate(system.model, system.case, stepping)
    found = []
    for _ in range(rounds):
        began = time.process_time()
        run = simulate(system.model, system.case, stepping)
        found.append((time.process_time() - began) / (run.steps + run.rejected))
    return min(found)


def main(short: bool) -> None:
    """Hoses of more and more pieces."""
    sizes, rounds = (PIECES[:1], 1) if short else (PIECES, ROUNDS)
    times: dict[Method, list[tuple[int, float]]] = {Method.EXPLICIT: [], Method.STIFF: []}
    for pieces in sizes:
        system = load_system("long-hose", [f"components.hose.pieces={pieces}"], until="0.1 s")
        states = len(system.case.state) - 1
        for method, found in times.items():
            found.append((states, step_time(system, replace(system.stepping, method=method, window=1e-3), rounds)))
    for method, found in times.items():
        figures = ", ".join(f"{seconds * 1e6:.0f} us at {states}" for states, seconds in found)
        (few, first), (many, last) = found[0], found[-1]
        growth = (last / first) / (many / few)
        met = () if short else (f"{MOST:g} times the growth in states", growth <= MOST)
        report(
            f"one {method.name.lower()} step by states", f"{figures}; {growth:.2f} times the growth", *met, listed=True
        )


if __name__ == "__main__":
    run_as_command(main)
