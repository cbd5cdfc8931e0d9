"""docs/keys.md names exactly the keys that there are, with the unit that each key ends in."""

import json
import re
import shlex
from pathlib import Path

import pytest

from vvdp.systems.system import shipped

DOCUMENTS = Path(__file__).parents[2] / "docs"
ENDINGS = {
    "m^3/s": "_m3_s",
    "rad/s": "_rad_s",
    "rad": "_rad",
    "Pa": "_Pa",
    "Hz": "_Hz",
    "W": "_W",
    "s": "_s",
    "K": "_K",
    "N*m": "_N_m",
}


def described(verb: str) -> dict[str, str]:
    """The keys of a verb with their units, as documented."""
    section = (DOCUMENTS / "keys.md").read_text("utf-8").partition(f"## `vvdp {verb}`")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| `(\w+)` \| ([^|]+) \| [^|]+ \|$", section, re.MULTILINE)
    assert len(rows) == len(dict(rows))
    return dict(rows)


@pytest.mark.parametrize(("verb", "options"), [("valve", ()), ("run", ("--until", "0.52 s", "--no-report"))])
def test_keys_are_those_described(vvdp, here, verb, options):
    found: set[str] = set()
    for name in shipped():
        found |= set(json.loads(vvdp(verb, name, "--json", *options).out))
    assert found == set(described(verb))


@pytest.mark.parametrize("verb", ["valve", "run"])
def test_keys_end_in_their_unit(verb):
    for key, unit in described(verb).items():
        ending = next((e for e in ENDINGS.values() if key.endswith(e)), "")
        assert ending == ENDINGS.get(unit, ""), key


def test_every_verb_is_in_the_guide():
    guide = (DOCUMENTS / "command-line.md").read_text("utf-8")
    for verb in ("run", "valve", "list", "show", "new", "report", "check"):
        assert f"## `vvdp {verb}`" in guide


def example(command: str) -> list[str]:
    """The lines that the guide shows after `command`, without what it leaves out."""
    guide = (DOCUMENTS / "command-line.md").read_text("utf-8")
    shown = re.split(r"\n(?=[^ \n])", guide.partition(f"    $ {command}\n")[2], maxsplit=1)[0]
    lines = [line.strip() for line in shown.splitlines()]
    return [line for line in lines if line and "..." not in line]


@pytest.mark.parametrize(
    "command",
    [
        'vvdp valve prototype --flow "40 lpm" --temperature "40 degC"',
        "vvdp show prototype",
        "vvdp new my-pump --from prototype",
        "vvdp list",
    ],
)
def test_the_examples_of_the_guide_are_real(vvdp, here, command):
    if command == "vvdp list":
        vvdp("new", "my-pump", "--from", "prototype")
    said = [line.strip() for line in vvdp(*shlex.split(command)[1:]).out.splitlines()]
    lines = example(command)
    assert lines
    assert [line for line in lines if line not in said] == []


def test_the_run_of_the_guide_shows_what_a_run_shows(vvdp, here):
    answer = vvdp("run", "prototype", "--until", "0.05 s", "--no-report", "--out", "out")
    labels = {line.strip().partition("  ")[0] for line in answer.out.splitlines()}
    lines = example("vvdp run prototype --set operation.duty_ratio=0.4 --out results/duty-0.4")
    quantities = [line.partition("  ")[0] for line in lines if "  " in line]
    assert len(quantities) > 15
    assert set(quantities) <= labels
