"""Runs the benchmarks named, or all of them, each in a process of its own, and writes the table in README.md."""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from benchmarks.measure import HERE, Line, machine

NAMES = (
    "real_time",
    "reference",
    "against_c",
    "peers",
    "start_up",
    "batch",
    "memory",
    "estimators",
    "maps",
    "logs",
    "networks",
    "chain",
    "axial_control",
    "displacement",
    "server",
    "cfd_overhead",
    "pages",
    "workbench",
)
README = HERE / "README.md"
BEGIN, END = "<!-- written by `python -m benchmarks.run --write` -->", "<!-- end of what is written -->"


def main() -> None:
    """One after the other: they would disturb each other."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", choices=[*NAMES, []], help="which; all, unless said")
    parser.add_argument("--short", action="store_true", help="in seconds each; the figures mean nothing")
    parser.add_argument("--write", action="store_true", help="put the figures into benchmarks/README.md")
    given = parser.parse_args()
    if given.short and given.write:
        parser.error("figures of the short form are not written")
    failed, found = [], dict[str, list[Line]]()
    with tempfile.TemporaryDirectory() as folder:
        for name in given.names or NAMES:
            print(f"\n== {name}", flush=True)
            lines = Path(folder) / f"{name}.json"
            command = [sys.executable, "-m", f"benchmarks.{name}", "--lines", str(lines)]
            if subprocess.run([*command, *(["--short"] if given.short else [])], check=False).returncode:
                failed.append(name)
            else:
                found[name] = [Line(**line) for line in json.loads(lines.read_text())]
    if given.write:
        README.write_text(written(README.read_text("utf-8"), machine(), found), "utf-8")
    if failed:
        sys.exit(f"failed: {', '.join(failed)}")


def written(page: str, where: str, found: dict[str, list[Line]]) -> str:
    """`page` with the lines of each benchmark in `found`; those of others stay as they were."""
    before, _, rest = page.partition(BEGIN)
    old, _, after = rest.partition(END)
    kept = {name: text for name in NAMES if (text := _section(old, name))}
    fresh = {name: "\n".join([f"### {name}", "", where, "", *_table(lines)]) for name, lines in found.items()}
    sections = [text for name in NAMES if (text := fresh.get(name) or kept.get(name))]
    return f"{before}{BEGIN}\n\n" + "\n\n".join(sections) + f"\n\n{END}{after}"


def _section(text: str, name: str) -> str:
    """The part of the page that a benchmark has written, without its end."""
    _, found, rest = text.partition(f"### {name}\n")
    return f"{found}{rest.partition('### ')[0]}".strip()


def _table(lines: list[Line]) -> list[str]:
    rows = ["| what | figure | target |", "|---|---|---|"]
    for line in lines:
        verdict = "" if line.met is None else ", met" if line.met else ", **missed**"
        rows.append(f"| {line.name} | {line.text} | {line.target}{verdict} |")
    return rows


if __name__ == "__main__":
    main()
