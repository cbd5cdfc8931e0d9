"""The compiled loop alone, without what `simulate` does around it."""

import numpy as np

from vvdp.simulation import loop, places
from vvdp.simulation.loops import compiled_loop
from vvdp.simulation.prepare import Prepared, start_run
from vvdp.simulation.stepping import Method, Stepping

ROWS = 512
"""Room for marks."""


def bare_run(
    ready: Prepared, until: float, record_times: np.ndarray | None = None, method: Method = Method.AUTOMATIC
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Final state, shape (n,), clock, and the states at `record_times` (none by default) of a run."""
    times = np.zeros(0) if record_times is None else record_times
    reached = start_run(ready, Stepping(until=until, method=method))
    n, y, clock = reached.state.size, reached.state, reached.clock
    record = np.zeros((times.size, n))
    workbench = loop.workbench(ready.plan, n, ready.width.size, ready.pattern)
    status = compiled_loop().run(
        *ready.linked[:4],
        *(*reached[:3], ready.vectors.params, ready.plan, *reached[3:]),
        *(ready.atol, ready.rtol, ready.scale, ready.floor, ready.width, ready.pattern, workbench),
        *(until, 1e6, 0.0, method.value, 1e300, 1),
        *(times, record, np.zeros((times.size, reached.command.size)), np.zeros((times.size, reached.memory.size))),
        *(np.zeros(ROWS), np.zeros((ROWS, n)), np.zeros(0), np.zeros((0, n)), y.copy(), y.copy()),
    )
    assert status == places.DONE
    return y, clock, record
