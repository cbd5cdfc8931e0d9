"""Fills in the words and units of docs/nomenclature.md from the classes of values. `python docs/site/nomenclature.py`

Symbols and meanings are written by hand and stay. A word that has no row gets one at the end, which is to be given its
symbol and meaning and moved to its section.
"""

import importlib
import pkgutil
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import is_dataclass
from pathlib import Path

import vvdp
from vvdp.base.conservation import Books, Stored
from vvdp.base.params import Params, field_kinds, field_types

PAGE = Path(__file__).parents[1] / "nomenclature.md"
ROOMS = ("fluid", "valve", "hydraulics", "sensing", "geometry", "estimation", "control")
ROOMS += ("network", "components", "programs", "systems", "simulation")
ROW = re.compile(r"^\| `(\w+)` \| ([^|]*) \| ([^|]*) \| ([^|]*) \|$")


def value_classes() -> Iterator[type]:
    """Parameter classes, states, and the books with their entries."""
    for info in pkgutil.walk_packages(vvdp.__path__, "vvdp."):
        if info.name.split(".")[1] not in ROOMS:
            continue
        for cls in vars(importlib.import_module(info.name)).values():
            if isinstance(cls, type) and cls.__module__ == info.name and _has_words(cls):
                yield cls
    yield from (Books, Stored)


def _has_words(cls: type) -> bool:
    is_tuple = hasattr(cls, "_fields") and cls.__name__.endswith(("State", "Spool", "Losses"))
    return is_tuple or issubclass(cls, Params)


def units_of_words() -> dict[str, set[str]]:
    """The SI units that each word has, over all classes; fields that are classes themselves have none."""
    found: dict[str, set[str]] = {}
    for cls in value_classes():
        for name, kind in field_kinds(cls).items():
            hint = field_types(cls)[name]
            is_nested = isinstance(hint, type) and (
                issubclass(hint, Params) or hasattr(hint, "_fields") or is_dataclass(hint)
            )
            if kind and not is_nested:
                found.setdefault(name, set()).add(kind.unit)
    return found


def fill_in(page: str, units: Mapping[str, set[str]]) -> str:
    """The page with a row for each word and unit; of a word with one row the unit is set right."""
    rows = [match for line in page.splitlines() if (match := ROW.match(line))]
    count = Counter(match[1] for match in rows)
    single = {word: next(iter(found)) for word, found in units.items() if len(found) == 1 and count[word] == 1}
    lines = [
        f"| `{match[1]}` | {match[2]} | {single.get(match[1], match[3])} | {match[4]} |" if match else line
        for line, match in ((line, ROW.match(line)) for line in page.splitlines())
    ]
    there = {(match[1], single.get(match[1], match[3])) for match in rows}
    missing = {(word, unit) for word, found in units.items() for unit in found} - there
    return "\n".join([*lines, *(f"| `{word}` |  | {unit} |  |" for word, unit in sorted(missing))]) + "\n"


def main() -> None:
    """Writes the page anew."""
    PAGE.write_text(fill_in(PAGE.read_text("utf-8"), units_of_words()), "utf-8")


if __name__ == "__main__":
    main()
