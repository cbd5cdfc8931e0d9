"""Values drawn from their whole ranges: nothing impossible is shown without a word, nothing hangs without one.

Before the gate 111 of 3004 such variations had an impossible efficiency, most of them without a warning that said so.
"""

import math

import numpy as np
import pytest

from vvdp.base.errors import ConfigError, RunError
from vvdp.base.signal import Signal
from vvdp.evaluation.bench import rotary_bench
from vvdp.evaluation.overview import warnings
from vvdp.evaluation.summary import summary
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system

BENCHES = ("prototype", "prototype-constant-load")
LEFT_ALONE = {"run", "encoder", "spool_filter", "limits"}
ENOUGH = 150
"""Portions of 2000 evaluations after which a run is stopped."""
DECADES = 12.0
"""Over so many a value is drawn where its range begins at zero."""
SHARES = ("cavitation_port_share", "mean_load_opening")


def drawn(rng, row) -> str:
    """A setting that gives the value of `row` a number from anywhere in its range, or up to ten times off."""
    low, high = max(row.kind.low, -1e6), min(row.kind.high, 1e9)
    nominal = row.value.base if isinstance(row.value, Signal) else row.value
    how = rng.random()
    if how < 0.4 and nominal:
        value = float(np.clip(nominal * 10.0 ** rng.uniform(-1.0, 1.0), low, high))
    elif low >= 0.0 and how < 0.9:
        least = max(low, high * 10.0**-DECADES)
        value = float(10.0 ** rng.uniform(np.log10(least), np.log10(high)))
    else:
        value = float(rng.choice([low, high, rng.uniform(low, high)]))
    unit = "" if row.kind.unit == "1" else f" {'bara' if row.kind.name == 'pressure level' else row.kind.unit}"
    value = value * 1e-5 if unit == " bara" else value
    return f"{row.table}.{row.key}={value!r}{unit}"


def impossible(found, reference) -> list[str]:
    """Numbers that no machine has; pressures are gauge, against a `reference` [Pa]."""
    told = []
    if not (math.isnan(found["efficiency"]) or 0.0 <= found["efficiency"] <= 1.0):
        told.append("efficiency")
    told += [key for key in SHARES if not -1e-9 <= found[key] <= 1.0 + 1e-9]
    told += [key for key, value in found.items() if key.startswith("pressure_min_") and value < -reference - 1.0]
    return told


def doubtful(found) -> list[str]:
    """Numbers that want a word beside them."""
    told = [key for key in ("efficiency", "loss_transition_W") if math.isnan(found[key])]
    told += [key for key in ("pwm_frequency_Hz",) if found[key] > 2e3]
    told += [key for key in ("trusted", "settled") if not found[key]]
    return told


def variation(seed: int) -> str:
    """What became of a variation: refused, failed, stopped or ran. Fails where a number stands without a word."""
    rng = np.random.default_rng([20261122, seed])
    name = BENCHES[seed % 2]
    rows = [row for row in load_system(name).rows if row.table not in LEFT_ALONE and row.kind is not None]
    chosen = rng.choice(len(rows), size=1 if seed % 3 else int(rng.integers(2, 6)), replace=False)
    settings = [drawn(rng, rows[place]) for place in chosen]
    try:
        system = load_system(name, settings, until="0.1 s")
    except ConfigError:
        return "refused"
    portions = iter(range(ENOUGH))
    try:
        run = simulate(
            system.model, system.case, system.stepping, stop=lambda: next(portions, None) is None, portion=2000.0
        )
    except RunError:
        return "failed"
    if not run.end > 0.0:
        return "stopped"
    found = summary(system, run)
    said = list(warnings(system, found))
    assert impossible(found, rotary_bench(system, "test").reference) == [], (name, settings)
    assert said or doubtful(found) == [], (name, settings, doubtful(found))
    return "ran" if run.finished else "stopped"


def tally(seeds) -> dict[str, int]:
    ends = [variation(seed) for seed in seeds]
    return {end: ends.count(end) for end in sorted(set(ends))}


@pytest.mark.thorough
def test_100_random_variations_show_nothing_impossible():
    found = tally(range(100))
    assert found["ran"] > 50, found


@pytest.mark.slow
@pytest.mark.parametrize("part", range(9))
def test_3000_random_variations_show_nothing_impossible(part):
    found = tally(range(300 * (part + 1), 300 * (part + 2)))
    assert found["ran"] > 150, found
