"""What a program around vvdp waits for: other threads, a stop from outside, the numbers of a run."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from itertools import pairwise
from statistics import median

from benchmarks.measure import ROUNDS, interleaved, report, run_as_command, spread
from vvdp.evaluation.summary import closed_forms, run_summary
from vvdp.simulation.batch import simulate_batch
from vvdp.simulation.crew import Crew, never
from vvdp.simulation.run import simulate
from vvdp.systems.system import System, load_system

SILENCE, STOPPED, SIMULATED = 0.04, 0.01, 5e-3
TICK = 1e-3


@contextmanager
def ticking() -> Iterator[list[float]]:
    """Times at which another thread was awake, while the block goes on; it sleeps for a millisecond in between."""
    awake, end = [time.perf_counter()], threading.Event()

    def tick() -> None:
        while not end.is_set():
            time.sleep(TICK)
            awake.append(time.perf_counter())

    thread = threading.Thread(target=tick)
    thread.start()
    try:
        yield awake
    finally:
        end.set()
        thread.join()


def silence(work: Callable[[], object]) -> float:
    """The longest time [s] for which another thread is not heard while `work` goes on."""
    with ticking() as awake:
        work()
    return max(later - earlier for earlier, later in pairwise(awake))


def until_it_ends(work: Callable[[Callable[[], bool]], object], after: float) -> float:
    """How long [s] `work` goes on after its `stop` could say so, some time [s] after its beginning."""
    wanted, told = threading.Event(), [0.0]

    def stop() -> None:
        told[0] = time.perf_counter()
        wanted.set()

    timer = threading.Timer(after, stop)
    timer.start()
    work(wanted.is_set)
    ended = time.perf_counter()
    timer.join()
    return ended - told[0]


def summaries(system: System, rounds: int) -> None:
    """Tells how long the part of a summary that the run gives takes, and the closed forms beside it."""
    run = simulate(system.model, system.case, system.stepping)
    found = run_summary(system, run)
    parts = {
        "summary, simulated": partial(run_summary, system, run),
        "closed forms": partial(closed_forms, system, found),
    }
    times = interleaved(parts, rounds)
    target = f"{1e3 * SIMULATED:g} ms", median(times["summary, simulated"]) < SIMULATED
    report("summary, simulated part", spread(times["summary, simulated"], "ms", 1e3), *target)
    report("summary, closed forms", spread(times["closed forms"], "ms", 1e3), listed=True)


def main(short: bool) -> None:
    """By the clock on the wall, since others wait."""
    rounds, after = (1, 0.02) if short else (ROUNDS, 0.2)
    system = load_system("prototype", until="1 s" if short else "60 s")
    model, case, stepping = system.model, system.case, system.stepping
    brief = load_system("prototype", until="10 ms")
    simulate(brief.model, brief.case, brief.stepping)  # compiled before the clock starts
    simulate_batch(brief.model, [brief.case], brief.stepping)
    run = partial(simulate, model, case, stepping)

    def batch(stop: Callable[[], bool] = never, *, lanes: bool = True) -> None:
        simulate_batch(model, [case] * 20, stepping, Crew(stop=stop), lanes=lanes)

    found = [silence(run) for _ in range(rounds)]
    report("another thread, silent for at most", spread(found, "ms", 1e3), "40 ms", median(found) < SILENCE)
    for name, work in (("run", run), ("batch in lanes", batch), ("batch one by one", partial(batch, lanes=False))):
        ends = [until_it_ends(lambda stop, work=work: work(stop=stop), after) for _ in range(rounds)]
        report(f"{name}, from stop to its end", spread(ends, "ms", 1e3), "10 ms", median(ends) < STOPPED)
    summaries(load_system("prototype", until="0.5 s"), rounds)


if __name__ == "__main__":
    run_as_command(main)
