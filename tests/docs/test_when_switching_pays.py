"""The tables of docs/when-switching-pays.md are those that its script writes, and its statements hold."""

import re

import pytest

from vvdp.rivals.supply_claim import cycle_losses, supply_claim


@pytest.fixture
def pays():
    import when_switching_pays

    return when_switching_pays


def kept(pays, name):
    """The rows of a table of the page."""
    part = pays.PAGE.read_text("utf-8").partition(f"<!-- {name}: made by")[2].partition("<!-- to here -->")[0]
    return [line for line in part.splitlines() if line.startswith("|")]


def numbers(row):
    return [float(each) for each in re.findall(r"-?\d+\.?\d*", row)]


def are_same(made, known, rel=0.011, abs_=1.01):
    """Whether rows agree to a unit of their last digit, which may differ on another machine."""
    assert [row.split("|")[1] for row in made] == [row.split("|")[1] for row in known]
    for row, other in zip(made, known, strict=True):
        assert numbers(row) == pytest.approx(numbers(other), rel=rel, abs=abs_), row
    return True


@pytest.fixture
def claim(pays):
    return supply_claim(pays.bench(), pays.machines())


@pytest.mark.thorough
def test_tables_of_the_claim(pays, claim):
    assert are_same(list(pays.share_rows(claim)), kept(pays, "shares"))
    assert are_same(list(pays.loss_rows(claim)), kept(pays, "losses"))
    assert are_same(list(pays.lead_rows(claim)), kept(pays, "leads"), abs_=12.0)


@pytest.mark.slow
def test_no_winner_rests_on_forces_and_times(pays):
    """30 % to either side: displacement control loses least, and the PWM valve loses more than load sensing."""
    held = pays.bench()
    for forces in (pays.SHARES[0], pays.SHARES[-1]):
        duties = [pays.scaled(duty, forces, times) for duty in pays.machines() for times in (1.0, 1.3)]
        means = cycle_losses(held, duties).means
        for row in range(len(duties)):
            ways = {key: float(values[row]) for key, values in means.items()}
            assert min(ways, key=lambda key: ways[key]) == "displacement"
            assert ways["load_sensing"] < ways["switched"] < ways["metered"]


def test_cycles_are_as_told(pays):
    """Largest flows of 12, 30 and 35 lpm, relief valves at 150, 170 and 130 bar."""
    found = {duty.name: duty for duty in pays.machines()}
    flows = []
    for duty in found.values():
        cycle = duty.cycle
        speeds = [(b - a) / (t - s) for a, b, s, t in zip(
            cycle.positions, cycle.positions[1:], cycle.times, cycle.times[1:], strict=False)]  # fmt: skip
        flows.append(6e4 * max(max(20.26e-4 * v, -10.77e-4 * v) for v in speeds))
    assert flows == pytest.approx([12.2, 30.4, 35.0], abs=0.1)
    assert [duty.relief_pressure for duty in found.values()] == [150e5, 170e5, 130e5]


@pytest.mark.slow
def test_all_is_what_the_script_writes(pays, tmp_path):
    path = tmp_path / "page.md"
    pays.main(path, tmp_path)
    assert {picture.name for picture in tmp_path.glob("*.png")} == {
        "supply-gains.png", "supply-winners.png", "linear-valves.png"
    }  # fmt: skip
    for name in ("circuits", "valves"):
        part = path.read_text("utf-8").partition(f"<!-- {name}: made by")[2].partition("<!-- to here -->")[0]
        made = [line for line in part.splitlines() if line.startswith("|")]
        assert are_same(made, kept(pays, name), rel=0.02)


def test_the_power_of_solenoids_counts_two_strokes_a_period(pays):
    """9 J a stroke, two valves, 75 Hz: 2 2 75 9 = 2700 W; with springs half of it."""
    from vvdp.rivals.linear_valves import STROKE_ENERGY, actuation_power

    text = " ".join(pays.PAGE.read_text("utf-8").split())
    both, one = actuation_power(2.0, 75.0), actuation_power(2.0, 75.0, 1.0)
    assert (both, one) == (2700.0, 1350.0)
    assert f"at most {STROKE_ENERGY:g} J a stroke" in text
    assert f"for two valves at 75 Hz at most {1e-3 * both:g} kW" in text and f"({1e-3 * one:g} kW if springs" in text
