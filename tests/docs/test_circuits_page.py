"""The tables of docs/circuits-compared.md are those that their command writes."""

import re

import pytest

from vvdp.systems.displacement.duties import shipped_duties
from vvdp.systems.displacement.rival_circuits import CIRCUITS


def kept_rows(page, duty):
    """The rows of a cycle on the page, by circuit."""
    table = page.partition(f"**{duty.name}**")[2].partition("\n\n**")[0].partition("<!--")[0]
    return {line.split("`")[1]: line for line in table.splitlines() if line.startswith("| `")}


def numbers(row):
    return [float(cell) for cell in re.findall(r"(?<=\| )-?[\d.]+(?= \|)", row)]


def are_same(made, kept):
    """Whether rows agree to a unit of their last digit, which may differ on another machine."""
    assert made.keys() == kept.keys()
    for name, row in made.items():
        assert numbers(row) == pytest.approx(numbers(kept[name]), rel=0.011, abs=0.02), name
        assert len(numbers(row)) == 13
    return True


def test_every_cycle_and_circuit_has_its_table_and_row():
    import circuits_compared

    page = circuits_compared.PAGE.read_text("utf-8")
    for duty in shipped_duties():
        assert list(kept_rows(page, duty)) == [each.name for each in CIRCUITS]
    for each in CIRCUITS:
        assert f"| `{each.name}` | " in page.partition("## The position loops")[0] and f"`{each.system}` |" in page


def test_numbers_are_written_short():
    import circuits_compared

    written = [circuits_compared.short(each) for each in (4236.1, 1043.9, 89.03, 0.0852, 0.004, -0.0, 5.0)]
    assert written == ["4240", "1040", "89", "0.0852", "0", "0", "5"]


def test_the_rows_of_the_rivals_are_what_their_command_writes():
    import circuits_compared

    heavy = next(each for each in shipped_duties() if each.name == "heavy")
    page = circuits_compared.PAGE.read_text("utf-8")
    rivals = [each for each in CIRCUITS if each.begin is None]
    found = circuits_compared.compared([heavy], rivals)
    made = {line.split("`")[1]: line for line in circuits_compared.rows(found, heavy)}
    kept = kept_rows(page, heavy)
    assert are_same(made, {name: kept[name] for name in made})


@pytest.mark.slow
def test_the_tables_are_what_their_command_writes(tmp_path):
    import circuits_compared

    path = tmp_path / "circuits-compared.md"
    circuits_compared.main(path)
    made, kept = (each.read_text("utf-8") for each in (path, circuits_compared.PAGE))
    for duty in shipped_duties():
        assert are_same(kept_rows(made, duty), kept_rows(kept, duty))
