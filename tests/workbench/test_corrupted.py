"""100 corrupted values and files: each gets a message, and the page goes on."""

import json
import random
import re

import pytest
from tests.workbench.conftest import serving
from tests.workbench.steps import COMPLETE, DUTY, enter, wait_for
from tests.workbench.test_server import answers, described, socket_of

from vvdp.systems.system import load_system, shipped_systems, source_text
from vvdp.workbench.work import value_rows

SEED, EACH = 40, 50
WRONG = (
    "", "nan", "inf", "-inf", "1e400", "abc", "1,5", "--3", 400 * "9", "0x10", "1 bar bar", "½", "\0", "{", "[1, 2]",
    "{step=[1]}", "<b>7</b>", "'", '"', "null", "1e308", "-1e308", "#", "=", "\u202e7", "1e-320",
)  # fmt: skip
MARKS = ("\0", "]", "[", '"', "=", "{", "'", "é", "\\", "1e999", "true", ",", "[[", "\ud7ff")


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    folder = tmp_path_factory.mktemp("corrupted")
    (folder / "pump.toml").write_text(source_text("prototype"))
    with serving(folder / "pump.toml") as found:
        yield found


def corrupted(text, chance):
    """A text with one part lost, put in, cut, doubled, removed, exchanged or with another value."""
    lines, at = text.split("\n"), chance.randrange(len(text))
    row, other = chance.randrange(len(lines)), chance.randrange(len(lines))
    exchanged = list(lines)
    exchanged[row], exchanged[other] = lines[other], lines[row]
    return chance.choice([
        text[:at] + text[at + chance.randint(1, 12) :],
        text[:at] + chance.choice(MARKS) + text[at:],
        text[:at],
        "\n".join([*lines[:row], lines[other], *lines[row:]]),
        "\n".join([*lines[:row], *lines[row + 1 :]]),
        re.sub(r'"([-\d.]+) ', f'"{chance.choice(WRONG[1:4])} ', text, count=1),
        "\n".join(exchanged),
    ])  # fmt: skip


def requests():
    """Drafts with a corrupted value, and drawings of a corrupted file."""
    chance = random.Random(SEED)
    systems = ("prototype", "buck-converter")
    rows = {name: [row for row in value_rows(load_system(name)) if "number" in row] for name in systems}
    for name in chance.choices(systems, k=EACH):
        row = chance.choice(rows[name])
        setting = f"{row['key']}={chance.choice(WRONG)} {row['unit']}".strip()
        yield {"kind": "draft", "system": name, "set": [setting], "charts": []}
    for name in chance.choices(sorted(shipped_systems()), k=EACH):
        yield {"kind": "draw", "system": name, "set": [], "text": corrupted(source_text(name), chance)}


def test_each_of_100_gets_an_answer_in_words(server):
    told = 0
    with socket_of(server) as page:
        for n, asked in enumerate(requests()):
            page.send(json.dumps({**asked, "n": n}))
            *_, packet = answers(page, {"draft": "draft", "draw": "drawing"}[asked["kind"]])
            head = described(packet)
            assert head["n"] == n
            for fault in head.get("faults", ()):
                told += 1
                assert fault["message"].strip() and not re.search("mistake of vvdp|Traceback", fault["message"]), fault
                is_placed = fault["key"] or fault["line"] or "is empty" in fault["message"]  # a text without tables
                assert is_placed or asked["kind"] == "draft", fault
            if asked["kind"] == "draft":
                key, _, value = asked["set"][0].partition("=")
                faults = head.get("faults", [])
                assert not faults or value.startswith("1e-320") or faults[0]["key"] in (key, key.rpartition(".")[0])
    assert told >= EACH  # most of what is corrupted is refused


def test_a_wrong_value_is_told_beside_its_field_and_the_page_goes_on(page):
    field = "document.querySelector('[data-key=\"operation.duty_ratio\"]')"
    for value in ("abc", "", "nan", "7", "<b>1</b>", "{"):
        enter(page, DUTY, value, "change")
        wait_for(page, f"{field}.querySelector('.wrong')?.textContent && state.answered === state.asked")
        assert "Traceback" not in page.ask("document.body.textContent")
        assert page.ask("document.querySelectorAll('.wrong').length") == 1
        assert page.ask("getComputedStyle(document.getElementById('listings')).fontStyle") == "italic"
    page.ask("document.getElementById('undo').click()")
    enter(page, DUTY, 0.45, "change")
    wait_for(page, f"{COMPLETE} && document.querySelectorAll('.wrong').length === 0")
    assert "0.45" in page.ask("document.getElementById('line').textContent")
