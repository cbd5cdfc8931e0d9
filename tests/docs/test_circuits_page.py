"""The tables of docs/circuits-compared.md are those that their command writes."""

import re

import numpy as np
import pytest

from vvdp.systems.displacement.duties import shipped_duties
from vvdp.systems.displacement.rival_circuits import CIRCUITS, SINKS


def duty(name):
    return next(each for each in shipped_duties() if each.name == name)


def kept_table(page, duty):
    """The lines of the table of a cycle on the page."""
    return page.partition(f"**{duty.name}**")[2].partition("\n\n**")[0].partition("<!--")[0].splitlines()


def kept_rows(page, duty):
    """The rows of a cycle on the page, by circuit."""
    return {line.split("`")[1]: line for line in kept_table(page, duty) if line.startswith("| `")}


def kept_sinks(page, duty):
    """The places of the losses that the table of a cycle shows."""
    (head,) = (line for line in kept_table(page, duty) if line.startswith("| circuit "))
    labels = [cell.strip() for cell in head.split("|")]
    return [place for place, sink in enumerate(SINKS) if sink.label in labels]


def rows_between(page, begin, end):
    """The rows of the table between two marks, by their first cell."""
    text = page.partition(begin)[2].partition(end)[0]
    return {line.split("|")[1].strip(): line for line in text.strip().splitlines()[2:]}


def spread_rows(page):
    """The rows of the spread, by circuit and what is changed."""
    import circuits_compared

    return rows_between(page, circuits_compared.SPREAD_BEGIN, circuits_compared.SPREAD_END)


def numbers(row):
    return [float(cell) for cell in re.findall(r"(?<=\| )-?[\d.]+(?= \|)", row)]


def are_same(made, kept):
    """Whether rows agree to a unit of their last digit, which may differ on another machine."""
    assert made.keys() == kept.keys()
    for name, row in made.items():
        assert numbers(row) == pytest.approx(numbers(kept[name]), rel=0.011, abs=0.02), name
        assert len(numbers(row)) == row.count("|") - 2 > 1
    return True


def test_every_cycle_and_circuit_has_its_table_and_row():
    import circuits_compared

    page = circuits_compared.PAGE.read_text("utf-8")
    for each in shipped_duties():
        assert list(kept_rows(page, each)) == [circuit.name for circuit in CIRCUITS]
    for each in CIRCUITS:
        assert f"| `{each.name}` | " in page.partition("## The position loops")[0] and f"`{each.system}` |" in page


def test_numbers_are_written_short():
    import circuits_compared

    written = [circuits_compared.short(each) for each in (4236.1, 1043.9, 89.03, 0.0852, 0.004, -0.0, 5.0)]
    assert written == ["4240", "1040", "89", "0.0852", "0", "0", "5"]


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["heavy", "three-loads"])
def test_the_rows_of_the_rivals_are_what_their_command_writes(name):
    import circuits_compared

    page = circuits_compared.PAGE.read_text("utf-8")
    rivals = [each for each in CIRCUITS if each.begin is None]
    found = circuits_compared.compared([duty(name)], rivals)
    rows = circuits_compared.rows(found, duty(name), kept_sinks(page, duty(name)))
    made = {line.split("`")[1]: line for line in rows}
    kept = kept_rows(page, duty(name))
    assert are_same(made, {name: kept[name] for name in made})


def test_one_to_three_loads_are_those_of_their_tables():
    """Drawn less returned, to the digits that the tables have."""
    import circuits_compared

    page = circuits_compared.PAGE.read_text("utf-8")
    kept = rows_between(page, circuits_compared.LOADS_BEGIN, circuits_compared.LOADS_END)
    tables = [kept_rows(page, duty(name)) for name in circuits_compared.LOADS]
    assert [*kept] == [each.name for each in CIRCUITS]
    for name, row in kept.items():
        drawn, returned = np.transpose([numbers(table[name])[1:3] for table in tables])
        assert numbers(row) == pytest.approx(drawn - returned, abs=max(0.01 * max(drawn), 1.0)), name


def columns(page, name):
    """The numbers of the table of a cycle, by circuit and head of the column, without units."""
    (head,) = (line for line in kept_table(page, duty(name)) if line.startswith("| circuit "))
    heads = [cell.strip().partition(" [")[0] for cell in head.split("|")[2:-1]]
    return {each: dict(zip(heads, numbers(row), strict=True)) for each, row in kept_rows(page, duty(name)).items()}


def test_the_sentences_follow_from_the_tables():
    """Each sentence is written anew from the table's numbers, and has to stand on the page."""
    import circuits_compared

    page = circuits_compared.PAGE.read_text("utf-8")
    text = " ".join(page.split())
    triangle, heavy, digging = (columns(page, name) for name in ("triangle", "heavy", "digging"))
    drawn = {name: [cycle[name]["drawn"] for cycle in (triangle, heavy, digging)] for name in heavy}
    vvdp, sensing, slow, constant = (drawn[name] for name in ("vvdp", "load-sensing", "vvdp-slow", "constant-pressure"))
    pairs = [f"{a:g} for {b:g}" for a, b in zip(sensing, vvdp, strict=True)]
    errors = {name: row["error"] for name, row in heavy.items()}
    lost, ideal = (heavy[name]["meter-out throttle"] for name in ("vvdp", "ideal-pump"))
    extra = lost - ideal
    sentences = [
        f"{pairs[0].replace(' for', ' W for')} on the triangle, {pairs[1]} under the heavy load, {pairs[2]} digging",
        "the VVDP draws {:g}, {:g} and {:g} W".format(*slow),
        "A pump that holds one pressure draws {:g}, {:g} and {:g} W".format(*constant),
        f"Under the heavy load the errors are {min(errors.values()):g} to {max(errors.values()):g} mm",
        f"`bleed-off` ({errors['bleed-off']:g} mm) and `linear-valves` ({errors['linear-valves']:g} mm) follow worst",
        f"it draws {heavy['throttle']['drawn'] / vvdp[1]:.1f} times less than throttling",
        f"Of the {vvdp[1]:g} W, {lost:g} W are lost over the meter-out throttle",
        f"loses {ideal:g} W there",
        f"The difference of {extra:g} W is due to the control law",
        f"would draw about {10 * round((vvdp[1] - extra) / 10):g} W",
    ]
    assert [each for each in sentences if each not in text] == []
    assert all(a < b for a, b in zip(sensing, vvdp, strict=True))
    assert sorted(errors, key=errors.get)[-2:] == ["bleed-off", "linear-valves"]


@pytest.mark.slow
def test_the_spread_is_what_its_command_writes():
    """Of the rivals; each assumed value with a range stands there with the ends at which it is not already."""
    import circuits_compared

    page = circuits_compared.PAGE.read_text("utf-8")
    duties = [duty(name) for name in circuits_compared.SPREAD_DUTIES]
    rivals = [each for each in circuits_compared.spread_circuits() if each.begin is None]
    found = circuits_compared.compared(duties, rivals)
    lines = [*circuits_compared.drawn_table(found, circuits_compared.SPREAD_DUTIES)][2:]
    made = {line.split("|")[1].strip(): line for line in lines if line}
    kept = spread_rows(page)
    assert are_same(made, {name: kept[name] for name in made})
    assert {name.partition(",")[0] for name in kept} == {*circuits_compared.SPREAD}
    assert {"load-sensing, margin 10 bar", "load-sensing, margin 30 bar"} <= kept.keys()


@pytest.mark.slow
def test_the_tables_are_what_their_command_writes(tmp_path):
    import circuits_compared

    path = tmp_path / "circuits-compared.md"
    circuits_compared.main(path)
    made, kept = (each.read_text("utf-8") for each in (path, circuits_compared.PAGE))
    for each in shipped_duties():
        assert are_same(kept_rows(made, each), kept_rows(kept, each))
    assert are_same(spread_rows(made), spread_rows(kept))
