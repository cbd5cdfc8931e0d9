"""Assumed values in words, by the table in which they stand."""

from typing import Annotated

import numpy as np
import pytest

from vvdp.base import kinds
from vvdp.base.kinds import LENGTH, SpeedSignal
from vvdp.base.params import Params, without_effect
from vvdp.base.tables import Sourced, Table, build
from vvdp.hydraulics.friction import RodFriction
from vvdp.hydraulics.pump import Pump as PumpParams
from vvdp.hydraulics.spool_drive import SpoolDrive
from vvdp.hydraulics.volume import Vessel
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


def counted(**classes):
    """Settings that are counted, of classes with their tables, all values assumed."""
    rows = []
    for name, (cls, values) in classes.items():
        table = {key: {"value": value, "status": "assumed"} for key, value in values.items()}
        faults = []
        made, found = build(cls, table, name, Table("file", {name: table}, {}), faults)
        assert made is not None and not faults
        rows += found
    return {row.setting for row in assumed_rows(rows)}


PUMP = {"displacement": "10 cc/rev", "leakage_conductance": "0 m^3/(s*Pa)", "friction_torque": "0 N*m"}
VESSEL = {"oil_volume": "1 l", "hose_compliance": "0 1/Pa", "precharge_pressure": "5 bar", "gas_exponent": "1.3"}


def test_values_without_effect_are_not_counted():
    """A pump without ripple, a vessel without gas and a friction without a dry part have five of them."""

    def settings(ripple="0", gas="0 l", breakaway="0 N"):
        friction = {"viscous_friction": "10 N*s/m", "breakaway_friction": breakaway}
        return counted(
            pump=(PumpParams, PUMP | {"ripple_amplitude": ripple}),
            line=(Vessel, VESSEL | {"gas_volume": gas}),
            friction=(RodFriction, friction),
        )

    idle = {"pump.ripple_count", "line.precharge_pressure", "line.gas_exponent", "friction.stribeck_velocity",
            "friction.coulomb_velocity"}  # fmt: skip
    assert not settings() & idle
    assert settings("1 %", "0.1 l", "5 N") == settings() | idle
    assert settings(ripple="1 %") == settings() | {"pump.ripple_count"}
    assert settings(gas="0.1 l") == settings() | {"line.precharge_pressure", "line.gas_exponent"}
    assert settings(breakaway="5 N") == settings() | {"friction.stribeck_velocity", "friction.coulomb_velocity"}


class Comb(Params):
    """A component of one's own with keys of the library in another sense."""

    ripple_amplitude: kinds.Length
    ripple_count: kinds.Count


class Speeds(Params):
    """A value that another table makes idle."""

    motor: Annotated[SpeedSignal, without_effect("drive.coupling", "own")]
    own: kinds.Speed


def test_the_rule_belongs_to_the_class_and_not_to_the_key():
    assert counted(comb=(Comb, {"ripple_amplitude": "0 mm", "ripple_count": "9"})) == {
        "comb.ripple_amplitude",
        "comb.ripple_count",
    }


@pytest.mark.parametrize(("coupling", "own", "is_counted"), [("0", "0", False), ("1", "0", True), ("0", "1", True)])
def test_another_table_may_make_a_value_idle(coupling, own, is_counted):
    drive = (SpoolDrive, {"coupling": f"{coupling} N*m*s"})
    found = counted(speeds=(Speeds, {"motor": "5 rpm", "own": f"{own} rpm"}), drive=drive)
    assert ("speeds.motor" in found) == is_counted


@pytest.mark.parametrize("name", ["prototype", "cylinder-stops", "displacement-control"])
def test_values_that_are_not_counted_have_no_effect(name):
    """All of them are changed at once, by 10 %: no bit of the states differs, at the rows or at the end."""
    system = load_system(name, (), "0.1 s")
    values = {row.setting: row.nominal for row in system.rows}
    idle = [row for row in system.rows if is_idle(row, values)]
    assert idle
    assert name == "cylinder-stops" or "operation.spool_motor_speed" in {row.setting for row in idle}
    settings = [f"{row.setting}={1.1 * row.nominal or 10.0!r} {row.kind.unit}".removesuffix(" 1") for row in idle]
    other = load_system(name, settings, "0.1 s")
    assert all(a.nominal != b.nominal for a, b in zip(system.rows, other.rows, strict=True) if a in idle)
    one, two = (simulate(each.model, each.case, each.stepping) for each in (system, other))
    assert np.array_equal(one.times, two.times) and np.array_equal(one.states, two.states)
