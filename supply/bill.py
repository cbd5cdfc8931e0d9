"""The bill of materials: `python -m supply.bill` writes supply/vvdp.cdx.json (CycloneDX 1.6) from the locks.

A component for every pin of requirements.lock, with the hashes of its wheels and source archive, the condition under
which it is installed, and its licence as the installed package states it. What requirements-core.lock has too is
required, all else optional. No clock and no network go into it: the same locks give the same bytes.
"""

import json
import re
import sys
import tomllib
import uuid
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import Distribution, PackageMetadata, PackageNotFoundError, distribution
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).parents[1]
BILL = Path(__file__).with_name("vvdp.cdx.json")
FULL, CORE = ROOT / "requirements.lock", ROOT / "requirements-core.lock"
NAMESPACE = uuid.UUID("6d1f3f0e-5f5a-5a53-9d7e-0f7d1c3ad0f1")
"""Of the serial numbers, which follow from the locks."""

STALE = "the bill is not that of the locks; write it with: make sbom"
STATED = {"fmpy": "BSD-2-Clause", "graphemeu": "MIT"}
"""Licences of packages whose metadata have the words of a licence and not its name, or only its file."""


class Pin(NamedTuple):
    """A package at one version: when it is installed, and the SHA-256 of each of its files."""

    name: str
    version: str
    condition: str
    hashes: tuple[str, ...]


def pins(lock: str) -> list[Pin]:
    """The pins of the text of a lock. Raises ValueError for a line that is none."""
    found = []
    for block in re.split(r"\n(?=\S)", lock.strip()):
        head, *hashes = block.split(" \\\n    --hash=sha256:")
        match = re.fullmatch(r"([\w.-]+)==([\w.+!]+)(?: ; (.+))?", head)
        if match is None or not hashes or not all(re.fullmatch(r"[0-9a-f]{64}", each) for each in hashes):
            raise ValueError(f"no pin with hashes: {block[:80]!r}")
        found.append(Pin(match[1], match[2], match[3] or "", tuple(hashes)))
    return found


def bill(full: str, core: str, project: Mapping[str, Any], licences: Mapping[str, str]) -> dict[str, Any]:
    """The bill of the texts of both locks, of the `project` that asks for them and of the licence of each package."""
    required = {pin.name for pin in pins(core)}
    serial = uuid.uuid5(NAMESPACE, full + core + json.dumps([project["version"], *sorted(licences.items())]))
    own = f"pkg:pypi/{project['name']}@{project['version']}"
    return {
        "$schema": "http://cyclonedx.org/schema/bom-1.6.schema.json",
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "serialNumber": f"urn:uuid:{serial}",
        "version": 1,
        "metadata": {
            "component": {
                "type": "application",
                "bom-ref": own,
                "name": project["name"],
                "version": project["version"],
                "purl": own,
                "licenses": [{"expression": project["license"]}],
            }
        },
        "components": [_component(pin, pin.name in required, licences.get(pin.name, "")) for pin in pins(full)],
    }


def _component(pin: Pin, is_required: bool, licence: str) -> dict[str, Any]:
    purl = f"pkg:pypi/{pin.name}@{pin.version}"
    found: dict[str, Any] = {
        "type": "library",
        "bom-ref": f"{purl}#{pin.condition}" if pin.condition else purl,
        "name": pin.name,
        "version": pin.version,
        "scope": "required" if is_required else "optional",
        "hashes": [{"alg": "SHA-256", "content": content} for content in pin.hashes],
        "purl": purl,
    }
    if licence:
        found["licenses"] = [{"license": {"name": licence}}]
    if pin.condition:
        found["properties"] = [{"name": "vvdp:condition", "value": pin.condition}]
    return found


def installed_licences(names: Iterable[str]) -> dict[str, str]:
    """The licence of each package that is installed here, as its metadata state it."""
    found = {}
    for name in names:
        try:
            found[name] = STATED.get(name) or _licence(distribution(name))
        except PackageNotFoundError:
            continue
    return found


def _licence(package: Distribution) -> str:
    """An SPDX expression where there is one, else the classifiers, else the first line of the licence's text."""
    told: PackageMetadata = package.metadata
    classes = [each.split(" :: ")[-1] for each in told.get_all("Classifier", []) if each.startswith("License :: ")]
    text = next(iter((told.get("License") or "").strip().splitlines()), "")
    return told.get("License-Expression") or " AND ".join(sorted(set(classes) - {"OSI Approved"})) or text


def kept_licences(kept: Mapping[str, Any]) -> dict[str, str]:
    """The licences that a bill states already, of the same versions: what only other systems install keeps its own."""
    return {
        each["name"]: each["licenses"][0]["license"]["name"]
        for each in kept.get("components", ())
        if "licenses" in each
    }


def text(content: Mapping[str, Any]) -> str:
    """A bill as it is written."""
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def main(arguments: Sequence[str]) -> None:
    """Writes the bill; with --check only says whether the one that is kept is that of the locks."""
    full, core = FULL.read_text("utf-8"), CORE.read_text("utf-8")
    kept = json.loads(BILL.read_text("utf-8")) if BILL.is_file() else {}
    licences = kept_licences(kept) | installed_licences(pin.name for pin in pins(full))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    made = text(bill(full, core, project, licences))
    if list(arguments) == ["--check"]:
        sys.exit(None if BILL.is_file() and made == BILL.read_text("utf-8") else STALE)
    BILL.write_text(made, "utf-8")
    print(f"{BILL.relative_to(ROOT)}: {len(pins(full))} components")


if __name__ == "__main__":
    main(sys.argv[1:])
