"""Attacks vvdp with mutated and hostile files, and says what became of each: `python -m tests.attack`.

With --share 0.0166 the first sixtieth of each kind; --write puts the counts into docs/reliability.md.
"""

import argparse
import io
import os
import sys
import tempfile
import time
from collections import Counter
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import NamedTuple

from tests.attack.cage import Outcome, caged
from tests.attack.directories import Directories
from tests.attack.fields import TEXTS, Field
from tests.attack.logs import DamagedLogs, HostileLogs
from tests.attack.page import PAGE, filled_in, read_rows

FIELDS: tuple[Field, ...] = (*TEXTS, Directories(), DamagedLogs(), HostileLogs())
GOOD = (Outcome.REFUSED, Outcome.READ)


class Count(NamedTuple):
    """What became of the files of a field, the most that one took [s, B], and what was said where it was a fault."""

    outcomes: Counter[Outcome]
    seconds: float
    memory: int
    faults: list[str]


def attacked(field: Field, share: float) -> Count:
    """What becomes of the first `share` of the files of a field."""
    outcomes, faults, seconds, memory = Counter[Outcome](), list[str](), 0.0, 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch, "attack")
        folder.mkdir()
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            field.warm(folder)
        for seed in range(max(round(share * field.files), 1)):
            verdict = caged(lambda seed=seed: field.attack(seed, folder), folder)  # type: ignore[misc]
            outcomes[verdict.outcome] += 1
            seconds, memory = max(seconds, verdict.seconds), max(memory, verdict.memory)
            if verdict.outcome not in GOOD:
                faults.append(
                    f"{field.name} {seed}: {verdict.outcome}: {verdict.said[:300]} ... {verdict.said[-1000:]}"
                )
    return Count(outcomes, seconds, memory, faults)


def main() -> None:
    """One kind of file after the other, each in this process."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("fields", nargs="*", help="kinds of files by a part of their name; all, unless said")
    parser.add_argument("--share", type=float, default=1.0, help="of the files of each kind")
    parser.add_argument("--write", action="store_true", help="put the counts into docs/reliability.md")
    parser.add_argument("--check", action="store_true", help="hold the counts against those in docs/reliability.md")
    given = parser.parse_args()
    wanted = [each for each in FIELDS if not given.fields or any(word in each.name for word in given.fields)]
    if (given.write or given.check) and (given.share != 1.0 or len(wanted) < len(FIELDS)):
        parser.error("the page has the counts of all files")
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    rows: dict[str, Counter[Outcome]] = {}
    failed = 0
    for field in wanted:
        began = time.perf_counter()
        count = attacked(field, given.share)
        rows[field.name], failed = count.outcomes, failed + len(count.faults)
        told = ", ".join(f"{number} {outcome}" for outcome, number in sorted(count.outcomes.items()))
        print(f"{field.name}: {told}; at most {count.seconds:.1f} s, {count.memory / 1e6:.0f} MB; "
              f"{time.perf_counter() - began:.0f} s", flush=True)  # fmt: skip
        print(*count.faults, sep="\n", end="\n" if count.faults else "", flush=True)
    if given.write:
        PAGE.write_text(filled_in(PAGE.read_text("utf-8"), rows), "utf-8")
    if given.check and read_rows(PAGE.read_text("utf-8")) != rows:
        sys.exit("the page has other counts; write them with: python -m tests.attack --write")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
