"""What vvdp is made of: the bill of materials is that of the locks, and every licence is one that is permitted."""

import json
import re
import tomllib

import pytest
from supply import bill

FULL, CORE = bill.FULL.read_text("utf-8"), bill.CORE.read_text("utf-8")
PROJECT = tomllib.loads((bill.ROOT / "pyproject.toml").read_text("utf-8"))["project"]
KEPT = json.loads(bill.BILL.read_text("utf-8"))
PERMITTED = re.compile(
    r"(MIT(-0|-CMU| License)?|0BSD|Zlib|CC0-1\.0|ISC( License \(ISCL\))?|PSF-2\.0|Python Software Foundation License"
    r"|BSD([- ][23]-Clause| License)?|Apache-2\.0( WITH LLVM-exception)?|Apache Software License"
    r"|MPL-2\.0|Mozilla Public License 2\.0 \(MPL 2\.0\))"
)
WEAK = {"asammdf", "casadi", "moocore", "nptdms"}
"""Under the LGPL, for extras alone; NOTICE names them."""


def licences(component):
    return [part["license"]["name"] for part in component.get("licenses", ())]


def test_the_bill_is_what_its_command_writes():
    made = bill.bill(FULL, CORE, PROJECT, bill.kept_licences(KEPT))
    assert bill.text(made) == bill.BILL.read_text("utf-8"), bill.STALE


def test_every_pin_of_the_locks_is_in_the_bill_with_its_files():
    lines = FULL.splitlines()
    assert len(KEPT["components"]) == sum("==" in line for line in lines)
    listed = [each["content"] for component in KEPT["components"] for each in component["hashes"]]
    assert listed == [line.strip(" \\").removeprefix("--hash=sha256:") for line in lines if "--hash=" in line]
    required = {each["name"] for each in KEPT["components"] if each["scope"] == "required"}
    assert required == {line.partition("==")[0] for line in CORE.splitlines() if "==" in line}


def test_another_lock_makes_another_bill():
    first = next(line for line in FULL.splitlines() if "--hash=" in line)
    other = FULL.replace(first.strip(" \\")[-8:], "0" * 8, 1)
    made = bill.bill(other, CORE, PROJECT, bill.kept_licences(KEPT))
    assert made["serialNumber"] != KEPT["serialNumber"] and made["components"] != KEPT["components"]
    with pytest.raises(ValueError, match=r"no pin with hashes: 'numpy==2\.0'"):
        bill.pins("numpy==2.0\n")


@pytest.mark.parametrize("component", KEPT["components"], ids=lambda each: f"{each['name']}-{each['version']}")
def test_every_licence_is_permitted(component):
    told = licences(component)
    if not told:  # nothing is known of what only other systems or versions of Python install
        assert "properties" in component
    elif component["name"] in WEAK:
        assert component["scope"] == "optional" and re.search("LGPL", told[0])
    else:
        parts = re.split(r" AND | OR ", told[0])
        assert parts and all(PERMITTED.fullmatch(part) for part in parts), told


def test_the_installed_packages_are_under_the_licences_of_the_bill():
    kept = bill.kept_licences(KEPT)
    installed = bill.installed_licences(sorted(kept))
    assert len(installed) > 20
    pinned = {pin.name: pin.version for pin in bill.pins(FULL)}
    from importlib.metadata import version

    same = {name for name in installed if version(name) == pinned[name]}
    assert {name: installed[name] for name in same} == {name: kept[name] for name in same}
