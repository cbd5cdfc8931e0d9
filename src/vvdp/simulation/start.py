"""The state at which a run begins: one number of a plausible size in each field."""

from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import RunError
from vvdp.base.kinds import NUMBER, PRESSURE_LEVEL, Kind
from vvdp.simulation.model import Case
from vvdp.simulation.values import leaves, names

LOWEST_START = 1e3
"""A pressure below this [Pa, absolute] at the start of a run was meant in another unit."""


def check_start(case: Case) -> None:
    """Raises RunError where the initial state is not one number of a plausible size in each field."""
    if not names(case.state):
        raise RunError(f"the state is {case.state!r}; expected a NamedTuple with a number in each field")
    for path, value, kind in leaves(case.state):
        if np.ndim(value):
            raise RunError(f"state {path!r} is an array; a state has one number for each field")
        if kind is None and not path.startswith("books.") and path.rpartition(".")[2] != "unused":
            raise RunError(
                f"state {path!r} has no kind; annotate it, for example `{path.rpartition('.')[2]}: Pressure`"
            )
        if kind is not None and (fault := kind.fault(float(value)) or _too_low(float(value), kind)):
            raise RunError(f"state {path!r} starts wrongly: {fault}")
    if hasattr(case.state, "books") and names(case.state)[-1] != "books":
        raise RunError("books must be the last field of the state")


def start_bounds(state: Any) -> tuple[Array, Array]:
    """Between which numbers, shape (n,) each, `check_start` has nothing against a state of this form."""
    kinds = [kind or NUMBER for _, _, kind in leaves(state)]
    low = [max(kind.low, LOWEST_START) if kind.name == PRESSURE_LEVEL.name else kind.low for kind in kinds]
    return np.array(low), np.array([kind.high for kind in kinds])


def _too_low(value: float, kind: Kind) -> str | None:
    if kind.name != PRESSURE_LEVEL.name or value >= LOWEST_START:
        return None
    return f"{value:g} Pa absolute is almost a vacuum; pressures are in Pa, absolute: was it meant in bar?"
