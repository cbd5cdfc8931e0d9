"""How far a rotary valve's spool moves along its axis: by its drive, by its helix, and as its solids allow."""

from collections.abc import Iterator, Mapping
from typing import Any, Protocol, runtime_checkable

import numpy as np

from vvdp.base.display import number, with_unit
from vvdp.base.errors import ConfigError, Fault
from vvdp.base.kinds import POSITION
from vvdp.base.params import Params
from vvdp.base.signal import Signal, signal_value
from vvdp.geometry.makeable import contradictions
from vvdp.geometry.shape import Travel, ValveShape, travel
from vvdp.network.network import Network
from vvdp.network.nodes import Connection, Source
from vvdp.simulation.values import flat, leaves
from vvdp.systems.extras import LoadedSystem
from vvdp.valve.geometry import transition_fraction
from vvdp.valve.rotary import RotaryValve

SLACK = 1e-3
"""Share of the helix length by which two travels may differ and still agree."""


@runtime_checkable
class Ends(Protocol):
    """Values of a component that ends the travel of what it moves [m]."""

    lower_end: float
    upper_end: float


def duty_travel(valve: RotaryValve) -> Travel:
    """Axial positions at which the duty ratio is 0 and 1 without a transition, -kappa L and (1 + kappa) L [m].

    Source  ours, docs/models/rotary-valve.md
    """
    kappa, L = transition_fraction(valve), valve.helix_length
    return Travel(-kappa * L, (1.0 + kappa) * L)


def helix_conflicts(stops: Travel, valve: RotaryValve) -> Iterator[str]:
    """Where end stops keep the spool from a duty ratio of 0 or 1, in sentences with numbers."""
    needed, slack = duty_travel(valve), SLACK * valve.helix_length
    why = f"; kappa is {number(transition_fraction(valve), 3)} of a helix of {_length(valve.helix_length)}"
    if stops.low > needed.low + slack:
        yield f"the spool stops at {_length(stops.low)}, duty ratio 0 needs {_length(needed.low)}{why}"
    if stops.high < needed.high - slack:
        yield f"the spool stops at {_length(stops.high)}, duty ratio 1 needs {_length(needed.high)}{why}"


def start_conflicts(stops: Travel, first: float | None, valve: RotaryValve) -> Iterator[str]:
    """Whether the spool starts beyond its end stops, in a sentence with numbers; `first` is where it starts [m]."""
    slack = SLACK * valve.helix_length
    if first is not None and not stops.low - slack <= first <= stops.high + slack:
        yield f"the spool starts at {_length(first)}, it goes from {_length(stops.low)} to {_length(stops.high)}"


def solid_conflicts(moved: Travel, valve: RotaryValve, shape: ValveShape) -> Iterator[str]:
    """Where a spool is let go further than its solids allow, in sentences with numbers."""
    allowed, slack = travel(shape, valve), SLACK * valve.helix_length
    half = max(moved.high / valve.helix_length - 0.5, 0.5 - moved.low / valve.helix_length)
    enough = float(np.ceil(200.0 * half - 1e-9) / 100.0)
    why = f"; geometry.stroke_ratio is {number(shape.stroke_ratio, 3)}, it takes {number(enough, 3)}"
    if moved.low < allowed.low - slack:
        yield f"the spool goes down to {_length(moved.low)}, its solids end at {_length(allowed.low)}{why}"
    if moved.high > allowed.high + slack:
        yield f"the spool goes up to {_length(moved.high)}, its solids end at {_length(allowed.high)}{why}"


def _length(position: float) -> str:
    return with_unit(position, POSITION)


def travel_warnings(system: LoadedSystem) -> Iterator[str]:
    """Where the axial drive of a system's spool, its helix and its solids contradict each other, in sentences.

    The drive's travel is that between its end stops. Solids are looked at where the file has a table [geometry], a
    prescribed position against them alone.
    """
    network, shape = system.circuit.network, system.shape
    valves = rotary_valves(network, system.tables)
    if len(valves) != 1:
        return
    stops = stop_travel(network)
    if stops is not None:
        yield from helix_conflicts(stops, valves[0])
        yield from start_conflicts(stops, first_position(system), valves[0])
    if shape is not None:
        moved = stops or prescribed_travel(network)
        yield from () if moved is None else solid_conflicts(moved, valves[0], shape)
        yield from (f"the valve cannot be made as a solid: {text}" for text in contradictions(shape, valves[0]))


def rotary_valves(network: Network, tables: Mapping[str, object]) -> list[RotaryValve]:
    """The rotary valves of a network, and those of its tables that no component has."""
    held: list[Params] = [value for part in network.parts.values() for value in part.values]
    return list(dict.fromkeys(each for each in (*held, *tables.values()) if isinstance(each, RotaryValve)))


def require_rotary_valve(system: LoadedSystem, verb: str) -> RotaryValve:
    """The rotary valve of a system. Raises ConfigError, which names `verb`, where it has none or several."""
    found = rotary_valves(system.circuit.network, system.tables)
    if len(found) != 1:
        message = f"`vvdp {verb}` needs a circuit with one rotary valve; this one has {len(found) or 'none'}"
        raise ConfigError([Fault(system.name, 0, "", message)])
    return found[0]


def stop_travel(network: Network) -> Travel | None:
    """The travel that the end stops of the spool leave [m]; None without any.

    They are on the rod that gives the valve its axial position, or in the drive that does; without a valve in the
    network the only ones that there are.
    """
    stops = {name: each for name in network.parts for each in network.parts[name].values if isinstance(each, Ends)}
    source = spool_source(network)
    moving = {path.partition(".")[0] for path in _paths(source)}
    own = [each for name, each in stops.items() if moving & {name, *network.parts[name].nodes.values()}]
    if source is None and len(stops) == 1:
        own = list(stops.values())
    return Travel(max(each.lower_end for each in own), min(each.upper_end for each in own)) if own else None


def spool_source(network: Network) -> Source | None:
    """Where a rotary valve's axial position comes from; None where there is no valve."""
    for part in network.parts.values():
        if "axial_position" in part.inputs and any(isinstance(value, RotaryValve) for value in part.values):
            return part.inputs["axial_position"]
    return None


def _paths(source: Source | None) -> list[str]:
    sources = source.sources if isinstance(source, Connection) else (source,)
    return [each for each in sources if isinstance(each, str)]


def prescribed_travel(network: Network) -> Travel | None:
    """Between which positions a prescribed spool stands over the run [m]; None where it is not prescribed."""
    return travel_of(spool_source(network))


def travel_of(source: Source | None) -> Travel | None:
    """Between which positions a source lies over the run [m]; None where it is not prescribed."""
    if source is None or _paths(source):
        return None
    ends = [_value(source, lambda each, end=end: each.extremes[end], {}) for end in (0, 1)]
    return Travel(min(ends), max(ends))


def first_position(system: LoadedSystem) -> float | None:
    """Where the spool of a system's rotary valve stands along its axis at first [m]; None where nothing says."""
    state = system.case.state
    known = dict(zip((path for path, _, _ in leaves(state)), flat(state).tolist(), strict=True))
    source = spool_source(system.circuit.network)
    if source is None or not known.keys() >= set(_paths(source)):
        return None
    return float(_value(source, lambda each: signal_value(0.0, each), known))


def _value(source: Any, of_signal: Any, known: Mapping[str, float]) -> Any:
    """The value of a source, with what is taken of its signals and what is `known` at its paths."""
    if isinstance(source, Signal):
        return of_signal(source)
    if isinstance(source, str):
        return known[source]
    if isinstance(source, Connection):
        return source.function(*(_value(each, of_signal, known) for each in source.sources))
    return source
