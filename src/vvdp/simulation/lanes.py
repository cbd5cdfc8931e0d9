"""Whether the cases of a model can run side by side in the lanes of a vector, and the arrays in which they do."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from vvdp.base.arrays import Array
from vvdp.base.signal import Signal
from vvdp.simulation import places
from vvdp.simulation.assembly import Assembly
from vvdp.simulation.case_rows import CaseRows
from vvdp.simulation.crew import Crew
from vvdp.simulation.layout import SIGNAL_SLOTS, blocks, members
from vvdp.simulation.link import default_cache, quiet
from vvdp.simulation.loops import compiled_lane_loop
from vvdp.simulation.model import Case, Model
from vvdp.simulation.parts import events_part, signals_part
from vvdp.simulation.prepare import Prepared
from vvdp.simulation.stepping import Method, Stepping
from vvdp.simulation.symbols import Op, Untraceable
from vvdp.simulation.trace import trace


class SideBySide(NamedTuple):
    """Code of a model for all lanes."""

    run: Any  # the loop for many cases at once
    rates: int  # its address
    events: int  # its address
    signals: Any  # signals(t, p, s)
    places: tuple[int, ...]  # of each signal in the parameters
    commands: tuple[int, ...]  # the places of those that the rates and events read
    reads: int  # how many of the parameters they may read


def side_by_side(model: Model, case: Case, digest: str, say: Callable[[str], None] = quiet) -> SideBySide | str:
    """The code of the model of this `digest`, or why it has none."""
    if digest not in _known:
        try:
            _known[digest] = _compile(model, case, say)
        except Untraceable as problem:
            _known[digest] = str(problem)
    return _known[digest]


_known: dict[str, SideBySide | str] = {}


def _compile(model: Model, case: Case, say: Callable[[str], None]) -> SideBySide:
    from vvdp.simulation.lane_code import lane_rates

    rates, events = trace(model, case), trace(model, case, events_part)
    if events.signals > rates.signals:
        raise Untraceable("the settings of a program with a trigger have signals")
    found, place = [], 0
    for _, leaf in members(case.params, ""):
        if isinstance(leaf, Signal):
            found.append(place)
            place += SIGNAL_SLOTS
        else:
            place += 1
    return SideBySide(
        run=compiled_lane_loop(say),
        rates=lane_rates(rates).address,
        events=lane_rates(events).address,
        signals=Assembly([signals_part(case)]).load(default_cache(), say)["signals"],
        places=tuple(found),
        commands=tuple(sorted({int(n.number) for g in (rates, events) for n in g.nodes if n.op is Op.COMMAND})),
        reads=blocks(case).tail,
    )


def run_lanes(code: SideBySide, ready: Prepared, stepping: Stepping, rows: CaseRows, crew: Crew) -> None:
    """Runs the cases of these rows, all changed in place; one that is to be run by itself keeps the status HANDED."""
    from vvdp.simulation import loop

    rows.moving[:] = (rows.params[:, [place + 1 for place in code.places]] > 0.0).any(axis=1)
    rules = _rules(code, ready, stepping)

    def work(queue: npt.NDArray[np.int64]) -> None:
        bench = loop.workbench(ready.plan, ready.vectors.state.size, ready.width.size, ready.pattern)
        code.run(
            *(code.rates, code.events, code.signals, *ready.linked[:4]),
            *(rows, rules, _room(code, ready), bench, queue),
        )

    crew.carry_out(work)


def _rules(code: SideBySide, ready: Prepared, stepping: Stepping) -> Any:
    from vvdp.simulation import lane_loop
    from vvdp.simulation.landing import GRAIN
    from vvdp.simulation.lane_vectors import WIDTH, Rules

    active, positions = ready.pattern.group.size, ready.width.size
    grain = np.zeros(positions)
    grain[positions - _modes(ready) :] = GRAIN
    return Rules(
        plan=ready.plan,
        atol=np.repeat(ready.atol[:active], WIDTH),
        rtol=np.repeat(ready.rtol[:active], WIDTH),
        width=ready.width,
        grain=grain,
        floor=ready.floor[:active],
        t_end=stepping.until,
        longest=stepping.longest_step,
        marks_from=stepping.means_from(stepping.until),
        span_times=stepping.span_times,
        reads=np.array(code.commands, np.int64),
        stiff_from=lane_loop.STIFF_FOR_GOOD if stepping.method is Method.AUTOMATIC else np.inf,
    )


def _modes(ready: Prepared) -> int:
    return int(ready.plan[0, places.LAST] - ready.plan[0, places.FIRST])


def _room(code: SideBySide, ready: Prepared) -> Any:
    from vvdp.simulation.lane_vectors import OWN, WIDTH, Lanes

    n, active, positions = ready.vectors.state.size, ready.pattern.group.size, ready.width.size
    width, signals = WIDTH, len(code.places)

    def rows(count: int) -> Array:
        return np.zeros(count * width)

    return Lanes(
        y=rows(n),
        trial=rows(n),
        nothing=rows(n),
        error=rows(active),
        lean=rows(active),
        turned=rows(active),
        low=rows(active),
        high=rows(active),
        k=np.zeros((7, (n + _modes(ready)) * width)),
        u=rows(ready.vectors.command.size),
        p=rows(code.reads),
        s=rows(signals),
        x=rows(positions),
        time=rows(1),
        stage=rows(1),
        h=rows(1),
        one=np.ones(width),
        values=np.zeros(signals),
        command=np.zeros(len(code.commands)),
        own=np.zeros((width, OWN)),
        before=np.zeros((width, positions)),
        reached=np.zeros((width, positions)),
        held=np.zeros((width, positions)),
        tried=np.zeros((width, positions)),
        case=np.full(width, -1, np.int64),
    )
