"""docs/keys.md names exactly the keys that there are, with the unit that each key ends in."""

import json
import re
from pathlib import Path

import pytest

from vvdp.systems.system import shipped

DOCUMENTS = Path(__file__).parents[2] / "docs"
ENDINGS = {
    "m^3/s": "_m3_s",
    "rad/s": "_rad_s",
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


@pytest.mark.parametrize(("verb", "options"), [("valve", ()), ("run", ("--until", "0.05 s", "--no-report"))])
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
