"""The headline of the README, with its ranges, is what its commands print."""

import re
from pathlib import Path

import pytest

import vvdp

README = (Path(__file__).parents[2] / "README.md").read_text("utf-8")
ROW = re.compile(r"^\| (?:as shipped|`--set (\w+)\.(\w+)=([^`]+)`).*? \| ([\d.]+) Hz \| ([\d.]+) % \|$", re.MULTILINE)
ROWS = ROW.findall(README)


def test_the_table_has_its_four_rows():
    assert len(ROWS) == 4


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[1] or "shipped")
def test_each_row_is_what_its_command_gives(row):
    table, key, value, frequency, efficiency = row
    run = vvdp.load("prototype", **({table: {key: value}} if table else {})).run()
    assert f"{run.number('pwm_frequency_Hz'):.1f}" == frequency
    assert f"{100.0 * run.number('efficiency'):.1f}" == efficiency


def test_the_ranges_are_those_of_the_table():
    frequencies, efficiencies = (sorted(float(row[place]) for row in ROWS) for place in (3, 4))
    text = " ".join(README.split())
    low, high = frequencies[0], frequencies[-1]
    assert f"from {low} to {high} Hz and from {efficiencies[0]} to {efficiencies[-1]} %" in text
