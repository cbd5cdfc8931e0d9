"""A circuit drawn by hand: each act is a change of lines, and what is drawn runs."""

import difflib

import pytest
from tests.workbench.conftest import LOG, serving
from tests.workbench.steps import COMPLETE, enter, middle, wait_for

from vvdp.systems.system import source_text

DRAWN = "document.getElementById('state').textContent === 'drawn; not yet run'"


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drawn")
    (folder / "buck.toml").write_text(source_text("buck-converter"))
    (folder / "rig.csv").write_text(LOG)
    with serving(folder / "buck.toml") as found:
        yield found


@pytest.fixture
def drawing(page):
    page.ask("document.getElementById('draw').click()")
    wait_for(page, f"document.querySelectorAll('#palette-list button').length > 70 && {DRAWN}")
    return page


def add(page, word):
    enter(page, "document.getElementById('palette-filter')", word)
    x, y = middle(page, "document.querySelector('#palette-list button')")
    page.click(x, y)
    wait_for(page, f"state.answered === state.asked && {DRAWN}")


def handle(owner, port):
    return (
        f"[...document.querySelectorAll('.handle')].find((e) => e.end.owner === '{owner}' && e.end.port === '{port}')"
    )


def changes(before, after):
    """Lines that went and lines that came."""
    found = [line for line in difflib.ndiff(before.splitlines(), after.splitlines()) if line[0] in "+-"]
    return [line[2:] for line in found if line[0] == "-"], [line[2:] for line in found if line[0] == "+"]


def test_a_part_is_dropped_joined_and_run(drawing):
    page = drawing
    before = page.ask("state.text")
    add(page, "orifice")
    dropped = page.ask("state.text")
    gone, come = changes(before, dropped)
    assert gone == [] and "[components.orifice]" in come and 'a = "orifice_a"' in come
    x, y = middle(page, handle("orifice", "a"))
    page.click(x, y)
    assert page.ask(f"{handle('orifice', 'a')}.classList.contains('is-chosen')")
    assert page.ask(f"{handle('valve', 'a')}.classList.contains('fits')")
    x, y = middle(page, handle("valve", "a"))
    page.click(x, y)
    wait_for(page, f"state.answered === state.asked && {DRAWN}")
    gone, come = changes(dropped, page.ask("state.text"))
    assert come == ['a = "supply"']
    assert gone[0] == 'a = "orifice_a"' and "[nodes.orifice_a]" in gone and "[nodes.orifice_b]" not in gone
    page.ask(f"{handle('orifice', 'b')}.focus()")
    page.press("Enter")
    page.ask(f"{handle('tube', 'b')}.focus()")
    page.press("Enter")
    wait_for(page, f"state.answered === state.asked && {DRAWN}")
    assert 'b = "load"' in changes(before, page.ask("state.text"))[1]
    page.ask("document.getElementById('run').click()")
    wait_for(page, f"{COMPLETE} && state.runs.at(-1).result.flow_mean_orifice_m3_s > 0", patience=60.0)
    for _ in range(3):
        page.ask("document.getElementById('undo').click()")
    assert page.ask("state.text") == before


def test_only_what_fits_can_be_joined(drawing):
    page = drawing
    add(page, "pump")
    before = page.ask("state.text")
    name = page.ask("[...drawnParts(state.text, 'components')].at(-1)[0]")
    ports = page.ask(f"Object.entries(drawnParts(state.text, 'components').get('{name}').known.ports)")
    (shaft,) = (port for port, joins in ports if joins == "shaft")
    end = "{{owner: '{}', port: '{}', node: '{}'}}".format
    ends = f"{end(name, shaft, f'{name}_{shaft}')}, {end('valve', 'a', 'supply')}"
    assert not page.ask(f"canJoin({ends})")
    page.ask(f"(() => {{ const [a, b] = [{ends}]; chooseEnd(a); chooseEnd(b); }})()")
    assert page.ask("document.getElementById('state').textContent") == "shaft and oil cannot be joined"
    assert page.ask("state.text") == before
    page.ask(f"openTable('{name}')")
    options = "[...document.querySelectorAll('#joints select')].map((e) => [...e.options].map((o) => o.value))"
    assert [f"{name}_{shaft}"] in page.ask(options)  # the only shaft; the oil ports offer no shaft
    assert all("supply" in each for each in page.ask(options) if each != [f"{name}_{shaft}"])
    page.ask("document.querySelector('#joints button').click()")
    wait_for(page, f"state.answered === state.asked && {DRAWN}")
    assert page.ask("state.text").strip() == page.ask("state.saved").strip()


def test_a_part_is_moved_by_mouse_and_by_keyboard(drawing):
    page = drawing
    symbol = "document.querySelector('#diagram [data-part=check_valve][tabindex]')"
    place = f"(() => {{ const c = centreOf({symbol}); return [c.x, c.y]; }})()"
    x, y = middle(page, symbol)
    page.drag((x, y), (x + 150, y))
    wait_for(page, f"state.text.includes('at = [') && state.answered === state.asked && {DRAWN}")
    gone, come = changes(page.ask("state.saved"), page.ask("state.text"))
    assert gone == [] and len(come) == 1
    column, row = page.ask("JSON.parse(/at = (.*)/.exec(state.text)[1])")
    assert page.ask(place)[0] == pytest.approx(14 + 120 * column, abs=60)
    assert row == 1
    page.ask(f"{symbol}.focus()")
    page.press("ArrowLeft")
    wait_for(page, f"!state.text.includes('at = [{column}, ') && state.answered === state.asked && {DRAWN}")
    assert page.ask("JSON.parse(/at = (.*)/.exec(state.text)[1])")[0] == pytest.approx(column - 0.5, abs=0.6)


def test_only_headers_begin_a_table(page):
    text = "[a.b] # first\nrows = [\n  [0, 1],\n  [1, 2]\n]\nkey = 1\n\n# of c\n[a.c]\nkey = 2\n"
    assert page.ask(f"tableSpan({text!r}.split('\\n'), 'a.b')") == [0, 8]
    assert page.ask(f"withLine({text!r}, 'a.c', 'key', '3')") == text.replace("key = 2", "key = 3")
    assert page.ask(f"withoutTable({text!r}, 'a.b')") == "# of c\n[a.c]\nkey = 2\n"
    assert page.ask(f"withTable({text!r}, 'a.d', ['x = 1'])") == text + "\n[a.d]\nx = 1\n"
    run = "# how long\n[run]\nuntil = 1\n"
    assert page.ask(f"withTable({run!r}, 'a.d', ['x = 1'])") == "[a.d]\nx = 1\n\n" + run


def test_a_text_that_is_written_otherwise_is_left_alone(drawing):
    page = drawing
    text = '[nodes]\nsupply.type = "tank"\n'
    page.ask(f"setText({text!r}); edit(withLine(state.text, 'nodes.supply', 'at', '[1, 1]'), '')")
    assert "only the text can change" in page.ask("document.getElementById('state').textContent")
    assert page.ask("state.text") == text


INLINE = """[nodes]
tank = { type = "tank" } # below
rail = { type = "volume", volume = { value = "100 cc", status = "assumed" }, start = "5 bar" }

[components]
load = { type = "orifice", a = "rail", b = 'tank', area = "15 mm^2, }" }

[parts.fine]
file = "filter.toml"
dirty = "rail"
"""


def test_entries_in_one_line_and_parts_are_changed_where_they_stand(drawing):
    page = drawing
    page.ask(f"setText({INLINE!r})")
    owners = "[...drawnOwners(state.text)].map(([name, {a, dirty, table}]) => [name, a ?? dirty, table])"
    assert page.ask(owners) == [["load", "rail", "components"], ["fine", "rail", "parts"]]
    assert page.ask("[...drawnParts(state.text, 'nodes')].map(([name, {type}]) => [name, type])") == [
        ["tank", "tank"], ["rail", "volume"],
    ]  # fmt: skip
    moved = page.ask("withLine(state.text, 'components.load', 'b', '\"rail\"')")
    assert changes(INLINE, moved)[1] == ['load = { type = "orifice", a = "rail", b = "rail", area = "15 mm^2, }" }']
    placed = page.ask("withLine(state.text, 'nodes.tank', 'at', '[1, 2]')")
    assert changes(INLINE, placed)[1] == ['tank = { type = "tank", at = [1, 2] } # below']
    assert changes(INLINE, page.ask("withoutTable(state.text, 'components.load')")) == (
        ["load = { type = \"orifice\", a = \"rail\", b = 'tank', area = \"15 mm^2, }\" }"], [],
    )  # fmt: skip
    changed = page.ask("writeInto(state.text, new Map([['nodes.rail.volume', 'nodes.rail.volume=2 l']]))[0]")
    assert changes(INLINE, changed)[1] == [
        'rail = { type = "volume", volume = { value = "2 l", status = "assumed" }, start = "5 bar" }'
    ]
    settings = ("oil.density=870 kg/m^3", "nodes.fine_bowl.volume=1 l")
    both = [[setting.partition("=")[0], setting] for setting in settings]
    text, missing = page.ask(f"writeInto(state.text, new Map({both}))")
    assert changes(INLINE, text) == ([], ["", "[oil]", 'density = "870 kg/m^3"'])
    assert missing == ["nodes.fine_bowl.volume"]
    page.ask("setText(state.saved)")


def test_a_shipped_part_is_dropped_and_its_port_moved(drawing):
    page = drawing
    page.ask("setText(state.saved)")
    add(page, "pump-unit")
    assert 'type = "pump-unit"' in page.ask("state.text")
    node = page.ask("drawnOwners(state.text).get('pump_unit').load")
    assert node == "pump_unit_load"
    x, y = middle(page, handle("pump_unit", "load"))
    page.click(x, y)
    assert page.ask(f"{handle('valve', 'a')}.classList.contains('fits')")
    x, y = middle(page, handle("valve", "a"))
    page.click(x, y)
    wait_for(page, f"state.answered === state.asked && {DRAWN}")
    assert page.ask("drawnOwners(state.text).get('pump_unit').load") == "supply"
    assert "[nodes.pump_unit_load]" not in page.ask("state.text")
    page.ask("openTable('pump_unit')")
    lists = "[...document.querySelectorAll('#joints select')].map((e) => e.value)"
    assert page.ask(lists) == ["supply", "pump_unit_tank", "pump_unit_shaft"]
    page.ask("document.querySelector('#joints button').click()")
    wait_for(page, f"state.answered === state.asked && {DRAWN}")
    assert page.ask("state.text").strip() == page.ask("state.saved").strip()
