"""Tables that a fit refuses, or warns of."""

import json

import pytest

from vvdp.base.errors import ConfigError
from vvdp.fitting.drop import COLUMNS
from vvdp.fitting.table import read_columns

FLOWS = [5.0 * k for k in range(1, 13)]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("flow [lpm],pressure_drop [bar]\n1," + "9" * 1_000_000 + "\n", ":2: is not a line of a table: field larger"),
        ("flow [lpm],pressure_drop [bar],diamter [mm]\n1,2,3\n", ":1: diamter [mm]: unknown column; did you mean 'dia"),
        ("flow [lpm],pressure_drop [bar]\n1,2\n1,5,2\n", ":3: 3 cells; must be at most 2, as there are headings"),
    ],
)  # fmt: skip
def test_a_damaged_table_is_refused(write, text, said):
    with pytest.raises(ConfigError) as refused:
        read_columns(write(text), COLUMNS)
    assert said in str(refused.value)


def test_other_columns_and_empty_cells_behind_are_left_out(write):
    found = read_columns(write("flow [lpm],pressure_drop [bar],note\n1,2,x,,\n"), COLUMNS)
    assert list(found) == ["flow", "pressure_drop"]


@pytest.mark.parametrize(("off", "warned"), [(1.0, False), (10.0, True)])
def test_points_that_scatter_far_are_warned_of(vvdp, write, tmp_path, off, warned):
    """One point ten times off: a scatter of more than 20 % that is nothing but this point."""
    drops = [0.01 * flow**1.9 * (off if k == 6 else 1.0) for k, flow in enumerate(FLOWS)]
    rows = "".join(f"{flow},{drop}\n" for flow, drop in zip(FLOWS, drops, strict=True))
    table, out = write("flow [lpm],pressure_drop [bar]\n" + rows), tmp_path / "out"
    answer = vvdp("fit", str(table), "--law", "drop", "--out", str(out), "--no-report", "--json")
    found = json.loads(answer.out)
    assert any("That is more than 20" in each for each in found["warnings"]) == warned
    assert (found["scatter"] > 0.2) == warned
