"""Numbers that docs/models/displacement-chapter6.md spells out, worked out by the system that it describes."""

import re
from pathlib import Path

import numpy as np
import pytest
from tests.systems.chapter6_cases import (
    HEAVIEST,
    HEAVY,
    KNOWN,
    LEARNS_ALL,
    LEARNS_LOAD,
    LEARNS_MASS,
    NAME,
    OUT_OF_REACH,
    OVERRUNNING,
    PRINTED,
    SLOW,
    in_mode,
    learned,
    pressures,
    ran,
)

from vvdp.systems.system import load_system

TEXT = (Path(__file__).parents[2] / "docs" / "models" / "displacement-chapter6.md").read_text("utf-8")
PAGE = " ".join(TEXT.split())
GUARDED = ("pressure_bounds.lowest_pressure=3 bar",)
QUICK = ("pressure_bounds.lowest_pressure=6 bar", "pressure_bounds.transition_band=6 bar", "pump.lag=20 ms")
LIMITED = ("pressure_bounds.highest_pressure=36 bar", "pressure_bounds.transition_band=2 bar")
HIGHER = ("pressure_bounds.highest_pressure=68 bar", "pressure_bounds.transition_band=2 bar")
CASES = {
    "as shipped": (),
    "the law as printed": PRINTED,
    "pump twice as slow": ("pump.lag=0.1 s",),
    "mode 2 off": (*OVERRUNNING, *OUT_OF_REACH),
    "mode 2 on": (*OVERRUNNING, *GUARDED),
    "mode 2, quick pump, wide band": (*OVERRUNNING, *QUICK),
    "mode 3 off": (*SLOW, *OUT_OF_REACH),
    "mode 3 on": SLOW,
    "mode 4 off": (*HEAVY, *OUT_OF_REACH),
    "mode 4 on": (*HEAVY, *LIMITED),
    "mode 5 off": (*HEAVIEST, *OUT_OF_REACH),
    "mode 5 on": (*HEAVIEST, *HIGHER),
}
LEARNED = {
    "nothing": ({}, False),
    "load": (LEARNS_LOAD, False),
    "load and mass": (LEARNS_MASS, False),
    "load, mass and modulus": (LEARNS_ALL, False),
    "all known": ({}, True),
}


def here(name: str) -> list[str]:
    """The cells of a row that say what is found here."""
    (row,) = re.findall(rf"^\| {re.escape(name)} \|(.*)\|$", TEXT.split("## To run")[0], re.MULTILINE) or re.findall(
        rf"^\| {re.escape(name)} \|(.*)\|$", TEXT.split("## What is learned")[1], re.MULTILINE
    )
    return [cell.strip() for cell in row.split("|")][1::2]


@pytest.mark.sampled(4)
@pytest.mark.parametrize("name", CASES)
def test_cases_of_the_chapter(name):
    found, run = ran(*CASES[name], until="64 s" if "mode 3" in name else "16 s")
    assert here(name) == [
        f"{100.0 * found['tracking_error_max_m']:.3f}",
        f"{max(np.max(p) for p in pressures(run)):.1f}",
        f"{100.0 * found['below_tank_share']:.1f}",
        f"{found['directional_switches']:.0f}",
    ]


@pytest.mark.parametrize("name", LEARNED)
def test_what_is_learned(name):
    gains, known = LEARNED[name]
    rms, peak, run = learned(tuple(gains.items()), known)
    believed = run.command.control
    modulus = 1e-6 / run.final_memory["control"].adaptation.compliance
    assert here(name) == [
        f"{rms:.3f}",
        f"{peak:.3f}",
        f"{believed.load_force[-1]:.0f}",
        f"{believed.moving_mass[-1]:.0f}",
        f"{modulus:.0f}",
    ]


def test_every_row_is_worked_out():
    first = TEXT.split("| case | error |")[1].split("\n\n")[0].splitlines()[2:]
    second = TEXT.split("| learned |")[1].split("\n\n")[0].splitlines()[2:]
    for rows, known in ((first, CASES), (second, LEARNED)):
        assert [row.split(" | ")[0].removeprefix("| ") for row in rows] == [*known]


def test_words_on_the_page():
    found, _ = ran()
    assert f"root mean square is {100.0 * found['tracking_error_rms_m']:.4f} cm" in PAGE
    assert f"open by {100.0 * found['return_opening_mean']:.1f} % in the mean" in PAGE
    assert f"gives {6e4 * found['pump_flow_max_m3_s']:.2f} lpm at most" in PAGE
    fourth, fifth = ran(*HEAVY, *LIMITED)[0], ran(*HEAVIEST, *HIGHER)[0]
    assert f"mode 4 acts {100.0 * in_mode(fourth, 4):.1f} % of the time" in PAGE
    assert f"exceeded for {100.0 * fourth['mode_4_share']:.1f} %" in PAGE
    assert f"mode 5 acts {100.0 * in_mode(fifth, 5):.1f} %" in PAGE
    counted = ran("pump.counted_at_outlet=0")[0]
    changes = [100.0 * abs(counted[key] / found[key] - 1.0) for key in ("tracking_error_max_m", "pressure_max_Pa")]
    assert "the error changes by {:.1f} % and the highest pressure by {:.1f} %".format(*changes) in PAGE


def test_settings_of_the_page_are_those_of_the_cases():
    """Each row of the page's second table makes the case that the first one shows."""
    table = TEXT.split("| case | `--set` |")[1].split("\n\n")[0].splitlines()[2:]
    rows = dict(re.match(r"\| (.*?) \| (.*) \|", row).groups() for row in table)
    told = {name: [s.replace('"', "") for s in re.findall(r"`(\w+\.\w+=.*?)`", text)] for name, text in rows.items()}
    off = set(told["modes off"])
    assert off == set(OUT_OF_REACH)
    assert set(told["the law as printed"]) == set(PRINTED)
    for name, case in (
        ("pump twice as slow", "pump twice as slow"),
        ("mode 3", "mode 3 on"),
        ("mode 2", "mode 2 on"),
        ("mode 4", "mode 4 on"),
        ("mode 5", "mode 5 on"),
    ):
        known = load_system(NAME, CASES[case]).circuit.case
        shown = load_system(NAME, told[name]).circuit.case
        assert shown.settings == known.settings, name
        assert shown.state.chamber_a == pytest.approx(known.state.chamber_a, rel=1e-3)
        assert shown.state.chamber_b == pytest.approx(known.state.chamber_b, rel=1e-3)
    assert load_system(NAME, told["the load is learned"])


def test_what_is_known_is_the_truth():
    assert all(re.search(rf"{value.split()[0]}\b", PAGE) for value in KNOWN.values())
