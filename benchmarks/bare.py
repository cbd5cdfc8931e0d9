"""The compiled loop alone, without what `simulate` does around it."""

import numpy as np

from vvdp.simulation import loop
from vvdp.simulation.run import Prepared

ROWS = 512
"""Room for marks."""


def bare_run(
    ready: Prepared, until: float, record_times: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Final state, shape (n,), clock, and the states at `record_times` (none by default) of an explicit run."""
    times = np.zeros(0) if record_times is None else record_times
    n, clock, record = ready.state.size, np.zeros(loop.CLOCK), np.zeros((times.size, ready.state.size))
    y, u, memory = ready.state.copy(), ready.command.copy(), ready.memory.copy()
    clock[loop.STEP], clock[loop.METHOD] = 1e-6, loop.EXPLICIT
    status = loop.run(
        *ready.linked[:4],
        *(y, u, memory, ready.params, ready.settings, ready.atol, ready.rtol, ready.scale, clock),
        *(ready.active, 1e-3, until, 0.0, loop.ONLY_EXPLICIT, 1e300, 1),
        *(times, record, np.zeros((times.size, u.size))),
        *(np.zeros(ROWS), np.zeros((ROWS, n)), y.copy(), y.copy()),
    )
    assert status == loop.DONE
    return y, clock, record
