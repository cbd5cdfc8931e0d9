"""The heat balance of a run and the temperatures of its volumes."""

from collections.abc import Iterator, Mapping

import numpy as np

from vvdp.base.kinds import MEAN_POWER, RATIO, TEMPERATURE, Kind
from vvdp.network.heat import TOTALS, warm_volumes
from vvdp.simulation.outcome import Outcome
from vvdp.simulation.run import Run
from vvdp.simulation.values import as_value, flat
from vvdp.systems.bound import Bound
from vvdp.systems.extras import LoadedSystem

COLDEST, HOTTEST = 258.15, 373.15
"""Oil temperatures [K] between which two points of a data sheet give the viscosity: from -15 degC, at which DIN 51524
has an oil of ISO VG 46 still flow, to 100 degC, the upper point itself."""


def heat_numbers(run: Outcome, system: LoadedSystem) -> dict[str, float]:
    """Mean powers of the heat balance, and what is missing in it over the whole run; empty without one."""
    volumes = warm_volumes(system.circuit.network)
    if not volumes:
        return {}
    window = run.window
    means = as_value(run.case.state, (window.last - window.first) / (window.end - window.begin))
    whole = as_value(run.case.state, run.final - flat(run.case.state))
    found = {f"{name}_W": float(getattr(means.books.totals, name)) for name in TOTALS}
    losses, outside, walls = (float(getattr(whole.books.totals, name)) for name in TOTALS)
    stored = sum(float(getattr(whole, f"{name}_heat")) for name in volumes)
    throughput = abs(losses) + abs(outside) + abs(walls) + abs(stored)
    found["heat_stored_W"] = sum(float(getattr(means, f"{name}_heat")) for name in volumes)
    found["heat_residual"] = (losses - outside - walls - stored) / throughput if throughput else 0.0
    return found


def temperature_numbers(system: LoadedSystem, run: Run) -> dict[str, float]:
    """The lowest and the highest temperature of each volume over the records of a run, by key."""
    return {
        f"temperature_{which}_{name}_K": float(extreme(getattr(run.outputs, f"{name}_temperature")))
        for name in warm_volumes(system.circuit.network)
        for which, extreme in (("min", np.min), ("max", np.max))
    }


def heat_quantities(system: LoadedSystem) -> Iterator[tuple[str, tuple[Kind, str]]]:
    """Kinds and labels of these numbers."""
    volumes = warm_volumes(system.circuit.network)
    for name in volumes:
        for which, label in (("min", "lowest"), ("max", "highest")):
            yield f"temperature_{which}_{name}_K", (TEMPERATURE, f"{name.replace('_', ' ')} temperature, {label}")
    if volumes:
        yield "heat_losses_W", (MEAN_POWER, "heat of losses in oil")
        yield "heat_outside_W", (MEAN_POWER, "heat carried to tanks and sources")
        yield "heat_walls_W", (MEAN_POWER, "heat through walls and coolers")
        yield "heat_stored_W", (MEAN_POWER, "heat stored in oil")
        yield "heat_residual", (RATIO, "heat residual, of the throughput")


def temperature_bounds(system: LoadedSystem, found: Mapping[str, float | bool]) -> Iterator[Bound]:
    """The bounds of the temperature of each volume of which a run shows it."""
    for name in warm_volumes(system.circuit.network):
        if f"temperature_max_{name}_K" in found:
            yield Bound(
                label=f"oil temperature in {name.replace('_', ' ')}",
                kind=TEMPERATURE,
                low=float(found[f"temperature_min_{name}_K"]),
                high=float(found[f"temperature_max_{name}_K"]),
                least=COLDEST,
                most=HOTTEST,
                otherwise="the data sheet does not show the viscosity there",
            )
