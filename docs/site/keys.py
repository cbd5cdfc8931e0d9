"""Fills in the tables of docs/keys.md: unit and label of every key, from the results of each verb.

`python docs/site/keys.py` changes the tables that have a column of labels; the column of meanings and all words between
them are written by hand and stay. A key that has no row gets one at the end of the last such table of its verb.
"""

import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np

from vvdp.base.kinds import FLAG, Kind
from vvdp.evaluation.quantities import quantities
from vvdp.results.result import Result
from vvdp.results.store import read_result
from vvdp.systems.system import load_system, shipped_systems

PAGE = Path(__file__).parents[1] / "keys.md"
HEAD = "| key | unit | label | meaning |"
ANY = r"\w+"
COMMANDS: Mapping[str, tuple[str, ...]] = {
    "map": ("map prototype --analytic",),
    "rig pressure-drop": ("rig pressure-drop prototype",),
    "design optimum": ("design optimum prototype --starts 1 --no-simulation",),
    "design tolerance": ("design tolerance prototype --samples 16 --runs 16",),
    "design temperature": ("design temperature prototype",),
    "compare circuits": ("compare circuits --cycle heavy --circuit throttle",),
    "compare controllers": ("compare controllers --seeds 1 --scenario nominal --controller passivity",),
    "compare estimators": ("compare estimators --seeds 2 --scenario constant --scenario step --estimator m-over-t",),
    "estimate": ("estimate log.csv --wave photodiode --pressure inlet",),
    "observability": ("observability axial-chamber",),
    "geometry": ("geometry prototype --fineness 10 --frames 0",),
}
"""What is run for the keys of a verb, small, beside a log; `--out` and `--json` are added."""
LONG_COMMANDS: Mapping[str, tuple[str, ...]] = {
    "map": ('map prototype --duty 0.3 0.9 2 --pressure "60 bar" "60 bar" 1',),
    "rig derived-capacity": ("rig derived-capacity prototype",),
    "rig ripple": ("rig ripple prototype",),
    "rig step": ("rig step prototype",),
    "rig pump": ('rig pump prototype --duty 0.3 0.9 3 --pressure "60 bar" "60 bar" 1 --speed "1800 rpm"',),
    "rig claims": ("rig claims prototype",),
    "design optimum": ("design optimum prototype --starts 1",),
    "design pareto": ("design pareto prototype --points 8 --generations 2",),
    "design robust": ("design robust prototype-constant-load --draws 2 --designs 4 --generations 2",),
    "cfd rail": ("cfd rail prototype",),
    "cfd turbine": ("cfd turbine prototype",),
    "cfd sweep": ('cfd sweep prototype --flow "20 lpm" "60 lpm" 3',),
}
"""The same, of what takes longer."""
Keys: TypeAlias = Mapping[str, tuple[str, str]]
"""Unit and label by key."""


class Section(NamedTuple):
    """What the page says of a verb: unit, label and meaning of each key, and the verbs whose keys are there as well.

    A word in angle brackets stands for one of the words that `names` has of it, or for any.
    """

    rows: Mapping[str, tuple[str, str, str]]
    others: tuple[str, ...]
    names: Mapping[str, tuple[str, ...]]

    def pattern(self, key: str) -> str:
        """The keys that a row describes, as a regular expression with a group for each name."""
        return re.sub(r"<(\w+)>", lambda word: f"(?P<{word[1]}>{'|'.join(self.names.get(word[1], (ANY,)))})", key)


def sections(page: str) -> dict[str, Section]:
    """What the page says, by verb, and of any result under no name."""
    found = {}
    for number, text in enumerate(page.split("\n## `vvdp ")):
        verb, _, text = text.partition("`\n") if number else ("", "", text)
        rows = [_cells(line) for line in text.splitlines() if line.startswith("| `")]
        shared = re.search(r"The keys of (.*?) are there as well", text)
        told = re.findall(r"`<(\w+)>` is ((?:`\w+`(?:,\s| or\s))+(?:`\w+`|nothing))", text)
        names = {name: tuple(re.findall(r"`(\w+)`|nothing", listed)) for name, listed in told}
        others = tuple(re.findall(r"`vvdp ([a-z -]+)`", shared[1])) if shared else ()
        found[verb] = Section({row[0].strip("`"): (row[1], row[2], row[3]) for row in rows}, others, names)
    return found


def _cells(line: str) -> tuple[str, str, str, str]:
    """Key, unit, label and meaning of a row; a table without labels has three columns."""
    cells = [cell.strip() for cell in line.strip("|\n").split("|")]
    key, unit, *words = cells
    return key, unit, words[0] if len(words) > 1 else "", words[-1]


def keys_of(result: Result) -> dict[str, tuple[str, str]]:
    """Unit and label of every key of the flat object of a result, but for those that all results have."""
    found = {key: (_unit(each.kind, each.kind is FLAG), each.label) for key, each in result.numbers.items()}
    if result.verb == "estimate":  # prints its numbers alone
        return found
    for name, table in result.tables.items():
        prefix = f"{name}_" if len(result.tables) > 1 else ""
        found |= {f"{prefix}{key}": (_unit(column.kind), column.label) for key, column in table.columns.items()}
    return found


def run_keys() -> dict[str, tuple[str, str]]:
    """Unit and label of every key of a run, of all shipped systems."""
    found = {}
    for name in shipped_systems():
        known = quantities(load_system(name))
        found |= {key: (_unit(kind, kind is FLAG), label) for key, (kind, label) in known.items()}
    return found


def _unit(kind: Kind | None, is_flag: bool = False) -> str:
    if kind is None:
        return "text"
    return "true or false" if is_flag else kind.unit


def fill_in(page: str, verb: str, keys: Keys) -> str:
    """The page with units and labels of a verb as they are, and with a row for each key that had none."""
    known = sections(page)
    section = known[verb]
    start = page.index(f"\n## `vvdp {verb}`\n") + 1
    end = page.find("\n## ", start)
    lines = page[start : len(page) if end < 0 else end].splitlines()
    exact = {key for key in section.rows if "<" not in key}
    patterns = [section.pattern(key) for key in section.rows if "<" in key]
    patterns += [known[other].pattern(key) for other in section.others for key in known[other].rows]
    own = {key: value for key, value in keys.items() if key in exact or not _is_one_of(key, patterns)}
    generic = {key: value for key, value in keys.items() if key not in exact}
    last, has_labels = 0, False
    for place, line in enumerate(lines):
        has_labels = line == HEAD or (has_labels and line.startswith("|"))
        if has_labels and line.startswith("| `"):
            key, unit, label, meaning = _cells(line)
            unit, label = _entry(key.strip("`"), section, own, generic) or (unit, label)
            lines[place], last = _row(key.strip("`"), unit, label, meaning), place
    new = [_row(key, *value, "") for key, value in own.items() if key not in exact]
    lines[last + 1 : last + 1] = new
    return page[:start] + "\n".join(lines) + "\n" + (page[end:] if end >= 0 else "")


def _is_one_of(key: str, patterns: list[str]) -> bool:
    return any(re.fullmatch(each, key) for each in patterns)


def _entry(key: str, section: Section, own: Keys, generic: Keys) -> tuple[str, str] | None:
    """Unit and label of a row; None where no result at hand has its key, or a longer row has it."""
    if "<" not in key:
        return own.get(key)
    closer = [section.pattern(row) for row in section.rows if "<" in row and len(row) > len(key)]
    others = {each: value for each, value in generic.items() if not _is_one_of(each, closer)}
    pairs = [(re.fullmatch(section.pattern(key), each), value) for each, value in others.items()]
    found = [(match, value) for match, value in pairs if match]
    if not found:
        return None
    units = {unit for _, (unit, _) in found}
    labels = {_generic(label, match.groupdict()) for match, (_, label) in found}
    unit = units.pop() if len(units) == 1 and not key.endswith(">") else "its own"
    return unit, labels.pop() if len(labels) == 1 else ""


def _generic(label: str, names: Mapping[str, str]) -> str:
    """A label with the names in angle brackets, where it holds them all."""
    for name, word in names.items():
        label = re.sub(rf"\b{re.escape(word.replace('_', ' '))}\b", f"<{name}>", label, count=1)
    return label


def _row(key: str, unit: str, label: str, meaning: str) -> str:
    return " ".join(f"| `{key}` | {unit} | {label} | {'' if meaning == label else meaning} |".split())


def results_of(commands: Mapping[str, tuple[str, ...]]) -> Iterator[tuple[str, Result]]:
    """The result of each command with its verb."""
    for verb, lines in commands.items():
        for line in lines:
            with tempfile.TemporaryDirectory() as folder:
                (Path(folder) / "log.csv").write_text(_log(), "utf-8")
                words = [*shlex.split(line), "--no-report", "--json", "--out", "out"]
                subprocess.run([sys.executable, "-m", "vvdp", *words], check=True, capture_output=True, cwd=folder)
                yield verb, read_result(Path(folder) / "out")


def _log() -> str:
    """A log of time, photodiode and inlet pressure at 24.7 turns a second."""
    time = np.arange(0.0, 1.5, 2e-4)
    angle = 0.3 + 2.0 * np.pi * 24.7 * time
    light = 0.4 + 3.0 * np.clip(0.5 + 1.6 * np.sin(4.0 * angle), 0.0, 1.0)
    inlet = np.clip(50.0 + 300.0 * np.sin(3.0 * angle), 5.0, 100.0)
    rows = (f"{t:.9g},{v:.9g},{p:.9g}" for t, v, p in zip(time, light, inlet, strict=True))
    return "\n".join(["time [s],photodiode [V],inlet [bar]", *rows, ""])


def main() -> None:
    """Writes the page anew."""
    page = fill_in(PAGE.read_text("utf-8"), "run", run_keys())
    for commands in (COMMANDS, LONG_COMMANDS):
        for verb, result in results_of(commands):
            page = fill_in(page, verb, keys_of(result))
    PAGE.write_text(page, "utf-8")


if __name__ == "__main__":
    main()
