"""Assumed values in words, by the table in which they stand."""

import numpy as np
import pytest

from vvdp.base.kinds import LENGTH
from vvdp.base.tables import Sourced
from vvdp.simulation.run import simulate
from vvdp.systems.assumed import assumed_rows, assumed_words, is_idle
from vvdp.systems.system import load_system


def rows(counts):
    return [
        Sourced(table, f"key_{n}", 1.0, LENGTH, "assumed", note=note)
        for (table, note), count in counts.items()
        for n in range(count)
    ]


@pytest.mark.parametrize(
    ("counts", "words"),
    [
        ({}, "no assumed values"),
        (
            {("oil", "default"): 16, ("components.load", "default"): 1},
            "17 assumed values: 16 of the default oil, 1 of load",
        ),
        ({("oil", "a data sheet"): 1}, "1 assumed value: 1 of the oil"),
        (
            {("components.a", ""): 4, ("components.b", ""): 3, ("nodes.c", ""): 2, ("initial", ""): 1},
            "10 assumed values: 4 of a, 3 of b, 2 of c, 1 of initial",
        ),
        (
            {("pilot_oil", "default"): 5, ("a", ""): 4, ("b", ""): 3, ("c", ""): 2, ("d", ""): 1},
            "15 assumed values: 5 of the default pilot oil, 4 of a, 3 of b, 3 of 2 other tables",
        ),
    ],
)
def test_values_are_counted_by_their_table(counts, words):
    assert assumed_words(rows(counts)) == words


def test_values_without_effect_are_not_counted():
    """A pump without ripple, a vessel without gas and a friction without a dry part have five of them."""
    text = {
        "pump": {"ripple_amplitude": 0.0, "ripple_count": 9.0},
        "line": {"gas_volume": 0.0, "precharge_pressure": 5e5, "gas_exponent": 1.3},
        "friction": {"coulomb_friction": 0.0, "breakaway_friction": 0.0, "stribeck_velocity": 0.02,
                     "coulomb_velocity": 1e-3},
    }  # fmt: skip

    def counted(**changed):
        rows = [
            Sourced(table, key, changed.get(key, value), LENGTH, "assumed")
            for table, values in text.items()
            for key, value in values.items()
        ]
        return [row.setting for row in assumed_rows(rows)]

    assert counted() == ["pump.ripple_amplitude", "line.gas_volume", "friction.coulomb_friction",
                         "friction.breakaway_friction"]  # fmt: skip
    assert "pump.ripple_count" in counted(ripple_amplitude=0.01) and "line.gas_exponent" in counted(gas_volume=1e-3)
    assert len(counted(breakaway_friction=10.0)) == 6


@pytest.mark.parametrize("name", ["prototype", "cylinder-stops", "displacement-control"])
def test_values_that_are_not_counted_have_no_effect(name):
    """All of them are changed at once, by 10 %: no bit of the states differs, at the rows or at the end."""
    system = load_system(name, (), "0.1 s")
    values = {row.setting: row.nominal for row in system.rows}
    idle = [row for row in system.rows if is_idle(row, values) and row.nominal > 0.0]
    assert idle
    settings = [f"{row.setting}={1.1 * row.nominal!r} {row.kind.unit}".removesuffix(" 1") for row in idle]
    other = load_system(name, settings, "0.1 s")
    assert all(a.nominal != b.nominal for a, b in zip(system.rows, other.rows, strict=True) if a in idle)
    one, two = (simulate(each.model, each.case, each.stepping) for each in (system, other))
    assert np.array_equal(one.times, two.times) and np.array_equal(one.states, two.states)
