"""Axial drives that do not do what is asked: they wait at their stop, or their supply does not reach so far.

Source  ours, docs/models/axial-control.md
"""

import itertools
import math
from collections.abc import Iterator, Mapping
from typing import Any

from vvdp.base.kinds import DURATION, POSITION
from vvdp.base.signal import Signal
from vvdp.network.network import Network, ProgramPart
from vvdp.network.nodes import Source
from vvdp.programs.arithmetic import product_step, table_step
from vvdp.programs.axial_stages import HOME, LEARN, AxialSequence, Stage
from vvdp.programs.chamber_laws import ChamberLaw
from vvdp.programs.chamber_report import static_reach_of
from vvdp.programs.report import origin
from vvdp.simulation.outcome import Outcome
from vvdp.systems.bound import Bound
from vvdp.systems.extras import LoadedSystem
from vvdp.systems.spool_travel import stop_travel

PATIENCE = 2.0
"""Multiple of the time for homing and learning after which control counts as never begun [1]; assumed."""


def sequences(network: Network) -> dict[str, AxialSequence]:
    """The programs of a network that home and learn before they control a drive, and how long they do."""
    settings = {name: program.settings for name, program in network.programs.items()}
    found = {name: getattr(getattr(each, "loop", each), "sequence", None) for name, each in settings.items()}
    return {name: each for name, each in found.items() if isinstance(each, AxialSequence)}


def stage_of(memory: Any) -> Stage | None:
    """The stage in a program's memory, however deep; None without one."""
    if isinstance(memory, Stage):
        return memory
    parts = memory if isinstance(memory, tuple) else ()
    return next((found for found in map(stage_of, parts) if found is not None), None)


def waiting_numbers(run: Outcome, system: LoadedSystem) -> dict[str, float]:
    """How long each drive waited that is not controlled at the end of a run, by key; none that may still begin."""
    found = {}
    for name, sequence in sequences(system.circuit.network).items():
        stage = stage_of(run.memory.get(name))
        if stage is not None and stage.number in (HOME, LEARN) and run.end > patience(sequence):
            found[f"uncontrolled_time_{name}_s"] = run.end
    return found


def waiting_bounds(system: LoadedSystem, found: Mapping[str, float | bool]) -> Iterator[Bound]:
    """The bounds of these times."""
    for name, sequence in sequences(system.circuit.network).items():
        if waited := found.get(f"uncontrolled_time_{name}_s"):
            yield Bound(
                label=f"time in which {name.replace('_', ' ')} did not control its drive",
                kind=DURATION,
                low=waited,
                high=waited,
                most=patience(sequence),
                otherwise="control never began: the spool was not at its stop for home_time, or its angle was not "
                "known for learn_time in all",
            )


def reach_bounds(system: LoadedSystem) -> Iterator[Bound]:
    """The bounds of the highest positions that are asked of drives of a spool: a chamber's supply, at its lowest, has
    to hold the spring there, and the drive has to go so far."""
    network = system.circuit.network
    travel = stop_travel(network)
    for name, program in network.programs.items():
        settings, wanted = program.settings, program.reads.get("reference")
        if wanted is None or (ends := range_asked(network, wanted)) is None:
            continue
        asked = ends[1]
        limits = {}
        if isinstance(settings, ChamberLaw):
            words = "the pilot supply does not hold the spool there against the spring"
            limits[words] = static_reach_of(settings.drive)
        if travel is not None and program.type.report is not None:
            limits["the drive ends there"] = travel.high
        for words, most in limits.items():
            yield Bound(
                label=f"position that is asked of {name.replace('_', ' ')}",
                kind=POSITION,
                low=asked,
                high=asked,
                most=most,
                otherwise=words,
            )


def range_asked(network: Network, source: Source) -> tuple[float, float] | None:
    """The lowest and highest value of a reference; None unless it consists of signals and products of them, which may
    pass through filters and limits, or a program limits it itself (`command_range` of its settings). A factor may have
    either sign, so each end of a product is that of a pair of ends.
    """
    if isinstance(source, Signal):
        return source.extremes
    program, field = origin(network, source)
    if program is None or program.type.step is table_step:
        return None
    limited = getattr(program.settings, "command_range", {}).get(field, (-math.inf, math.inf))
    low, high = _followed_range(network, program) or (-math.inf, math.inf)
    found = min(max(low, limited[0]), limited[1]), max(min(high, limited[1]), limited[0])
    return found if all(map(math.isfinite, found)) else None


def _followed_range(network: Network, program: ProgramPart) -> tuple[float, float] | None:
    """The range of a command that passes on what a program reads, or the product of it; None of any other."""
    followed = [program.reads["reads"]] if "reads" in program.reads else [*program.reads.values()]
    if len(followed) > 1 and program.type.step is not product_step:
        return None
    ranges = [found for each in followed if (found := range_asked(network, each)) is not None]
    if not ranges or len(ranges) < len(followed):
        return None
    ends = [math.prod(pair) for pair in itertools.product(*ranges)]
    return min(ends), max(ends)


def patience(sequence: AxialSequence) -> float:
    """From how long a wait on control never begins [s]."""
    return PATIENCE * (sequence.home_time + sequence.learn_time)
