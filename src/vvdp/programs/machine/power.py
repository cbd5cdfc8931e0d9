"""Mean powers of the whole machine over a time, from its energy balance.

Source  ours, docs/models/whole-machine.md
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.simulation.run import Run
from vvdp.simulation.values import leaves

PARTS: Mapping[str, tuple[str, tuple[str, ...]]] = MappingProxyType(
    {
        "pump_power_mean_W": ("power of the pump", ("supplied.pump_shaft",)),
        "full_open_loss_mean_W": (
            "lost in the rotary valve fully open",
            ("spent.valve.nozzle", "spent.valve.centre_section", "spent.valve.outlet_turbine"),
        ),
        "transition_loss_mean_W": ("lost in transitions, throttling", ("totals.transition_meter_power",)),
        "relief_loss_mean_W": ("lost over the relief valve", ("spent.relief_valve",)),
        "leakage_loss_mean_W": (
            "lost by leakage of pump, rotary valve and cylinder",
            ("spent.pump.leakage", "spent.valve.leakage", "spent.cylinder"),
        ),
        "directional_loss_mean_W": ("lost over the directional valve", ("spent.directional_valve.edges",)),
        "return_loss_mean_W": ("lost over the return valve", ("spent.directional_valve.return_throttle",)),
        "friction_loss_mean_W": ("lost by friction of the cylinder", ("spent.friction", "spent.end_stops")),
        "dump_loss_mean_W": ("lost over the dump valve", ("spent.dump_valve",)),
        "spool_friction_mean_W": ("friction of the spool, within the valve's loss", ("spent.valve.spool_friction",)),
        "axial_power_mean_W": (
            "power of the axial drive",
            ("supplied.pilot_supply", "supplied.pilot_tank", "supplied.gerotor"),
        ),
        "load_power_mean_W": ("power that the load gives; negative: takes", ("supplied.load_force",)),
        "actuator_power_mean_W": ("power of the oil on the rod while it drives", ("totals.actuator_meter_power",)),
        "ideal_pump_power_mean_W": (
            "power of an ideal variable pump, the same run",
            ("totals.supply_meter_power",),
        ),
    }
)
"""Label of each mean power, and the books that it is the sum of; those that a machine has not are left out."""

SHARES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "actuator_share": ("actuator power over pump power", "actuator_power_mean_W"),
        "ideal_pump_share": ("ideal pump's power over pump power", "ideal_pump_power_mean_W"),
    }
)
"""Label of each share of the pump power, and whose it is."""


def whole_periods(run: Run, begin: float, period: float) -> tuple[float, float]:
    """The longest time from `begin` on [s] that a run has recorded and that is a whole number of periods [s].

    Raises ParameterError where there is none.
    """
    count = np.floor((run.end - begin) / period + 1e-9)
    if count < 1.0:
        raise ParameterError(f"the run ends at {run.end:g} s; a whole period from {begin:g} s on takes {period:g} s")
    return begin, begin + float(count) * period


def mean_powers(run: Run, begin: float, end: float) -> dict[str, float]:
    """Mean powers and their shares between the recorded rows next to two times [s].

    The powers of pump, losses and load are those of the books, so that they add up to the stored energy of the oil.
    """
    rows = [int(np.argmin(np.abs(run.times - time))) for time in (begin, end)]
    duration = float(run.times[rows[1]] - run.times[rows[0]])
    books: dict[str, Any] = {path: column for path, column, _ in leaves(run.state.books)}

    def mean(paths: tuple[str, ...]) -> float:
        return sum(float(books[path][rows[1]] - books[path][rows[0]]) for path in paths if path in books) / duration

    found: dict[str, float] = {key: mean(paths) for key, (_, paths) in PARTS.items() if books.keys() & {*paths}}
    found["full_open_loss_mean_W"] -= found["transition_loss_mean_W"]
    pump = found["pump_power_mean_W"]
    return found | {key: found[of] / pump if pump > 0.0 else np.nan for key, (_, of) in SHARES.items()}
