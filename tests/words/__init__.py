"""Sentences of pages and messages that tests expect, in one table per verb: a change of words is made in one place.

`wording.run.interrupted` is the fragment `interrupted` of `run.toml`, as a person reads it; what varies stands in
braces, for `format`. Numbers, keys, units and names of files are the test's own.
"""

import tomllib
from pathlib import Path
from types import SimpleNamespace

TABLES = {path.stem: tomllib.loads(path.read_text("utf-8")) for path in sorted(Path(__file__).parent.glob("*.toml"))}
wording = SimpleNamespace(**{name: SimpleNamespace(**table) for name, table in TABLES.items()})
